//! What a log holds, part by part: enough to say what is otherwise in another version of it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::core::event::{Events, RangeReading, Return, SonarId};
use crate::core::geometry::{Pose2, wrap_angle};
use crate::core::observer::Setting;
use crate::core::rounding::{micro, rounded};
use crate::core::statistics::{median, seconds};

/// The log that results come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogInfo {
    /// Its file name.
    pub file: String,
    /// The digest of its events.
    pub events_sha256: String,
    /// Its parts; `None` in files from before they held them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub odometry: Option<OdometryProfile>,
    /// By name; `None` in files from before they held them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sonars: Option<BTreeMap<String, SonarProfile>>,
}

/// The odometry of a log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OdometryProfile {
    pub stamps: Stamps,
    /// The first pose in the world: x, y in metres and yaw in radians.
    pub start: [f64; 3],
    /// The last pose as seen from the first.
    pub end: [f64; 3],
    /// Metres driven, all steps added up.
    pub path: f64,
    /// Radians turned, all steps added up, whichever way.
    pub turned: f64,
    /// Of the poses.
    pub digest: String,
}

/// What one sonar measures, and where it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SonarProfile {
    /// In the robot's frame: x, y in metres and yaw in radians.
    pub mount: [f64; 3],
    /// Mean opening angle, radians.
    pub beam_width: Option<f64>,
    /// Mean least and greatest range, metres; none where there is no limit.
    pub limits: [Option<f64>; 2],
    /// Mean variance that messages give, square metres.
    pub variance: Option<f64>,
    pub stamps: Stamps,
    pub echoes: u64,
    /// Mean range of the echoes, metres.
    pub mean: f64,
    /// How far they spread about it, one standard deviation, metres.
    pub spread: f64,
    /// How far an echo mostly is off the middle of its neighbours, metres.
    pub roughness: f64,
    /// Of the ranges.
    pub digest: String,
}

/// When messages were stamped.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stamps {
    pub count: u64,
    pub first_ns: i64,
    /// From the first to the last, seconds.
    pub lasts: f64,
    /// Of the steps from one to the next.
    pub digest: String,
    /// Every one, in no file: there where the log itself is at hand.
    #[serde(skip)]
    pub all: AtHand,
}

/// What is known beyond a file, and so nothing that two files differ in.
#[derive(Debug, Clone, Default)]
pub struct AtHand(pub Vec<i64>);

impl PartialEq for AtHand {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl LogInfo {
    pub fn of(setting: &Setting<'_>) -> Self {
        let events = setting.events;
        let sonars = (0..).zip(&events.sonars).filter_map(|(place, sonar)| {
            let readings: Vec<RangeReading> = events.readings.of_sonar(SonarId(place)).collect();
            let profile = SonarProfile::of(sonar.robot_from_sensor, &readings);
            (!readings.is_empty()).then(|| (sonar.name.clone(), profile))
        });
        Self {
            file: setting.source.file.clone(),
            events_sha256: setting.events_sha256.to_owned(),
            odometry: OdometryProfile::of(events),
            sonars: Some(sonars.collect()),
        }
    }

    /// The stamp of its first reading.
    pub fn origin_ns(&self) -> Option<i64> {
        let firsts = self.sonars.iter().flat_map(BTreeMap::values);
        firsts.map(|sonar| sonar.stamps.first_ns).min()
    }
}

impl OdometryProfile {
    fn of(events: &Events) -> Option<Self> {
        let samples = &events.odometry;
        let poses = || samples.iter().map(|sample| sample.world_from_robot);
        let (first, last) = (poses().next()?, poses().next_back()?);
        let steps = || poses().zip(poses().skip(1));
        let way = |(a, b): (Pose2, Pose2)| (b.position() - a.position()).norm();
        let turn = |(a, b): (Pose2, Pose2)| wrap_angle(b.yaw - a.yaw).abs();
        let end = first.inverse_transform(last.position());
        Some(Self {
            stamps: Stamps::of(samples.iter().map(|sample| sample.stamp_ns)),
            start: [first.x, first.y, first.yaw].map(micro),
            end: [end.x, end.y, wrap_angle(last.yaw - first.yaw)].map(micro),
            path: micro(steps().map(way).fold(0.0, |sum, way| sum + way)),
            turned: micro(steps().map(turn).fold(0.0, |sum, turn| sum + turn)),
            digest: digest(poses().flat_map(|pose| [pose.x, pose.y, pose.yaw].map(bits))),
        })
    }
}

impl SonarProfile {
    fn of(mount: Pose2, readings: &[RangeReading]) -> Self {
        let is_echo = |reading: &&RangeReading| reading.classify() == Return::Echo;
        let echoes = readings.iter().filter(is_echo).map(|reading| reading.range);
        let echoes: Vec<f64> = echoes.collect();
        let mean = mean(echoes.iter().copied());
        let squares = echoes.iter().map(|range| (range - mean) * (range - mean));
        let mut off: Vec<f64> = (echoes.windows(3))
            .filter_map(|window| match window {
                [a, b, c] => Some((b - (a + c) / 2.0).abs()),
                _ => None,
            })
            .collect();
        off.sort_by(f64::total_cmp);
        let of_all = |of: fn(&RangeReading) -> f64| {
            let mean = self::mean(readings.iter().map(of));
            mean.is_finite().then(|| rounded(mean))
        };
        Self {
            mount: [mount.x, mount.y, mount.yaw].map(micro),
            beam_width: of_all(|reading| reading.beam_width),
            limits: [
                of_all(|reading| reading.min_range),
                of_all(|reading| reading.max_range),
            ],
            variance: of_all(|reading| reading.variance),
            stamps: Stamps::of(readings.iter().map(|reading| reading.stamp_ns)),
            echoes: echoes.len() as u64,
            mean: micro(mean),
            spread: micro(self::mean(squares).sqrt()),
            roughness: micro(median(&off).unwrap_or_default()),
            digest: digest(readings.iter().map(|reading| bits(reading.range))),
        }
    }
}

impl Stamps {
    pub(super) fn of(stamps: impl Iterator<Item = i64> + Clone) -> Self {
        let (first_ns, last) = (stamps.clone().next(), stamps.clone().last());
        let first_ns = first_ns.unwrap_or_default();
        Self {
            count: stamps.clone().count() as u64,
            first_ns,
            lasts: micro(seconds(first_ns, last.unwrap_or(first_ns))),
            digest: digest(
                stamps
                    .clone()
                    .map(|at| at.wrapping_sub(first_ns).to_le_bytes()),
            ),
            all: AtHand(stamps.collect()),
        }
    }
}

/// 0 of nothing.
fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = numbers.fold((0_u64, 0.0), |(count, sum), one| (count + 1, sum + one));
    if count == 0 { 0.0 } else { sum / count as f64 }
}

fn bits(number: f64) -> [u8; 8] {
    let number = if number.is_nan() {
        f64::NAN
    } else {
        rounded(number)
    };
    number.to_bits().to_le_bytes()
}

/// The first digits of a SHA-256.
fn digest(parts: impl Iterator<Item = [u8; 8]>) -> String {
    const DIGITS: usize = 12;
    let mut hash = Sha256::new();
    parts.for_each(|part| hash.update(part));
    let mut text = format!("{:x}", hash.finalize());
    text.truncate(DIGITS);
    text
}
