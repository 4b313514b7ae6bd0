//! Fusion of extracted features with the registered ones.

mod corners;
mod ends;
mod explained;
mod gather;
mod information;
mod paper;
mod settle;

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use super::arc::Arc;
use super::feature::{Action, MapFeature, Segment, Shape, Status};
use crate::core::config::{Config, Map as Bounds, NoiseAwareOptions};
use crate::core::geometry::{angle_between, unit};
use crate::core::ties;

/// The registered features.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    features: Vec<MapFeature>,
    next_id: u32,
    /// The readings of features that a single run gave.
    lone: BTreeMap<u32, Vec<Arc>>,
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
            information::distance(shape, &known.shape, self.bounds.max_wall_gap)
                .filter(|distance| *distance < self.bounds.gate)
        } else {
            paper::deviation(shape, known, self.bounds.match_distance)
        }
    }

    fn fuse(&self, known: &MapFeature, shape: &Shape, readings: u32) -> Shape {
        if self.departures.fuse_by_information {
            information::fuse(&known.shape, shape)
        } else {
            paper::fuse(known, shape, readings)
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

/// How many features of a map look like another one: lines that overlap within 5 cm and 5 degrees,
/// points within `match_distance`. The gates of (24) and (25), a standard deviation wide, leave
/// such duplicates.
pub fn duplicates(features: &[MapFeature], match_distance: f64) -> usize {
    features
        .iter()
        .enumerate()
        .filter(|(place, feature)| {
            features
                .iter()
                .take(*place)
                .any(|other| alike(other, feature, match_distance))
        })
        .count()
}

fn alike(a: &MapFeature, b: &MapFeature, match_distance: f64) -> bool {
    match (&a.shape, &b.shape) {
        (Shape::Line(a), Shape::Line(b)) => coincide(a, b),
        (Shape::Point(a), Shape::Point(b)) => (a.position - b.position).norm() < match_distance,
        _ => false,
    }
}

fn coincide(a: &Segment, b: &Segment) -> bool {
    let offset = unit(a.theta).dot(&b.mid) - a.rho;
    let way = unit(a.theta + FRAC_PI_2).dot(&(b.mid - a.mid)).abs();
    let tilt = angle_between(a.theta, signed_like(b, a).theta);
    offset.abs() < 0.05 && tilt < 5_f64.to_radians() && way < a.half_length + b.half_length
}

/// The segment under the sign of (rho, theta) that is nearer to the other's.
fn signed_like(segment: &Segment, other: &Segment) -> Segment {
    if angle_between(segment.theta, other.theta) > FRAC_PI_2 {
        segment.flipped()
    } else {
        *segment
    }
}

/// The segment with the extent of the given ones, projected on its line.
fn spanning(line: Segment, segments: &[Segment]) -> Segment {
    let along = unit(line.theta + FRAC_PI_2);
    let (low, high) = segments
        .iter()
        .flat_map(Segment::ends)
        .map(|end| end.dot(&along))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), way| {
            (low.min(way), high.max(way))
        });
    Segment {
        mid: unit(line.theta) * line.rho + along * ((low + high) / 2.0),
        half_length: (high - low) / 2.0,
        ..line
    }
}

/// By how much two segments overlap along the first one's line, metres; negative where there is a
/// gap between them.
fn overlap(a: &Segment, b: &Segment) -> f64 {
    let along = unit(a.theta + FRAC_PI_2);
    let way = along.dot(&(b.mid - a.mid)).abs();
    a.half_length + b.half_length - way
}

#[cfg(test)]
mod tests;
