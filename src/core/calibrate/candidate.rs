//! What may be off, by what the ranges and the beams of a replay say: to be tried.

use super::bearings::{Beam, trials};
use super::borne_out::Heard;
use super::parameter::{Parameter, Quantity, Whose};
use super::ranges::{self, RangeEstimate, Unknown};
use super::seen::Scene;
use crate::core::bits::Bits;
use crate::core::event::SonarId;
use crate::core::replay::{Outcome, Replay};
use crate::core::statistics::median;

/// An estimate is clear from so many standard deviations on, and from such a gain on, in natural
/// logarithms.
const CLEAR: f64 = 4.0;
const CLEAR_OF_SEVERAL: f64 = 3.0;
const CLEAR_GAIN: f64 = 10.0;
/// Where more is explained, no clock of a single sonar is late.
const SOUND: f64 = 0.98;

/// Clocks whose delays lie no farther apart are one, seconds.
const ONE_CLOCK: f64 = 0.04;

/// What is known no better than so many times what matters mends nothing.
const VAGUE: f64 = 5.0;

/// What a parameter gains where nothing is off, in natural logarithms: with a thousand readings.
const OF_PARAMETER: f64 = 3.5;

/// Parameters that are off together, the others being as configured.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// By how much, with standard deviations.
    pub values: Vec<Estimated>,
    /// By how much the log is likelier with them, in natural logarithms.
    pub gain: f64,
}

/// A parameter as a log has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// Which.
    pub parameter: Parameter,
    /// As a change of what is configured.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// All that one replay says of its parameters.
#[derive(Debug, Clone)]
pub struct Estimates {
    /// What the ranges say; `None` where there are too few.
    pub ranges: Option<RangeEstimate>,
    /// What they say of each sonar's clock, were its mount right; `None` where nothing points at it.
    clocks: Option<RangeEstimate>,
    /// What the beams say.
    pub beams: Vec<Beam>,
    /// How long the log is, seconds.
    pub seconds: f64,
    scene: Scene,
}

impl Estimates {
    /// Of a replay.
    pub fn new(replay: &Replay<'_>, outcome: &Outcome) -> Self {
        let scene = Scene::new(replay, outcome);
        let mut widths = vec![0.0; scene.mounts.len()];
        for ping in &scene.pings {
            if let Some(width) = widths.get_mut(ping.sonar.index()) {
                *width = ping.beam_width;
            }
        }
        let beams = (0..).zip(widths).zip(trials(&scene));
        let source = replay.setting().source;
        let share = Bits::of(outcome).and_then(|bits| bits.explained_share());
        let is_troubled = share.is_some_and(|share| share < SOUND);
        Self {
            beams: beams
                .map(|((sonar, width), trials)| Beam::new(SonarId(sonar), width, &trials))
                .collect(),
            ranges: ranges::estimate(&scene, Unknown::Mounts, replay, outcome),
            clocks: is_troubled
                .then(|| ranges::estimate(&scene, Unknown::Clocks, replay, outcome))
                .flatten(),
            seconds: source.end_ns.saturating_sub(source.start_ns) as f64 * 1e-9,
            scene,
        }
    }

    /// What was heard, and the map.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Everything that can be off by itself.
    pub fn groups(&self) -> Vec<Vec<Parameter>> {
        use Quantity::{BeamWidth, RangeOffset, RangeScale, X, Y, Yaw};
        let of_all = |of| Parameter::Sonar(Whose::All, of);
        let all = |of| vec![of_all(of)];
        let shared = [
            vec![Parameter::RangeDelay],
            vec![Parameter::ClockRate],
            vec![Parameter::OdometryScale],
            vec![Parameter::OdometryTurnScale],
            vec![of_all(X), of_all(Y)],
            all(RangeScale),
            all(RangeOffset),
            all(BeamWidth),
        ];
        let sonars = self.beams.iter().flat_map(|beam| {
            let of = |quantity| Parameter::Sonar(Whose::One(beam.sonar), quantity);
            [
                vec![of(Yaw)],
                vec![of(X), of(Y)],
                vec![of(RangeScale)],
                vec![of(RangeOffset)],
                vec![of(BeamWidth)],
            ]
        });
        shared.into_iter().chain(sonars).collect()
    }

    /// What the log says of some parameters, the others being as configured.
    pub fn of(&self, parameters: &[Parameter]) -> Option<Candidate> {
        let peak = match parameters {
            [Parameter::Sonar(whose, Quantity::Yaw)] => {
                let beam = self.beams.iter().find(|beam| whose.holds(beam.sonar))?;
                Some(beam.axis()?)
            }
            [Parameter::Sonar(Whose::All, Quantity::BeamWidth)] => {
                Some(Beam::all_wider(&self.beams)?)
            }
            [Parameter::Sonar(whose, Quantity::BeamWidth)] => {
                let beam = self.beams.iter().find(|beam| whose.holds(beam.sonar))?;
                Some(beam.wider()?)
            }
            _ => None,
        };
        if let ([parameter], Some(peak)) = (parameters, peak) {
            return Some(Candidate {
                values: vec![Estimated {
                    parameter: *parameter,
                    value: peak.value,
                    deviation: peak.deviation,
                }],
                gain: peak.gain,
            });
        }
        let is_clock =
            |parameter: &Parameter| matches!(parameter, Parameter::Sonar(_, Quantity::Delay));
        let alone = match parameters.iter().all(is_clock) {
            // Sonars that are late together have one clock.
            true => self.clocks.as_ref()?.common(parameters)?,
            false => self.ranges.as_ref()?.alone(parameters)?,
        };
        let values = alone.values.iter().zip(&alone.deviations);
        Some(Candidate {
            values: values
                .map(|((parameter, value), deviation)| Estimated {
                    parameter: *parameter,
                    value: *value,
                    deviation: *deviation,
                })
                .collect(),
            gain: alone.gain,
        })
    }

    /// What is clearly off, the likeliest first; of one sonar's mount and ranges by no more than its readings lie nearer
    /// to the map with it.
    pub fn candidates(&self) -> Vec<Candidate> {
        let clear = |group: &[Parameter]| {
            self.of(group)
                .filter(|candidate| candidate.is_clear(self.seconds))
        };
        let groups = self.groups().into_iter();
        let clear = groups.flat_map(|group| match (clear(&group), group.as_slice()) {
            (Some(candidate), _) => vec![candidate],
            // Of a mount's x and y one may be all that the ranges tell.
            (None, [x, y]) => [x, y]
                .into_iter()
                .filter_map(|one| clear(&[*one]))
                .collect(),
            (None, _) => Vec::new(),
        });
        let clear: Vec<Candidate> = clear.collect();
        let mut first: Vec<Candidate> = self.of_clocks().into_iter().collect();
        if clear.is_empty() {
            return first;
        }
        let heard = Heard::new(&self.scene);
        let borne_out = |candidate: Candidate| {
            let values = candidate.values.iter();
            let gain = heard.gain(values.map(|one| (one.parameter, one.value)));
            Candidate {
                gain: gain.map_or(candidate.gain, |gain| gain.min(candidate.gain)),
                ..candidate
            }
        };
        let mut candidates: Vec<Candidate> = (clear.into_iter())
            .map(borne_out)
            .filter(|candidate| candidate.is_clear(self.seconds))
            .collect();
        candidates.sort_by(|a, b| b.worth().total_cmp(&a.worth()));
        // Clocks that differ lead least squares astray for everything else.
        first.extend(candidates);
        first
    }

    /// The sonars whose clocks are late together, the others being right: two at least have a clock of their own. What
    /// one alone is late, it may as well be off otherwise.
    fn of_clocks(&self) -> Option<Candidate> {
        let mut delays = self.clocks.as_ref()?.delays();
        delays.retain(|(_, _, deviation)| *deviation < ONE_CLOCK / 2.0);
        delays.sort_by(|a, b| a.1.total_cmp(&b.1));
        // The widest gap is between the two.
        let gap = |at: &usize| {
            let both = delays.get(*at).zip(delays.get(at + 1));
            both.map_or(0.0, |(a, b)| b.1 - a.1)
        };
        let widest = (0..delays.len()).max_by(|a, b| gap(a).total_cmp(&gap(b)))?;
        if gap(&widest) < ONE_CLOCK {
            return None;
        }
        let (early, late) = delays.split_at(widest + 1);
        let off = |some: &[(Parameter, f64, f64)]| {
            let mut of: Vec<f64> = some.iter().map(|(_, delay, _)| delay.abs()).collect();
            of.sort_by(f64::total_cmp);
            median(&of)
        };
        let group = if off(early) > off(late) { early } else { late };
        if group.len() < 2 {
            return None;
        }
        let mut group: Vec<Parameter> = group.iter().map(|(parameter, ..)| *parameter).collect();
        group.sort();
        self.of(&group).filter(|found| found.is_clear(self.seconds))
    }

    /// What the same sonar may be off instead, where the ranges tell it.
    pub fn siblings(&self, group: &[Parameter]) -> Vec<Candidate> {
        let [Parameter::Sonar(Whose::One(sonar), first), ..] = group else {
            return Vec::new();
        };
        if matches!(first, Quantity::Yaw | Quantity::BeamWidth) {
            return Vec::new();
        }
        let of = |quantity| Parameter::Sonar(Whose::One(*sonar), quantity);
        let all = [
            vec![of(Quantity::X), of(Quantity::Y)],
            vec![of(Quantity::RangeScale)],
            vec![of(Quantity::RangeOffset)],
            vec![of(Quantity::Delay)],
        ];
        // A mount in x and y is no other than one in x.
        let others = all
            .iter()
            .filter(|other| !group.iter().all(|own| other.contains(own)));
        let others = others.filter_map(|other| self.of(other));
        others.filter(Candidate::is_possible).collect()
    }
}

/// Whether values are off by more than their uncertainty, and by enough to matter in a log of so many
/// seconds. Of several, each is more uncertain where another one can stand for it.
pub fn are_clear(values: &[Estimated], seconds: f64) -> bool {
    let clear = if values.len() > 1 {
        CLEAR_OF_SEVERAL
    } else {
        CLEAR
    };
    values.iter().any(|one| {
        let least = one.least(seconds);
        let is_sure = one.value.abs() > clear * one.deviation;
        is_sure && one.value.abs() > least && one.deviation < VAGUE * least
    })
}

impl Candidate {
    /// Whether it is off by more than its uncertainty, and by enough to matter in a log of so many seconds.
    pub fn is_clear(&self, seconds: f64) -> bool {
        self.gain > CLEAR_GAIN
            && self.gain.is_finite()
            && are_clear(&self.values, seconds)
            && self.is_possible()
    }

    /// Whether ranges of a map could find it.
    fn is_possible(&self) -> bool {
        self.values.iter().all(|one| one.value.abs() < one.most())
    }

    /// Its parameters.
    pub fn parameters(&self) -> Vec<Parameter> {
        self.values.iter().map(|one| one.parameter).collect()
    }

    /// Whose it is, and whether the beams say so.
    pub fn origin(&self) -> Option<(Parameter, bool)> {
        let first = self.values.first()?.parameter;
        let is_shared = self.values.iter().any(|one| match (first, one.parameter) {
            (Parameter::Sonar(first, _), Parameter::Sonar(whose, _)) => first != whose,
            _ => false,
        });
        Some(match first {
            // What several sonars are off together says nothing of what each is alone.
            several if is_shared => (several, false),
            Parameter::Sonar(whose, quantity) => {
                let of_beam = matches!(quantity, Quantity::Yaw | Quantity::BeamWidth);
                (Parameter::Sonar(whose, Quantity::X), of_beam)
            }
            shared => (shared, false),
        })
    }

    /// The gain less what a parameter gains by chance.
    pub fn worth(&self) -> f64 {
        self.gain - OF_PARAMETER * self.values.len() as f64
    }
}

impl Estimated {
    /// Whether it is off by more than its uncertainty.
    pub fn is_sure(&self) -> bool {
        self.value.abs() > CLEAR * self.deviation
    }

    /// What matters: less moves no feature by more than a centimetre or so.
    pub fn least(&self, seconds: f64) -> f64 {
        match self.parameter {
            Parameter::RangeDelay => 0.01,
            Parameter::ClockRate => 0.02 / seconds.max(1.0),
            Parameter::OdometryScale | Parameter::OdometryTurnScale => 0.003,
            Parameter::Sonar(_, quantity) => match quantity {
                Quantity::X | Quantity::Y => 0.01,
                Quantity::Yaw => 1.0_f64.to_radians(),
                Quantity::RangeScale => 0.004,
                Quantity::RangeOffset => 0.008,
                Quantity::Delay => 0.02,
                Quantity::BeamWidth => 3.0_f64.to_radians(),
            },
        }
    }

    /// What is off by more is nothing that ranges of a map could find.
    fn most(&self) -> f64 {
        match self.parameter {
            Parameter::RangeDelay => 1.5,
            Parameter::ClockRate => 0.05,
            Parameter::OdometryScale | Parameter::OdometryTurnScale => 0.2,
            Parameter::Sonar(_, quantity) => match quantity {
                Quantity::X | Quantity::Y | Quantity::RangeOffset | Quantity::RangeScale => 0.2,
                Quantity::Yaw => 1.5,
                Quantity::Delay => 1.5,
                Quantity::BeamWidth => 2.0,
            },
        }
    }

    /// More uncertain than this the log cannot tell.
    pub fn tellable(&self, seconds: f64) -> f64 {
        3.0 * self.least(seconds)
    }
}
