//! Map features against the walls and points of the world.

mod lengths;
mod pairing;

use std::collections::BTreeSet;

use serde::{Serialize, Serializer};

use self::lengths::Lengths;
pub use self::pairing::Match;
use self::pairing::Pairing;
use super::matching::{Errors, index};
use super::truth::Truth;
use crate::core::rounding::optional;
use crate::core::tmam::feature::{Kind, MapFeature, Status};
use crate::core::world::Reflector;

/// How the lines, or the points, of a map did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KindScore {
    /// Features of the map.
    pub features: u64,
    /// Walls or points of the world that echoed often enough to be asked for.
    pub visible: u64,
    /// Those that the map shows; with those it misses, all that are visible.
    pub matched: u64,
    /// How many of the matches are with walls or points that hardly echoed and are not asked for.
    pub unasked: u64,
    /// Visible walls or points without a feature.
    pub missed: Vec<Missed>,
    /// Features that are no wall or point of the world.
    pub spurious: Vec<u32>,
    /// Features that are one which already has a better feature. They count as spurious too, but
    /// are listed here.
    #[serde(serialize_with = "shown")]
    pub duplicates: Vec<(u32, Reflector)>,
    /// Walls or points that a feature matched with another one shows as well: the next
    /// piece of the same wall, another wall's end in the same corner.
    #[serde(serialize_with = "shown")]
    pub shared: Vec<(u32, Reflector)>,
    /// Features that are right without being asked for: lines on other parts of a wall that has
    /// one.
    pub parts: Vec<u32>,
    /// How far the matched ones are off.
    pub errors: Errors,
    /// Share of the visible walls' length that lies beside lines of the map; `None` for points.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional")]
    pub covered: Option<f64>,
    /// How far lines that lie on walls go on beside none, all together, metres; `None` for points.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional")]
    pub overrun: Option<f64>,
    /// Features matched one to one with walls or points.
    pub matches: Vec<Match>,
}

/// A wall or point that is not in the map, and how often it echoed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Missed {
    #[serde(rename = "index", serialize_with = "index")]
    pub reflector: Reflector,
    pub echoes: u64,
}

/// How a map did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapScore {
    /// Whether it holds every visible wall and point once and nothing else.
    pub exact: bool,
    pub lines: KindScore,
    pub points: KindScore,
    /// Where the world has pillars or the map circles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circles: Option<KindScore>,
}

/// Whether a feature has enough behind it to be held against the truth strictly.
pub fn is_confirmed(feature: &MapFeature) -> bool {
    feature.status == Status::Confirmed
}

impl MapScore {
    /// Holds a map against the truth.
    pub fn new<'a>(features: impl Iterator<Item = &'a MapFeature> + Clone, truth: &Truth) -> Self {
        let of_kind = |kind| {
            let features = features.clone().filter(|f| f.shape.kind() == kind);
            KindScore::new(kind, &features.collect::<Vec<_>>(), truth)
        };
        let (lines, points) = (of_kind(Kind::Line), of_kind(Kind::Point));
        let circles = of_kind(Kind::Circle);
        let are_told = circles.features > 0 || !truth.world().pillars().is_empty();
        Self {
            exact: [&lines, &points, &circles]
                .iter()
                .all(|kind| kind.is_exact()),
            lines,
            points,
            circles: are_told.then_some(circles),
        }
    }
}

impl KindScore {
    fn new(kind: Kind, features: &[&MapFeature], truth: &Truth) -> Self {
        let Pairing {
            matches,
            shared,
            duplicates,
            parts,
            spurious,
        } = Pairing::new(kind, features, truth);
        let there = matches.iter().map(|m| m.reflector);
        let there: BTreeSet<Reflector> = there.chain(shared.iter().map(|(_, r)| *r)).collect();
        let visible = truth.reflectors(kind).into_iter();
        let visible: Vec<Reflector> = visible.filter(|r| truth.is_visible(*r)).collect();
        let missed = visible.iter().filter(|r| !there.contains(r));
        let missed: Vec<Missed> = missed
            .map(|reflector| Missed {
                reflector: *reflector,
                echoes: truth.echoes(*reflector),
            })
            .collect();
        let unasked = matches.iter().filter(|m| !truth.is_visible(m.reflector));
        let lengths = (kind == Kind::Line).then(|| Lengths::new(features, truth));
        Self {
            features: features.len() as u64,
            visible: visible.len() as u64,
            matched: (visible.len() - missed.len()) as u64,
            unasked: unasked.count() as u64,
            errors: Errors::of(matches.iter().map(|m| &m.comparison)),
            covered: lengths.and_then(|lengths| lengths.covered),
            overrun: lengths.map(|lengths| lengths.overrun),
            missed,
            matches,
            shared,
            spurious,
            duplicates,
            parts,
        }
    }

    /// How many of the matched have no feature of their own: one that is matched with another shows them.
    pub fn without_own(&self) -> u64 {
        let own = (self.matches.len() as u64).saturating_sub(self.unasked);
        self.matched.saturating_sub(own)
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

#[derive(Serialize)]
struct Shown {
    id: u32,
    index: usize,
}

/// Features and the walls or points that they show.
fn shown<S: Serializer>(pairs: &[(u32, Reflector)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(pairs.iter().map(|(id, reflector)| Shown {
        id: *id,
        index: reflector.index(),
    }))
}

#[cfg(test)]
pub(super) mod testing;
#[cfg(test)]
mod tests;
