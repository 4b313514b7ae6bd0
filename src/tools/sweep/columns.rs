//! What is told of every cell, and by what cells are ranked.

use std::cmp::Ordering;

use super::score::Score;
use super::{Cell, Sweep};

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
    /// Which is better.
    pub better: Better,
    /// Whether it needs the truth.
    pub of_truth: bool,
    /// Decimals in a table; files have more.
    pub decimals: usize,
    /// What it is multiplied with in a table: 100 for shares, 1000 for millimetres.
    pub scale: f64,
    /// The number.
    pub of: fn(&Score) -> Option<f64>,
}

fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// A count that is told in tables under `head`.
const fn count(
    name: &'static str,
    head: &'static str,
    better: Better,
    of: fn(&Score) -> Option<f64>,
) -> Column {
    Column {
        name,
        head,
        better,
        of_truth: false,
        decimals: 0,
        scale: 1.0,
        of,
    }
}

impl Column {
    /// The same, held against the truth.
    const fn of_truth(self) -> Self {
        Self {
            of_truth: true,
            ..self
        }
    }

    /// The same, told with some decimals of a unit that is so many times smaller.
    const fn told(self, decimals: usize, scale: f64) -> Self {
        Self {
            decimals,
            scale,
            ..self
        }
    }

    /// The same, told in per cent.
    const fn percent(self) -> Self {
        self.told(1, 100.0)
    }
}

use Better::{High, Low};

/// Every column.
pub const COLUMNS: &[Column] = &[
    count("map_errors", "map errors", Low, |s| {
        Some(s.truth.as_ref()?.map_errors() as f64)
    })
    .of_truth(),
    count("missed", "", Low, |s| Some(s.truth.as_ref()?.missed as f64)).of_truth(),
    count("spurious", "", Low, |s| {
        Some(s.truth.as_ref()?.spurious as f64)
    })
    .of_truth(),
    count("twice", "", Low, |s| Some(s.truth.as_ref()?.twice as f64)).of_truth(),
    count("wrong_share", "wrong %", Low, |s| {
        share(s.truth.as_ref()?.wrong, s.labelled())
    })
    .percent()
    .of_truth(),
    count("bits", "bits", Low, |s| s.bits).told(3, 1.0),
    count("explained_share", "explained %", High, |s| {
        share(s.explained, s.arcs)
    })
    .percent(),
    count("chi2", "chi2", Low, |s| s.chi2).told(3, 1.0),
    count("labelled_share", "labelled %", High, |s| {
        share(s.labelled(), s.arcs)
    })
    .percent(),
    count("suspect_share", "suspect %", Low, |s| {
        share(s.suspects, s.labelled())
    })
    .percent(),
    count("sound_share", "", High, |s| {
        let sound = s.labelled() as f64 - 2.0 * s.suspects as f64;
        (s.arcs > 0).then(|| sound / s.arcs as f64)
    })
    .percent(),
    count("lines", "lines", Low, |s| Some(s.lines as f64)),
    count("points", "points", Low, |s| Some(s.points as f64)),
    count("rms", "rms mm", Low, |s| s.rms).told(1, 1000.0),
    count("frames", "", High, |s| Some(s.frames as f64)),
    count("arcs", "", High, |s| Some(s.arcs as f64)),
    count("contact", "", High, |s| Some(s.contact as f64)),
    count("intersection", "", High, |s| Some(s.intersection as f64)),
    count("suspects", "", Low, |s| Some(s.suspects as f64)),
];

/// By what cells are ranked where nothing else is asked for, the first that differs decides.
pub const WITH_TRUTH: &[&str] = &["map_errors", "wrong_share", "labelled_share", "bits"];
/// The same without the truth.
pub const WITHOUT_TRUTH: &[&str] = &["bits", "sound_share"];

/// The column with a name.
pub fn find(name: &str) -> Option<&'static Column> {
    COLUMNS.iter().find(|column| column.name == name)
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

    /// Better cells first; those without a value last.
    pub fn compare(&self, a: &Score, b: &Score) -> Ordering {
        match ((self.of)(a), (self.of)(b)) {
            (Some(a), Some(b)) if self.better == Better::Low => a.total_cmp(&b),
            (Some(a), Some(b)) => b.total_cmp(&a),
            (a, b) => b.is_some().cmp(&a.is_some()),
        }
    }

    /// A value for a table.
    pub fn text(&self, score: &Score) -> String {
        self.number((self.of)(score))
    }

    /// The least difference that a table shows.
    pub fn least(&self) -> String {
        let decimals = self.decimals;
        format!("{:.decimals$}", libm::pow(0.1, decimals as f64))
    }

    /// A number of the column for a table.
    pub fn number(&self, number: Option<f64>) -> String {
        let decimals = self.decimals;
        number.map_or_else(
            || "-".to_owned(),
            |value| format!("{:.decimals$}", value * self.scale),
        )
    }
}

/// The columns that a sweep has.
pub fn columns(with_truth: bool) -> impl Iterator<Item = &'static Column> {
    COLUMNS
        .iter()
        .filter(move |column| with_truth || !column.of_truth)
}

/// Puts the best cells first; what failed comes last, what is equal stays in the grid's order.
pub fn rank(cells: &mut [Cell], by: &[&'static Column]) {
    cells.sort_by(|a, b| match (&a.score, &b.score) {
        (Ok(one), Ok(other)) => by
            .iter()
            .map(|column| column.compare(one, other))
            .find(|order| order.is_ne())
            .unwrap_or(a.index.cmp(&b.index)),
        (a_score, b_score) => b_score
            .is_ok()
            .cmp(&a_score.is_ok())
            .then(a.index.cmp(&b.index)),
    });
}

impl Sweep {
    /// The column that was ranked by first.
    pub fn first_column(&self) -> Option<&'static Column> {
        self.ranked_by.first().copied()
    }

    /// The cells that no ranked column tells from the best one, which is the first of them.
    pub fn leaders(&self) -> impl Iterator<Item = &Cell> {
        let best = self.best().map(|(_, score)| score);
        self.cells.iter().take_while(move |cell| {
            let (Some(best), Ok(score)) = (best, &cell.score) else {
                return false;
            };
            let mut by = self.ranked_by.iter();
            by.all(|column| column.compare(best, score).is_eq())
        })
    }

    /// Whether nothing that was swept makes a difference.
    pub fn is_flat(&self) -> bool {
        self.cells.len() > 1 && self.leaders().count() == self.cells.len()
    }
}
