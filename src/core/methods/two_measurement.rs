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
//! A sonar that moves without turning sees a point at a bearing before the step and at another one after it, and
//! the tangent's bearing lies between them: what both beams hold of a crossing they hold of the tangent, and the model
//! fails, as the paper says, but for lines whose foot is about to leave the beam. A turn decides. One after what
//! the sonar passes, as on the inside of a curve, keeps the crossing in both beams for longer than the tangent, and
//! points are told; one away from it, as on the outside or where a ring turns on the spot, does the reverse, and lines are.

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
                // It fixes no radius.
                PairTarget::Feature(Kind::Circle) => continue,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Vec2;
    use crate::core::tmam::fit::testing::arc;

    fn seeing(x: f64, y: f64, yaw: f64, range: impl Fn(Vec2) -> f64) -> Arc {
        let sensor = Vec2::new(x, y);
        Arc {
            beam_width: 22.5_f64.to_radians(),
            ..arc(0, sensor, yaw.to_radians(), range(sensor))
        }
    }

    #[test]
    fn a_point_is_told_where_the_sonar_turned() {
        let corner = unit(10_f64.to_radians());
        let range = |sensor: Vec2| (corner - sensor).norm();
        let (a, b) = (seeing(0.0, 0.0, -1.0, range), seeing(0.3, 0.0, 24.0, range));
        assert_eq!(target(&a, &b), PairTarget::Feature(Kind::Point));
        // Had it not turned, the beams would hold the tangent as well.
        let (a, b) = (seeing(0.0, 0.0, 12.0, range), seeing(0.3, 0.0, 12.0, range));
        assert_eq!(target(&a, &b), PairTarget::Neither(Reason::Ambiguous));
    }

    #[test]
    fn a_line_is_told_where_its_foot_is_about_to_leave_the_beam() {
        let range = |sensor: Vec2| 1.0 - sensor.x;
        let pair = |yaw| [seeing(0.0, 0.0, yaw, range), seeing(0.0, 0.12, yaw, range)];
        let [a, b] = pair(-11.2);
        assert_eq!(target(&a, &b), PairTarget::Feature(Kind::Line));
        let [a, b] = pair(0.0);
        assert_eq!(target(&a, &b), PairTarget::Neither(Reason::Ambiguous));
    }

    #[test]
    fn a_line_is_told_where_the_sonar_turned_away() {
        let range = |sensor: Vec2| 1.0 - sensor.x;
        let turned = |by: f64| [seeing(0.0, 0.0, -by, range), seeing(0.0, 0.3, by, range)];
        let [a, b] = turned(7.0);
        assert_eq!(target(&a, &b), PairTarget::Feature(Kind::Line));
        let [a, b] = turned(-7.0);
        assert_eq!(target(&a, &b), PairTarget::Neither(Reason::Ambiguous));
    }

    #[test]
    fn a_radius_between_is_an_arc_feature() {
        let post = Vec2::new(1.5, 0.2);
        let range = |sensor: Vec2| (post - sensor).norm() - 0.5;
        let (a, b) = (seeing(0.0, 0.0, -3.2, range), seeing(0.3, 0.0, 19.6, range));
        assert_eq!(target(&a, &b), PairTarget::Neither(Reason::ArcFeature));
    }
}
