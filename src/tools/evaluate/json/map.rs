//! The map in an evaluation for machines.

use serde::Serialize;

use crate::core::rounding::{optional, rounded};
use crate::core::world::Reflector;
use crate::tools::evaluate::errors::Errors;
use crate::tools::evaluate::map::{KindScore, MapScore, Match};
use crate::tools::evaluate::matching;
use crate::tools::evaluate::truth::Truth;

#[derive(Serialize)]
pub struct Map<'a> {
    exact: bool,
    lines: Features<'a>,
    points: Features<'a>,
}

#[derive(Serialize)]
struct Features<'a> {
    features: u64,
    visible: u64,
    matched: u64,
    unasked: u64,
    missed: Vec<Missed>,
    spurious: &'a [u32],
    duplicates: Vec<Named>,
    shared: Vec<Named>,
    parts: &'a [u32],
    errors: &'a Errors,
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional")]
    covered: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional")]
    overrun: Option<f64>,
    matches: Vec<Pair>,
}

#[derive(Serialize)]
struct Missed {
    index: usize,
    echoes: u64,
}

/// A feature and the wall or point that it shows.
#[derive(Serialize)]
struct Named {
    id: u32,
    index: usize,
}

#[derive(Serialize)]
struct Pair {
    id: u32,
    index: usize,
    #[serde(flatten)]
    error: ErrorFields,
    #[serde(serialize_with = "optional")]
    nees: Option<f64>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum ErrorFields {
    Line { rho: f64, theta: f64 },
    Point { distance: f64 },
}

pub fn map<'a>(score: &'a MapScore, truth: &Truth) -> Map<'a> {
    Map {
        exact: score.is_exact(),
        lines: features(&score.lines, truth),
        points: features(&score.points, truth),
    }
}

fn features<'a>(score: &'a KindScore, truth: &Truth) -> Features<'a> {
    Features {
        features: score.features,
        visible: score.visible,
        matched: score.matched(),
        unasked: score.unasked,
        missed: score
            .missed
            .iter()
            .map(|reflector| Missed {
                index: index(*reflector),
                echoes: truth.echoes(*reflector),
            })
            .collect(),
        spurious: &score.spurious,
        duplicates: named(&score.duplicates),
        shared: named(&score.shared),
        parts: &score.parts,
        errors: &score.errors,
        covered: score.covered,
        overrun: score.overrun,
        matches: score.matches.iter().map(pair).collect(),
    }
}

fn named(pairs: &[(u32, Reflector)]) -> Vec<Named> {
    let pairs = pairs.iter();
    pairs
        .map(|(id, reflector)| Named {
            id: *id,
            index: index(*reflector),
        })
        .collect()
}

fn pair(found: &Match) -> Pair {
    Pair {
        id: found.feature,
        index: index(found.reflector),
        error: match found.comparison.error {
            matching::Error::Line { rho, theta, .. } => ErrorFields::Line {
                rho: rounded(rho),
                theta: rounded(theta),
            },
            matching::Error::Point { distance } => ErrorFields::Point {
                distance: rounded(distance),
            },
        },
        nees: found.comparison.nees,
    }
}

pub fn index(reflector: Reflector) -> usize {
    match reflector {
        Reflector::Line(index) | Reflector::Point(index) => index,
    }
}
