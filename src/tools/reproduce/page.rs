//! The page.

use std::fmt::Write as _;

use super::counts::Counts;
use super::experiment::{Experiment, Reproduction};
use super::paper::{self, TableRow};
use crate::core::config::Rule;
use crate::core::geometry::angle_between;
use crate::core::rounding::fixed;
use crate::core::tmam::feature::{Point, Shape, Status};
use crate::core::world::Reflector;

/// The noise and the seed of `docs/table1.md`.
pub const OF_THE_DOCS: (f64, u64) = (0.003, 1);

/// Table I, the counts, and where the paper's rule comes nearest to them, as Markdown.
pub fn page(reproduction: &Reproduction) -> String {
    let millimetres = reproduction.sigma * 1e3;
    let made = match (reproduction.sigma, reproduction.seed) {
        (sigma, seed) if (sigma, seed) == OF_THE_DOCS => {
            "Made by `tmam reproduce -o docs`; a test holds this page to it".to_owned()
        }
        (sigma, seed) => format!("Made by `tmam reproduce --noise {sigma} --seed {seed}`"),
    };
    let mut text = format!(
        "# The paper's experiment\n\n\
         {made}. The paper's room in 150 steps of 12 cm past \
         sixteen sonars, {millimetres} mm of\nnoise, seed {}. Lengths are centimetres and angles radians, as in the \
         paper.\n\n\
         ## Table I\n\n\
         | feature | actual | the paper's estimate | ours, its rule | ours, noise-aware |\n|---|---:|---:|---:|---:|\n",
        reproduction.seed
    );
    for (index, (point, line)) in paper::POINTS.iter().zip(&paper::LINES).enumerate() {
        for (name, row, reflector) in [
            ("point", point, Reflector::Point(index)),
            ("line", line, Reflector::Line(index)),
        ] {
            let ours = (reproduction.rules.each_ref()).map(|one| estimate(one, row, reflector));
            let [papers, noise_aware] = ours;
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "| {} {name} | {} | {} | {papers} | {noise_aware} |",
                row.number,
                pair(row.actual),
                pair(row.estimated),
            );
        }
    }
    let [papers, _] = &reproduction.rules;
    let too_many = papers.outcome.map.len().saturating_sub(12);
    let _ = writeln!(
        text,
        "\nA dash: nothing in the map is that feature. Of a wall or a corner that is there several times the best one \
         is shown; under the\npaper's rule the map has {too_many} features more than the twelve. \
         [evaluation.md](evaluation.md#table-i) has twenty seeds.\n\n\
         ## The counts\n\n{HEAD}"
    );
    row(&mut text, "the paper", &Counts::OF_THE_PAPER);
    for one in &reproduction.rules {
        let name = match one.rule {
            Rule::Paper => "ours, its rule",
            Rule::NoiseAware => "ours, noise-aware",
        };
        row(&mut text, name, &one.counts);
    }
    let _ = writeln!(
        text,
        "\nOf the readings of this room half have no echo: smooth walls are heard only by the sonar that faces \
         them. A reading that is associated counts once.\n\n\
         ## Where the paper's rule comes nearest to the paper's counts\n\n\
         The paper gives neither its noise nor alpha, beta and gamma. Of {} combinations these come nearest, by the \
         sum of the\nlogarithms of the ratios of the five counts, one added to each:\n\n{HEAD}",
        reproduction.tried
    );
    for trial in &reproduction.nearest {
        let name = format!(
            "{} mm, alpha {}, beta {}, gamma {} deg",
            trial.sigma * 1e3,
            trial.alpha,
            1.0 / trial.alpha,
            trial.gamma
        );
        row(&mut text, &name, &trial.counts);
    }
    text.push_str(FIGURES);
    text
}

const HEAD: &str = "\
| | readings | associated | points extracted | lines extracted | points in the map | lines in the map |\n\
|---|---:|---:|---:|---:|---:|---:|";

const FIGURES: &str = "
## Figures 5 and 6

What was extracted from single runs under the noise-aware rule, and the map that came of it; pale the room, green
the path.

![The extracted features in the room](figure5.svg)

![The map: six walls and six corners](figure6.svg)
";

fn row(text: &mut String, name: &str, counts: &Counts) {
    let ([ep, el], [rp, rl]) = (counts.extracted, counts.registered);
    let (readings, associated) = (counts.readings, counts.associated);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "| {name} | {readings} | {associated} | {ep} | {el} | {rp} | {rl} |"
    );
}

/// Centimetres and radians.
fn pair((rho, angle): (f64, f64)) -> String {
    format!("{}, {}", fixed(rho * 100.0, 2), fixed(angle, 4))
}

/// What the map has of a feature.
fn estimate(experiment: &Experiment, row: &TableRow, reflector: Reflector) -> String {
    let map = &experiment.evaluation.map;
    let mut matches = map.points.matches.iter().chain(&map.lines.matches);
    let found = matches.find(|found| found.reflector == reflector);
    let feature = found.and_then(|found| {
        let mut features = experiment.outcome.map.iter();
        features.find(|feature| feature.id == found.feature)
    });
    let Some(feature) = feature else {
        return "-".to_owned();
    };
    let estimate = pair(match feature.shape {
        Shape::Point(point) => point.polar(),
        // Not in this experiment.
        Shape::Circle(circle) => Point::without_covariance(circle.center).polar(),
        // (rho, theta) and (-rho, theta + pi) are one line: the one that the paper has.
        Shape::Line(line) => {
            let flipped = line.flipped();
            let off = |theta: f64| angle_between(theta, row.actual.1);
            if off(flipped.theta) < off(line.theta) {
                (flipped.rho, flipped.theta)
            } else {
                (line.rho, line.theta)
            }
        }
    });
    match feature.status {
        Status::Confirmed => estimate,
        Status::Tentative => format!("({estimate})"),
    }
}
