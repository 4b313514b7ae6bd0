//! What rough walls that are seen at an angle say of the walls of the map.
//!
//! A run of `oblique` arcs gives a line, too: through the near edge of the beam. How wide the beam is there is
//! hardly known, and it turns that line; so its covariance is large. It makes no wall, but where the map has
//! one that it is, that one is seen once more, and reaches as far.

use std::collections::BTreeMap;

use super::fusion::{fuse_by_information, mahalanobis_distance};
use crate::core::config::Config;
use crate::core::event::SonarId;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{MapFeature, Segment, Shape};
use crate::core::tmam::hearing::Hearing;
use crate::core::tmam::hypothesis::Gate;
use crate::core::tmam::label::{Label, Reason};
use crate::core::tmam::oblique::line_through_edge;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::Way;

/// How far the half width of the beam is off where walls of the map show it, and where only the log says
/// it, radians: one standard deviation.
const HALF_WIDTH_SHOWN: f64 = 1.0 * std::f64::consts::PI / 180.0;
const HALF_WIDTH_SAID: f64 = 3.0 * std::f64::consts::PI / 180.0;

/// Fewer readings than this lie on a line by chance; and more than so many are not fitted at once.
const FEWEST: usize = 4;
const MOST: usize = 64;

/// Chi2 with two degrees of freedom up to which a wall is the one that was seen: one in a thousand lies
/// beyond.
const GATE: f64 = 13.82;

/// A rough wall that a sonar saw at an angle in passing.
#[derive(Debug, Clone, PartialEq)]
pub struct RoughWall {
    /// The arcs, all of one sonar.
    pub arcs: Vec<Arc>,
    /// The wall as far as they reach.
    pub segment: Segment,
}

impl RoughWall {
    /// Those of all runs of `oblique` arcs, by sonar. `reports` are of every arc, in order; the walls of `map`
    /// show how wide the beams are.
    pub fn all(reports: &[ArcReport], map: &[MapFeature], config: &Config) -> Vec<Self> {
        let hearings = Hearing::of_sonars(reports, map);
        let gate = Gate::new(config.opinion.gate);
        let mut sequences: BTreeMap<SonarId, Vec<&ArcReport>> = BTreeMap::new();
        for report in reports {
            let sequence = sequences.entry(report.arc.id.sonar).or_default();
            sequence.push(report);
        }
        let mut walls = Vec::new();
        for (sonar, sequence) in &sequences {
            let shown = hearings.get(sonar).and_then(|hearing| hearing.half_width);
            let is_oblique =
                |report: &&ArcReport| report.label == Label::Unidentified(Reason::Oblique);
            let goes_on = |a: &&ArcReport, b: &&ArcReport| {
                is_oblique(a)
                    && is_oblique(b)
                    && b.follows_echo
                    && Way::between(&a.arc, &b.arc).continues(config)
            };
            for run in sequence.chunk_by(goes_on) {
                let arcs: Vec<Arc> = run.iter().map(|report| report.arc).collect();
                if run.first().is_some_and(is_oblique) {
                    walls.extend(in_parts(&arcs, shown, &gate));
                }
            }
        }
        walls
    }

    /// The one line of a map that it is, by its place, and that line fused with it; `None` where there is
    /// none, or more than one.
    pub fn known(&self, map: &[MapFeature], max_wall_gap: f64) -> Option<(usize, Shape)> {
        let seen = Shape::Line(self.segment);
        let is_seen = |shape: &Shape| {
            let distance = mahalanobis_distance(shape, &seen, max_wall_gap);
            distance.is_some_and(|distance| distance < GATE)
        };
        let mut known = map.iter().enumerate().filter(|(_, f)| is_seen(&f.shape));
        let (at, feature) = known.next()?;
        let is_only = known.next().is_none();
        is_only.then(|| (at, fuse_by_information(&feature.shape, &seen)))
    }
}

/// The map with its lines as far as rough walls show them.
pub fn extended(map: &[MapFeature], walls: &[RoughWall], max_wall_gap: f64) -> Vec<MapFeature> {
    let mut extended = map.to_vec();
    for wall in walls {
        if let Some((at, shape)) = wall.known(&extended, max_wall_gap)
            && let Some(feature) = extended.get_mut(at)
        {
            feature.shape = shape;
        }
    }
    extended
}

/// The walls of a run: as many of its arcs as one explains, from its start on.
fn in_parts(run: &[Arc], shown: Option<f64>, gate: &Gate) -> Vec<RoughWall> {
    let (mut walls, mut rest) = (Vec::new(), run);
    while rest.len() >= FEWEST {
        let longest = (FEWEST..=rest.len().min(MOST))
            .map_while(|count| {
                let arcs = rest.get(..count)?;
                Some((count, wall_of(arcs, shown, gate)?))
            })
            .last();
        let count = match longest {
            Some((count, segment)) => {
                walls.push(RoughWall {
                    arcs: rest.iter().take(count).copied().collect(),
                    segment,
                });
                count
            }
            None => 1,
        };
        rest = rest.get(count..).unwrap_or_default();
    }
    walls
}

/// The wall through the edges of the beams that explains all of some arcs.
fn wall_of(arcs: &[Arc], shown: Option<f64>, gate: &Gate) -> Option<Segment> {
    let said = arcs.first()?.beam_width / 2.0;
    let (half, off) = match shown {
        Some(half) => (half, HALF_WIDTH_SHOWN),
        None => (said, HALF_WIDTH_SAID),
    };
    line_through_edge(arcs, half, off, gate)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Vector2};

    use super::*;
    use crate::core::geometry::{Vec2, unit};
    use crate::core::tmam::feature::Status;
    use crate::core::tmam::fit::testing::{Gauss, SIGMA, arc};

    /// Of the wall: its normal's direction and its distance from the origin.
    const THETA: f64 = 1.4;
    const RHO: f64 = 3.0;
    const WIDTH: f64 = 1.0;

    /// Reports of a sensor on the way along x past a rough wall, whose foot is 0.4 rad beside the beam.
    fn passing(count: u32) -> Vec<ArcReport> {
        let yaw = THETA - 0.25 - 0.4;
        let mut noise = Gauss::new(4);
        let mut reports: Vec<ArcReport> = Vec::new();
        for k in 0..count {
            let sensor = Vec2::new(0.12 * f64::from(k), 0.0);
            let range = (RHO - unit(THETA).dot(&sensor)) / libm::cos(0.4);
            let mut report = ArcReport::new(arc(k, sensor, yaw, range + SIGMA * noise.sample()));
            report.follows_echo = !reports.is_empty();
            report.label = Label::Unidentified(Reason::Oblique);
            reports.push(report);
        }
        reports
    }

    /// A piece of a wall, tentative.
    fn piece(id: u32, theta: f64, rho: f64, from: f64) -> MapFeature {
        let covariance = Matrix2::identity() * 1e-6;
        let line = Segment::of_line_about(Vec2::zeros(), Vector2::new(rho, theta), covariance);
        let at = |way: f64| unit(theta) * rho + line.along() * way;
        MapFeature {
            id,
            shape: Shape::Line(line.reaching_over([at(from), at(from + WIDTH)])),
            readings: 5,
            runs: 1,
            status: Status::Tentative,
        }
    }

    fn seen(reports: &[ArcReport]) -> Vec<RoughWall> {
        RoughWall::all(reports, &[], &Config::default())
    }

    fn extent(feature: &MapFeature) -> [f64; 2] {
        match feature.shape {
            Shape::Line(segment) => segment.extent(),
            _ => panic!("no line"),
        }
    }

    #[test]
    fn a_rough_wall_extends_the_wall_that_it_is() {
        let walls = seen(&passing(12));
        assert_eq!(walls.len(), 1);
        let turn = walls[0].segment.covariance.m22.sqrt();
        assert!((0.1..10.0).contains(&turn.to_degrees()), "{turn}");
        let known = piece(3, THETA, RHO, -0.5);
        let after = extended(&[known], &walls, 1.0);
        let ([low, high], [before, end]) = (extent(&after[0]), extent(&known));
        assert!(
            low < before - 0.5 && (high - end).abs() < 0.1,
            "{low} {high}"
        );
        let Shape::Line(line) = after[0].shape else {
            panic!("a point")
        };
        assert!((line.theta - THETA).abs() < 1e-3 && (line.rho - RHO).abs() < 2e-3);
    }

    #[test]
    fn another_wall_stays_and_of_two_neither_is_taken() {
        let walls = seen(&passing(12));
        let parallel = piece(3, THETA, RHO + 0.6, -0.5);
        let beyond_a_gap = piece(4, THETA, RHO, 5.0);
        let map = [parallel, beyond_a_gap];
        assert_eq!(extended(&map, &walls, 1.0), map);
        let two = [piece(3, THETA, RHO, -0.5), piece(4, THETA, RHO, -0.8)];
        assert_eq!(extended(&two, &walls, 1.0), two);
    }

    #[test]
    fn few_readings_and_other_arcs_give_no_wall() {
        assert!(seen(&passing(3)).is_empty());
        let mut reports = passing(6);
        reports[3].label = Label::Contact;
        assert!(seen(&reports).is_empty(), "three and two");
        let mut reports = passing(12);
        for report in &mut reports[6..] {
            report.arc.range += 0.5;
        }
        let walls = seen(&reports);
        let readings: Vec<usize> = walls.iter().map(|wall| wall.arcs.len()).collect();
        assert_eq!(readings, [6, 6], "a second wall behind the first one");
    }
}
