//! A log with other mounts, clocks, ranges and odometry.

use std::collections::BTreeMap;

use super::parameter::{Parameter, Quantity, Whose};
use crate::core::config::{Config, SonarOverride};
use crate::core::event::{Events, OdometrySample, Return, Sonar, SonarId};
use crate::core::geometry::{Pose2, wrap_angle};

/// By how much parameters change; those that are not named stay.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Change {
    /// In the order of the parameters, in SI units and radians.
    pub by: BTreeMap<Parameter, f64>,
}

impl Change {
    /// What a configuration changes in the ranges and the odometry that messages give. (Mounts and beams
    /// are taken from it before; clocks act where poses are looked up.)
    pub fn of_configuration(config: &Config, sonars: &[Sonar]) -> Self {
        let mut by = BTreeMap::new();
        let mut change = |parameter, value: f64| {
            if value != 0.0 {
                by.insert(parameter, value);
            }
        };
        let input = &config.input;
        change(Parameter::OdometryScale, input.odometry_scale - 1.0);
        change(
            Parameter::OdometryTurnScale,
            input.odometry_turn_scale - 1.0,
        );
        for (place, sonar) in (0..).zip(sonars) {
            let [scale, offset] = configured_range(config, &sonar.name);
            let whose = Whose::One(SonarId(place));
            change(Parameter::Sonar(whose, Quantity::RangeScale), scale - 1.0);
            change(Parameter::Sonar(whose, Quantity::RangeOffset), offset);
            let delay = configured_delay(config, &sonar.name);
            change(Parameter::Sonar(whose, Quantity::Delay), delay);
        }
        Self { by }
    }

    /// Whether nothing changes.
    pub fn is_empty(&self) -> bool {
        self.by.is_empty()
    }

    /// With more of a parameter.
    pub fn add(&mut self, parameter: Parameter, value: f64) {
        *self.by.entry(parameter).or_default() += value;
    }

    /// Both changes, one after the other.
    pub fn and(&self, other: &Self) -> Self {
        let mut both = self.clone();
        for (parameter, value) in &other.by {
            both.add(*parameter, *value);
        }
        both
    }

    /// The value of a parameter.
    pub fn of(&self, parameter: Parameter) -> f64 {
        self.by.get(&parameter).copied().unwrap_or_default()
    }

    fn of_sonar(&self, sonar: SonarId, quantity: Quantity) -> f64 {
        self.of(Parameter::Sonar(Whose::All, quantity))
            + self.of(Parameter::Sonar(Whose::One(sonar), quantity))
    }

    /// Changes a log's mounts, beams, ranges and odometry.
    pub fn apply(&self, events: &mut Events) {
        if self.is_empty() {
            return;
        }
        for (place, sonar) in (0..).zip(&mut events.sonars) {
            let of = |quantity| self.of_sonar(SonarId(place), quantity);
            let mount = sonar.robot_from_sensor;
            sonar.robot_from_sensor = Pose2::new(
                mount.x + of(Quantity::X),
                mount.y + of(Quantity::Y),
                mount.yaw + of(Quantity::Yaw),
            );
        }
        let mut is_delayed = false;
        events.readings.change(|reading| {
            let of = |quantity| self.of_sonar(reading.sonar, quantity);
            let [scale, offset] = [1.0 + of(Quantity::RangeScale), of(Quantity::RangeOffset)];
            let wider = of(Quantity::BeamWidth);
            // What is no echo stays none.
            if reading.classify() == Return::Echo {
                reading.range = reading.range * scale + offset;
            }
            reading.min_range = reading.min_range * scale + offset;
            reading.max_range = reading.max_range * scale + offset;
            reading.beam_width += wider;
            let delay_ns = nanoseconds(of(Quantity::Delay));
            reading.stamp_ns = reading.stamp_ns.saturating_sub(delay_ns);
            is_delayed |= delay_ns != 0;
        });
        if is_delayed {
            events.sort();
        }
        let scales = [Parameter::OdometryScale, Parameter::OdometryTurnScale]
            .map(|scale| 1.0 + self.of(scale));
        if scales != [1.0, 1.0] {
            events.odometry = scaled(&events.odometry, scales);
        }
    }

    /// Changes the clocks of a configuration.
    pub fn apply_clocks(&self, config: &mut Config) {
        config.input.range_delay += self.of(Parameter::RangeDelay);
        config.input.range_clock_rate += self.of(Parameter::ClockRate);
    }
}

/// As stamps count.
pub fn nanoseconds(seconds: f64) -> i64 {
    // A float too large for a stamp becomes the largest one.
    libm::rint(seconds * 1e9) as i64
}

/// What a configuration says of a sonar, then of its ring.
fn known<'c>(config: &'c Config, sonar: &str) -> impl Iterator<Item = &'c SonarOverride> {
    let ring = sonar.rsplit_once('[').map(|(ring, _)| ring);
    let names = [Some(sonar), ring].into_iter().flatten();
    let known: Vec<_> = names.filter_map(|name| config.sonar.get(name)).collect();
    known.into_iter()
}

/// How much later than those of others a configuration has a sonar's ranges stamped, seconds.
pub fn configured_delay(config: &Config, sonar: &str) -> f64 {
    let delay = known(config, sonar).find_map(|known| known.range_delay);
    delay.unwrap_or(0.0)
}

/// The scale and the offset that a configuration gives a sonar's ranges.
pub fn configured_range(config: &Config, sonar: &str) -> [f64; 2] {
    let scale = known(config, sonar).find_map(|known| known.range_scale);
    let offset = known(config, sonar).find_map(|known| known.range_offset);
    let all = &config.sonars;
    [
        scale.or(all.range_scale).unwrap_or(1.0),
        offset.or(all.range_offset).unwrap_or(0.0),
    ]
}

/// The same way with distances and turns multiplied.
pub fn scaled(samples: &[OdometrySample], [distance, turn]: [f64; 2]) -> Vec<OdometrySample> {
    let mut scaled: Vec<OdometrySample> = Vec::with_capacity(samples.len());
    let mut before: Option<Pose2> = None;
    for sample in samples {
        let now = sample.world_from_robot;
        let world_from_robot = match (before, scaled.last()) {
            (Some(before), Some(last)) => {
                let step = before.inverse_transform(now.position()) * distance;
                let turned = wrap_angle(now.yaw - before.yaw) * turn;
                let step = Pose2::new(step.x, step.y, turned);
                last.world_from_robot.compose(&step)
            }
            _ => now,
        };
        scaled.push(OdometrySample {
            world_from_robot,
            ..*sample
        });
        before = Some(now);
    }
    scaled
}
