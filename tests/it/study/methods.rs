//! TMAM and its rivals on the same logs.

use std::fmt::Write as _;

use tmam_replay::core::log::Log;
use tmam_replay::core::tmam::feature::{MapFeature, Status};
use tmam_replay::core::tmam::label::Kind;
use tmam_replay::tools::evaluate::Evaluation;
use tmam_replay::tools::evaluate::map::KindScore;

use super::drives::Rules;
use super::tables::{Row, mean, percent, sum, table as markdown};

/// How the confirmed map of each did.
pub fn table(rows: &[Row]) -> String {
    let precision = |of: fn(&Evaluation) -> &KindScore| {
        move |runs: &[Evaluation]| {
            let all = sum(runs, |run| of(run).features);
            percent(all - sum(runs, |run| of(run).surplus()), all)
        }
    };
    let recall = |of: fn(&Evaluation) -> &KindScore| {
        move |runs: &[Evaluation]| {
            percent(
                sum(runs, |run| of(run).matched),
                sum(runs, |run| of(run).visible),
            )
        }
    };
    let lines: fn(&Evaluation) -> &KindScore = |run| &run.confirmed.lines;
    let points: fn(&Evaluation) -> &KindScore = |run| &run.confirmed.points;
    let pillars = |runs: &[Evaluation]| {
        let count = |of: fn(&KindScore) -> u64| {
            let circles = runs.iter().filter_map(|run| run.confirmed.circles.as_ref());
            circles.map(of).sum()
        };
        percent(count(|kind| kind.matched), count(|kind| kind.visible))
    };
    let used = |runs: &[Evaluation]| {
        percent(
            sum(runs, |run| run.labels.given()),
            sum(runs, |run| run.labels.arcs),
        )
    };
    let wrong = |runs: &[Evaluation]| {
        percent(
            sum(runs, |run| run.labels.wrong_labels()),
            sum(runs, |run| run.labels.given()),
        )
    };
    let off = |runs: &[Evaluation]| mean(runs, |run| Some(lines(run).errors.rho?.mean * 1e3), 1);
    let away =
        |runs: &[Evaluation]| mean(runs, |run| Some(points(run).errors.position?.mean * 1e3), 1);
    markdown(
        rows,
        &[
            ("readings used %", &used),
            ("wrongly %", &wrong),
            ("lines right %", &precision(lines)),
            ("found %", &recall(lines)),
            ("off by mm", &off),
            ("points right %", &precision(points)),
            ("found %", &recall(points)),
            ("off by mm", &away),
            ("pillars found %", &pillars),
        ],
    )
}

/// What each method makes of a log of which nobody knows the truth.
pub fn of_log(log: &Log, rules: &Rules) -> String {
    let mut text = String::from(
        "| rule | arcs | labelled % | lines | points | tentative | readings in features |\n\
         |---|---:|---:|---:|---:|---:|---:|\n",
    );
    for (name, outcome) in rules.replay(log) {
        let confirmed = |kind| {
            let is = |f: &&MapFeature| f.status == Status::Confirmed && f.shape.kind() == kind;
            outcome.map.iter().filter(is).count()
        };
        let tentative = outcome.map.iter().filter(|f| f.status == Status::Tentative);
        let arcs = outcome.reports.len() as u64;
        let labelled = ["contact", "intersection"].map(|label| outcome.labelled(label));
        let _ = writeln!(
            text,
            "| {name} | {arcs} | {} | {} | {} | {} | {} |",
            percent(labelled.iter().sum(), arcs),
            confirmed(Kind::Line),
            confirmed(Kind::Point),
            tentative.count(),
            outcome.associated_readings,
        );
    }
    text
}
