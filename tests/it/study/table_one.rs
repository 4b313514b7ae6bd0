//! The twelve features of the paper's Table I: which are estimated better than the paper did.

use std::fmt::Write as _;

use tmam_replay::core::geometry::{Vec2, unit};
use tmam_replay::core::world::{Reflector, World};
use tmam_replay::tools::evaluate::Evaluation;
use tmam_replay::tools::evaluate::matching::Error;
use tmam_replay::tools::reproduce::paper::{LINES, POINTS};

use super::tables::Row;

/// The numbers of the features in Table I: corners, then walls.
const NUMBERS: [u8; 12] = [1, 3, 5, 7, 9, 11, 2, 4, 6, 8, 10, 12];

/// Which of the twelve features of a confirmed map are closer to the truth than the paper's.
fn closer(evaluation: &Evaluation) -> [bool; 12] {
    let map = &evaluation.confirmed;
    let mut closer = [false; 12];
    for found in &map.points.matches {
        if let (Reflector::Point(index), Error::Point { distance }) =
            (found.reflector, found.comparison.error)
        {
            let (rho, alpha) = POINTS[index].estimated;
            let truth: Vec2 = World::room().points()[index];
            closer[index] = distance < (unit(alpha) * rho - truth).norm();
        }
    }
    for found in &map.lines.matches {
        if let (
            Reflector::Line(index),
            Error::Line {
                rho_at_origin: rho,
                theta,
                ..
            },
        ) = (found.reflector, found.comparison.error)
        {
            let (estimate, truth) = (LINES[index].estimated, LINES[index].actual);
            closer[6 + index] = rho.abs() < (estimate.0 - truth.0).abs()
                && theta.abs() < (estimate.1 - truth.1).abs();
        }
    }
    closer
}

/// In how many seeds all twelve are closer.
pub fn complete(runs: &[Evaluation]) -> usize {
    let all = |run: &&Evaluation| closer(run).iter().all(|closer| *closer);
    runs.iter().filter(all).count()
}

/// How many of the twelve are closer, and in how many seeds each is not.
pub fn table(rows: &[Row], seeds: u64) -> String {
    let mut text = format!(
        "Features of the confirmed map that are closer to the actual values than the paper's estimates: \
         points by\ndistance, lines by rho and by theta.\n\n\
         | room | rule | all twelve, of {seeds} | closer, of 12 | seeds in which a feature of Table I is not |\n\
         |---|---|---:|---:|---|\n"
    );
    for (case, rule, runs) in rows {
        let all: Vec<[bool; 12]> = runs.iter().map(closer).collect();
        let complete = all
            .iter()
            .filter(|closer| closer.iter().all(|c| *c))
            .count();
        let count: usize = all.iter().flatten().filter(|c| **c).count();
        let mut failing: Vec<(u8, usize)> = NUMBERS
            .iter()
            .enumerate()
            .map(|(place, number)| (*number, all.iter().filter(|closer| !closer[place]).count()))
            .filter(|(_, seeds)| *seeds > 0)
            .collect();
        failing.sort_unstable();
        let failing: Vec<String> = failing
            .iter()
            .map(|(number, seeds)| format!("{number}: {seeds}"))
            .collect();
        let _ = writeln!(
            text,
            "| {} | {rule} | {complete} | {:.1} | {} |",
            case.name(),
            count as f64 / all.len().max(1) as f64,
            if failing.is_empty() {
                "-".to_owned()
            } else {
                failing.join(", ")
            },
        );
    }
    text
}
