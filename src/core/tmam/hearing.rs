//! How much of what each sonar hears the two hypotheses explain, and how much of it rough walls do.
//!
//! A sonar that looks at rough walls at an angle, whose mount is wrong or that hears others has hardly a
//! triple that a wall or a point explains. What it makes of the few that are left is chance.

use std::collections::{BTreeMap, BTreeSet};

use super::feature::{MapFeature, Segment, Shape, Status};
use super::hypothesis::Support;
use super::label::{Label, Reason};
use super::report::ArcReport;
use super::residual::RangeResidual;
use crate::core::event::SonarId;
use crate::core::geometry::{unit, wrap_angle};

/// Of a sonar of which a smaller share than this is explained, hardly a triple is.
const HARDLY: f64 = 0.3;
/// Fewer triples than this tell nothing of a sonar.
const ENOUGH: u64 = 30;
/// Fewer arcs than this tell nothing of its beam.
const ENOUGH_OBLIQUE: usize = 10;
/// A rough wall may go on beyond what was seen of it by this, metres.
const BEYOND: f64 = 0.5;

/// What is known of what one sonar hears.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Hearing {
    /// Triples of neighbouring arcs.
    pub triples: u64,
    /// Those around which a line or a point explains the readings, or both do.
    pub explained: u64,
    /// Arcs of rough walls that are seen at an angle.
    pub oblique: u64,
    /// Half the width of the beam as rough walls show it that the map knows, radians.
    pub half_width: Option<f64>,
}

impl Hearing {
    /// Whether hardly a triple is explained.
    pub fn is_hardly_explained(&self) -> bool {
        self.triples >= ENOUGH && (self.explained as f64) < HARDLY * self.triples as f64
    }

    /// The sonars of which hardly a triple is explained.
    pub fn hardly_explained(reports: &[ArcReport]) -> BTreeSet<SonarId> {
        let hearings = Self::of_sonars(reports, &[]).into_iter();
        let hardly = hearings.filter(|(_, hearing)| hearing.is_hardly_explained());
        hardly.map(|(sonar, _)| sonar).collect()
    }

    /// Of every sonar, by the reports of all its arcs and the final map.
    pub fn of_sonars(reports: &[ArcReport], map: &[MapFeature]) -> BTreeMap<SonarId, Self> {
        let mut sonars: BTreeMap<SonarId, (Self, Vec<f64>)> = BTreeMap::new();
        let walls: Vec<Segment> = map
            .iter()
            .filter(|feature| feature.status == Status::Confirmed)
            .filter_map(|feature| match feature.shape {
                Shape::Line(segment) => Some(segment),
                Shape::Point(_) | Shape::Circle(_) => None,
            })
            .collect();
        for report in reports.iter().filter(|report| report.triple.is_some()) {
            let (hearing, halves) = sonars.entry(report.arc.id.sonar).or_default();
            let support = report.window.map(|window| window.support);
            hearing.triples += 1;
            hearing.explained += u64::from(support.is_some_and(|s| s != Support::Neither));
            if report.label == Label::Unidentified(Reason::Oblique) {
                hearing.oblique += 1;
                let shown = walls.iter().filter_map(|wall| half_width(report, wall));
                let nominal = report.arc.beam_width / 2.0;
                halves.extend(shown.min_by(|a, b| {
                    let off = |half: &f64| (half - nominal).abs();
                    off(a).total_cmp(&off(b))
                }));
            }
        }
        let whole = |(mut hearing, mut halves): (Self, Vec<f64>)| {
            halves.sort_by(f64::total_cmp);
            let middle = halves.get(halves.len() / 2).copied();
            hearing.half_width = middle.filter(|_| halves.len() >= ENOUGH_OBLIQUE);
            hearing
        };
        let sonars = sonars.into_iter();
        sonars.map(|(sonar, of)| (sonar, whole(of))).collect()
    }
}

/// How far from its axis the beam meets a wall where the range does; `None` where it does not within
/// twice its half width, on the side of the foot.
fn half_width(report: &ArcReport, wall: &Segment) -> Option<f64> {
    let arc = &report.arc;
    let foot = RangeResidual::of_line(wall, arc);
    let distance = arc.range - foot.residual;
    if !(distance > 0.0 && distance < arc.range) {
        return None;
    }
    let to_foot = wrap_angle(foot.bearing - arc.world_from_sensor.yaw);
    let half = to_foot.abs() - libm::acos(distance / arc.range);
    let met = arc.point_at(arc.world_from_sensor.yaw + half.abs().copysign(to_foot));
    let way = (met - wall.mid).perp(&unit(wall.theta)).abs();
    let is_beam = (0.0..=arc.beam_width).contains(&half);
    (is_beam && way <= wall.half_length + BEYOND).then_some(half)
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix2;

    use super::*;
    use crate::core::geometry::Vec2;
    use crate::core::tmam::fit::testing::arc;
    use crate::core::tmam::hypothesis::Gate;
    use crate::core::tmam::triple::TripleTest;
    use crate::core::{config::Triple, tmam::hypothesis::HypothesisTest};

    /// The middle one of three arcs that measure these ranges on the way along x, with its label.
    fn report(ranges: [f64; 3], yaw: f64, label: Label) -> ArcReport {
        let at = |k: u32, range| arc(k, Vec2::new(0.1 * f64::from(k), 0.0), yaw, range);
        let three = [at(0, ranges[0]), at(1, ranges[1]), at(2, ranges[2])];
        let gate = Gate::new(6.63);
        let mut report = ArcReport::new(three[1]);
        report.label = label;
        report.triple = Some(TripleTest::of(&three, &Triple::default(), &gate));
        report.window = Some(HypothesisTest::of(&three, &gate));
        report
    }

    #[test]
    fn a_sonar_with_three_of_ten_triples_explained_is_trusted() {
        let one = |explained: bool| {
            let middle = if explained { 2.0 } else { 3.0 };
            report([2.0, middle, 2.0], 1.57, Label::Contact)
        };
        for (explained, hardly) in [(12, false), (11, true), (0, true)] {
            let reports: Vec<ArcReport> = (0..40).map(|k| one(k < explained)).collect();
            let hearing = Hearing::of_sonars(&reports, &[])[&SonarId(0)];
            assert_eq!((hearing.triples, hearing.explained), (40, explained));
            assert_eq!(hearing.is_hardly_explained(), hardly, "{hearing:?}");
            let few = Hearing::of_sonars(&reports[11..40], &[])[&SonarId(0)];
            assert!(!few.is_hardly_explained(), "too few to tell");
        }
    }

    #[test]
    fn walls_of_the_map_show_how_wide_the_beam_is() {
        // A wall along y = 2, seen to the right of where it is nearest, 0.15 off the axis.
        let wall = MapFeature {
            id: 0,
            shape: Shape::Line(Segment {
                rho: 2.0,
                theta: std::f64::consts::FRAC_PI_2,
                covariance: Matrix2::identity() * 1e-6,
                mid: Vec2::new(2.0, 2.0),
                half_length: 2.0,
            }),
            readings: 9,
            runs: 2,
            status: Status::Confirmed,
        };
        let range = 2.0 / libm::sin(0.8 + 0.15);
        let label = Label::Unidentified(Reason::Oblique);
        let reports = vec![report([range; 3], 0.8, label); 10];
        let hearing = Hearing::of_sonars(&reports, &[wall])[&SonarId(0)];
        assert_eq!(hearing.oblique, 10);
        assert!(
            (hearing.half_width.unwrap() - 0.15).abs() < 1e-9,
            "{hearing:?}"
        );
        let few = Hearing::of_sonars(&reports[1..], &[wall])[&SonarId(0)];
        assert_eq!(few.half_width, None);
        let unknown = Hearing::of_sonars(&reports, &[])[&SonarId(0)];
        assert_eq!(unknown.half_width, None);
    }
}
