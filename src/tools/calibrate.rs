//! A log held against its configuration: what it says of every mount, beam, clock and scale, and what is
//! off. [`text`] tells it to a person, [`Calibration::write`] to machines (`tmam.calibration/1`).

mod json;
pub mod text;

use std::f64::consts::LOG2_E;

use crate::core::calibrate::candidate::Estimated;
use crate::core::calibrate::parameter::{Parameter, Quantity, Whose};
use crate::core::calibrate::search::{Effort, Search, search};
use crate::core::config::Config;
use crate::core::event::Events;
use crate::core::replay::{Outcome, Replay};
use crate::io::config::changed::{ChangedKey, changed_keys};

/// A log held against its configuration.
#[derive(Debug)]
pub struct Calibration<'a> {
    /// Its file name.
    pub file: &'a str,
    /// The log.
    pub events: &'a Events,
    /// What it was replayed with.
    pub config: &'a Config,
    /// What was found and tried.
    pub search: Search,
    /// What the log says of every parameter, in their order.
    pub rows: Vec<Row>,
}

/// What a log says of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// How far it is from what is configured, with its standard deviation; `None` where nothing is known.
    pub estimated: Option<Estimated>,
    /// The parameter.
    pub parameter: Parameter,
    /// What the log gains by it, bits an arc.
    pub gain: f64,
    /// What follows.
    pub state: State,
}

/// What follows from an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// The log agrees.
    AsConfigured,
    /// The log says otherwise, and a replay bears it out.
    Off,
    /// The log says otherwise, but no replay is the better for it.
    NotBorneOut,
    /// The log cannot tell.
    CannotTell(Why),
}

/// Why a log cannot tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Why {
    /// The sonar hears hardly anything that the map has.
    Unheard,
    /// What it hears lies far from the edges of its beam.
    NoEdge,
    /// What it hears does not move with it.
    Unseen,
}

impl<'a> Calibration<'a> {
    /// Of a replay.
    pub fn new(replay: &'a Replay<'_>, outcome: &Outcome) -> Self {
        let search = search(replay, outcome, Effort::THOROUGH);
        Self {
            file: &replay.log().file,
            events: &replay.log().events,
            config: replay.config(),
            rows: rows(&search),
            search,
        }
    }

    /// The keys that mend what is off.
    pub fn keys(&self) -> Vec<ChangedKey> {
        changed_keys(&self.search.change, self.events, self.config)
    }
}

fn rows(search: &Search) -> Vec<Row> {
    let estimates = &search.estimates;
    let arcs = search.standings[0].bits.arcs.max(1) as f64;
    let mut rows: Vec<Row> = Vec::new();
    for group in estimates.groups() {
        let candidate = estimates.of(&group);
        for (at, parameter) in group.iter().enumerate() {
            let left = candidate.as_ref().and_then(|found| found.values.get(at));
            let changed = search.change.of(*parameter);
            let estimated = left.map(|left| Estimated {
                value: changed + left.value,
                ..*left
            });
            let cause = search.causes.iter().find(|cause| {
                let mut values = cause.values.iter();
                values.any(|one| one.parameter == *parameter)
            });
            let gain = match cause {
                Some(cause) => {
                    let [before, after] = &cause.standings;
                    after.gain_over(before).max(0.0) / arcs
                }
                None => candidate.as_ref().map_or(0.0, |found| found.gain.max(0.0)) * LOG2_E / arcs,
            };
            let is_clear = candidate
                .as_ref()
                .is_some_and(|found| found.is_clear(estimates.seconds));
            let tells =
                estimated.is_some_and(|one| one.deviation < one.tellable(estimates.seconds));
            let state = match (cause.is_some(), tells, is_clear) {
                (true, _, _) => State::Off,
                (false, false, _) => State::CannotTell(why(search, *parameter)),
                (false, true, true) => State::NotBorneOut,
                (false, true, false) => State::AsConfigured,
            };
            rows.push(Row {
                estimated,
                parameter: *parameter,
                gain,
                state,
            });
        }
    }
    rows
}

fn why(search: &Search, parameter: Parameter) -> Why {
    /// Fewer readings of the map's features than this say little.
    const FEW: usize = 10;
    match parameter {
        Parameter::Sonar(_, Quantity::Yaw | Quantity::BeamWidth) => Why::NoEdge,
        Parameter::Sonar(Whose::One(sonar), _) => {
            let ranges = search.estimates.ranges.as_ref();
            let readings = ranges.and_then(|ranges| ranges.readings.get(sonar.index()));
            if readings.is_none_or(|readings| *readings < FEW) {
                Why::Unheard
            } else {
                Why::Unseen
            }
        }
        _ => Why::Unseen,
    }
}

impl State {
    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::AsConfigured => "as-configured",
            Self::Off => "off",
            Self::NotBorneOut => "not-borne-out",
            Self::CannotTell(_) => "cannot-tell",
        }
    }
}

impl Why {
    /// In words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Unheard => "hardly a reading is of a feature of the map",
            Self::NoEdge => {
                "what is heard lies far from the edges of the beam, or the map has too little beside it"
            }
            Self::Unseen => "the ranges hardly change with it on this way",
        }
    }
}
