//! Which feature of a map is which wall or point.

use std::f64::consts::FRAC_PI_2;

use super::reflectors;
use crate::core::assignment::assign;
use crate::core::geometry::unit;
use crate::core::tmam::feature::{Kind, MapFeature, Segment, Shape};
use crate::core::world::Reflector;
use crate::tools::evaluate::matching::{Comparison, TrueLine, compare};
use crate::tools::evaluate::truth::{Origin, Truth};

/// A line shows another wall as well when it covers at least this share of the shorter of the two,
/// and is there twice when at least this share of it lies beside a better one.
const MOST: f64 = 0.5;

/// A map feature that is a wall or point of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// The feature's id.
    pub feature: u32,
    /// What it is.
    pub reflector: Reflector,
    /// How well it fits.
    pub comparison: Comparison,
}

/// Every feature of one kind in one of these, but for `shared`, which has some of the matched again.
#[derive(Debug, Clone, PartialEq)]
pub struct Pairing {
    /// One to one.
    pub matches: Vec<Match>,
    /// Walls or points without a feature of their own that a feature shows as well.
    pub shared: Vec<(u32, Reflector)>,
    /// What already has a better feature.
    pub duplicates: Vec<(u32, Reflector)>,
    /// Right, but not asked for.
    pub parts: Vec<u32>,
    /// None of the world's.
    pub spurious: Vec<u32>,
}

/// A feature that can be a wall or point: their places in the lists of both.
#[derive(Clone, Copy)]
struct Candidate {
    row: usize,
    column: usize,
    cost: f64,
    comparison: Comparison,
}

impl Pairing {
    /// Pairs the features of one kind.
    pub fn new(kind: Kind, features: &[&MapFeature], truth: &Truth) -> Self {
        let reflectors = reflectors(kind, truth);
        let candidates = candidates(features, &reflectors, truth);
        let costs: Vec<_> = candidates
            .iter()
            .map(|c| (c.row, c.column, c.cost))
            .collect();
        let pairs = assign(features.len(), reflectors.len(), &costs);
        let mut all = Self {
            matches: Vec::new(),
            shared: Vec::new(),
            duplicates: Vec::new(),
            parts: Vec::new(),
            spurious: Vec::new(),
        };
        let is_pair = |c: &&Candidate| pairs.contains(&(c.row, c.column));
        for found in candidates.iter().filter(is_pair) {
            if let (Some(feature), Some(reflector)) =
                (features.get(found.row), reflectors.get(found.column))
            {
                all.matches.push(Match {
                    feature: feature.id,
                    reflector: *reflector,
                    comparison: found.comparison,
                });
            }
        }
        let taken: Vec<usize> = pairs.iter().map(|(row, _)| *row).collect();
        all.sort_leftovers(features, &reflectors, &candidates, taken);
        let unpaired = |column: &usize| !pairs.iter().any(|(_, paired)| paired == column);
        for column in (0..reflectors.len()).filter(unpaired) {
            let Some(reflector) = reflectors.get(column) else {
                continue;
            };
            let shows = |c: &&Candidate| {
                let feature = features.get(c.row).filter(|_| c.column == column);
                feature.is_some_and(|feature| shows(&feature.shape, *reflector, truth))
            };
            let best = candidates.iter().filter(shows);
            let best = best.min_by(|a, b| a.cost.total_cmp(&b.cost));
            let best = best.and_then(|c| features.get(c.row));
            all.shared
                .extend(best.map(|feature| (feature.id, *reflector)));
        }
        all
    }

    /// What the features without a partner are; the best first, as it is against the better ones
    /// that they are held.
    fn sort_leftovers(
        &mut self,
        features: &[&MapFeature],
        reflectors: &[Reflector],
        candidates: &[Candidate],
        mut taken: Vec<usize>,
    ) {
        let mut nearest: Vec<Candidate> = Vec::new();
        for (row, feature) in features.iter().enumerate() {
            if taken.contains(&row) {
                continue;
            }
            let own = candidates.iter().filter(|c| c.row == row);
            match own.min_by(|a, b| a.cost.total_cmp(&b.cost)) {
                Some(found) => nearest.push(*found),
                None => self.spurious.push(feature.id),
            }
        }
        nearest.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        for found in nearest {
            let (Some(feature), Some(reflector)) =
                (features.get(found.row), reflectors.get(found.column))
            else {
                continue;
            };
            let on_it = |row: &&usize| {
                candidates
                    .iter()
                    .any(|c| c.row == **row && c.column == found.column)
            };
            let better: Vec<&Shape> = taken
                .iter()
                .filter(on_it)
                .filter_map(|row| features.get(*row))
                .map(|feature| &feature.shape)
                .collect();
            if is_new(&feature.shape, &better) {
                self.parts.push(feature.id);
                taken.push(found.row);
            } else {
                self.duplicates.push((feature.id, *reflector));
            }
        }
        self.parts.sort_unstable();
        self.duplicates.sort_unstable_by_key(|(id, _)| *id);
    }
}

fn candidates(features: &[&MapFeature], reflectors: &[Reflector], truth: &Truth) -> Vec<Candidate> {
    let mut all = Vec::new();
    for (row, feature) in features.iter().enumerate() {
        for (column, reflector) in reflectors.iter().enumerate() {
            if let Some(comparison) = compare(&feature.shape, *reflector, truth.world())
                && let Some(cost) = comparison.cost
            {
                all.push(Candidate {
                    row,
                    column,
                    cost,
                    comparison,
                });
            }
        }
    }
    all
}

/// Whether a feature within the gates of a wall or point shows it, though it is matched with another.
fn shows(shape: &Shape, reflector: Reflector, truth: &Truth) -> bool {
    match (shape, reflector) {
        (Shape::Line(segment), Reflector::Line(index)) => {
            let wall = truth.world().walls().get(index);
            wall.map(TrueLine::of).is_some_and(|wall| {
                let (low, high) = wall.beside(segment);
                high - low >= MOST * wall.length.min(2.0 * segment.half_length)
            })
        }
        // Surveyed walls end near each other in a corner, but not in one place.
        _ => truth.origin() == Origin::EchoModel,
    }
}

/// Whether most of a line lies beside none of `better`, which are on the same wall.
fn is_new(shape: &Shape, better: &[&Shape]) -> bool {
    let Shape::Line(segment) = shape else {
        return false;
    };
    let axis = unit(segment.theta + FRAC_PI_2);
    let length = 2.0 * segment.half_length;
    let beside = |other: &Segment| {
        let [a, b] = other.ends().map(|end| (end - segment.mid).dot(&axis));
        let (low, high) = (a.min(b), a.max(b));
        high.min(segment.half_length) - low.max(-segment.half_length)
    };
    better.iter().all(|other| match other {
        Shape::Line(other) => beside(other) < MOST * length,
        Shape::Point(_) => true,
    })
}
