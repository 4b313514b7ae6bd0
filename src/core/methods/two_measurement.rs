//! Two measurements: the model that TMAM replaces, equation (4) of its paper over all bearings of a beam.
//!
//! Leonard and Durrant-Whyte, *Directed Sonar Sensing for Mobile Robot Navigation* (1992), have the geometry;
//! the rule is as Wang et al. tell it: of two neighbouring readings the radius of the circle that both
//! touch is looked at for every bearing. A least radius that is very large makes a line, a largest one that
//! is very small a point, all else an *arc feature*. Where the arcs have both a common tangent and a
//! crossing, the least radius is 0 and the largest infinite: the model fails.
//!
//! Assumed: neighbouring readings of one sonar; *very large* and *very small* are [`LARGE`] and [`SMALL`], of
//! which the paper says nothing; features are fitted to the pair and fused by information, as TMAM does, so that
//! nothing but the model differs.
//!
//! Pairs of steps as short as a decimetre nearly always have a tangent and a crossing, so it decides only
//! where one of them just leaves the beam.

use std::collections::BTreeMap;

use super::rival::{Found, Rival, Scan};
use super::sequences::Sequences;
use crate::core::config::{Config, Map as Bounds};
use crate::core::geometry::{direction, unit};
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::{MapFeature, Shape};
use crate::core::tmam::fit::{FitOptions, fit_line, fit_point};
use crate::core::tmam::label::{Kind, Reason};
use crate::core::tmam::map::fusion::{fuse_by_information, mahalanobis_distance};
use crate::core::tmam::pair::{Points, circle_radius};

/// A target of at least this radius is a line, metres.
const LARGE: f64 = 1.0;
/// One of at most this radius is a point, metres.
const SMALL: f64 = 0.2;
/// Bearings that are looked at.
const BEARINGS: u32 = 64;

/// What the readings of a pair come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PairTarget {
    Feature(Kind),
    Neither(Reason),
}

/// The last reading of each sonar, and why arcs belong to no feature.
#[derive(Debug)]
pub struct TwoMeasurement {
    sequences: Sequences,
    reasons: BTreeMap<ArcId, Reason>,
}

impl TwoMeasurement {
    pub fn new(config: &Config) -> Self {
        Self {
            sequences: Sequences::new(2, &config.sequence),
            reasons: BTreeMap::new(),
        }
    }
}

/// What the radii of all bearings say.
fn target(a: &Arc, b: &Arc) -> PairTarget {
    let points = Points::of(a, b);
    let has_tangent = points.contact.iter().any(Option::is_some);
    let has_crossing = points.intersection.iter().any(Option::is_some);
    if has_tangent && has_crossing {
        return PairTarget::Neither(Reason::Ambiguous);
    }
    let mut radii: Vec<f64> = radii(a, b).collect();
    radii.extend(has_tangent.then_some(f64::INFINITY));
    radii.extend(has_crossing.then_some(0.0));
    let bounds = radii.iter().map(|radius| (*radius, *radius));
    let bounds = bounds.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    match bounds {
        None => PairTarget::Neither(Reason::NoPoints),
        Some((least, _)) if least >= LARGE => PairTarget::Feature(Kind::Line),
        Some((_, largest)) if largest <= SMALL => PairTarget::Feature(Kind::Point),
        Some(_) => PairTarget::Neither(Reason::ArcFeature),
    }
}

/// The radius of every bearing of the first beam, where both beams hold the circle.
fn radii(a: &Arc, b: &Arc) -> impl Iterator<Item = f64> {
    let baseline = b.center() - a.center();
    let (d, base) = (baseline.norm(), direction(baseline));
    let shares = (0..=BEARINGS).map(|i| f64::from(i) / f64::from(BEARINGS) - 0.5);
    shares.filter_map(move |share| {
        let bearing = a.world_from_sensor.yaw + share * a.beam_width;
        let radius = circle_radius(a.range, b.range, d, libm::cos(bearing - base)); // (4)
        let center = a.center() + unit(bearing) * (a.range + radius);
        let is_held = radius.is_finite() && b.beam_holds(direction(center - b.center()));
        (radius >= 0.0 && is_held).then_some(radius)
    })
}

impl Rival for TwoMeasurement {
    fn take(&mut self, scan: &Scan) -> Vec<Found> {
        let to_the_end = FitOptions {
            converge: true,
            ..FitOptions::default()
        };
        let mut found = Vec::new();
        for pair in self.sequences.take(scan) {
            let [a, b] = pair.as_slice() else {
                continue;
            };
            let fit = match target(a, b) {
                PairTarget::Feature(Kind::Line) => fit_line(&pair, &to_the_end),
                PairTarget::Feature(Kind::Point) => fit_point(&pair, &to_the_end),
                PairTarget::Neither(reason) => {
                    self.reasons.insert(b.id, reason);
                    continue;
                }
            };
            if let (Some(shape), None) = (fit.shape, fit.rejection) {
                found.push(Found { shape, arcs: pair });
            }
        }
        found
    }

    fn distance(&self, known: &MapFeature, shape: &Shape, bounds: &Bounds) -> Option<f64> {
        mahalanobis_distance(shape, &known.shape, bounds.max_wall_gap)
            .filter(|distance| *distance < bounds.gate)
    }

    fn fused(&self, known: &MapFeature, shape: &Shape, _readings: u32) -> Shape {
        fuse_by_information(&known.shape, shape)
    }

    fn reason(&self, arc: ArcId) -> Reason {
        self.reasons.get(&arc).copied().unwrap_or(Reason::Missing)
    }
}
