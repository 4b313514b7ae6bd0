//! Which feature of a map is which wall or point.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;

use serde::Serialize;

use crate::core::assignment::assign;
use crate::core::geometry::unit;
use crate::core::tmam::feature::{Kind, MapFeature, Shape};
use crate::core::world::Reflector;
use crate::tools::evaluate::matching::{Comparison, TrueLine, index};
use crate::tools::evaluate::truth::{Origin, Truth};

/// A line shows another wall as well when it covers at least this share of the shorter of the two,
/// and is there twice when at least this share of it lies beside a better one.
const MOST: f64 = 0.5;

/// A map feature that is a wall or point of the world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Match {
    #[serde(rename = "id")]
    pub feature: u32,
    #[serde(rename = "index", serialize_with = "index")]
    pub reflector: Reflector,
    /// How well it fits.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Every feature of one kind in one of these, but for `shared`, which has some of the matched again.
#[derive(Debug, Clone, Default, PartialEq)]
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
struct Candidate<'a> {
    row: usize,
    column: usize,
    feature: &'a MapFeature,
    reflector: Reflector,
    cost: f64,
    comparison: Comparison,
}

impl Pairing {
    /// Pairs the features of one kind.
    pub fn new(kind: Kind, features: &[&MapFeature], truth: &Truth) -> Self {
        let mut candidates = Vec::new();
        for (row, &feature) in features.iter().enumerate() {
            let of_it = truth.candidates(&feature.shape);
            candidates.extend(of_it.map(|(reflector, comparison, cost)| Candidate {
                row,
                column: reflector.index(),
                feature,
                reflector,
                cost,
                comparison,
            }));
        }
        let costs = candidates.iter().map(|c| (c.row, c.column, c.cost));
        let costs: Vec<_> = costs.collect();
        let columns = truth.reflectors(kind).len();
        let pairs: BTreeSet<(usize, usize)> = assign(features.len(), columns, &costs)
            .into_iter()
            .collect();
        let matched = candidates
            .iter()
            .filter(|c| pairs.contains(&(c.row, c.column)));
        let mut all = Self {
            matches: matched.map(Candidate::as_match).collect(),
            ..Self::default()
        };
        let taken: BTreeSet<usize> = pairs.iter().map(|(row, _)| *row).collect();
        all.sort_leftovers(features, &candidates, taken);
        all.share(&candidates, &pairs, truth);
        all
    }

    /// Gives walls and points that have no feature of their own the best of those that show them.
    fn share(
        &mut self,
        candidates: &[Candidate<'_>],
        pairs: &BTreeSet<(usize, usize)>,
        truth: &Truth,
    ) {
        let paired: BTreeSet<usize> = pairs.iter().map(|(_, column)| *column).collect();
        let mut best: BTreeMap<usize, &Candidate<'_>> = BTreeMap::new();
        let unpaired = candidates.iter().filter(|c| !paired.contains(&c.column));
        for found in unpaired.filter(|c| shows(&c.feature.shape, c.reflector, truth)) {
            let known = best.entry(found.column).or_insert(found);
            if found.cost < known.cost {
                *known = found;
            }
        }
        let best = best.into_values();
        self.shared = best.map(|c| (c.feature.id, c.reflector)).collect();
    }

    /// What the features without a partner are; the best first, as it is against the better ones
    /// that they are held.
    fn sort_leftovers(
        &mut self,
        features: &[&MapFeature],
        candidates: &[Candidate<'_>],
        mut taken: BTreeSet<usize>,
    ) {
        let (mut by_row, mut by_column) = (BTreeMap::new(), BTreeMap::new());
        for candidate in candidates {
            let nearest = by_row.entry(candidate.row).or_insert(candidate);
            if candidate.cost < nearest.cost {
                *nearest = candidate;
            }
            let on_it: &mut Vec<_> = by_column.entry(candidate.column).or_default();
            on_it.push(candidate);
        }
        let rows = (0..features.len()).zip(features);
        let lost = rows.filter(|(row, _)| !by_row.contains_key(row));
        self.spurious = lost.map(|(_, feature)| feature.id).collect();
        let mut nearest: Vec<&Candidate<'_>> = by_row.into_values().collect();
        nearest.retain(|found| !taken.contains(&found.row));
        nearest.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        for found in nearest {
            let on_it = by_column.get(&found.column).into_iter().flatten();
            let mut better = on_it.filter(|other| taken.contains(&other.row));
            if better.all(|other| lies_apart(&found.feature.shape, &other.feature.shape)) {
                self.parts.push(found.feature.id);
                taken.insert(found.row);
            } else {
                self.duplicates.push((found.feature.id, found.reflector));
            }
        }
        self.parts.sort_unstable();
        self.duplicates.sort_unstable_by_key(|(id, _)| *id);
    }
}

impl Candidate<'_> {
    fn as_match(&self) -> Match {
        Match {
            feature: self.feature.id,
            reflector: self.reflector,
            comparison: self.comparison,
        }
    }
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

/// Whether most of a line does not lie beside another one on the same wall.
fn lies_apart(shape: &Shape, other: &Shape) -> bool {
    let (Shape::Line(segment), Shape::Line(other)) = (shape, other) else {
        return false;
    };
    let axis = unit(segment.theta + FRAC_PI_2);
    let [a, b] = other.ends().map(|end| (end - segment.mid).dot(&axis));
    let (low, high) = (a.min(b), a.max(b));
    let beside = high.min(segment.half_length) - low.max(-segment.half_length);
    beside < MOST * 2.0 * segment.half_length
}
