//! Map features against the walls and points of the world.

use super::errors::Errors;
use super::matching::{Comparison, TrueLine, compare};
use super::truth::Truth;
use crate::assignment::assign;
use crate::tmam::feature::{Kind, MapFeature, Shape, Status};
use crate::world::Reflector;

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

/// How the lines, or the points, of a map did.
#[derive(Debug, Clone, PartialEq)]
pub struct KindScore {
    /// Walls or points of the world that echoed often enough to be asked for.
    pub visible: u64,
    /// Features of the map.
    pub features: u64,
    /// Features matched one to one with walls or points.
    pub matches: Vec<Match>,
    /// Visible walls or points without a feature.
    pub missed: Vec<Reflector>,
    /// Features that are no wall or point of the world.
    pub spurious: Vec<u32>,
    /// Features that are one which already has a better feature. They count as spurious too, but
    /// are listed here.
    pub duplicates: Vec<(u32, Reflector)>,
    /// How far the matched ones are off.
    pub errors: Errors,
    /// Share of the visible walls' length that lies beside a segment matched or duplicate; `None`
    /// for points.
    pub covered: Option<f64>,
}

/// How a map did.
#[derive(Debug, Clone, PartialEq)]
pub struct MapScore {
    /// Its lines.
    pub lines: KindScore,
    /// Its points.
    pub points: KindScore,
}

/// Whether a feature has enough behind it to be held against the truth strictly.
pub fn is_confirmed(feature: &MapFeature) -> bool {
    feature.status == Status::Confirmed
}

impl MapScore {
    /// Holds a map against the truth.
    pub fn new<'a>(features: impl Iterator<Item = &'a MapFeature> + Clone, truth: &Truth) -> Self {
        let of_kind = |kind| features.clone().filter(move |f| f.shape.kind() == kind);
        Self {
            lines: KindScore::new(Kind::Line, &of_kind(Kind::Line).collect::<Vec<_>>(), truth),
            points: KindScore::new(
                Kind::Point,
                &of_kind(Kind::Point).collect::<Vec<_>>(),
                truth,
            ),
        }
    }

    /// Whether it holds every visible wall and point once and nothing else.
    pub fn is_exact(&self) -> bool {
        self.lines.is_exact() && self.points.is_exact()
    }
}

impl KindScore {
    fn new(kind: Kind, features: &[&MapFeature], truth: &Truth) -> Self {
        let reflectors = reflectors(kind, truth);
        let mut within = Vec::new();
        let mut costs = Vec::new();
        for (row, feature) in features.iter().enumerate() {
            for (column, reflector) in reflectors.iter().enumerate() {
                let Some(comparison) = compare(&feature.shape, *reflector, truth.world()) else {
                    continue;
                };
                if let Some(cost) = comparison.cost {
                    costs.push((row, column, cost));
                    within.push((row, column, comparison));
                }
            }
        }
        let pairs = assign(features.len(), reflectors.len(), &costs);
        let mut matches = Vec::new();
        for pair in &pairs {
            let found = within
                .iter()
                .find(|(row, column, _)| (*row, *column) == *pair);
            if let (Some((_, _, comparison)), Some(feature), Some(reflector)) =
                (found, features.get(pair.0), reflectors.get(pair.1))
            {
                matches.push(Match {
                    feature: feature.id,
                    reflector: *reflector,
                    comparison: *comparison,
                });
            }
        }
        let (mut spurious, mut duplicates) = (Vec::new(), Vec::new());
        for (row, feature) in features.iter().enumerate() {
            if pairs.iter().any(|(paired, _)| *paired == row) {
                continue;
            }
            let nearest = costs
                .iter()
                .filter(|cost| cost.0 == row)
                .min_by(|a, b| a.2.total_cmp(&b.2));
            match nearest.and_then(|cost| reflectors.get(cost.1)) {
                Some(reflector) => duplicates.push((feature.id, *reflector)),
                None => spurious.push(feature.id),
            }
        }
        let is_matched = |reflector| matches.iter().any(|m| m.reflector == reflector);
        let visible = || reflectors.iter().copied().filter(|r| truth.is_visible(*r));
        Self {
            visible: visible().count() as u64,
            features: features.len() as u64,
            missed: visible().filter(|r| !is_matched(*r)).collect(),
            errors: Errors::of(matches.iter().map(|m| &m.comparison)),
            covered: match kind {
                Kind::Line => covered(features, &matches, &duplicates, truth),
                Kind::Point => None,
            },
            matches,
            spurious,
            duplicates,
        }
    }

    /// Features that are too many: no wall or point of the world, or one already there.
    pub fn surplus(&self) -> u64 {
        (self.spurious.len() + self.duplicates.len()) as u64
    }

    /// Whether it holds every visible one once and nothing else.
    pub fn is_exact(&self) -> bool {
        self.missed.is_empty() && self.surplus() == 0
    }
}

/// Every wall, or point, of the world.
pub(super) fn reflectors(kind: Kind, truth: &Truth) -> Vec<Reflector> {
    let world = truth.world();
    match kind {
        Kind::Line => (0..world.walls().len()).map(Reflector::Line).collect(),
        Kind::Point => (0..world.points().len()).map(Reflector::Point).collect(),
    }
}

/// The share of the visible walls' length beside their segments.
fn covered(
    features: &[&MapFeature],
    matches: &[Match],
    duplicates: &[(u32, Reflector)],
    truth: &Truth,
) -> Option<f64> {
    let of_wall = |wall: usize| {
        let matched = matches.iter().map(|m| (m.feature, m.reflector));
        let all = matched.chain(duplicates.iter().copied());
        all.filter(move |(_, reflector)| *reflector == Reflector::Line(wall))
    };
    let (mut beside, mut length) = (0.0, 0.0);
    for (index, wall) in truth.world().walls().iter().enumerate() {
        if !truth.is_visible(Reflector::Line(index)) {
            continue;
        }
        let line = TrueLine::of(wall);
        let mut parts: Vec<(f64, f64)> = of_wall(index)
            .filter_map(|(id, _)| features.iter().find(|feature| feature.id == id))
            .filter_map(|feature| match &feature.shape {
                Shape::Line(segment) => Some(line.beside(segment)),
                Shape::Point(_) => None,
            })
            .collect();
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        beside += union(&parts);
        length += line.length;
    }
    (length > 0.0).then(|| beside / length)
}

/// The length of the union of intervals sorted by where they begin.
fn union(parts: &[(f64, f64)]) -> f64 {
    let mut reached = f64::NEG_INFINITY;
    parts
        .iter()
        .map(|(low, high)| {
            let new = (high - low.max(reached)).max(0.0);
            reached = reached.max(*high);
            new
        })
        .sum()
}

#[cfg(test)]
pub(super) mod testing;
#[cfg(test)]
mod tests;
