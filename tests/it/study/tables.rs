//! The study's scores as Markdown.

use std::fmt::Write as _;

use tmam_replay::tools::evaluate::Evaluation;
use tmam_replay::tools::evaluate::map::{KindScore, MapScore};
use tmam_replay::tools::evaluate::matching::Nees;
use tmam_replay::tools::evaluate::suspects::SuspectScore;

use super::drives::Case;
use super::table_one;

/// A case, a rule, and its scores over the seeds.
pub type Row = (Case, &'static str, Vec<Evaluation>);

/// A column: its head, and what a row has there.
type Column<'a> = (&'a str, &'a dyn Fn(&[Evaluation]) -> String);

/// Every table of the page.
pub fn all(rows: &[Row], seeds: u64) -> String {
    let mut text = String::new();
    section(&mut text, "Labels and suspects", &labels(rows));
    section(&mut text, "Suspects under other gates", &gates(rows));
    let of = format!("exact of {seeds}");
    section(&mut text, "The whole map", &map(rows, &of, |e| &e.map));
    section(
        &mut text,
        "The confirmed map",
        &map(rows, &of, |e| &e.confirmed),
    );
    section(&mut text, "Covariances", &covariances(rows));
    section(&mut text, "Table I", &table_one::table(rows, seeds));
    text
}

/// Ten laps, and odometry that drifts.
pub fn others(rows: &[Row], seeds: u64) -> String {
    let mut text = String::new();
    section(
        &mut text,
        "Ten laps, and drift",
        &summary(rows, "rule", seeds),
    );
    text
}

/// Sigma as measured from the ranges.
pub fn measured(rows: &[Row], seeds: u64) -> String {
    let mut text = String::new();
    section(
        &mut text,
        "Without variance in the messages",
        &summary(rows, "rule", seeds),
    );
    text
}

/// Rough walls, cross-talk and posts in a row.
pub fn worlds(rows: &[Row], seeds: u64) -> String {
    let lines = |e: &Evaluation| e.confirmed.lines.spurious.len() as u64;
    let points = |e: &Evaluation| e.confirmed.points.spurious.len() as u64;
    let missed =
        |e: &Evaluation| (e.confirmed.lines.missed.len() + e.confirmed.points.missed.len()) as u64;
    let twice = |e: &Evaluation| {
        (e.confirmed.lines.duplicates.len() + e.confirmed.points.duplicates.len()) as u64
    };
    let table = table(
        rows,
        &[
            ("labelled %", &|r| {
                percent(sum(r, |e| e.labels.given()), sum(r, |e| e.labels.arcs))
            }),
            ("wrong of given %", &|r| {
                percent(
                    sum(r, |e| e.labels.wrong_labels()),
                    sum(r, |e| e.labels.given()),
                )
            }),
            ("oblique arcs", &|r| each(r, |e| e.labels.oblique.arcs)),
            ("right %", &|r| {
                percent(
                    sum(r, |e| e.labels.oblique.right),
                    sum(r, |e| e.labels.oblique.arcs),
                )
            }),
            ("found %", &|r| {
                percent(
                    sum(r, |e| e.labels.oblique.right),
                    sum(r, |e| e.labels.other.get("oblique").copied().unwrap_or(0)),
                )
            }),
            ("walls covered %", &|r| {
                let covered: f64 = r.iter().filter_map(|e| e.confirmed.lines.covered).sum();
                format!("{:.1}", 100.0 * covered / r.len().max(1) as f64)
            }),
            ("missed", &|r| each(r, missed)),
            ("twice", &|r| each(r, twice)),
            ("false lines", &|r| each(r, lines)),
            ("false points", &|r| each(r, points)),
        ],
    );
    format!(
        "\n### Rough walls, false echoes and posts\n\nMaps are the confirmed ones, counts are per seed, of {seeds} \
         seeds.\n\n{table}"
    )
}

/// Odometry that drifts, and poses that are estimated.
pub fn poses(rows: &[Row], seeds: u64) -> String {
    let table = paths(rows, seeds);
    format!(
        "\n### Poses estimated with the features\n\nThe noise-aware rule. Maps are the confirmed ones, counts are \
         per seed. The path error is the root mean square\nof positions with the first pose laid on the true one, \
         mean over the seeds; *aligned*: with the whole path laid on the\ntrue one; *told*: with the noise of odometry \
         in the configuration.\n\n{table}"
    )
}

/// The same where more is wrong, and farther round.
pub fn harder(rows: &[Row], seeds: u64) -> String {
    format!("\n### Where more is wrong\n\n{}", paths(rows, seeds))
}

fn paths(rows: &[Row], seeds: u64) -> String {
    let corrected = format!("corrected of {seeds}");
    let exact = format!("exact of {seeds}");
    let nees = |e: &Evaluation| e.path.and_then(|path| path.nees);
    let rms = |e: &Evaluation| e.path.map(|path| 1e3 * path.from_first.rms);
    let aligned = |e: &Evaluation| e.path.map(|path| 1e3 * path.aligned.rms);
    let missed =
        |e: &Evaluation| (e.confirmed.lines.missed.len() + e.confirmed.points.missed.len()) as u64;
    let twice = |e: &Evaluation| {
        (e.confirmed.lines.duplicates.len() + e.confirmed.points.duplicates.len()) as u64
    };
    let spurious = |e: &Evaluation| {
        (e.confirmed.lines.spurious.len() + e.confirmed.points.spurious.len()) as u64
    };
    let table = table(
        rows,
        &[
            (&corrected, &|r| {
                r.iter().filter(|e| nees(e).is_some()).count().to_string()
            }),
            ("path error, mm", &|r| mean(r, rms, 1)),
            ("aligned", &|r| mean(r, aligned, 1)),
            ("wrong of given %", &|r| {
                percent(
                    sum(r, |e| e.labels.wrong_labels()),
                    sum(r, |e| e.labels.given()),
                )
            }),
            (&exact, &|r| {
                sum(r, |e| u64::from(e.confirmed.exact)).to_string()
            }),
            ("missed", &|r| each(r, missed)),
            ("twice", &|r| each(r, twice)),
            ("else spurious", &|r| each(r, spurious)),
            ("NEES lines", &|r| {
                mean_nees(r, |e| e.confirmed.lines.errors.nees)
            }),
            ("NEES points", &|r| {
                mean_nees(r, |e| e.confirmed.points.errors.nees)
            }),
            ("NEES poses", &|r| mean(r, nees, 2)),
        ],
    );
    table.replacen("| room | rule |", "| drive | poses |", 1)
}

/// A mean over the seeds that have it.
pub fn mean(runs: &[Evaluation], of: impl Fn(&Evaluation) -> Option<f64>, digits: usize) -> String {
    let values: Vec<f64> = runs.iter().filter_map(of).collect();
    match values.len() {
        0 => "-".to_owned(),
        n => format!("{:.digits$}", values.iter().sum::<f64>() / n as f64),
    }
}

/// The noise-aware rule without each of its switches.
pub fn switches(rows: &[Row], seeds: u64) -> String {
    let mut text = String::new();
    section(
        &mut text,
        "Without one switch",
        &summary(rows, "without", seeds),
    );
    text
}

/// One row for all that matters of a case.
fn summary(rows: &[Row], second: &str, seeds: u64) -> String {
    let exact = format!("exact of {seeds}");
    let twice = |e: &Evaluation| {
        (e.confirmed.lines.duplicates.len() + e.confirmed.points.duplicates.len()) as u64
    };
    let spurious = |e: &Evaluation| {
        (e.confirmed.lines.spurious.len() + e.confirmed.points.spurious.len()) as u64
    };
    let missed =
        |e: &Evaluation| (e.confirmed.lines.missed.len() + e.confirmed.points.missed.len()) as u64;
    let text = table(
        rows,
        &[
            ("labelled %", &|r| {
                percent(sum(r, |e| e.labels.given()), sum(r, |e| e.labels.arcs))
            }),
            ("wrong of given %", &|r| {
                percent(
                    sum(r, |e| e.labels.wrong_labels()),
                    sum(r, |e| e.labels.given()),
                )
            }),
            (&exact, &|r| {
                sum(r, |e| u64::from(e.confirmed.exact)).to_string()
            }),
            ("missed", &|r| each(r, missed)),
            ("twice", &|r| each(r, twice)),
            ("else spurious", &|r| each(r, spurious)),
            ("NEES lines", &|r| {
                mean_nees(r, |e| e.confirmed.lines.errors.nees)
            }),
            ("NEES points", &|r| {
                mean_nees(r, |e| e.confirmed.points.errors.nees)
            }),
            ("Table I, all twelve", &|r| {
                table_one::complete(r).to_string()
            }),
        ],
    );
    format!(
        "Maps are the confirmed ones; exact and Table I are of {seeds} seeds, counts per seed.\n\n{}",
        text.replacen("| room | rule |", &format!("| room | {second} |"), 1)
    )
}

fn section(text: &mut String, title: &str, table: &str) {
    let _ = write!(text, "\n### {title}\n\n{table}");
}

/// A table whose first two columns are the case and the rule.
pub fn table(rows: &[Row], columns: &[Column<'_>]) -> String {
    let mut text = "| room | rule |".to_owned();
    for (head, _) in columns {
        let _ = write!(text, " {head} |");
    }
    text.push_str("\n|---|---|");
    text.push_str(&"---:|".repeat(columns.len()));
    text.push('\n');
    for (case, rule, runs) in rows {
        let _ = write!(text, "| {} | {rule} |", case.name());
        for (_, cell) in columns {
            let _ = write!(text, " {} |", cell(runs));
        }
        text.push('\n');
    }
    text
}

/// Sums a count over the seeds.
pub fn sum(runs: &[Evaluation], of: impl Fn(&Evaluation) -> u64) -> u64 {
    runs.iter().map(of).sum()
}

/// A share of sums over the seeds, per cent.
pub fn percent(part: u64, whole: u64) -> String {
    match whole {
        0 => "-".to_owned(),
        _ => format!("{:.1}", 100.0 * part as f64 / whole as f64),
    }
}

/// A count per seed.
pub fn each(runs: &[Evaluation], of: impl Fn(&Evaluation) -> u64) -> String {
    format!("{:.1}", sum(runs, of) as f64 / runs.len().max(1) as f64)
}

fn labels(rows: &[Row]) -> String {
    let lines = |e: &Evaluation| {
        e.labels.contact.arcs.line + e.labels.intersection.arcs.line + e.labels.unidentified.line
    };
    let points = |e: &Evaluation| {
        e.labels.contact.arcs.point + e.labels.intersection.arcs.point + e.labels.unidentified.point
    };
    let share =
        |runs: &[Evaluation],
         part: &dyn Fn(&Evaluation) -> u64,
         whole: &dyn Fn(&Evaluation) -> u64| { percent(sum(runs, part), sum(runs, whole)) };
    table(
        rows,
        &[
            ("labelled %", &|r| {
                share(r, &|e| e.labels.given(), &|e| e.labels.arcs)
            }),
            ("wrong of given %", &|r| {
                share(r, &|e| e.labels.wrong_labels(), &|e| e.labels.given())
            }),
            ("contact right %", &|r| {
                share(r, &|e| e.labels.contact.arcs.line, &|e| {
                    e.labels.contact.arcs.total()
                })
            }),
            ("found %", &|r| {
                share(r, &|e| e.labels.contact.arcs.line, &lines)
            }),
            ("intersection right %", &|r| {
                share(r, &|e| e.labels.intersection.arcs.point, &|e| {
                    e.labels.intersection.arcs.total()
                })
            }),
            ("found %", &|r| {
                share(r, &|e| e.labels.intersection.arcs.point, &points)
            }),
            ("wrong found by suspects %", &|r| {
                share(r, &|e| suspects(e).configured.wrong_found, &|e| {
                    suspects(e).wrong
                })
            }),
            ("right suspected %", &|r| {
                share(r, &|e| suspects(e).configured.right_accused, &|e| {
                    suspects(e).right
                })
            }),
        ],
    )
}

fn suspects(evaluation: &Evaluation) -> &SuspectScore {
    (evaluation.suspects.as_ref()).expect("the study is of TMAM, whose map predicts labels")
}

fn gates(rows: &[Row]) -> String {
    let at = |place: usize| {
        move |runs: &[Evaluation]| {
            let gate = |e: &Evaluation| suspects(e).gates[place].score;
            format!(
                "{} / {}",
                percent(
                    sum(runs, |e| gate(e).wrong_found),
                    sum(runs, |e| suspects(e).wrong)
                ),
                percent(
                    sum(runs, |e| gate(e).right_accused),
                    sum(runs, |e| suspects(e).right)
                ),
            )
        }
    };
    let cells = [at(0), at(1), at(2), at(3)];
    let heads = ["chi2 2.71", "3.84", "6.63", "10.83"];
    let columns: Vec<Column<'_>> = heads
        .iter()
        .zip(&cells)
        .map(|(head, cell)| (*head, cell as &dyn Fn(&[Evaluation]) -> String))
        .collect();
    format!(
        "Wrong labels found and right labels suspected, both %.\n\n{}",
        table(rows, &columns)
    )
}

fn map(rows: &[Row], exact: &str, of: fn(&Evaluation) -> &MapScore) -> String {
    let count = |kind: fn(&MapScore) -> &KindScore, what: fn(&KindScore) -> u64| {
        move |runs: &[Evaluation]| each(runs, |e| what(kind(of(e))))
    };
    let lines: fn(&MapScore) -> &KindScore = |m| &m.lines;
    let points: fn(&MapScore) -> &KindScore = |m| &m.points;
    table(
        rows,
        &[
            (exact, &|r| sum(r, |e| u64::from(of(e).exact)).to_string()),
            ("lines right", &count(lines, |k| k.matches.len() as u64)),
            ("missed", &count(lines, |k| k.missed.len() as u64)),
            ("twice", &count(lines, |k| k.duplicates.len() as u64)),
            ("else spurious", &count(lines, |k| k.spurious.len() as u64)),
            ("walls covered %", &|r| {
                let covered: f64 = r.iter().filter_map(|e| lines(of(e)).covered).sum();
                format!("{:.1}", 100.0 * covered / r.len().max(1) as f64)
            }),
            ("points right", &count(points, |k| k.matches.len() as u64)),
            ("missed", &count(points, |k| k.missed.len() as u64)),
            ("twice", &count(points, |k| k.duplicates.len() as u64)),
            ("else spurious", &count(points, |k| k.spurious.len() as u64)),
        ],
    )
}

/// The normalised error squared, mean over features and seeds.
pub fn mean_nees(runs: &[Evaluation], of: fn(&Evaluation) -> Nees) -> String {
    let (mut total, mut features) = (0.0, 0);
    for nees in runs.iter().map(of) {
        total += nees.mean.unwrap_or(0.0) * nees.features as f64;
        features += nees.features;
    }
    match features {
        0 => "-".to_owned(),
        n => format!("{:.2}", total / n as f64),
    }
}

fn covariances(rows: &[Row]) -> String {
    let nees = |of: fn(&Evaluation) -> Nees| move |runs: &[Evaluation]| mean_nees(runs, of);
    format!(
        "Normalised error squared per degree of freedom, mean over features and seeds.\n\n{}",
        table(
            rows,
            &[
                ("confirmed lines", &nees(|e| e.confirmed.lines.errors.nees)),
                (
                    "confirmed points",
                    &nees(|e| e.confirmed.points.errors.nees)
                ),
                (
                    "lines of one run",
                    &nees(|e| e.extracted.lines.pure_errors.nees)
                ),
                (
                    "points of one run",
                    &nees(|e| e.extracted.points.pure_errors.nees)
                ),
            ],
        )
    )
}
