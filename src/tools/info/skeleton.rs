//! The part of `tmam.toml` that a log needs and does not have.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use toml::Value;

use crate::core::legible::one_line;
use crate::core::replay::ReplayError;
use crate::io::config::keys;
use crate::io::log::survey::{PLACEHOLDER_BEAM_WIDTH, PLACEHOLDER_MAX_RANGE};
use crate::io::log::{LogError, MissingMount};
use crate::tools::findings::facts::{Facts, missing_mounts, without_beam};
use crate::tools::findings::sonars::SonarFacts;
use crate::tools::findings::trial::{Replayable, wider_gap};

/// Keys by section, in the order in which they came up.
#[derive(Debug, Default)]
struct Sections(Vec<(String, Vec<KeyLine>)>);

#[derive(Debug)]
struct KeyLine {
    key: &'static str,
    value: Value,
    comment: String,
}

impl Sections {
    /// Adds a key; those of one section follow each other.
    fn add(&mut self, section: &str, key: &'static str, value: Value, comment: impl Into<String>) {
        let line = KeyLine {
            key,
            value,
            comment: comment.into(),
        };
        match self.0.last_mut() {
            Some((last, lines)) if last == section => lines.push(line),
            _ => self.0.push((section.to_owned(), vec![line])),
        }
    }
}

/// The keys that are missing, with placeholders; `None` where nothing is.
pub fn skeleton(facts: &Facts, obstacles: &[LogError]) -> Option<String> {
    let mut sections = Sections::default();
    types(&mut sections, facts, obstacles);
    odometry(&mut sections, facts, obstacles);
    parameters(&mut sections, facts);
    rings(&mut sections, obstacles);
    sonars(&mut sections, facts, obstacles);
    if sections.0.is_empty() {
        return None;
    }
    let mut text = String::from(match facts.replay.possible {
        Replayable::Yes => "# What would make more of this log.\n",
        Replayable::InPart => {
            "# What the sonars need that a replay leaves out. The values are placeholders: put in the right ones.\n"
        }
        Replayable::WithSkeleton => {
            "# What this log needs to be replayed. The values are placeholders: put in the right ones.\n"
        }
        Replayable::No => {
            "# A part of what this log needs. It is not enough: see what else stands in the way.\n"
        }
    });
    for (section, lines) in &sections.0 {
        let _ = write!(text, "\n[{section}]\n");
        for line in lines {
            let assignment = format!("{} = {}", line.key, line.value);
            let _ = if line.comment.is_empty() {
                writeln!(text, "{assignment}")
            } else {
                writeln!(text, "{assignment:<32} # {}", one_line(&line.comment))
            };
        }
    }
    Some(text)
}

const DATA_SHEET: &str = "deg, full angle: see the data sheet";
const TO_THE_LEFT: &str = "m, to the left";
const LOOKS: &str = "deg, counter-clockwise: where the beam looks";
const MEASURE: &str = "m in the robot's frame: measure these; any name will do for the sonar";
const TO_ITS_POINTS: &str = "deg, counter-clockwise: where its points lie, seen from the robot";
const NO_ECHO: &str = "m: see the data sheet; a point at this distance is no echo";

/// So many channels are given a type at the most.
const MOST_TYPES: usize = 256;

/// The types of channels of which the file does not say them, where something is missing.
fn types(sections: &mut Sections, facts: &Facts, obstacles: &[LogError]) {
    let is_missing = |obstacle: &LogError| {
        matches!(
            obstacle,
            LogError::NoRanges { .. } | LogError::NoOdometry { .. }
        )
    };
    if !obstacles.iter().any(is_missing) {
        return;
    }
    let untyped = facts.channels.iter().filter(|channel| channel.is_untyped());
    let mut comment = "a guess by the topic, as the others: leave out what is neither";
    for channel in untyped.take(MOST_TYPES) {
        let topic = channel.topic.as_str();
        let guess = if topic == "/tf" || topic == "/tf_static" {
            "tf2_msgs/msg/TFMessage"
        } else if topic.contains("odom") {
            "nav_msgs/msg/Odometry"
        } else {
            "sensor_msgs/msg/Range"
        };
        let section = format!("channel.{}", keys::quoted(topic));
        let value = Value::String(guess.to_owned());
        sections.add(&section, "type", value, std::mem::take(&mut comment));
    }
}

fn odometry(sections: &mut Sections, facts: &Facts, obstacles: &[LogError]) {
    let input = &facts.replay.config.input;
    for obstacle in obstacles {
        match obstacle {
            LogError::ManyOdometries { topics, .. } => {
                let chosen = input.odometry_topics.first().cloned().unwrap_or_default();
                let others = topics.iter().map(String::as_str);
                let others = others.filter(|topic| globset::escape(topic) != chosen);
                let others = others.collect::<Vec<_>>().join(", ");
                let comment = format!("choose one; the others: {others}");
                let chosen = Value::Array(vec![Value::String(chosen)]);
                sections.add("input", "odometry_topics", chosen, comment);
            }
            LogError::NoRobotFrame { .. } | LogError::UnclearTransforms { .. } => sections.add(
                "input",
                "robot_frame",
                Value::String(input.robot_frame.clone().unwrap_or_default()),
                "a guess: the frame that the odometry moves",
            ),
            LogError::NoOdometry { passed_over, .. } => {
                if let Some((robot, world)) = passed_over.first() {
                    let comment = format!(
                        "a guess: what `{robot}` moves in, by transforms the other way round"
                    );
                    let world = Value::String(world.clone());
                    sections.add("input", "world_frame", world, comment);
                }
            }
            _ => {}
        }
    }
}

fn parameters(sections: &mut Sections, facts: &Facts) {
    let config = &facts.replay.config;
    let no_frames = |r: &ReplayError| matches!(r, ReplayError::NoFrames { .. });
    if let Some(odometry) = &facts.odometry {
        let mended = facts.replay.outcome.is_some() && facts.replay.refused.iter().any(no_frames);
        let gap = if mended {
            Some(config.frames.max_odometry_gap)
        } else {
            wider_gap(odometry, config.frames.max_odometry_gap)
        };
        if let (Some(gap), Some(interval)) = (gap, odometry.usual_interval) {
            let comment = format!("s; one in twenty samples comes later than {interval:.2} s");
            sections.add("frames", "max_odometry_gap", Value::Float(gap), comment);
        }
    }
    for refusal in &facts.replay.refused {
        if let ReplayError::GammaBeyondBeam { beam_width, .. } = refusal {
            let narrowest = beam_width.to_degrees();
            let comment = format!("deg; below the narrowest beam, {narrowest:.2} deg");
            sections.add("triple", "gamma", degrees(config.triple.gamma), comment);
        }
    }
}

/// The mounts, beams and limits that sonars lack.
fn sonars(sections: &mut Sections, facts: &Facts, obstacles: &[LogError]) {
    let mounts = missing_mounts(obstacles).into_iter();
    let mounts: BTreeMap<&str, &MissingMount> = mounts.map(|m| (m.sonar.as_str(), m)).collect();
    let beams: BTreeSet<&str> = without_beam(obstacles).into_iter().collect();
    let has_no_beam = |sonar: &&SonarFacts| beams.contains(sonar.name.as_str());
    let beam_width = degrees(PLACEHOLDER_BEAM_WIDTH);
    // One key for all, unless it is one sonar among many that lacks it.
    let count = facts.sonars.iter().filter(has_no_beam).count();
    let for_all = count > 1 || (count == 1 && facts.sonars.len() == 1);
    if for_all {
        sections.add("sonars", "beam_width", beam_width.clone(), DATA_SHEET);
    }
    let mut explained = false;
    for sonar in &facts.sonars {
        let section = format!("sonar.{}", keys::quoted(&sonar.name));
        if let Some(missing) = mounts.get(sonar.name.as_str()) {
            let frame = match missing.robot_frame.as_str() {
                "" => "the robot's frame".to_owned(),
                frame => format!("`{frame}`"),
            };
            let measure = format!("m in {frame}: measure these");
            // The first one says what holds for all.
            let is_first = !std::mem::replace(&mut explained, true);
            for (key, comment) in [("x", measure.as_str()), ("y", TO_THE_LEFT), ("yaw", LOOKS)] {
                let comment = if is_first { comment } else { "" };
                sections.add(&section, key, Value::Float(0.0), comment);
            }
        }
        if !for_all && has_no_beam(&sonar) {
            sections.add(&section, "beam_width", beam_width.clone(), DATA_SHEET);
        }
        if sonar.limits_are_senseless() {
            let limit = PLACEHOLDER_MAX_RANGE + sonar.min_range.max(0.0);
            let comment = format!(
                "m: see the data sheet; the log has {} to {}",
                short(sonar.min_range),
                short(sonar.max_range)
            );
            sections.add(&section, "max_range", Value::Float(limit), comment);
        }
    }
}

/// The sonars of which only the points are known where their beams ended.
fn rings(sections: &mut Sections, obstacles: &[LogError]) {
    let rings = obstacles.iter().filter_map(|obstacle| match obstacle {
        LogError::UnplacedRing(ring) => Some(ring),
        _ => None,
    });
    for ring in rings {
        for (index, direction) in ring.directions.iter().enumerate() {
            let section = format!("sonar.{}", ring.name(index));
            let direction = libm::round(direction.to_degrees() * 10.0) / 10.0;
            for (key, value, comment) in [
                ("x", Value::Float(0.0), MEASURE),
                ("y", Value::Float(0.0), TO_THE_LEFT),
                ("yaw", Value::Float(direction), TO_ITS_POINTS),
                ("beam_width", degrees(PLACEHOLDER_BEAM_WIDTH), DATA_SHEET),
                ("max_range", Value::Float(PLACEHOLDER_MAX_RANGE), NO_ECHO),
            ] {
                // The first one says what holds for all.
                let comment = if index == 0 { comment } else { "" };
                sections.add(&section, key, value, comment);
            }
        }
    }
}

/// A number as short as the file had it: ranges are single floats there.
fn short(number: f64) -> String {
    let single = number as f32;
    if f64::from(single) == number {
        single.to_string()
    } else {
        number.to_string()
    }
}

/// Degrees without the dust of the conversion.
fn degrees(radians: f64) -> Value {
    Value::Float(libm::round(radians.to_degrees() * 1e9) / 1e9)
}
