//! What each sonar is and what came back to it.

use serde::Serialize;

use crate::core::config::Config;
use crate::core::event::{Events, RangeReading, Return, Sonar, SonarId};
use crate::core::geometry::{Pose2, Vec2};
use crate::core::odometry::Track;
use crate::core::rounding::{number, optional};
use crate::core::statistics::{fraction, median, rate};

/// A sensor that moved less than this between two readings stood still, metres.
const STILL: f64 = 1e-3;

/// Ranges come as 32-bit numbers; what lies closer together than this is dust, metres.
const DUST: f64 = 2e-6;
/// Steps finer than this are no steps, metres.
const FINEST_STEP: f64 = 1e-4;
/// No driver publishes an echo more often.
const LONGEST_RUN: usize = 6;
/// So many different ranges are needed to speak of a common step.
const ENOUGH: usize = 8;
/// A difference may miss a multiple of the step by this fraction of it.
const MISS: f64 = 0.02;

/// One sonar.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SonarFacts {
    #[serde(skip)]
    pub id: SonarId,
    /// Its name.
    pub name: String,
    /// The topic its readings came on.
    pub topic: String,
    /// Where it sits on the robot; `None` where that is not known.
    pub mount: Option<MountFacts>,
    /// Full opening angle of the beam, radians; `None` where that is not known.
    #[serde(serialize_with = "optional")]
    pub beam_width: Option<f64>,
    /// Closest distance it can measure, metres.
    #[serde(serialize_with = "number")]
    pub min_range: f64,
    /// Where "no echo" begins, metres; infinite (null) where there is no limit.
    #[serde(serialize_with = "number")]
    pub max_range: f64,
    /// Whether beam width or limits change from reading to reading; the first ones are given here.
    pub varies: bool,
    /// Its readings.
    pub readings: u64,
    /// Echoes among them.
    pub echoes: u64,
    /// Readings in which nothing echoed.
    pub no_echoes: u64,
    /// Readings that mean nothing: NaN, minus infinity, below `min_range`.
    pub invalid: u64,
    /// Stamp of the first reading, nanoseconds.
    pub first_ns: i64,
    /// Stamp of the last reading, nanoseconds.
    pub last_ns: i64,
    /// Readings per second.
    #[serde(serialize_with = "optional")]
    pub rate: Option<f64>,
    /// The shortest echo, metres.
    #[serde(serialize_with = "optional")]
    pub shortest: Option<f64>,
    /// The echo in the middle, metres.
    #[serde(serialize_with = "optional")]
    pub median: Option<f64>,
    /// The longest echo, metres.
    #[serde(serialize_with = "optional")]
    pub longest: Option<f64>,
    /// How finely it tells ranges apart.
    pub resolution: Option<Resolution>,
    /// Echoes whose sensor moved by more than the resolution since the echo before.
    pub moved: u64,
    /// Those among them that are the echo before, bit by bit.
    pub repeats: u64,
    /// Those among them in short runs: a wall that is passed gives a long run of equal ranges where there is no noise,
    /// a driver that publishes an echo again a short one.
    #[serde(skip)]
    pub republished: u64,
    /// The range of most of its echoes, metres, and how many these are.
    #[serde(skip)]
    pub commonest: Option<(f64, u64)>,
    /// Way of the sensor from one reading to the next while it moves, in the middle of all, metres.
    #[serde(serialize_with = "optional")]
    pub baseline: Option<f64>,
    /// How far its ranges scatter while it passes walls, standard deviation, metres.
    #[serde(serialize_with = "optional")]
    pub scatter: Option<f64>,
    /// Neighbouring readings that lie farther apart than `sequence` allows.
    pub too_far_apart: u64,
}

/// Where a sonar sits on the robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MountFacts {
    /// Metres.
    #[serde(serialize_with = "number")]
    pub x: f64,
    /// Metres.
    #[serde(serialize_with = "number")]
    pub y: f64,
    /// Direction of the beam axis, radians.
    #[serde(serialize_with = "number")]
    pub yaw: f64,
}

/// How finely a sonar tells ranges apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resolution {
    /// The common step of all ranges, or else the smallest difference between two of them, metres.
    #[serde(serialize_with = "number")]
    pub step: f64,
    /// Whether all ranges are multiples of the step apart.
    pub quantised: bool,
}

impl SonarFacts {
    /// Limits between which no echo can lie.
    pub fn limits_are_senseless(&self) -> bool {
        self.max_range <= self.min_range || self.max_range <= 0.0
    }

    /// Share of the moved echoes that repeat the one before.
    pub fn repeated(&self) -> f64 {
        fraction(self.repeats, self.moved)
    }

    /// Share of the moved echoes that a driver seems to have published again.
    pub fn republished(&self) -> f64 {
        fraction(self.republished, self.moved)
    }
}

/// A reading and where its sensor was.
type PlacedReading = (RangeReading, Option<Vec2>);

/// The facts of every sonar, in the order of [`Events::sonars`].
pub fn sonars(events: &Events, config: &Config) -> Vec<SonarFacts> {
    let track = Track::of_ranges(&events.odometry, config);
    // One sonar after the other: all at once would take as much memory as the log.
    let of_sonar = |(sonar, id): (&Sonar, SonarId)| {
        let mut near = 0;
        let placed = events.readings.of_sonar(id).map(|reading| {
            let robot = track.world_from_robot_next(&reading, &mut near).ok();
            let at = robot.map(|robot: Pose2| robot.transform(sonar.robot_from_sensor.position()));
            (reading, at)
        });
        facts(sonar, &placed.collect::<Vec<PlacedReading>>(), config)
    };
    let ids = (0..).map(SonarId);
    let sonars = events.sonars.iter().zip(ids);
    sonars.filter_map(of_sonar).collect()
}

fn facts(sonar: &Sonar, readings: &[PlacedReading], config: &Config) -> Option<SonarFacts> {
    let ((first, _), (last, _)) = (readings.first()?, readings.last()?);
    let of_kind = |kind| {
        let readings = readings.iter().map(|(reading, _)| *reading);
        readings.filter(move |reading| reading.classify() == kind)
    };
    let count = |kind| of_kind(kind).count() as u64;
    let mut echoes: Vec<f64> = of_kind(Return::Echo).map(|echo| echo.range).collect();
    echoes.sort_by(f64::total_cmp);
    let resolution = resolution(&echoes);
    let [moved, repeats, republished] = repeats(readings, resolution.map_or(0.0, |r| r.step));
    let mount = sonar.robot_from_sensor;
    let said = |r: &RangeReading| [r.beam_width, r.min_range, r.max_range].map(f64::to_bits);
    Some(SonarFacts {
        id: first.sonar,
        name: sonar.name.clone(),
        topic: sonar.topic.clone(),
        mount: Some(MountFacts {
            x: mount.x,
            y: mount.y,
            yaw: mount.yaw,
        }),
        beam_width: Some(first.beam_width),
        min_range: first.min_range,
        max_range: first.max_range,
        varies: readings.iter().any(|(r, _)| said(r) != said(first)),
        readings: readings.len() as u64,
        echoes: count(Return::Echo),
        no_echoes: count(Return::NoEcho),
        invalid: count(Return::Invalid),
        first_ns: first.stamp_ns,
        last_ns: last.stamp_ns,
        rate: rate(readings.len(), first.stamp_ns, last.stamp_ns),
        shortest: echoes.first().copied(),
        median: median(&echoes),
        longest: echoes.last().copied(),
        resolution,
        moved,
        repeats,
        republished,
        commonest: commonest(&echoes),
        baseline: baseline(readings),
        scatter: None,
        too_far_apart: too_far_apart(readings, config),
    })
}

/// How far a sensor went between two readings.
fn way(a: Option<Vec2>, b: Option<Vec2>) -> Option<f64> {
    Some((b? - a?).norm())
}

/// Echoes of a sensor that moved since the echo before, those that are that echo again, and those of these in short
/// runs.
fn repeats(readings: &[PlacedReading], resolution: f64) -> [u64; 3] {
    let echoes: Vec<&PlacedReading> = readings
        .iter()
        .filter(|(r, _)| r.classify() == Return::Echo)
        .collect();
    let farther = resolution.max(STILL);
    let moved = |echoes: &[&PlacedReading]| {
        let ways = echoes.array_windows().map(|[a, b]| way(a.1, b.1));
        ways.filter(|way| way.is_some_and(|way| way > farther))
            .count() as u64
    };
    let runs = echoes.chunk_by(|a, b| a.0.range.to_bits() == b.0.range.to_bits());
    let in_runs = runs.map(|run| (run.len(), moved(run)));
    in_runs.fold(
        [moved(&echoes), 0, 0],
        |[all, repeats, republished], (length, again)| {
            let short = if length <= LONGEST_RUN { again } else { 0 };
            [all, repeats + again, republished + short]
        },
    )
}

/// The commonest of sorted ranges.
fn commonest(sorted: &[f64]) -> Option<(f64, u64)> {
    let runs = sorted.chunk_by(|a, b| a.to_bits() == b.to_bits());
    let longest = runs.max_by_key(|run| run.len())?;
    Some((*longest.first()?, longest.len() as u64))
}

fn baseline(readings: &[PlacedReading]) -> Option<f64> {
    let mut ways: Vec<f64> = readings
        .array_windows()
        .filter_map(|[(_, from), (_, to)]| way(*from, *to))
        .filter(|way| *way > STILL)
        .collect();
    ways.sort_by(f64::total_cmp);
    median(&ways)
}

fn too_far_apart(readings: &[PlacedReading], config: &Config) -> u64 {
    let bounds = &config.sequence;
    let apart = readings.array_windows().filter(|[(a, from), (b, to)]| {
        let seconds = b.stamp_ns.saturating_sub(a.stamp_ns) as f64 * 1e-9;
        seconds > bounds.max_gap || way(*from, *to).is_some_and(|way| way > bounds.max_baseline)
    });
    apart.count() as u64
}

/// The resolution of sorted ranges; `None` where they are all the same.
pub fn resolution(sorted: &[f64]) -> Option<Resolution> {
    let differences: Vec<f64> = sorted
        .array_windows()
        .map(|[a, b]| b - a)
        .filter(|d| *d > DUST)
        .collect();
    let smallest = differences.iter().copied().min_by(f64::total_cmp)?;
    let step = common_step(&differences, smallest);
    Some(Resolution {
        step: step.unwrap_or(smallest),
        quantised: step.is_some(),
    })
}

/// The step of which all differences are multiples.
fn common_step(differences: &[f64], smallest: f64) -> Option<f64> {
    if differences.len() < ENOUGH || smallest < FINEST_STEP {
        return None;
    }
    let mut steps = 0.0;
    let mut telling = 0;
    for difference in differences {
        let multiple = libm::round(difference / smallest);
        let allowed = (MISS * smallest).max(DUST) * multiple.max(1.0);
        // A multiple so large that anything is near one says nothing.
        if allowed < smallest / 4.0 {
            if (difference - multiple * smallest).abs() > allowed {
                return None;
            }
            telling += 1;
        }
        steps += multiple;
    }
    (telling >= ENOUGH).then(|| differences.iter().sum::<f64>() / steps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::OdometrySample;

    /// A sonar on a robot that drives 0.1 m a second along x.
    fn driven(ranges: &[f64]) -> SonarFacts {
        let stamp = |k: usize| k as i64 * 1_000_000_000;
        let events = Events {
            sonars: vec![Sonar {
                name: "s".into(),
                topic: "/s".into(),
                robot_from_sensor: Pose2::new(0.2, 0.0, 1.0),
            }],
            readings: ranges
                .iter()
                .enumerate()
                .map(|(k, range)| RangeReading {
                    stamp_ns: stamp(k),
                    sonar: SonarId(0),
                    range: *range,
                    min_range: 0.1,
                    max_range: 5.0,
                    beam_width: 0.4,
                    variance: 0.0,
                })
                .collect(),
            odometry: (0..ranges.len())
                .map(|k| OdometrySample {
                    stamp_ns: stamp(k),
                    world_from_robot: Pose2::new(0.1 * k as f64, 0.0, 0.0),
                })
                .collect(),
        };
        sonars(&events, &Config::default()).remove(0)
    }

    #[test]
    fn what_came_back_is_counted() {
        let facts = driven(&[1.0, f64::INFINITY, 2.0, f64::NAN, 3.0, 0.05]);
        assert_eq!(
            (facts.readings, facts.echoes, facts.no_echoes, facts.invalid),
            (6, 3, 1, 2)
        );
        assert_eq!(
            (facts.shortest, facts.median, facts.longest),
            (Some(1.0), Some(2.0), Some(3.0))
        );
        assert!((facts.rate.unwrap() - 1.0).abs() < 1e-12);
        assert!((facts.baseline.unwrap() - 0.1).abs() < 1e-12);
        assert_eq!(facts.too_far_apart, 0);
    }

    #[test]
    fn a_repeat_counts_only_when_the_sensor_moved_by_more_than_the_resolution() {
        let facts = driven(&[1.0, 1.0, 1.05, 1.05, 2.0]);
        assert_eq!((facts.moved, facts.repeats), (4, 2));
        let coarse = driven(&[1.0, 1.0, 1.5, 1.5, 2.0]);
        assert_eq!((coarse.moved, coarse.repeats), (0, 0));
        assert_eq!(coarse.repeated(), 0.0);
    }

    fn of(ranges: impl IntoIterator<Item = f64>) -> Option<Resolution> {
        let mut ranges: Vec<f64> = ranges.into_iter().map(|r| f64::from(r as f32)).collect();
        ranges.sort_by(f64::total_cmp);
        resolution(&ranges)
    }

    #[test]
    fn centimetres_in_32_bits_are_centimetres() {
        let found = of([
            0.25, 0.26, 0.4, 0.41, 0.46, 0.49, 0.77, 1.3, 1.31, 1.33, 1.34, 2.48, 3.0, 3.9, 3.95,
            4.33, 4.33,
        ])
        .unwrap();
        assert!(found.quantised, "{found:?}");
        assert!((found.step - 0.01).abs() < 1e-6);
    }

    #[test]
    fn the_ticks_of_a_timer_are_found_too() {
        let ticks = [
            100, 101, 103, 104, 110, 160, 161, 163, 190, 192, 240, 300, 301, 303, 500,
        ];
        let found = of(ticks.map(|k| f64::from(k) * 0.001_715)).unwrap();
        assert!(found.quantised && (found.step - 0.001_715).abs() < 1e-7);
    }

    #[test]
    fn ranges_on_no_raster_have_a_smallest_difference() {
        let found = of((1..200).map(|k| 1.0 + 3.0 * (f64::from(k) * 0.618_034).fract())).unwrap();
        assert!(!found.quantised && found.step < 0.02, "{found:?}");
    }

    #[test]
    fn two_ranges_close_together_by_chance_make_no_raster() {
        let mut ranges: Vec<f64> = (1..40)
            .map(|k| 1.0 + 5.0 * (f64::from(k) * 0.618_034).fract())
            .collect();
        ranges.push(ranges[0] + 0.001_2);
        assert!(!of(ranges).unwrap().quantised);
    }

    #[test]
    fn too_few_ranges_show_no_step() {
        assert_eq!(of([]), None);
        assert_eq!(of([1.0, 1.0]), None);
        let two = of([1.0, 1.25]).unwrap();
        assert_eq!((two.step, two.quantised), (0.25, false));
    }
}
