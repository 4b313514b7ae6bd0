//! Causes in words: what is off, what was tried, and what came of it.

use std::fmt::Write as _;

use crate::core::calibrate::candidate::Estimated;
use crate::core::calibrate::change::Change;
use crate::core::calibrate::parameter::{Parameter, Quantity, Whose};
use crate::core::calibrate::search::{Cause, Effort, Search, Standing, search};
use crate::core::config::{Config, Method, Rule};
use crate::core::event::{Events, SonarId, name_of};
use crate::core::legible::one_line;
use crate::core::replay::{CauseTold, Outcome, Replay};
use crate::core::rounding::fixed;
use crate::core::wording::few;
use crate::io::config::changed::{ChangedKey, changed_keys};

/// What was looked at.
pub const LOOKED_AT: &str = "mounts, beams, range scale and offset of every sonar, range delay and clock rate, \
                             odometry scales";

/// What a table calls a parameter.
pub fn named(parameter: Parameter, events: &Events) -> String {
    match parameter {
        Parameter::RangeDelay => "range delay".to_owned(),
        Parameter::ClockRate => "range clock rate".to_owned(),
        Parameter::OdometryScale => "odometry scale".to_owned(),
        Parameter::OdometryTurnScale => "odometry turn scale".to_owned(),
        Parameter::Sonar(whose, quantity) => format!("{} {}", who(whose, events), of(quantity)),
    }
}

fn of(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::X => "x",
        Quantity::Y => "y",
        Quantity::Yaw => "yaw",
        Quantity::RangeScale => "range scale",
        Quantity::RangeOffset => "range offset",
        Quantity::Delay => "delay",
        Quantity::BeamWidth => "beam width",
    }
}

fn who(whose: Whose, events: &Events) -> String {
    match whose {
        Whose::All => "all sonars".to_owned(),
        Whose::One(sonar) => name(sonar, events),
    }
}

fn name(sonar: SonarId, events: &Events) -> String {
    one_line(name_of(&events.sonars, sonar)).into_owned()
}

/// A parameter's unit in words, and what a number of it is multiplied with.
pub fn unit(parameter: Parameter) -> (&'static str, f64) {
    match parameter {
        Parameter::RangeDelay => ("ms", 1e3),
        Parameter::ClockRate | Parameter::OdometryScale | Parameter::OdometryTurnScale => {
            ("%", 100.0)
        }
        Parameter::Sonar(_, quantity) => match quantity {
            Quantity::X | Quantity::Y | Quantity::RangeOffset => ("cm", 100.0),
            Quantity::RangeScale => ("%", 100.0),
            Quantity::Delay => ("ms", 1e3),
            Quantity::Yaw | Quantity::BeamWidth => ("deg", 1.0_f64.to_degrees()),
        },
    }
}

/// `+3.1 deg (+-0.3)`.
pub fn amount(one: &Estimated) -> String {
    let (unit, scale) = unit(one.parameter);
    let decimals = if matches!(unit, "ms") {
        0
    } else {
        1 + usize::from(unit == "%")
    };
    let value = fixed(one.value.abs() * scale, decimals);
    let sign = if one.value < 0.0 { "-" } else { "+" };
    format!(
        "{sign}{value} {unit} (+-{})",
        fixed(one.deviation * scale, decimals)
    )
}

/// Turned by more than this a sonar looks the other way, radians.
const ROUND: f64 = 3.0;
/// Ranges that are off by more are told by a factor.
const ROUGH: f64 = 0.3;

/// `a and b`, or as [`few`].
fn both(names: &[String]) -> String {
    match names {
        [one, other] => format!("{one} and {other}"),
        _ => few(names),
    }
}

fn sonar_of(one: &Estimated) -> Option<SonarId> {
    match one.parameter {
        Parameter::Sonar(Whose::One(sonar), _) => Some(sonar),
        _ => None,
    }
}

/// What is off: `sonar_06 is turned by +3.1 deg (+-0.3)`.
pub fn what(values: &[Estimated], events: &Events) -> String {
    let Some(first) = values.first() else {
        return String::new();
    };
    let size = amount(first);
    let without_sign = size.trim_start_matches(['+', '-']);
    let (more, less) = match first.parameter {
        Parameter::RangeDelay | Parameter::Sonar(_, Quantity::Delay) => ("late", "early"),
        Parameter::ClockRate => ("fast", "slow"),
        _ => ("short", "long"),
    };
    let word = if first.value > 0.0 { more } else { less };
    let mut sonars: Vec<SonarId> = values.iter().filter_map(sonar_of).collect();
    sonars.dedup();
    let sonars: Vec<String> = sonars
        .into_iter()
        .map(|sonar| name(sonar, events))
        .collect();
    match first.parameter {
        Parameter::RangeDelay => format!("ranges are stamped {without_sign} too {word}"),
        Parameter::ClockRate => {
            format!("the clock of the ranges runs {without_sign} too {word}")
        }
        Parameter::OdometryScale => {
            format!("distances of odometry are {without_sign} too {word}")
        }
        Parameter::OdometryTurnScale => format!("turns of odometry are {without_sign} too {word}"),
        Parameter::Sonar(whose, quantity) => {
            let who = who(whose, events);
            let is = match whose {
                Whose::One(_) => "is",
                Whose::All => "are",
            };
            match quantity {
                Quantity::Delay if sonars.len() > 1 => format!(
                    "ranges of {} are stamped {without_sign} too {word}, and those of the others are not",
                    both(&sonars)
                ),
                Quantity::Delay => {
                    format!("ranges of {who} alone are stamped {without_sign} too {word}")
                }
                Quantity::Yaw if sonars.len() > 1 => format!(
                    "{} are exchanged: each measures from where another of them is said to be",
                    both(&sonars)
                ),
                Quantity::Yaw if first.value.abs() > ROUND => {
                    format!("{who} looks the other way: it is turned by {size}")
                }
                Quantity::RangeScale if first.value.abs() > ROUGH => format!(
                    "ranges of {who} are {} times what they should be",
                    fixed(1.0 / (1.0 + first.value), 2)
                ),
                Quantity::Yaw => format!("{who} {is} turned by {size}"),
                Quantity::X | Quantity::Y => {
                    let parts = values.iter().map(|one| match one.parameter {
                        Parameter::Sonar(_, quantity) => {
                            format!("{} by {}", of(quantity), amount(one))
                        }
                        _ => String::new(),
                    });
                    let parts: Vec<String> = parts.collect();
                    format!("{who} {is} mounted elsewhere: {}", parts.join(", "))
                }
                Quantity::RangeScale | Quantity::RangeOffset => {
                    format!("ranges of {who} are {without_sign} too {word}")
                }
                Quantity::BeamWidth => {
                    let wider = if first.value > 0.0 {
                        "wider"
                    } else {
                        "narrower"
                    };
                    format!("the beam of {who} is {without_sign} {wider} than configured")
                }
            }
        }
    }
}

fn share(standing: &Standing) -> String {
    let share = standing.bits.explained_share().unwrap_or(0.0);
    fixed(100.0 * share, 1)
}

fn bits(standing: &Standing) -> String {
    fixed(standing.bits.per_arc().unwrap_or(0.0), 2)
}

/// What came of it: `explained rises from 79.0 to 88.1 %, ...`.
pub fn came_of(cause: &Cause) -> String {
    if let Some(alone) = cause.by_odometry {
        let [before, after] = alone.map(|share| fixed(100.0 * share, 1));
        return format!(
            "odometry's own poses explain {after} % of the arcs in place of {before} %; the estimated path makes up for it"
        );
    }
    let [before, after] = &cause.standings;
    let mut text = format!(
        "explained goes from {} to {} %, bits from {} to {}",
        share(before),
        share(after),
        bits(before),
        bits(after)
    );
    if before.suspects != after.suspects {
        // Writing into a string cannot fail.
        let _ = write!(
            text,
            ", suspects from {} to {}",
            before.suspects, after.suspects
        );
    }
    text
}

/// How a change of so many keys is typed: the first few.
pub fn settings(keys: &[ChangedKey]) -> String {
    const SHOWN: usize = 9;
    let shown: Vec<String> = keys.iter().take(SHOWN).map(ChangedKey::setting).collect();
    match keys.len().saturating_sub(SHOWN) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// A cause in words. `before` are the values of the causes that are mended already.
fn told(cause: &Cause, before: &Change, events: &Events, config: &Config) -> CauseTold {
    let mut changed = before.clone();
    for one in &cause.values {
        changed.add(one.parameter, one.value);
    }
    let mended = changed_keys(before, events, config);
    let keys: Vec<ChangedKey> = changed_keys(&changed, events, config)
        .into_iter()
        .filter(|key| !mended.contains(key))
        .collect();
    let mut text = format!(
        "{}: with {} {}",
        what(&cause.values, events),
        settings(&keys),
        came_of(cause)
    );
    for rival in &cause.rivals {
        // Writing into a string cannot fail.
        let _ = write!(text, "; or {}, which explains as much", what(rival, events));
    }
    CauseTold {
        text,
        settings: keys.iter().map(ChangedKey::setting).collect(),
        sonar: cause.values.first().and_then(sonar_of),
    }
}

/// All causes, the weightiest first.
pub fn all(search: &Search, events: &Events, config: &Config) -> Vec<CauseTold> {
    let mut before = Change::default();
    let causes = search.causes.iter().map(|cause| {
        let told = told(cause, &before, events, config);
        for one in &cause.values {
            before.add(one.parameter, one.value);
        }
        told
    });
    causes.collect()
}

/// What is off in a log that was replayed; `None` under the paper's rule and by other methods, whose maps are
/// not made of all that is heard.
pub fn look_for(replay: &Replay<'_>, outcome: &Outcome) -> Option<Vec<CauseTold>> {
    let config = replay.config();
    (config.method == Method::Tmam && config.rule == Rule::NoiseAware).then(|| {
        let found = search(replay, outcome, Effort::AFTER_REPLAY);
        all(&found, &replay.log().events, config)
    })
}
