//! Odometry that an estimated path has stretched: its map is right, and so no replay gains by a mended scale, but
//! the scale is known.

use super::candidate::{Candidate, Estimated};
use super::parameter::{Parameter, Quantity, Whose};
use crate::core::joint::JointEstimate;

/// A path is corrected by less of a share by chance.
const LEAST: f64 = 0.01;

/// A scale of which so much is left was not it.
const LEFT: f64 = 0.5;

/// What a path says of odometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretched {
    /// By which shares distances and turns are too short.
    scales: [Estimated; 2],
    /// Share of the arcs that the map of odometry's own poses explains.
    pub explained: f64,
}

impl Stretched {
    /// Of an estimated path.
    pub fn of(joint: &JointEstimate) -> Self {
        let of = |parameter, at: usize| Estimated {
            parameter,
            value: joint.scales.get(at).copied().unwrap_or_default(),
            deviation: joint.scale_sigmas.get(at).copied().unwrap_or_default(),
        };
        Self {
            scales: [
                of(Parameter::OdometryScale, 0),
                of(Parameter::OdometryTurnScale, 1),
            ],
            explained: joint.explained[0].share,
        }
    }

    /// What distances that are too short may come of.
    pub fn candidates(&self, gain: f64) -> Vec<Candidate> {
        let [distance, _] = &self.scales;
        let all = if distance.value.abs() < LEAST {
            Vec::new()
        } else {
            Self::stands_for(distance)
        };
        let of = |one| Candidate {
            values: vec![one],
            gain,
        };
        all.into_iter().map(of).collect()
    }

    /// What a scale may come of: itself, and where it is of distances, ranges that are too long by as much.
    pub fn stands_for(scale: &Estimated) -> Vec<Estimated> {
        let ranges = Estimated {
            parameter: Parameter::Sonar(Whose::All, Quantity::RangeScale),
            value: 1.0 / (1.0 + scale.value) - 1.0,
            ..*scale
        };
        let is_of_distances = scale.parameter == Parameter::OdometryScale;
        let ranges = is_of_distances.then_some(ranges);
        [*scale].into_iter().chain(ranges).collect()
    }

    /// The scales that are off by more than chance, the surest first.
    pub fn off(&self) -> Vec<Estimated> {
        let is_off = |one: &&Estimated| one.value.abs() > LEAST && one.is_sure();
        let mut off: Vec<Estimated> = self.scales.iter().filter(is_off).copied().collect();
        let sure = |one: &Estimated| (one.value / one.deviation).abs();
        off.sort_by(|a, b| sure(b).total_cmp(&sure(a)));
        off
    }

    /// Whether a scale is right in a later replay, and odometry's own map better for it.
    pub fn is_mended_in(&self, later: &Self, scale: &Estimated) -> bool {
        let mut left = later
            .scales
            .iter()
            .filter(|one| one.parameter == scale.parameter);
        left.all(|left| left.value.abs() < LEFT * scale.value.abs())
            && later.explained > self.explained
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stretched(scales: [(f64, f64); 2], explained: f64) -> Stretched {
        let of = |parameter, (value, deviation)| Estimated {
            parameter,
            value,
            deviation,
        };
        Stretched {
            scales: [
                of(Parameter::OdometryScale, scales[0]),
                of(Parameter::OdometryTurnScale, scales[1]),
            ],
            explained,
        }
    }

    #[test]
    fn a_scale_is_off_by_more_than_chance_and_the_surest_is_first() {
        let off = |scales| -> Vec<Parameter> {
            let off = stretched(scales, 0.5).off().into_iter();
            off.map(|one| one.parameter).collect()
        };
        assert_eq!(
            off([(0.02, 0.0025), (0.001, 0.0001)]),
            [Parameter::OdometryScale]
        );
        assert_eq!(off([(0.02, 0.006), (0.0, 0.001)]), []);
        assert_eq!(
            off([(0.02, 0.004), (-0.03, 0.003)]),
            [Parameter::OdometryTurnScale, Parameter::OdometryScale]
        );
    }

    #[test]
    fn a_scale_is_mended_where_little_of_it_is_left_and_odometry_explains_more() {
        let before = stretched([(0.02, 0.002), (0.0, 0.001)], 0.5);
        let scale = before.off()[0];
        let is_mended = |left, explained| {
            let later = stretched([(left, 0.002), (0.05, 0.001)], explained);
            before.is_mended_in(&later, &scale)
        };
        assert!(is_mended(-0.003, 0.66));
        assert!(!is_mended(0.012, 0.66) && !is_mended(-0.003, 0.5));
    }

    #[test]
    fn distances_that_are_too_short_may_be_ranges_that_are_too_long() {
        let [distance, ranges] = &stretched([(0.25, 0.01), (0.0, 0.01)], 0.5).candidates(7.0)[..]
        else {
            panic!("two");
        };
        assert_eq!(distance.values[0].value, 0.25);
        assert!((ranges.values[0].value + 0.2).abs() < 1e-12);
        assert!(
            stretched([(0.009, 0.001), (0.2, 0.01)], 0.5)
                .candidates(7.0)
                .is_empty()
        );
    }
}
