//! `docs/methods.md`: TMAM and its rivals on the same logs. One command makes every table of the page anew.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use tmam_replay::core::config::Config;
use tmam_replay::core::log::Log;
use tmam_replay::core::tmam::feature::{MapFeature, Status};
use tmam_replay::core::tmam::label::Kind;
use tmam_replay::core::world::Reflector;
use tmam_replay::io::log::read;
use tmam_replay::tools::evaluate::Evaluation;
use tmam_replay::tools::evaluate::map::KindScore;

use super::drives::{Case, Drive, METHODS, Rules};
use super::tables::{Row, mean, mean_nees, percent, sum, table as markdown};
use super::{FEWER_SEEDS, at_both, cases, hold_on, rows, updating};
use crate::support::{Bench, shared};

/// The page, and what makes its tables anew.
const PAGE: [&str; 2] = [
    "docs/methods.md",
    "TMAM_UPDATE_DOCS=1 cargo test --release --test it -- --include-ignored study::methods",
];

/// The rules that tell what crossings of several sonars' arcs are good for.
const CROSSINGS: [&str; 3] = ["tmam, without crossings", "tmam", "tbf"];

/// What dense scans show of the first seed beside: the methods that other drives give little to.
const NEEDING_SCANS: [&str; 3] = ["tmam", "rcd", "crowley"];

const OFFICE: Drive = Drive::Office {
    laps: 1,
    drifts: false,
};

/// Replays of a log whose processor time is measured together.
const REPLAYS: u32 = 10;

#[test]
#[ignore = "takes minutes; docs/methods.md says how to run it"]
fn the_page_holds_what_the_study_finds() {
    let mut found = rows(&sparse(), FEWER_SEEDS, &Rules::methods(false));
    let pillars = at_3_mm(Drive::Pillars(10));
    let with_circles = Rules::methods_and_circles();
    found.extend(rows(&[pillars], FEWER_SEEDS, &with_circles));
    let scans = at_both(&[Drive::Scans]);
    found.extend(rows(&scans, FEWER_SEEDS, &Rules::methods(true)));
    let text = table(&found);
    hold_on(PAGE, "methods", &text);
    hold_on(PAGE, "better", &better(&text));

    let rough = rows(
        &rough(),
        FEWER_SEEDS,
        &Rules::methods(false).only(&CROSSINGS),
    );
    let of_a_case = |a: &Row, b: &Row| a.0 == b.0;
    let helped = found.chunk_by(of_a_case).filter(|rows| is_helped(rows));
    let all: Vec<&[Row]> = helped.chain(rough.chunk_by(of_a_case)).collect();
    hold_on(PAGE, "crossings", &crossings(&all));
    if updating() {
        hold_on(PAGE, "time", &time());
    }
}

/// Two worlds of the same study, so that a method that changes is seen by every run of the tests.
#[test]
fn the_page_holds_what_the_first_seed_gives() {
    let outliers = Case {
        drive: Drive::Outliers,
        sigma: 0.010,
    };
    let mut found = rows(&[outliers], 1, &Rules::methods(false));
    let scans = at_3_mm(Drive::Scans);
    let rules = Rules::methods(true).only(&NEEDING_SCANS);
    found.extend(rows(&[scans], 1, &rules));
    hold_on(PAGE, "first seed", &table(&found));
}

/// A real log, of which nobody knows the truth.
#[test]
fn the_page_holds_what_each_method_makes_of_a_house() {
    let Some(path) = shared("house_run1.mcap") else {
        return;
    };
    let log = read(&path, &Config::default()).unwrap();
    hold_on(PAGE, "house", &of_log(&log, &Rules::methods(false)));
}

fn at_3_mm(drive: Drive) -> Case {
    Case {
        drive,
        sigma: 0.003,
    }
}

/// The drives that are no dense scans.
fn sparse() -> Vec<Case> {
    let drift = [Drive::LittleDrift, Drive::MuchDrift];
    let others = drift.into_iter().chain([OFFICE, Drive::Loft(0)]);
    (cases().into_iter().chain(others.map(at_3_mm)))
        .chain(at_both(&[Drive::Outliers]))
        .collect()
}

/// Where false points are looked for.
fn rough() -> Vec<Case> {
    let loft = Case {
        drive: Drive::Loft(50),
        sigma: 0.010,
    };
    let mut rough = at_both(&[30, 60, 100].map(Drive::Rough));
    rough.push(loft);
    rough
}

/// How the confirmed map of each did.
fn table(rows: &[Row]) -> String {
    let precision = |of: fn(&Evaluation) -> &KindScore| {
        move |runs: &[Evaluation]| {
            let all = sum(runs, |run| of(run).features);
            percent(all - sum(runs, |run| of(run).surplus()), all)
        }
    };
    let recall = |of: fn(&Evaluation) -> &KindScore| move |runs: &[Evaluation]| found(runs, of);
    let lines: fn(&Evaluation) -> &KindScore = |run| &run.confirmed.lines;
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
            ("lines found %", &recall(lines)),
            ("lines off mm", &off),
            ("points right %", &precision(points)),
            ("points found %", &recall(points)),
            ("points off mm", &away),
            ("pillars found %", &pillars),
        ],
    )
}

/// The share that the maps have of what echoed often enough, per cent.
fn found(runs: &[Evaluation], of: fn(&Evaluation) -> &KindScore) -> String {
    percent(
        sum(runs, |run| of(run).matched),
        sum(runs, |run| of(run).visible),
    )
}

/// Where a rival, or the paper's rule, has a better number than TMAM in a table of these methods. That more
/// readings are used is not better.
fn better(table: &str) -> String {
    let mut text = String::from("| room | what | tmam | better |\n|---|---|---:|---|\n");
    let cells = |line| -> Vec<&str> { str::split(line, '|').map(str::trim).collect() };
    let mut lines = table.lines().map(cells);
    let heads = lines.next().unwrap();
    let rows: Vec<Vec<&str>> = lines.skip(1).collect();
    for of_a_room in rows.chunk_by(|a, b| a[1] == b[1]) {
        let (tmam, others) = of_a_room.split_first().unwrap();
        let is_other =
            |row: &&Vec<&str>| !row[2].starts_with("tmam") || row[2].ends_with("paper's rule");
        let others: Vec<&Vec<&str>> = others.iter().filter(is_other).collect();
        for (column, head) in heads.iter().enumerate().skip(4) {
            let Ok(ours) = tmam[column].parse::<f64>() else {
                continue;
            };
            let is_error = head.ends_with("mm") || head.starts_with("wrongly");
            let is_better = |row: &&&Vec<&str>| {
                let theirs = row[column].parse::<f64>();
                theirs.is_ok_and(|theirs| {
                    if is_error {
                        theirs < ours
                    } else {
                        theirs > ours
                    }
                })
            };
            let better = others.iter().filter(is_better);
            let better: Vec<String> = better
                .map(|row| format!("{} {}", row[2], row[column]))
                .collect();
            if !better.is_empty() {
                let _ = writeln!(
                    text,
                    "| {} | {head} | {ours:.1} | {} |",
                    tmam[1],
                    better.join("; ")
                );
            }
        }
    }
    text
}

/// Of the rows of a case those of a rule.
fn of_rule<'a>(rows: &'a [Row], rule: &str) -> &'a [Evaluation] {
    let row = rows.iter().find(|(_, name, _)| *name == rule);
    row.map(|(_, _, runs)| runs).unwrap()
}

/// Whether crossings find points in a case that are not found without.
fn is_helped(rows: &[Row]) -> bool {
    let [without, with, _] = CROSSINGS.map(|rule| found(of_rule(rows, rule), points));
    without != with
}

fn points(run: &Evaluation) -> &KindScore {
    &run.confirmed.points
}

/// What crossings of several sonars' arcs are good for, of the rows of each case.
fn crossings(cases: &[&[Row]]) -> String {
    let mut text = String::from(
        "| room | points found %: without crossings | with them | tbf | points that are none: without | with | tbf | \
         in no drive's map | NEES |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    for rows in cases {
        let runs = CROSSINGS.map(|rule| of_rule(rows, rule));
        let [without, with, tbf] = runs.map(|runs| found(runs, points));
        let [none_without, none, none_tbf] =
            runs.map(|runs| sum(runs, |run| points(run).surplus()));
        let _ = writeln!(
            text,
            "| {} | {without} | {with} | {tbf} | {none_without} | {none} | {none_tbf} | {} | {} |",
            rows[0].0.name(),
            never_found(runs[1]),
            mean_nees(runs[1], |run| points(run).errors.nees),
        );
    }
    text
}

/// How many points every run misses.
fn never_found(runs: &[Evaluation]) -> usize {
    let missed = runs.iter().map(|run| -> BTreeSet<Reflector> {
        points(run)
            .missed
            .iter()
            .map(|missed| missed.reflector)
            .collect()
    });
    missed
        .reduce(|a, b| &a & &b)
        .map_or(0, |missed| missed.len())
}

/// Milliseconds of processor time for a frame.
fn time() -> String {
    let drives = [
        ("stepwise", Drive::Stepwise),
        ("driven", Drive::Driven),
        ("much drift", Drive::MuchDrift),
        ("office once", OFFICE),
    ];
    let bench = Bench::new();
    let mut text = String::from("| rule |");
    for (name, drive) in drives {
        let _ = write!(text, " {name} |");
        bench.put(&format!("{name}.mcap"), at_3_mm(drive).log(1));
    }
    let _ = writeln!(text, "\n|---|{}", "---:|".repeat(drives.len()));
    for (rule, config) in METHODS.iter().filter(|(name, _)| *name != CROSSINGS[0]) {
        bench.put("tmam.toml", config);
        let _ = write!(text, "| {rule} |");
        for (name, _) in drives {
            let _ = write!(text, " {:.2} |", milliseconds_of_a_frame(&bench, name));
        }
        text.push('\n');
    }
    text
}

fn milliseconds_of_a_frame(bench: &Bench, log: &str) -> f64 {
    let replay = format!(
        "tmam replay '{log}.mcap' --config tmam.toml --no-causes --no-recording --features out.json -q"
    );
    let run = bench.sh(&format!(
        "for n in $(seq {REPLAYS}); do {replay} || exit; done; times"
    ));
    assert_eq!(run.code, 0, "{}", run.stderr);
    // The shell's own times, then those of what it started: user and system.
    let times = run.stdout.lines().last().unwrap();
    let seconds = times.split_whitespace().map(|time| {
        let (minutes, seconds) = time.trim_end_matches('s').split_once('m').unwrap();
        60.0 * minutes.parse::<f64>().unwrap() + seconds.parse::<f64>().unwrap()
    });
    let frames = bench.json("out.json")["counts"]["frames"].as_f64().unwrap();
    1e3 * seconds.sum::<f64>() / f64::from(REPLAYS) / frames
}

/// What each method makes of a log of which nobody knows the truth.
fn of_log(log: &Log, rules: &Rules) -> String {
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
