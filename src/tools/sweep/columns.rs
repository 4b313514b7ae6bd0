//! What is told of every cell, and by what cells are ranked.

use std::cmp::Ordering;

use super::score::{Score, TruthScore};
use crate::core::rounding::rounded;
use crate::core::statistics::share;
use crate::tools::tables::optional;
use Better::{High, Low};

/// Which of two values is the better one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    /// The smaller.
    Low,
    /// The larger.
    High,
}

/// A number that is told of every cell.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// In files and for `--sort`.
    pub name: &'static str,
    /// In tables; empty for what only files have.
    pub head: &'static str,
    pub better: Better,
    /// Decimals in a table; files have more.
    pub decimals: usize,
    /// What it is multiplied with in a table: 100 for shares, 1000 for millimetres.
    pub scale: f64,
    /// The number.
    pub of: fn(&Score) -> Option<f64>,
}

/// Decimals and scale in a table.
const COUNT: (usize, f64) = (0, 1.0);
const PERCENT: (usize, f64) = (1, 100.0);
const NUMBER: (usize, f64) = (3, 1.0);
const MILLIMETRES: (usize, f64) = (1, 1000.0);

const fn column(
    name: &'static str,
    head: &'static str,
    better: Better,
    (decimals, scale): (usize, f64),
    of: fn(&Score) -> Option<f64>,
) -> Column {
    Column {
        name,
        head,
        better,
        decimals,
        scale,
        of,
    }
}

fn count(count: u64) -> Option<f64> {
    Some(count as f64)
}

fn of_truth(score: &Score, of: fn(&TruthScore) -> u64) -> Option<f64> {
    count(of(score.truth.as_ref()?))
}

/// What only the truth tells.
const OF_TRUTH: &[Column] = &[
    column("map_errors", "map errors", Low, COUNT, |s| {
        of_truth(s, TruthScore::map_errors)
    }),
    column("missed", "", Low, COUNT, |s| of_truth(s, |t| t.missed)),
    column("spurious", "", Low, COUNT, |s| of_truth(s, |t| t.spurious)),
    column("twice", "", Low, COUNT, |s| of_truth(s, |t| t.twice)),
    column("wrong_share", "wrong %", Low, PERCENT, |s| {
        share(s.truth.as_ref()?.wrong, s.labelled())
    }),
];

/// What every sweep has.
const ALWAYS: &[Column] = &[
    column("bits", "bits", Low, NUMBER, |s| s.bits),
    column("explained_share", "explained %", High, PERCENT, |s| {
        share(s.explained?, s.arcs)
    }),
    column("chi2", "chi2", Low, NUMBER, |s| s.chi2),
    column("labelled_share", "labelled %", High, PERCENT, |s| {
        share(s.labelled(), s.arcs)
    }),
    column("suspect_share", "suspect %", Low, PERCENT, |s| {
        share(s.suspects?, s.labelled())
    }),
    column("sound_share", "sound %", High, PERCENT, |s| {
        let sound = s.labelled() as f64 - 2.0 * s.suspects? as f64;
        (s.arcs > 0).then(|| sound / s.arcs as f64)
    }),
    column("lines", "lines", Low, COUNT, |s| count(s.lines)),
    column("points", "points", Low, COUNT, |s| count(s.points)),
    column("rms", "rms mm", Low, MILLIMETRES, |s| s.rms),
    column("frames", "", High, COUNT, |s| count(s.frames)),
    column("arcs", "", High, COUNT, |s| count(s.arcs)),
    column("contact", "", High, COUNT, |s| count(s.contact)),
    column("intersection", "", High, COUNT, |s| count(s.intersection)),
    column("suspects", "", Low, COUNT, |s| count(s.suspects?)),
];

/// The columns that a sweep has.
pub fn columns(with_truth: bool) -> impl Iterator<Item = &'static Column> {
    let of_truth = if with_truth { OF_TRUTH } else { &[] };
    of_truth.iter().chain(ALWAYS)
}

/// By what cells are ranked where nothing else is asked for; the first that differs decides.
pub fn ranking(with_truth: bool) -> impl Iterator<Item = &'static Column> {
    let names: &[&str] = if with_truth {
        &["map_errors", "wrong_share", "labelled_share", "bits"]
    } else {
        &["bits", "sound_share"]
    };
    let found = move |name| columns(with_truth).find(|column| column.name == name);
    names.iter().copied().filter_map(found)
}

impl Column {
    /// What a person reads above it.
    pub fn heading(&self) -> &'static str {
        if self.head.is_empty() {
            self.name
        } else {
            self.head
        }
    }

    /// Whether it counts something: a whole number.
    pub fn is_count(&self) -> bool {
        (self.decimals, self.scale) == COUNT
    }

    /// Better cells first; those without a value last.
    pub fn compare(&self, a: &Score, b: &Score) -> Ordering {
        match ((self.of)(a), (self.of)(b)) {
            (Some(a), Some(b)) if self.better == Low => a.total_cmp(&b),
            (Some(a), Some(b)) => b.total_cmp(&a),
            (a, b) => b.is_some().cmp(&a.is_some()),
        }
    }

    /// The value of a cell as files hold it.
    pub fn rounded(&self, score: &Score) -> Option<f64> {
        (self.of)(score).map(rounded)
    }

    /// The least difference that a table shows.
    pub fn least(&self) -> String {
        let decimals = self.decimals;
        format!("{:.decimals$}", libm::pow(0.1, decimals as f64))
    }

    /// A number of the column for a table.
    pub fn number(&self, number: Option<f64>) -> String {
        optional(number.map(|number| number * self.scale), self.decimals)
    }
}
