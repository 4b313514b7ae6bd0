//! An evaluation for a person, within 100 columns.

use std::fmt::Write as _;

use super::errors::{Errors, Spread};
use super::extracted::ExtractedScore;
use super::labels::{ByTarget, LabelScore};
use super::map::{KindScore, MapScore};
use super::suspects::{Gate, SuspectScore};
use super::truth::{AGREEING_SIGMAS, Origin, Truth};
use super::{Evaluation, share};
use crate::core::observer::Setting;
use crate::core::world::Reflector;
use crate::tools::info::tables::{render, table};

/// Everything, as text.
pub fn text(setting: &Setting<'_>, truth: &Truth, evaluation: &Evaluation) -> String {
    let mut text = head(setting, truth);
    section(
        &mut text,
        "LABELS (arcs by what echoed)",
        &labels(&evaluation.labels),
    );
    section(&mut text, "SUSPECTS", &suspects(&evaluation.suspects));
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

/// Writing into a string cannot fail.
fn section(text: &mut String, title: &str, body: &str) {
    let _ = write!(text, "\n{title}\n{body}");
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
    let counted = |count: usize, thing: &str| match count {
        1 => format!("1 {thing}"),
        n => format!("{n} {thing}s"),
    };
    format!(
        "{}{} against {origin},\nin a world of {} and {}, ends of walls included\n",
        setting.source.file,
        if setting.source.complete {
            ""
        } else {
            " (INCOMPLETE)"
        },
        counted(world.walls().len(), "wall"),
        counted(world.points().len(), "point"),
    )
}

fn labels(score: &LabelScore) -> String {
    let mut rows = table(
        &["label", "line", "point", "other", "precision %", "recall %"],
        1,
    );
    let counts = |name: &str, arcs: ByTarget| {
        [
            name.to_owned(),
            arcs.line.to_string(),
            arcs.point.to_string(),
            arcs.other.to_string(),
        ]
    };
    for (name, arcs, class) in [
        ("contact", score.contact, score.contact_score),
        ("intersection", score.intersection, score.intersection_score),
    ] {
        let scores = [percent(class.precision), percent(class.recall)];
        rows.add_row(counts(name, arcs).into_iter().chain(scores));
    }
    rows.add_row(counts("unidentified", score.unidentified));
    for (reason, arcs) in &score.reasons {
        rows.add_row(counts(&format!("  {reason}"), *arcs));
    }
    let mut text = render(&rows);
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
    let other: Vec<String> = score
        .other
        .iter()
        .filter(|(_, count)| **count > 0)
        .map(|(why, count)| format!("{count} {why}"))
        .collect();
    if !other.is_empty() {
        let _ = writeln!(text, "  other: {}", other.join(", "));
    }
    text
}

fn suspects(score: &SuspectScore) -> String {
    let mut rows = table(
        &[
            "gate",
            "suspects",
            "wrong found",
            "of wrong %",
            "precision %",
            "right accused",
            "of right %",
        ],
        1,
    );
    let mut row = |name: String, gate: &Gate| {
        rows.add_row([
            name,
            gate.suspects.to_string(),
            gate.wrong_found.to_string(),
            percent(gate.recall),
            percent(gate.precision),
            gate.right_accused.to_string(),
            percent(gate.right_accused_share),
        ]);
    };
    row("as configured".to_owned(), &score.configured);
    for other in &score.gates {
        row(format!("chi2 {:.2}", other.gate), &other.score);
    }
    render(&rows)
}

fn map(score: &MapScore) -> String {
    let mut rows = table(
        &[
            "kind",
            "there",
            "in map",
            "matched",
            "missed",
            "spurious",
            "twice",
            "more",
            "covered %",
            "beyond m",
        ],
        1,
    );
    for (name, kind) in [("lines", &score.lines), ("points", &score.points)] {
        rows.add_row([
            name.to_owned(),
            kind.visible.to_string(),
            kind.features.to_string(),
            kind.matched().to_string(),
            kind.missed.len().to_string(),
            kind.surplus().to_string(),
            kind.duplicates.len().to_string(),
            kind.more().to_string(),
            kind.covered
                .map_or_else(String::new, |covered| percent(Some(covered))),
            kind.overrun
                .map_or_else(String::new, |overrun| format!("{overrun:.2}")),
        ]);
    }
    let mut text = render(&rows);
    text.push_str(
        "  there: walls and points that echoed at least 3 times, each of them matched or missed; spurious: no\n  \
         wall or point of the world, or one that is in the map already (twice); more: right without being\n  \
         asked for, another part of a wall that is matched, or what echoed less often; beyond: length of\n  \
         these lines beside no wall\n",
    );
    for (name, kind) in [("walls", &score.lines), ("points", &score.points)] {
        if kind.without_own() > 0 {
            let _ = writeln!(
                text,
                "  {} of the matched {name} have no feature of their own: that of the next one shows them",
                kind.without_own()
            );
        }
        let missed: Vec<String> = kind.missed.iter().map(|r| number(*r)).collect();
        if !missed.is_empty() {
            let _ = writeln!(text, "  missed {name}: {}", missed.join(", "));
        }
    }
    text
}

fn number(reflector: Reflector) -> String {
    match reflector {
        Reflector::Line(index) | Reflector::Point(index) => index.to_string(),
    }
}

fn errors(evaluation: &Evaluation) -> String {
    let mut rows = table(
        &[
            "features",
            "number",
            "rho mm",
            "",
            "theta deg",
            "",
            "place mm",
            "",
            "NEES",
            "in 95 %",
        ],
        1,
    );
    let mut row = |name: &str, count: u64, errors: &Errors| {
        let two = |spread: Option<Spread>, scale: f64, decimals: usize| match spread {
            Some(Spread { mean, max }) => [mean, max].map(|x| format!("{:.decimals$}", x * scale)),
            None => [String::new(), String::new()],
        };
        let cells = [name.to_owned(), count.to_string()]
            .into_iter()
            .chain(two(errors.rho, 1e3, 1))
            .chain(two(errors.theta, 1_f64.to_degrees(), 2))
            .chain(two(errors.position, 1e3, 1))
            .chain([
                errors
                    .nees
                    .mean
                    .map_or_else(|| "-".to_owned(), |mean| format!("{mean:.2}")),
                percent(errors.nees.within_95),
            ]);
        rows.add_row(cells);
    };
    let in_map = |kind: &KindScore| kind.matches.len() as u64;
    row(
        "map lines",
        in_map(&evaluation.map.lines),
        &evaluation.map.lines.errors,
    );
    row(
        "map points",
        in_map(&evaluation.map.points),
        &evaluation.map.points.errors,
    );
    for (name, score) in [
        ("lines", &evaluation.extracted_lines),
        ("points", &evaluation.extracted_points),
    ] {
        row(
            &format!("run {name}, of one target"),
            score.pure,
            &score.pure_errors,
        );
        row(
            &format!("run {name}, near one"),
            score.near_errors.nees.features,
            &score.near_errors,
        );
    }
    let mut text = render(&rows);
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
        purity(&evaluation.extracted_lines),
        purity(&evaluation.extracted_points),
    );
    text
}

/// A share in per cent; `-` of nothing.
fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "-".to_owned(), |share| format!("{:.1}", 100.0 * share))
}
