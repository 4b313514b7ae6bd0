//! Whether the readings of one sonar lie nearer to the features that others hear, were the sonar as estimated: least
//! squares over everything at once can run astray where a reading was taken for one of another feature.

use super::parameter::{Parameter, Quantity, Whose};
use super::ranges::{BESIDE_BEAM, BEYOND_END, OF_MAP, OF_OTHERS, SIGMAS};
use super::seen::{Ping, Place, Scene};
use crate::core::event::SonarId;
use crate::core::geometry::{Pose2, Vec2, angle_between, rotate};
use crate::core::statistics::fraction;

/// A bearing may be so far outside of the beam of a sonar that looks where it is said to, radians.
const BESIDE: f64 = 0.04;

/// How the readings of a sonar lie to the features that others hear.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Fit {
    /// Echoes.
    pub echoes: usize,
    /// Those of a feature.
    pub near: usize,
    /// How unlikely they are, in natural logarithms.
    pub misfit: f64,
}

impl Fit {
    /// The share of the echoes that are of a feature.
    pub fn share(&self) -> f64 {
        fraction(self.near as u64, self.echoes as u64)
    }
}

/// The features, each with how many readings of every sonar fit it.
pub struct Heard<'a> {
    scene: &'a Scene,
    counts: Vec<Vec<usize>>,
}

impl<'a> Heard<'a> {
    /// As the map is.
    pub fn new(scene: &'a Scene) -> Self {
        let count = |place: &Place| {
            let mut counts = vec![0; scene.mounts.len()];
            for ping in &scene.pings {
                let fit = ping.echo.and_then(|(range, variance)| {
                    misfit(
                        place,
                        ping,
                        ping.world_from_sensor,
                        BESIDE_BEAM,
                        range,
                        variance,
                    )
                });
                if fit.is_some_and(|fit| fit < SIGMAS * SIGMAS)
                    && let Some(count) = counts.get_mut(ping.sonar.index())
                {
                    *count += 1;
                }
            }
            counts
        };
        Self {
            scene,
            counts: scene.places.iter().map(count).collect(),
        }
    }

    /// By how much the readings of a sonar are likelier with some of its values changed, in natural logarithms.
    /// `None` where the values are not the mount or the ranges of one sonar: of all of them, the map would move.
    pub fn gain(&self, values: impl Iterator<Item = (Parameter, f64)>) -> Option<f64> {
        let mut whose = None;
        let (mut moved, mut scale, mut offset) = (Vec2::zeros(), 1.0, 0.0);
        for (parameter, value) in values {
            let Parameter::Sonar(Whose::One(sonar), quantity) = parameter else {
                return None;
            };
            whose = Some(sonar);
            match quantity {
                Quantity::X => moved.x += value,
                Quantity::Y => moved.y += value,
                Quantity::RangeScale => scale += value,
                Quantity::RangeOffset => offset += value,
                Quantity::Yaw | Quantity::BeamWidth | Quantity::Delay => return None,
            }
        }
        let whose = whose?;
        let places = self.of_others(whose);
        let nearest = |ping: &Ping, moved: Vec2, range: f64, variance: f64| {
            let mount = self.scene.mounts.get(ping.sonar.index());
            let robot_yaw = ping.world_from_sensor.yaw - mount.map_or(0.0, |mount| mount.yaw);
            let place = ping.world_from_sensor.position() + rotate(moved, robot_yaw);
            let sensor = Pose2::new(place.x, place.y, ping.world_from_sensor.yaw);
            nearest_of(&places, ping, sensor, BESIDE_BEAM, range, variance)
        };
        let pings = self.scene.pings.iter().filter(|ping| ping.sonar == whose);
        let gains = pings.filter_map(|ping| {
            let (range, variance) = ping.echo?;
            let as_it_is = nearest(ping, Vec2::zeros(), range, variance);
            let changed = nearest(ping, moved, range * scale + offset, variance);
            Some((as_it_is - changed) / 2.0)
        });
        Some(gains.fold(0.0, |sum, gain| sum + gain))
    }

    /// How the readings of a sonar lie to the features that others hear, in its beam, were it mounted so and its ranges
    /// multiplied.
    pub fn fit(&self, sonar: SonarId, places: &[&Place], mount: Pose2, scale: f64) -> Fit {
        let told = self.scene.mounts.get(sonar.index()).copied();
        let told = told.unwrap_or(Pose2::IDENTITY);
        let mut fit = Fit::default();
        for ping in self.scene.pings.iter().filter(|ping| ping.sonar == sonar) {
            let Some((range, variance)) = ping.echo else {
                continue;
            };
            let sensor = ping
                .world_from_sensor
                .compose(&told.inverse())
                .compose(&mount);
            let off = nearest_of(places, ping, sensor, BESIDE, range * scale, variance);
            fit.echoes += 1;
            fit.near += usize::from(off < SIGMAS * SIGMAS);
            fit.misfit += off / 2.0;
        }
        fit
    }

    /// The features that sonars beside one hear: what it alone hears lies where it puts it.
    pub fn of_others(&self, sonar: SonarId) -> Vec<&'a Place> {
        let is_of_others = |counts: &Vec<usize>| {
            let all: usize = counts.iter().sum();
            all - counts.get(sonar.index()).copied().unwrap_or(0) >= OF_OTHERS
        };
        let places = self.scene.places.iter().zip(&self.counts);
        places
            .filter(|(_, counts)| is_of_others(counts))
            .map(|(place, _)| place)
            .collect()
    }
}

/// The square of what a range is off the nearest feature, in standard deviations, as far as that matters.
fn nearest_of(
    places: &[&Place],
    ping: &Ping,
    sensor: Pose2,
    beside_beam: f64,
    range: f64,
    variance: f64,
) -> f64 {
    let near = places
        .iter()
        .filter_map(|place| misfit(place, ping, sensor, beside_beam, range, variance));
    near.fold(SIGMAS * SIGMAS, f64::min)
}

/// The square of what a range is off a feature, in standard deviations; `None` where the sensor does not hear it.
fn misfit(
    place: &Place,
    ping: &Ping,
    sensor: Pose2,
    beside_beam: f64,
    range: f64,
    variance: f64,
) -> Option<f64> {
    let expected = place.expected(sensor.position())?;
    let is_heard = expected.inside > -BEYOND_END
        && angle_between(expected.bearing, sensor.yaw) < ping.beam_width / 2.0 + beside_beam;
    let off = range - expected.range;
    is_heard.then_some(off * off / (variance + OF_MAP * OF_MAP))
}
