//! Map features against the walls and points of the world.

mod lengths;
mod pairing;

use self::lengths::Lengths;
pub use self::pairing::Match;
use self::pairing::Pairing;
use super::errors::Errors;
use super::truth::Truth;
use crate::core::tmam::feature::{Kind, MapFeature, Status};
use crate::core::world::Reflector;

/// How the lines, or the points, of a map did.
#[derive(Debug, Clone, PartialEq)]
pub struct KindScore {
    /// Walls or points of the world that echoed often enough to be asked for.
    pub visible: u64,
    /// Features of the map.
    pub features: u64,
    /// Features matched one to one with walls or points.
    pub matches: Vec<Match>,
    /// How many of these matches are with walls or points that hardly echoed and are not asked for.
    pub unasked: u64,
    /// Walls or points that a feature matched with another one shows as well: the next
    /// piece of the same wall, another wall's end in the same corner.
    pub shared: Vec<(u32, Reflector)>,
    /// Visible walls or points without a feature.
    pub missed: Vec<Reflector>,
    /// Features that are no wall or point of the world.
    pub spurious: Vec<u32>,
    /// Features that are one which already has a better feature. They count as spurious too, but
    /// are listed here.
    pub duplicates: Vec<(u32, Reflector)>,
    /// Features that are right without being asked for: lines on other parts of a wall that has
    /// one.
    pub parts: Vec<u32>,
    /// How far the matched ones are off.
    pub errors: Errors,
    /// Share of the visible walls' length that lies beside lines of the map; `None` for points.
    pub covered: Option<f64>,
    /// How far lines that lie on walls go on beside none, all together, metres; `None` for points.
    pub overrun: Option<f64>,
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
        let pairing = Pairing::new(kind, features, truth);
        let Pairing {
            matches,
            shared,
            duplicates,
            parts,
            spurious,
        } = pairing;
        let unasked = matches.iter().filter(|m| !truth.is_visible(m.reflector));
        let unasked = unasked.count() as u64;
        let is_there = |reflector| {
            matches.iter().any(|m| m.reflector == reflector)
                || shared.iter().any(|(_, other)| *other == reflector)
        };
        let reflectors = reflectors(kind, truth);
        let visible = || reflectors.iter().copied().filter(|r| truth.is_visible(*r));
        let lengths = match kind {
            Kind::Line => Some(Lengths::new(features, truth)),
            Kind::Point => None,
        };
        Self {
            visible: visible().count() as u64,
            features: features.len() as u64,
            missed: visible().filter(|r| !is_there(*r)).collect(),
            errors: Errors::of(matches.iter().map(|m| &m.comparison)),
            covered: lengths.and_then(|lengths| lengths.covered),
            overrun: lengths.map(|lengths| lengths.overrun),
            unasked,
            matches,
            shared,
            spurious,
            duplicates,
            parts,
        }
    }

    /// Visible walls or points that the map shows; with those it misses, all that are visible.
    pub fn matched(&self) -> u64 {
        self.visible.saturating_sub(self.missed.len() as u64)
    }

    /// How many of these have no feature of their own: one that is matched with another shows them.
    pub fn without_own(&self) -> u64 {
        let own = (self.matches.len() as u64).saturating_sub(self.unasked);
        self.matched().saturating_sub(own)
    }

    /// Features that are right without being asked for.
    pub fn more(&self) -> u64 {
        self.unasked + self.parts.len() as u64
    }

    /// Features that are too many: no wall or point of the world, or one already there.
    pub fn surplus(&self) -> u64 {
        (self.spurious.len() + self.duplicates.len()) as u64
    }

    /// Whether it holds every visible one once, whole, and nothing else.
    pub fn is_exact(&self) -> bool {
        self.missed.is_empty() && self.surplus() == 0 && self.parts.is_empty()
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

#[cfg(test)]
pub(super) mod testing;
#[cfg(test)]
mod tests;
