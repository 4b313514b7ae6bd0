//! Points that are one cylinder.
//!
//! From one way past it a sonar seldom tells a pillar from a point: the bearing sweeps too little. It takes it for a
//! point near the side that it saw, and from every other side for another one. All of them together tell: the
//! readings of two points or more, seen from bearings far enough apart, fit one circle.

use std::collections::BTreeSet;

use super::refine::GATE;
use crate::core::config;
use crate::core::geometry::{Vec2, direction};
use crate::core::ties;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::circle::{CircleFit, Parameters, RADII, chi2, covariance, is_held};
use crate::core::tmam::feature::{Circle, MapFeature, Shape, Status};
use crate::core::tmam::hypothesis::Gate;
use crate::core::tmam::prediction::{MapPrediction, Reach};

/// Readings of a circle, at least.
const FEWEST: usize = 12;
/// Bearings from which it is seen, at least so far apart from first to last: radians.
const SWEPT: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// A point of a cylinder lies this near to it, metres: runs that took it for a point put it into the cylinder, or
/// before it.
const NEAR: f64 = 0.15;
/// Standard deviations beyond which a reading does not agree with a circle.
const OFF: f64 = 5.0;
/// And within which it is one of its readings.
const SIGMAS: f64 = 3.0;
/// The axis may lie outside a beam by this, radians: it is off a little while the circle is looked for.
const SLACK: f64 = 0.02;
/// Rounds of gathering readings and fitting anew.
const ROUNDS: usize = 3;

/// A circle, and the features that it is in truth: the first of them, by its id, becomes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Round {
    pub feature: MapFeature,
    pub absorbed: Vec<u32>,
}

/// The circle that explains most of the points and circles of a map together, two of them at least; `None`
/// where there is none.
pub fn first(features: &[MapFeature], arcs: &[Arc], bounds: &config::Map) -> Option<Round> {
    let places: Vec<(&MapFeature, Vec2)> = (features.iter())
        .filter_map(|feature| Some((feature, place(feature)?)))
        .collect();
    let readings = Readings::new(features, arcs, bounds);
    let apart = 2.0 * RADII.end() + 2.0 * NEAR;
    let mut found = Vec::new();
    for (at, (a, first)) in places.iter().enumerate() {
        for (b, second) in places.iter().skip(at + 1) {
            let way = (second - first).norm();
            if way > apart {
                continue;
            }
            let pair = BTreeSet::from([a.id, b.id]);
            let middle = (first + second) / 2.0;
            let start = middle.push((way / 2.0).clamp(*RADII.start(), *RADII.end()));
            if let Some(round) = readings.round(pair, start, &places) {
                found.push((-f64::from(round.feature.readings), round));
            }
        }
    }
    ties::first_least(found, |_, _| 0.5).map(|(_, round)| round)
}

/// Where a point or a circle is; walls are none.
fn place(feature: &MapFeature) -> Option<Vec2> {
    match feature.shape {
        Shape::Line(_) => None,
        Shape::Point(point) => Some(point.position),
        Shape::Circle(circle) => Some(circle.center),
    }
}

/// Readings, each with the features that explain it.
struct Readings<'a> {
    features: &'a [MapFeature],
    arcs: Vec<(Arc, Vec<u32>)>,
}

impl<'a> Readings<'a> {
    fn new(features: &'a [MapFeature], arcs: &[Arc], bounds: &config::Map) -> Self {
        let all: Vec<MapFeature> = (features.iter())
            .map(|feature| MapFeature {
                status: Status::Confirmed,
                ..*feature
            })
            .collect();
        let prediction = MapPrediction::new(&all, &Reach::of(bounds.max_wall_gap));
        let explained = |arc: &Arc| (*arc, prediction.associate(arc).all().to_vec());
        Self {
            features,
            arcs: arcs.iter().map(explained).collect(),
        }
    }

    /// Those that some features explain, and no other one.
    fn of(&self, ids: &BTreeSet<u32>) -> Vec<Arc> {
        let theirs = |by: &[u32]| !by.is_empty() && by.iter().all(|id| ids.contains(id));
        let arcs = self.arcs.iter().filter(|(_, by)| theirs(by));
        arcs.map(|(arc, _)| *arc).collect()
    }

    /// Those that a circle explains and no feature but the given ones, labelled or not.
    fn explained(&self, ids: &BTreeSet<u32>, circle: &Parameters) -> Vec<Arc> {
        let fits = |arc: &Arc| {
            let one = std::slice::from_ref(arc);
            chi2(circle, one) < SIGMAS * SIGMAS && is_held(circle, one, 0.0)
        };
        let arcs = self.arcs.iter();
        arcs.filter(|(arc, by)| by.iter().all(|id| ids.contains(id)) && fits(arc))
            .map(|(arc, _)| *arc)
            .collect()
    }

    /// The circle of some features, and of others beside it.
    fn round(
        &self,
        mut ids: BTreeSet<u32>,
        start: Parameters,
        places: &[(&MapFeature, Vec2)],
    ) -> Option<Round> {
        let mut fit = fitted(start, &self.of(&ids))?;
        let mut arcs = Vec::new();
        for _ in 0..ROUNDS {
            let circle = fit.parameters;
            let beside = places.iter().filter(|(_, place)| {
                let from_center = (place - circle.xy()).norm();
                from_center < circle.z + NEAR
            });
            ids.extend(beside.map(|(feature, _)| feature.id));
            arcs = self.of(&ids);
            // Single outliers are those of the features, too.
            let fits = |arc: &Arc| {
                let one = std::slice::from_ref(arc);
                chi2(&circle, one) < OFF * OFF && is_held(&circle, one, SLACK)
            };
            let fitting = arcs.iter().filter(|arc| fits(arc)).count();
            if 10 * fitting < 9 * arcs.len() {
                return None;
            }
            arcs.retain(fits);
            fit = fitted(circle, &arcs)?;
        }
        let gate = Gate::new(GATE).at(arcs.len().saturating_sub(3));
        let is_told =
            arcs.len() >= FEWEST && fit.chi2 < gate && swept(&fit.parameters, &arcs) >= SWEPT;
        if !is_told {
            return None;
        }
        let gathered = self.explained(&ids, &fit.parameters);
        if let Some(again) = fitted(fit.parameters, &gathered)
            && again.chi2 < Gate::new(GATE).at(gathered.len() - 3)
        {
            (fit, arcs) = (again, gathered);
        }
        let circle = Circle::of(fit.parameters, covariance(&fit.parameters, &arcs)?);
        let members = || self.features.iter().filter(|f| ids.contains(&f.id));
        let (first, others) = (members().next()?, members().skip(1));
        Some(Round {
            feature: MapFeature {
                shape: Shape::Circle(circle),
                readings: u32::try_from(arcs.len()).unwrap_or(u32::MAX),
                runs: members().map(|f| f.runs).fold(0, u32::saturating_add),
                status: Status::Confirmed,
                ..*first
            },
            absorbed: others.map(|f| f.id).collect(),
        })
    }
}

/// The circle that some readings determine; `None` where it is no cylinder.
fn fitted(start: Parameters, arcs: &[Arc]) -> Option<CircleFit> {
    if arcs.len() < FEWEST {
        return None;
    }
    CircleFit::from(start, arcs).filter(CircleFit::is_cylinder)
}

/// The angle over which a circle is seen, from its centre: what is left of the turn beside the largest gap.
fn swept(circle: &Parameters, arcs: &[Arc]) -> f64 {
    let mut bearings: Vec<f64> = (arcs.iter())
        .map(|arc| direction(arc.center() - circle.xy()))
        .collect();
    bearings.sort_by(f64::total_cmp);
    let gaps = bearings.array_windows().map(|[a, b]| b - a);
    let around = bearings.first().zip(bearings.last());
    let around = around.map(|(first, last)| std::f64::consts::TAU - (last - first));
    let widest = gaps.chain(around).fold(0.0, f64::max);
    std::f64::consts::TAU - widest
}
