//! An evaluation for a person, within 100 columns.

use std::fmt::Write as _;

use super::extracted::ExtractedScore;
use super::labels::{ByTarget, Class, LabelScore};
use super::map::{KindScore, MapScore};
use super::matching::{Errors, Spread};
use super::path::{PathError, PathScore};
use super::scorer::Evaluation;
use super::suspects::{Gate, SuspectScore};
use super::truth::{AGREEING_SIGMAS, Origin, Truth};
use crate::core::legible::one_line;
use crate::core::observer::Setting;
use crate::core::statistics::share;
use crate::core::wording::counted;
use crate::tools::tables::{TableColumn, listed, optional, percent, section};

/// Everything, as text.
pub fn text(setting: &Setting<'_>, truth: &Truth, evaluation: &Evaluation) -> String {
    let mut text = head(setting, truth);
    section(
        &mut text,
        "LABELS (arcs by what echoed)",
        &labels(&evaluation.labels),
    );
    if let Some(score) = &evaluation.suspects {
        section(&mut text, "SUSPECTS", &suspects(score));
    }
    if let Some(path) = &evaluation.path {
        section(&mut text, "PATH", &self::path(path));
    }
    section(&mut text, "MAP", &map(&evaluation.map));
    if evaluation.confirmed != evaluation.map {
        section(
            &mut text,
            "MAP, CONFIRMED FEATURES ONLY",
            &map(&evaluation.confirmed),
        );
    }
    section(&mut text, "ERRORS (mean, largest)", &errors(evaluation));
    text
}

fn head(setting: &Setting<'_>, truth: &Truth) -> String {
    let world = truth.world();
    let origin = match truth.origin() {
        Origin::Log => "what the log says that echoed".to_owned(),
        Origin::EchoModel => format!(
            "the echo model at each arc's pose, within {AGREEING_SIGMAS} sigma or {:.3} m",
            truth.agreeing_range()
        ),
    };
    format!(
        "{}{} against {origin},\nin a world of {} and {}, ends of walls included{}\n",
        one_line(&setting.source.file),
        if setting.source.complete {
            ""
        } else {
            " (INCOMPLETE)"
        },
        counted(world.walls().len() as u64, "wall"),
        counted(world.points().len() as u64, "point"),
        match world.pillars().len() {
            0 => String::new(),
            pillars => format!(", and {}", counted(pillars as u64, "pillar")),
        },
    )
}

fn labels(score: &LabelScore) -> String {
    type Row = (String, ByTarget, Option<Class>);
    let class = |name: &str, class: Class| (name.to_owned(), class.arcs, Some(class));
    let mut rows: Vec<Row> = vec![
        class("contact", score.contact),
        class("intersection", score.intersection),
    ];
    rows.extend(score.circle.map(|circle| class("circle", circle)));
    rows.extend([("unidentified".to_owned(), score.unidentified, None)]);
    let reasons = score.reasons.iter();
    rows.extend(reasons.map(|(reason, arcs)| (format!("  {reason}"), *arcs, None)));
    let of_class = |row: &Row, of: fn(Class) -> Option<f64>| {
        row.2.map_or_else(String::new, |class| percent(of(class)))
    };
    let mut columns: Vec<TableColumn<'_, Row>> = vec![
        ("label", &|(name, ..)| name.clone()),
        ("line", &|(_, arcs, _)| arcs.line.to_string()),
        ("point", &|(_, arcs, _)| arcs.point.to_string()),
        ("other", &|(_, arcs, _)| arcs.other.to_string()),
    ];
    if score.circle.is_some() {
        columns.insert(3, ("pillar", &|(_, arcs, _)| arcs.circle.to_string()));
    }
    let precision = |row: &Row| of_class(row, |class| class.precision);
    let recall = |row: &Row| of_class(row, |class| class.recall);
    columns.extend([
        ("precision %", &precision as &dyn Fn(&Row) -> String),
        ("recall %", &recall),
    ]);
    let mut text = listed::<Row>(1, &columns, &rows);
    let _ = writeln!(
        text,
        "  {} of {} arcs labelled ({} %), {} labels wrong ({} %; {} % of those on a wall or point)\n  \
         wrong: {} where three readings saw one target, {} where they saw different or unknown ones",
        score.given(),
        score.arcs,
        percent(score.coverage),
        score.wrong_labels(),
        percent(score.wrong_share),
        percent(score.wrong_share_known),
        score.wrong.one_target,
        score.wrong.mixed,
    );
    if score.wrong.pillar > 0 {
        let _ = writeln!(
            text,
            "  and {} where a pillar echoed, which is neither wall nor point",
            score.wrong.pillar
        );
    }
    let other = score.other.iter().filter(|(_, count)| **count > 0);
    let other: Vec<String> = other.map(|(why, count)| format!("{count} {why}")).collect();
    if !other.is_empty() {
        let _ = writeln!(text, "  other: {}", other.join(", "));
    }
    text
}

fn suspects(score: &SuspectScore) -> String {
    type Row = (String, Gate);
    let gates = score.gates.iter();
    let gates = gates.map(|other| (format!("chi2 {:.2}", other.gate), other.score));
    let configured = ("as configured".to_owned(), score.configured);
    let rows: Vec<Row> = std::iter::once(configured).chain(gates).collect();
    listed::<Row>(
        1,
        &[
            ("gate", &|(name, _)| name.clone()),
            ("suspects", &|(_, gate)| gate.suspects.to_string()),
            ("wrong found", &|(_, gate)| gate.wrong_found.to_string()),
            ("of wrong %", &|(_, gate)| percent(gate.recall)),
            ("precision %", &|(_, gate)| percent(gate.precision)),
            ("right accused", &|(_, gate)| gate.right_accused.to_string()),
            ("of right %", &|(_, gate)| percent(gate.right_accused_share)),
        ],
        &rows,
    )
}

fn path(score: &PathScore) -> String {
    type Row = (&'static str, PathError);
    let mut text = listed::<Row>(
        1,
        &[
            ("laid on the true path by", &|(name, _)| (*name).to_owned()),
            ("rms mm", &|(_, e)| optional(Some(e.rms * 1e3), 1)),
            ("largest mm", &|(_, e)| optional(Some(e.max * 1e3), 1)),
            ("heading rms deg", &|(_, e)| {
                optional(Some(e.heading.to_degrees()), 2)
            }),
        ],
        &[
            ("its first pose", score.from_first),
            ("all of it (ATE)", score.aligned),
        ],
    );
    let _ = writeln!(
        text,
        "  {} over {:.1} m",
        counted(score.poses, "pose"),
        score.length
    );
    if let Some(nees) = score.nees {
        let _ = writeln!(
            text,
            "  NEES of the estimated poses {nees:.2} per degree of freedom"
        );
    }
    text
}

fn map(score: &MapScore) -> String {
    type Row<'a> = (&'a str, &'a KindScore);
    let mut kinds: Vec<Row<'_>> = vec![("lines", &score.lines), ("points", &score.points)];
    kinds.extend(score.circles.iter().map(|kind| ("circles", kind)));
    let where_known =
        |x: Option<f64>, told: &dyn Fn(f64) -> String| x.map_or_else(String::new, told);
    let mut text = listed::<Row<'_>>(
        1,
        &[
            ("kind", &|(name, _)| (*name).to_owned()),
            ("there", &|(_, kind)| kind.visible.to_string()),
            ("in map", &|(_, kind)| kind.features.to_string()),
            ("matched", &|(_, kind)| kind.matched.to_string()),
            ("missed", &|(_, kind)| kind.missed.len().to_string()),
            ("spurious", &|(_, kind)| kind.surplus().to_string()),
            ("twice", &|(_, kind)| kind.duplicates.len().to_string()),
            ("more", &|(_, kind)| kind.more().to_string()),
            ("covered %", &|(_, kind)| {
                where_known(kind.covered, &|covered| percent(Some(covered)))
            }),
            ("beyond m", &|(_, kind)| {
                where_known(kind.overrun, &|overrun| format!("{overrun:.2}"))
            }),
        ],
        &kinds,
    );
    text.push_str(
        "  there: walls and points that echoed at least 3 times, each of them matched or missed; spurious: no\n  \
         wall or point of the world, or one that is in the map already (twice); more: right without being\n  \
         asked for, another part of a wall that is matched, or what echoed less often; beyond: length of\n  \
         these lines beside no wall\n",
    );
    for (name, kind) in kinds {
        let name = match name {
            "lines" => "walls",
            "circles" => "pillars",
            _ => name,
        };
        if kind.without_own() > 0 {
            let _ = writeln!(
                text,
                "  {} of the matched {name} have no feature of their own: that of the next one shows them",
                kind.without_own()
            );
        }
        let missed = kind.missed.iter();
        let missed: Vec<String> = missed.map(|m| m.reflector.index().to_string()).collect();
        if !missed.is_empty() {
            let _ = writeln!(text, "  missed {name}: {}", missed.join(", "));
        }
    }
    text
}

fn errors(evaluation: &Evaluation) -> String {
    type Row<'a> = (String, u64, &'a Errors);
    let mut extracted = vec![
        ("lines", &evaluation.extracted.lines),
        ("points", &evaluation.extracted.points),
    ];
    extracted.extend(
        evaluation
            .extracted
            .circles
            .iter()
            .map(|score| ("circles", score)),
    );
    let mut in_map = vec![
        ("lines", &evaluation.map.lines),
        ("points", &evaluation.map.points),
    ];
    in_map.extend(
        evaluation
            .map
            .circles
            .iter()
            .map(|score| ("circles", score)),
    );
    let in_map = in_map.into_iter();
    let mut rows: Vec<Row<'_>> = in_map
        .map(|(name, kind)| {
            let matched = kind.matches.len() as u64;
            (format!("map {name}"), matched, &kind.errors)
        })
        .collect();
    for (name, score) in extracted {
        let near = &score.near_errors;
        rows.push((
            format!("run {name}, of one target"),
            score.pure,
            &score.pure_errors,
        ));
        rows.push((format!("run {name}, near one"), near.nees.features, near));
    }
    // They have a radius, and nothing that lines have.
    let (circles, rows): (Vec<Row<'_>>, Vec<Row<'_>>) =
        (rows.into_iter()).partition(|(_, _, errors)| errors.radius.is_some());
    let told = |of: Option<Spread>, which: fn(Spread) -> f64, scale, decimals| {
        of.map_or_else(String::new, |spread| {
            optional(Some(which(spread) * scale), decimals)
        })
    };
    const DEGREES: f64 = 180.0 / std::f64::consts::PI;
    let columns: [TableColumn<'_, Row<'_>>; 10] = [
        ("features", &|(name, ..)| name.clone()),
        ("number", &|(_, count, _)| count.to_string()),
        ("rho mm", &|(.., e)| told(e.rho, |s| s.mean, 1e3, 1)),
        ("", &|(.., e)| told(e.rho, |s| s.max, 1e3, 1)),
        ("theta deg", &|(.., e)| {
            told(e.theta, |s| s.mean, DEGREES, 2)
        }),
        ("", &|(.., e)| told(e.theta, |s| s.max, DEGREES, 2)),
        ("place mm", &|(.., e)| told(e.position, |s| s.mean, 1e3, 1)),
        ("", &|(.., e)| told(e.position, |s| s.max, 1e3, 1)),
        ("NEES", &|(.., e)| optional(e.nees.mean, 2)),
        ("in 95 %", &|(.., e)| percent(e.nees.within_95)),
    ];
    let mut text = listed(1, &columns, &rows);
    if !circles.is_empty() {
        text.push_str(&listed(
            1,
            &[
                ("features", &|(name, ..): &Row<'_>| name.clone()),
                ("number", &|(_, count, _)| count.to_string()),
                ("place mm", &|(.., e)| told(e.position, |s| s.mean, 1e3, 1)),
                ("", &|(.., e)| told(e.position, |s| s.max, 1e3, 1)),
                ("radius mm", &|(.., e)| told(e.radius, |s| s.mean, 1e3, 1)),
                ("", &|(.., e)| told(e.radius, |s| s.max, 1e3, 1)),
                ("NEES", &|(.., e)| optional(e.nees.mean, 2)),
                ("in 95 %", &|(.., e)| percent(e.nees.within_95)),
            ],
            &circles,
        ));
    }
    let purity = |score: &ExtractedScore| {
        format!(
            "{} ({} % of one target)",
            score.features,
            percent(share(score.pure, score.features))
        )
    };
    let _ = writeln!(
        text,
        "  NEES: error squared over covariance, per degree of freedom; 1 where the covariances are\n  \
         honest. Used runs: {} lines, {} points",
        purity(&evaluation.extracted.lines),
        purity(&evaluation.extracted.points),
    );
    text
}
