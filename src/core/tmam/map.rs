//! The map: extracted features are fused with registered ones, and at the end of the log all of them
//! are looked at again.

mod backing;
pub mod corners;
mod crossings;
pub mod ends;
mod foretold;
pub mod fusion;
pub mod refine;
pub mod rough;
mod round;

use std::collections::{BTreeMap, BTreeSet};

use super::arc::Arc;
use super::feature::{Action, MapFeature, Shape, Status};
use crate::core::config::{Config, Map as Bounds, NoiseAwareOptions};
use crate::core::event::SonarId;
use crate::core::ties;
use backing::Backing;
use fusion::alike;
pub use fusion::duplicates;
use rough::RoughWall;

/// The registered features.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    features: Vec<MapFeature>,
    next_id: u32,
    /// The readings of features that a single run gave.
    lone: BTreeMap<u32, Vec<Arc>>,
    /// Which sonars gave each feature, and when.
    backing: BTreeMap<u32, Backing>,
    bounds: Bounds,
    departures: NoiseAwareOptions,
}

/// What became of a feature in the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Fused {
    /// Whether it is new.
    pub action: Action,
    /// The map feature it went into, as it is now.
    pub feature: MapFeature,
    /// Map features that turned out to be the same, and are gone.
    pub absorbed: Vec<u32>,
}

impl Map {
    /// An empty map.
    pub fn new(config: &Config) -> Self {
        Self {
            features: Vec::new(),
            next_id: 0,
            lone: BTreeMap::new(),
            backing: BTreeMap::new(),
            bounds: config.map.clone(),
            departures: config.departures(),
        }
    }

    /// Every registered feature, by id.
    pub fn features(&self) -> &[MapFeature] {
        &self.features
    }

    /// Fuses a feature that a run of associated readings gave with the nearest match, or registers it
    /// as a new one.
    pub fn add(&mut self, shape: Shape, associated: &[Arc]) -> Fused {
        let readings = u32::try_from(associated.len()).unwrap_or(u32::MAX);
        let at = self.nearest(&shape, None);
        if let Some(known) = at.and_then(|at| self.features.get(at)).copied() {
            let backing = self.backing.entry(known.id).or_default();
            backing.join(&Backing::of(associated));
            return self.merge(known, shape, readings);
        }
        let mut feature = MapFeature {
            id: self.next_id,
            shape,
            readings,
            runs: 1,
            status: Status::Confirmed,
        };
        feature.status = self.status(&feature);
        self.next_id = self.next_id.saturating_add(1);
        self.features.push(feature);
        self.backing.insert(feature.id, Backing::of(associated));
        if self.departures.confirm {
            self.lone.insert(feature.id, associated.to_vec());
        }
        Fused {
            action: Action::Registered(feature.id),
            feature,
            absorbed: Vec::new(),
        }
    }

    fn merge(&mut self, known: MapFeature, shape: Shape, readings: u32) -> Fused {
        let mut feature = MapFeature {
            shape: self.fuse(&known, &shape, readings),
            readings: known.readings.saturating_add(readings),
            runs: known.runs.saturating_add(1),
            ..known
        };
        let absorbed = if self.departures.merge {
            self.absorb(&mut feature)
        } else {
            Vec::new()
        };
        feature.status = self.status(&feature);
        self.lone.remove(&feature.id);
        if let Some(place) = self.features.iter_mut().find(|f| f.id == feature.id) {
            *place = feature;
        }
        Fused {
            action: Action::Merged(feature.id),
            feature,
            absorbed,
        }
    }

    /// Takes up every other feature that is the same now that `feature` has changed.
    fn absorb(&mut self, feature: &mut MapFeature) -> Vec<u32> {
        let mut absorbed = Vec::new();
        while let Some(at) = self.nearest(&feature.shape, Some(feature.id)) {
            let other = self.features.remove(at);
            feature.shape = self.fuse(feature, &other.shape, other.readings);
            feature.readings = feature.readings.saturating_add(other.readings);
            feature.runs = feature.runs.saturating_add(other.runs);
            self.lone.remove(&other.id);
            if let Some(backing) = self.backing.remove(&other.id) {
                self.backing.entry(feature.id).or_default().join(&backing);
            }
            absorbed.push(other.id);
        }
        absorbed
    }

    /// The place of the nearest feature within the gates, but for the one with the id `except`.
    fn nearest(&self, shape: &Shape, except: Option<u32>) -> Option<usize> {
        let others = self.features.iter().enumerate();
        let others = others
            .filter(|(_, known)| Some(known.id) != except)
            .filter_map(|(at, known)| Some((self.distance(shape, known)?, at)));
        ties::first_least(others, |_, _| ties::LENGTH).map(|(_, at)| at)
    }

    /// How far a feature is from a registered one; `None` beyond the gates.
    fn distance(&self, shape: &Shape, known: &MapFeature) -> Option<f64> {
        if self.departures.fuse_by_information {
            fusion::mahalanobis_distance(shape, &known.shape, self.bounds.max_wall_gap)
                .filter(|distance| *distance < self.bounds.gate)
        } else {
            fusion::deviation(shape, known, self.bounds.match_distance)
        }
    }

    fn fuse(&self, known: &MapFeature, shape: &Shape, readings: u32) -> Shape {
        if self.departures.fuse_by_information {
            fusion::fuse_by_information(&known.shape, shape)
        } else {
            fusion::fuse_by_readings(known, shape, readings)
        }
    }

    fn status(&self, feature: &MapFeature) -> Status {
        let supported = feature.runs >= self.bounds.confirm_runs
            || feature.readings >= self.bounds.confirm_readings;
        if supported || !self.departures.confirm {
            Status::Confirmed
        } else {
            Status::Tentative
        }
    }
}

impl Map {
    /// Doubts what one run alone gave, fits features anew to all readings, joins corners, and ends
    /// walls at them, as far as the rule says so. `hardly` are the sonars of which hardly a triple is
    /// explained, `rough` the rough walls that were seen at an angle. Returns what changed, in order; the last
    /// one of an id is what it is now.
    pub fn settle(
        &mut self,
        arcs: &[Arc],
        hardly: &BTreeSet<SonarId>,
        rough: &[RoughWall],
    ) -> Vec<MapFeature> {
        let mut settled = self.put(self.doubtful());
        settled.extend(self.support(rough));
        settled.extend(self.put(self.unbacked(hardly)));
        settled.extend(self.end_walls());
        settled.extend(self.gather(arcs));
        let crossings = self.cross(arcs, hardly);
        if !crossings.is_empty() {
            settled.extend(crossings);
            settled.extend(self.gather(arcs));
        }
        if self.departures.join_corners {
            let foretold = self.put(foretold::confirm(&self.features, &self.lone, arcs, hardly));
            if !foretold.is_empty() {
                settled.extend(foretold);
                settled.extend(self.gather(arcs));
            }
            settled.extend(self.put(corners::join(&self.features)));
            settled.extend(self.end_walls());
        }
        settled
    }

    /// Points that are one cylinder become that, if the rule says so. Returns what changed, in order, and what
    /// is gone.
    pub fn round(&mut self, arcs: &[Arc]) -> (Vec<MapFeature>, Vec<u32>) {
        let (mut settled, mut absorbed) = (Vec::new(), Vec::new());
        if !self.departures.circles {
            return (settled, absorbed);
        }
        while let Some(found) = round::first(&self.features, arcs, &self.bounds) {
            self.features.retain(|f| !found.absorbed.contains(&f.id));
            settled.extend(self.put(vec![found.feature]));
            absorbed.extend(found.absorbed);
        }
        (settled, absorbed)
    }

    /// Walls that were seen at an angle as well, as far as that; each time is another run.
    fn support(&mut self, rough: &[RoughWall]) -> Vec<MapFeature> {
        let mut settled = Vec::new();
        for wall in rough {
            let known = wall.known(&self.features, self.bounds.max_wall_gap);
            if let Some((at, shape)) = known
                && let Some(known) = self.features.get(at)
            {
                let backing = self.backing.entry(known.id).or_default();
                backing.join(&Backing::of(&wall.arcs));
                let mut feature = MapFeature {
                    shape,
                    runs: known.runs.saturating_add(1),
                    ..*known
                };
                feature.status = self.status(&feature);
                settled.extend(self.put(vec![feature]));
            }
        }
        settled
    }

    /// Points in which arcs of several sonars cross that nothing explains, if the rule says so: new ones, or
    /// tentative ones that this confirms.
    fn cross(&mut self, arcs: &[Arc], hardly: &BTreeSet<SonarId>) -> Vec<MapFeature> {
        if !self.departures.crossings {
            return Vec::new();
        }
        let found = crossings::find(&self.features, arcs, hardly, &self.bounds);
        let mut crossed = Vec::new();
        for crossing in found {
            let shape = Shape::Point(crossing.point);
            let known = self.nearest(&shape, None);
            let known = known.and_then(|at| self.features.get(at)).copied();
            let (id, runs) = known.map_or((self.next_id, 0), |known| (known.id, known.runs));
            let feature = MapFeature {
                id,
                shape,
                readings: u32::try_from(crossing.arcs.len()).unwrap_or(u32::MAX),
                runs,
                status: Status::Confirmed,
            };
            if known.is_none() {
                self.next_id = self.next_id.saturating_add(1);
                self.features.push(feature);
            }
            self.lone.remove(&id);
            let backing = self.backing.entry(id).or_default();
            backing.join(&Backing::of(&crossing.arcs));
            crossed.extend(self.put(vec![feature]));
        }
        crossed
    }

    /// Fits features anew to all readings, if the rule says so.
    fn gather(&mut self, arcs: &[Arc]) -> Vec<MapFeature> {
        if !self.departures.gather {
            return Vec::new();
        }
        let ending = self.departures.end_at_corners;
        let mut settled = self.put(refine::refine(&self.features, arcs, &self.bounds, ending));
        settled.extend(self.end_walls());
        settled
    }

    /// A feature of a single run stays tentative if another one with more support looks like it or
    /// explains all its readings.
    fn doubtful(&self) -> Vec<MapFeature> {
        let doubtful = |lone: &MapFeature, arcs: &[Arc]| {
            let stronger = |f: &&MapFeature| {
                f.status == Status::Confirmed && f.runs > 1 && f.readings > lone.readings
            };
            self.features.iter().filter(stronger).any(|other| {
                alike(other, lone, self.bounds.match_distance)
                    || refine::explains(&other.shape, arcs)
            })
        };
        let features = self.features.iter();
        features
            .filter(|f| f.status == Status::Confirmed)
            .filter(|f| self.lone.get(&f.id).is_some_and(|arcs| doubtful(f, arcs)))
            .map(|feature| MapFeature {
                status: Status::Tentative,
                ..*feature
            })
            .collect()
    }

    /// What a single one of the sonars of which hardly a triple is explained saw on a single visit
    /// stays tentative.
    fn unbacked(&self, hardly: &BTreeSet<SonarId>) -> Vec<MapFeature> {
        let unbacked = |feature: &&MapFeature| {
            let backing = self.backing.get(&feature.id);
            backing
                .and_then(Backing::alone)
                .is_some_and(|sonar| hardly.contains(&sonar))
        };
        let features = self.features.iter().filter(|_| self.departures.confirm);
        features
            .filter(|f| f.status == Status::Confirmed)
            .filter(unbacked)
            .map(|feature| MapFeature {
                status: Status::Tentative,
                ..*feature
            })
            .collect()
    }

    /// Registers features anew under the ids that they have.
    fn put(&mut self, changed: Vec<MapFeature>) -> Vec<MapFeature> {
        for changed in &changed {
            if let Some(feature) = self.features.iter_mut().find(|f| f.id == changed.id) {
                *feature = *changed;
            }
        }
        changed
    }

    /// Ends walls at the confirmed points on them.
    fn end_walls(&mut self) -> Vec<MapFeature> {
        if !self.departures.end_at_corners {
            return Vec::new();
        }
        let points = refine::confirmed_points(&self.features);
        let mut changed = Vec::new();
        for feature in &mut self.features {
            let cut = ends::cut(feature.shape, &points);
            if cut != feature.shape {
                feature.shape = cut;
                changed.push(*feature);
            }
        }
        changed
    }
}

#[cfg(test)]
mod tests;
