//! The twelve features of the paper's Table I: which are estimated better than the paper did.

use std::fmt::Write as _;

use tmam_replay::core::geometry::{Vec2, unit};
use tmam_replay::core::world::{Reflector, World};
use tmam_replay::tools::evaluate::Evaluation;
use tmam_replay::tools::evaluate::matching::Error;

use super::tables::Row;

/// What the paper estimated of the room's corners, in the room's order: metres and radians.
const POINTS: [(f64, f64); 6] = [
    (0.045_357, -0.8192),
    (4.0522, 0.004),
    (4.444, 0.4605),
    (8.2413, 0.2442),
    (9.4311, 0.5628),
    (5.0629, 1.5735),
];

/// And of its walls: rho and theta.
const LINES: [(f64, f64); 6] = [
    (0.005_839, 1.5686),
    (4.0273, 0.0161),
    (1.9798, 1.5754),
    (8.0712, 0.0222),
    (5.0045, 1.5702),
    (0.020_828, 0.006),
];

/// And what is true of its walls.
const TRUE_LINES: [(f64, f64); 6] = [
    (0.0, std::f64::consts::FRAC_PI_2),
    (4.0, 0.0),
    (2.0, std::f64::consts::FRAC_PI_2),
    (8.0, 0.0),
    (5.0, std::f64::consts::FRAC_PI_2),
    (0.0, 0.0),
];

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
            let (rho, alpha) = POINTS[index];
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
            let (estimate, truth) = (LINES[index], TRUE_LINES[index]);
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
