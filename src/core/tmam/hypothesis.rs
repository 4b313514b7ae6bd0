//! Hypothesis test: which of a line, a point and, where they are asked for, a circle explains neighbouring readings within their noise.
//!
//! The paper compares two angles; it does not ask whether the readings are precise enough to tell.
//! Here a line and a point are fitted to the same readings, inside the beams, and the weighted
//! squares of what remains say what the readings themselves support.

mod circle;
mod gate;
mod line;
mod minimum;
mod point;

pub use gate::Gate;

use serde::Serialize;

use self::line::BestLine;
use super::arc::Arc;
use super::circle::FEWEST;
use super::label::{Kind, Label, Reason};

/// What readings support.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Support {
    /// Only a line explains them.
    Line,
    /// Only a point does.
    Point,
    /// Only a circle does, and there are more readings than it has unknowns.
    Circle,
    /// Both do: the base line is too short for the noise, or the target is seen end-on.
    Ambiguous,
    /// Neither does: they come from different targets.
    Neither,
}

/// A line and a point tested on neighbouring readings of one sonar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HypothesisTest {
    /// How many readings; two more than there are degrees of freedom.
    pub readings: usize,
    /// Weighted squares that remain of the best line inside the beams; infinite where the beams
    /// have no bearing in common.
    pub chi2_line: f64,
    /// The same of the best point.
    pub chi2_point: f64,
    /// The same of the best circle, which has one degree of freedom less; `None` where circles are not asked for.
    pub chi2_circle: Option<f64>,
    /// What either must stay below to explain so many readings.
    pub gate: f64,
    /// What a circle must stay below.
    pub gate_circle: f64,
    /// Whether the line fits better still where its foot leaves the beams: a smooth wall does not echo
    /// from there, a rough one does, with other ranges.
    pub is_beside: bool,
    /// What follows from the comparisons.
    pub support: Support,
}

impl HypothesisTest {
    /// Of neighbouring arcs, at least three of them.
    pub fn of(arcs: &[Arc], gate: &Gate) -> Self {
        Self::with_circles(false, arcs, gate)
    }

    /// The same, with circles if they are asked for.
    pub fn with_circles(circles: bool, arcs: &[Arc], gate: &Gate) -> Self {
        let (line, point) = (line::best(arcs), point::least_chi2(arcs));
        let circle = circles.then(|| circle::least_chi2(arcs));
        Self::from_chi2(arcs.len(), line, point, circle, gate)
    }

    /// The same readings under another gate.
    pub fn under(&self, gate: &Gate) -> Self {
        let line = BestLine {
            chi2: self.chi2_line,
            is_beside: self.is_beside,
        };
        Self::from_chi2(self.readings, line, self.chi2_point, self.chi2_circle, gate)
    }

    fn from_chi2(
        readings: usize,
        line: BestLine,
        chi2_point: f64,
        chi2_circle: Option<f64>,
        gate: &Gate,
    ) -> Self {
        let chi2_line = line.chi2;
        let gate_circle = gate.at(readings.saturating_sub(3));
        let gate = gate.at(readings.saturating_sub(2));
        let is_circle = chi2_circle.is_some_and(|chi2| chi2 < gate_circle) && readings >= FEWEST;
        Self {
            readings,
            chi2_line,
            chi2_point,
            chi2_circle,
            gate,
            gate_circle,
            is_beside: line.is_beside,
            support: match (chi2_line < gate, chi2_point < gate) {
                (true, false) => Support::Line,
                (false, true) => Support::Point,
                (true, true) => Support::Ambiguous,
                (false, false) if is_circle => Support::Circle,
                (false, false) => Support::Neither,
            },
        }
    }

    /// How many readings it has to either side of the one in the middle.
    pub fn half_width(&self) -> usize {
        self.readings / 2
    }

    /// chi2 of the best feature of a kind.
    pub fn chi2_of(&self, kind: Kind) -> f64 {
        match kind {
            Kind::Line => self.chi2_line,
            Kind::Point => self.chi2_point,
            Kind::Circle => self.chi2_circle.unwrap_or(f64::INFINITY),
        }
    }

    /// Whether a circle explains the readings, or there are too few of them to say no.
    fn may_be_circle(&self) -> bool {
        (self.chi2_circle).is_some_and(|chi2| self.readings < FEWEST || chi2 < self.gate_circle)
    }

    /// The kind of feature that alone explains the readings, where the other one is worse by at
    /// least `decisive`, and a line's foot is in the beams. A circle, which has a parameter more, must be
    /// better than both by that.
    pub fn decided(&self, decisive: f64) -> Option<Kind> {
        if self.beyond(Kind::Circle, decisive) >= 0.0 {
            return Some(Kind::Circle);
        }
        let kind = self.support.kind()?;
        let (lead, is_open) = match kind {
            Kind::Line => (self.chi2_point - self.chi2_line, self.is_beside),
            Kind::Point => (self.chi2_line - self.chi2_point, false),
            Kind::Circle => return None,
        };
        (lead >= decisive && !is_open).then_some(kind)
    }

    /// The label that the readings give the arc in their middle.
    pub fn label(&self, decisive: f64) -> Label {
        match self.decided(decisive) {
            Some(kind) => kind.label(),
            None if self.support == Support::Neither => Label::Unidentified(Reason::Neither),
            None => Label::Unidentified(Reason::Ambiguous),
        }
    }

    /// Whether more readings would tell no more: they decide, or no kind explains them. What is a point so far
    /// may still turn out to be a circle, where these are asked for.
    pub fn is_final(&self, decisive: f64) -> bool {
        match self.decided(decisive) {
            Some(Kind::Point) => self.chi2_circle.is_none(),
            Some(Kind::Line | Kind::Circle) => true,
            None => self.support == Support::Neither && !self.may_be_circle(),
        }
    }

    /// Which of several windows, narrowest first, decides: the first that does, or the last one where that tells
    /// a circle.
    pub fn deciding(windows: &[Self], decisive: f64) -> Option<usize> {
        let kind = |test: &Self| test.decided(decisive);
        if windows.last().and_then(kind) == Some(Kind::Circle) {
            return Some(windows.len() - 1);
        }
        windows.iter().position(|test| kind(test).is_some())
    }

    /// How far the readings are beyond deciding for a kind, as chi2: the least of its room below the
    /// gate, the other kind's excess over it, and what the lead has beyond `decisive`. Negative where
    /// they do not decide for it; without end where no gate would make them.
    pub fn beyond(&self, kind: Kind, decisive: f64) -> f64 {
        if kind == Kind::Line && self.is_beside {
            return f64::NEG_INFINITY;
        }
        let (own, other) = match kind {
            Kind::Line => (self.chi2_line, self.chi2_point),
            Kind::Point => (self.chi2_point, self.chi2_line),
            Kind::Circle => {
                let circle = self.chi2_circle.filter(|_| self.readings >= FEWEST);
                let other = self.chi2_line.min(self.chi2_point);
                return circle.map_or(f64::NEG_INFINITY, |own| {
                    (self.gate_circle - own).min(other - own - decisive)
                });
            }
        };
        // Of two infinite ones there is no difference, and no room below the gate either.
        let gate = self.gate;
        (gate - own).min(other - gate).min(other - own - decisive)
    }

    /// Whether the readings contradict a label.
    pub fn contradicts(&self, label: Label) -> bool {
        use Support::{Circle, Line, Neither, Point};
        match label {
            Label::Contact => matches!(self.support, Point | Circle | Neither),
            Label::Intersection => matches!(self.support, Line | Circle | Neither),
            Label::Circle => self.chi2_circle.is_some() && !self.may_be_circle(),
            Label::Unidentified(_) => false,
        }
    }
}

impl Support {
    /// The word in files: `line`, `point`, `circle`, `ambiguous` or `neither`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Point => "point",
            Self::Circle => "circle",
            Self::Ambiguous => "ambiguous",
            Self::Neither => "neither",
        }
    }

    /// The one kind of feature that explains the readings.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::Line => Some(Kind::Line),
            Self::Point => Some(Kind::Point),
            Self::Circle => Some(Kind::Circle),
            Self::Ambiguous | Self::Neither => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::SonarId;
    use crate::core::geometry::{Pose2, Vec2, unit};
    use crate::core::tmam::arc::ArcId;
    use proptest::prelude::*;

    const GATE: f64 = 6.63;

    /// Three arcs of a sensor that looks along `yaw`, a step of 12 cm apart along x.
    fn triple(yaw: f64, sigma: f64, range: impl Fn(Vec2) -> f64) -> [Arc; 3] {
        [0.0, 0.12, 0.24].map(|x| {
            let sensor = Vec2::new(x, 0.0);
            Arc {
                id: ArcId {
                    frame: 0,
                    sonar: SonarId(0),
                },
                stamp_ns: 0,
                world_from_sensor: Pose2::new(sensor.x, sensor.y, yaw),
                range: range(sensor),
                beam_width: 0.5,
                variance: sigma * sigma,
            }
        })
    }

    fn opinion(arcs: &[Arc; 3]) -> HypothesisTest {
        HypothesisTest::of(arcs, &Gate::new(GATE))
    }

    proptest! {
        #[test]
        fn exact_readings_support_what_gave_them(yaw in 1.1..2.0f64, tilt in -0.1..0.1f64, rho in 1.5..4.0f64) {
            let normal = unit(yaw + tilt);
            let wall = opinion(&triple(yaw, 1e-5, |s| rho - normal.dot(&s)));
            prop_assert!(wall.chi2_line < 1e-3, "{wall:?}");
            prop_assert_eq!(wall.support, Support::Line);
            let corner = Vec2::new(0.12, 0.0) + unit(yaw + tilt) * rho;
            let point = opinion(&triple(yaw, 1e-5, |s| (corner - s).norm()));
            prop_assert!(point.chi2_point < 1e-3, "{point:?}");
            prop_assert_eq!(point.support, Support::Point);
        }

        #[test]
        fn coarse_readings_decide_nothing(yaw in 1.3..1.8f64, rho in 1.0..3.0f64) {
            let normal = unit(yaw);
            let wall = opinion(&triple(yaw, 0.1, |s| rho - normal.dot(&s)));
            prop_assert_eq!(wall.support, Support::Ambiguous);
        }
    }

    #[test]
    fn readings_of_different_targets_support_nothing() {
        let found = opinion(&triple(
            1.57,
            0.003,
            |s| if s.x == 0.12 { 2.5 } else { 2.0 },
        ));
        assert_eq!(found.support, Support::Neither);
        assert!(found.contradicts(Label::Contact) && found.contradicts(Label::Intersection));
    }

    #[test]
    fn seen_end_on_a_wall_and_a_point_look_alike() {
        let found = opinion(&triple(0.0, 0.003, |s| 3.0 - s.x));
        assert_eq!(found.support, Support::Ambiguous, "{found:?}");
        assert!(!found.contradicts(Label::Contact));
    }

    #[test]
    fn a_line_that_fits_best_beside_the_beams_decides_nothing() {
        // A rough wall echoes along the edge of the beams, its foot 0.2 rad beside that.
        let normal = unit(1.57 - 0.45);
        let rough = |s: Vec2| (3.0 - normal.dot(&s)) / libm::cos(0.2);
        let found = opinion(&triple(1.57, 0.014, rough));
        assert_eq!(found.support, Support::Line, "{found:?}");
        assert_eq!(found.decided(0.0), None);
        assert!(!found.is_final(0.0) && found.beyond(Kind::Line, 0.0) < 0.0);
        // With its foot in the beams it does.
        let normal = unit(1.57 - 0.2);
        let smooth = opinion(&triple(1.57, 1e-4, |s| 3.0 - normal.dot(&s)));
        assert_eq!(smooth.decided(0.0), Some(Kind::Line), "{smooth:?}");
    }

    #[test]
    fn beams_without_a_common_bearing_have_no_line() {
        let mut arcs = triple(1.57, 0.003, |_| 2.0);
        arcs[2].world_from_sensor.yaw = 0.2;
        assert_eq!(opinion(&arcs).chi2_line, f64::INFINITY);
    }

    #[test]
    fn chi2_has_one_degree_of_freedom() {
        // Over many noisy triples of a wall, the mean of chi2 is one.
        let mut rng = crate::core::tmam::fit::testing::Gauss::new(5);
        let (sigma, n) = (0.003, 2000);
        let sum: f64 = (0..n)
            .map(|_| {
                let mut arcs = triple(1.6, sigma, |_| 2.0);
                for arc in &mut arcs {
                    arc.range += sigma * rng.sample();
                }
                opinion(&arcs).chi2_line
            })
            .sum();
        let mean = sum / f64::from(n);
        assert!((0.85..1.15).contains(&mean), "{mean}");
    }
}
