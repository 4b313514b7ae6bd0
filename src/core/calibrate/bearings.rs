//! Where a sonar looks and how wide its beam is. (6) and (7) do not know; what does is at which bearings it
//! hears the features of the map, and at which it does not although they are there.
//!
//! Each feature near enough is a trial: it is heard, where the range is its own, or missed, where the range
//! is longer. (A shorter range says nothing.) Inside the beam most are heard, outside of it only by chance;
//! the two edges of the beam are where the one becomes the other.

use super::seen::{Ping, Scene};
use crate::core::event::SonarId;
use crate::core::geometry::{unit, wrap_angle};

/// Bearings beside the axis that are looked at, radians.
const ASIDE: f64 = 60.0 * DEGREE;
/// Steps of the edges.
const STEP: f64 = 0.25 * DEGREE;
/// How blurred an edge is by what the map and the poses are off: radians.
const BLUR: f64 = 0.4 * DEGREE;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A range is a feature's within so many standard deviations; maps add an error of their own, metres.
const SIGMAS: f64 = 3.0;
const OF_MAP: f64 = 0.003;
/// Nearer to its end than this a wall is no trial, metres.
const INSIDE: f64 = 0.15;

/// The shares of features that a sonar hears inside and outside of its beam lie within these bounds.
const INSIDE_SHARE: [f64; 2] = [0.5, 0.98];
const OUTSIDE_SHARE: [f64; 2] = [0.01, 0.3];
/// Fewer trials than this say nothing.
const FEWEST: usize = 12;

/// A feature that should be heard at a bearing from the axis, or not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// From the configured axis, radians.
    pub bearing: f64,
    /// Whether it is.
    pub is_heard: bool,
}

/// What one sonar's beam says.
#[derive(Debug, Clone)]
pub struct Beam {
    /// The sonar.
    pub sonar: SonarId,
    /// How wide the beam is configured, radians.
    pub width: f64,
    /// Trials that it had.
    pub trials: usize,
    /// How many of them were heard, of those in the beam.
    pub heard: usize,
    edges: Option<Edges>,
}

/// The value that the trials point at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// The value, as a change of what is configured.
    pub value: f64,
    /// Its standard deviation, all values being weighted by their likelihood.
    pub deviation: f64,
    /// By how much the trials are likelier with it, in natural logarithms.
    pub gain: f64,
}

/// The trials of every sonar.
pub fn trials(scene: &Scene) -> Vec<Vec<Trial>> {
    let mut trials = vec![Vec::new(); scene.mounts.len()];
    for ping in &scene.pings {
        if let Some(trials) = trials.get_mut(ping.sonar.index()) {
            take(scene, ping, trials);
        }
    }
    trials
}

fn take(scene: &Scene, ping: &Ping, trials: &mut Vec<Trial>) {
    let sensor = ping.world_from_sensor.position();
    let farthest = scene.reach(ping.sonar);
    let (range, variance) = ping.echo.unwrap_or((f64::INFINITY, 0.0));
    let gate = SIGMAS * (variance + OF_MAP * OF_MAP).sqrt();
    let mut heard: Vec<f64> = Vec::new();
    let mut missed: Vec<f64> = Vec::new();
    for place in &scene.places {
        let Some(expected) = place.expected(sensor) else {
            continue;
        };
        let bearing = wrap_angle(expected.bearing - ping.world_from_sensor.yaw);
        if bearing.abs() > ASIDE || expected.range > farthest || expected.inside < 0.0 {
            continue;
        }
        let off = range - expected.range;
        if off < -gate {
            continue;
        }
        let foot = sensor + unit(expected.bearing) * (expected.range - 2.0 * gate).max(0.0);
        if scene.places.iter().any(|other| other.hides(sensor, foot)) {
            continue;
        }
        if off <= gate {
            heard.push(bearing);
        } else if expected.inside > INSIDE && off > 3.0 * gate {
            missed.push(bearing);
        }
    }
    // Of several that fit, one was heard.
    if let [bearing] = heard.as_slice() {
        trials.push(Trial {
            bearing: *bearing,
            is_heard: true,
        });
    }
    trials.extend(missed.into_iter().map(|bearing| Trial {
        bearing,
        is_heard: false,
    }));
}

/// The likelihood of the edges of a beam.
#[derive(Debug, Clone)]
struct Edges {
    /// Of the right edge at each step from `-ASIDE`, by the trials to the right of the axis.
    low: Vec<f64>,
    /// Of the left edge, by the others.
    high: Vec<f64>,
}

fn steps() -> usize {
    (2.0 * ASIDE / STEP) as usize + 1
}

/// A trial by its distance from the axis, towards an edge, and its likelihood outside and inside.
struct Weighed {
    out: f64,
    outside: f64,
    inside: f64,
    is_heard: bool,
}

impl Edges {
    fn new(trials: &[Trial], half: f64) -> Self {
        let share = |inside: bool, [low, high]: [f64; 2]| {
            let of = trials
                .iter()
                .filter(|trial| (trial.bearing.abs() < half) == inside);
            let (mut all, mut heard) = (2.0, low + high);
            for trial in of {
                all += 1.0;
                heard += f64::from(u8::from(trial.is_heard));
            }
            (heard / all).clamp(low, high)
        };
        let shares = [share(false, OUTSIDE_SHARE), share(true, INSIDE_SHARE)];
        let weighed = |trial: &Trial, side: f64| {
            let [outside, inside] = shares.map(|heard| likelihood(heard, trial.is_heard));
            Weighed {
                out: side * trial.bearing,
                outside,
                inside,
                is_heard: trial.is_heard,
            }
        };
        let of = |side: f64| {
            let ours = trials
                .iter()
                .filter(|trial| (trial.bearing < 0.0) == (side < 0.0));
            let mut ours: Vec<Weighed> = ours.map(|trial| weighed(trial, side)).collect();
            ours.sort_by(|a, b| a.out.total_cmp(&b.out));
            of_edge(&ours, shares)
        };
        Self {
            low: of(-1.0),
            high: of(1.0),
        }
    }

    /// Of a beam between two bearings.
    fn of(&self, low: f64, high: f64) -> f64 {
        at(&self.low, -low) + at(&self.high, high)
    }
}

fn likelihood(heard: f64, is_heard: bool) -> f64 {
    libm::log(if is_heard { heard } else { 1.0 - heard })
}

/// The likelihood of an edge at every step of its distance from the axis.
fn of_edge(trials: &[Weighed], [outside, inside]: [f64; 2]) -> Vec<f64> {
    let sums = |of: &dyn Fn(&Weighed) -> f64| {
        let mut sums = vec![0.0];
        let mut sum = 0.0;
        for trial in trials {
            sum += of(trial);
            sums.push(sum);
        }
        sums
    };
    let (within, beyond) = (sums(&|trial| trial.inside), sums(&|trial| trial.outside));
    let all_beyond = beyond.last().copied().unwrap_or(0.0);
    let near = 6.0 * BLUR;
    (0..steps())
        .map(|step| {
            let edge = step as f64 * STEP - ASIDE;
            let from = trials.partition_point(|trial| trial.out < edge - near);
            let to = trials.partition_point(|trial| trial.out <= edge + near);
            let clear = |sums: &[f64], at: usize| sums.get(at).copied().unwrap_or(0.0);
            let mut sum = clear(&within, from) + all_beyond - clear(&beyond, to);
            for trial in trials.get(from..to).unwrap_or_default() {
                let in_beam = 1.0 / (1.0 + libm::exp((trial.out - edge) / BLUR));
                sum += likelihood(outside + (inside - outside) * in_beam, trial.is_heard);
            }
            sum
        })
        .collect()
}

/// A likelihood between its steps.
fn at(values: &[f64], edge: f64) -> f64 {
    let place = ((edge + ASIDE) / STEP).clamp(0.0, (values.len().max(2) - 1) as f64);
    let before = place as usize;
    let share = place - before as f64;
    let of = |at: usize| values.get(at).or(values.last()).copied().unwrap_or(0.0);
    of(before) * (1.0 - share) + of(before + 1) * share
}

impl Beam {
    /// From the trials of a sonar.
    pub fn new(sonar: SonarId, width: f64, trials: &[Trial]) -> Self {
        let half = width / 2.0;
        let is_enough = trials.len() >= FEWEST && half < ASIDE;
        let inside = trials.iter().filter(|trial| trial.bearing.abs() < half);
        Self {
            sonar,
            width,
            trials: inside.clone().count(),
            heard: inside.filter(|trial| trial.is_heard).count(),
            edges: is_enough.then(|| Edges::new(trials, half)),
        }
    }

    /// Where its axis is at the configured width, from the configured one.
    pub fn axis(&self) -> Option<Peak> {
        let (edges, half) = (self.edges.as_ref()?, self.width / 2.0);
        let free = ASIDE - half;
        peak(-free, free, &|axis| edges.of(axis - half, axis + half))
    }

    fn at_width(&self, wider: f64) -> f64 {
        let half = (self.width + wider) / 2.0;
        self.edges
            .as_ref()
            .map_or(0.0, |edges| edges.of(-half, half))
    }

    /// How much wider it is at the configured axis.
    pub fn wider(&self) -> Option<Peak> {
        Self::all_wider(std::slice::from_ref(self))
    }

    /// How much wider all beams are.
    pub fn all_wider(beams: &[Self]) -> Option<Peak> {
        let known = || beams.iter().filter(|beam| beam.edges.is_some());
        let narrowest = known().map(|beam| beam.width).fold(f64::INFINITY, f64::min);
        let all = |wider| known().fold(0.0, |sum, beam| sum + beam.at_width(wider));
        if !narrowest.is_finite() {
            return None;
        }
        peak(-narrowest * 0.8, 2.0 * ASIDE - narrowest, &all)
    }
}

/// The mean of the values between two bounds, weighted by their likelihood, and how sure it is.
fn peak(low: f64, high: f64, of: &dyn Fn(f64) -> f64) -> Option<Peak> {
    let configured = of(0.0);
    let count = ((high - low) / STEP) as usize + 1;
    let values: Vec<(f64, f64)> = (0..=count)
        .map(|step| low + step as f64 * STEP)
        .map(|value| (value, of(value)))
        .collect();
    let best = values
        .iter()
        .map(|(_, likelihood)| *likelihood)
        .fold(f64::NEG_INFINITY, f64::max);
    // What is nearly as likely, by weight.
    let (mut weight, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for (value, likelihood) in &values {
        let share = libm::exp(likelihood - best);
        weight += share;
        sum += share * value;
        squares += share * value * value;
    }
    let value = sum / weight;
    let deviation = (squares / weight - value * value)
        .max(STEP * STEP / 12.0)
        .sqrt();
    weight.is_finite().then_some(Peak {
        value,
        deviation,
        gain: best - configured,
    })
}
