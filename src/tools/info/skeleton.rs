//! The part of `tmam.toml` that a log needs and does not have.

use std::fmt::Write as _;

use toml::Value;

use super::trial::wider_gap;
use super::{Info, Verdict};
use crate::core::legible::one_line;
use crate::core::replay::ReplayError;
use crate::io::config::keys;
use crate::io::log::LogError;
use crate::io::log::survey::{PLACEHOLDER_BEAM_WIDTH, PLACEHOLDER_MAX_RANGE};

/// Keys by section, in the order in which they came up.
#[derive(Debug, Default)]
struct Sections(Vec<(String, Vec<Line>)>);

#[derive(Debug)]
struct Line {
    key: &'static str,
    value: Value,
    comment: String,
}

impl Sections {
    fn add(&mut self, section: &str, key: &'static str, value: Value, comment: impl Into<String>) {
        let line = Line {
            key,
            value,
            comment: comment.into(),
        };
        match self.0.iter_mut().find(|(known, _)| known == section) {
            Some((_, lines)) => lines.push(line),
            None => self.0.push((section.to_owned(), vec![line])),
        }
    }
}

/// The keys that are missing, with placeholders; `None` where nothing is.
pub fn skeleton(info: &Info, obstacles: &[LogError]) -> Option<String> {
    let mut sections = Sections::default();
    types(&mut sections, info, obstacles);
    odometry(&mut sections, info, obstacles);
    parameters(&mut sections, info);
    rings(&mut sections, obstacles);
    sonars(&mut sections, info, obstacles);
    if sections.0.is_empty() {
        return None;
    }
    let mut text = String::from(match info.verdict {
        Verdict::Yes => "# What would make more of this log.\n",
        Verdict::InPart => {
            "# What the sonars need that a replay leaves out. The values are placeholders: put in the right ones.\n"
        }
        Verdict::WithSkeleton => {
            "# What this log needs to be replayed. The values are placeholders: put in the right ones.\n"
        }
        Verdict::No => {
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

/// So many channels are given a type at the most.
const MOST_TYPES: usize = 256;

/// The types of channels of which the file does not say them, where something is missing.
fn types(sections: &mut Sections, info: &Info, obstacles: &[LogError]) {
    let is_missing = |obstacle: &LogError| {
        matches!(
            obstacle,
            LogError::NoRanges { .. } | LogError::NoOdometry { .. }
        )
    };
    if !obstacles.iter().any(is_missing) {
        return;
    }
    let untyped = info.channels.iter().filter(|channel| channel.is_untyped());
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

fn odometry(sections: &mut Sections, info: &Info, obstacles: &[LogError]) {
    let input = &info.trial.config.input;
    for obstacle in obstacles {
        match obstacle {
            LogError::ManyOdometries { topics, .. } => {
                let chosen = input.odometry_topics.first().cloned().unwrap_or_default();
                let others: Vec<&str> = topics
                    .iter()
                    .filter(|topic| globset::escape(topic) != chosen)
                    .map(String::as_str)
                    .collect();
                sections.add(
                    "input",
                    "odometry_topics",
                    Value::Array(vec![Value::String(chosen)]),
                    format!("choose one; the others: {}", others.join(", ")),
                );
            }
            LogError::NoRobotFrame { .. } | LogError::UnclearTransforms { .. } => sections.add(
                "input",
                "robot_frame",
                Value::String(input.robot_frame.clone().unwrap_or_default()),
                "a guess: the frame that the odometry moves",
            ),
            LogError::NoOdometry { passed_over, .. } => {
                if let Some((robot, world)) = passed_over.first() {
                    sections.add(
                        "input",
                        "world_frame",
                        Value::String(world.clone()),
                        format!(
                            "a guess: what `{robot}` moves in, by transforms the other way round"
                        ),
                    );
                }
            }
            _ => {}
        }
    }
}

fn parameters(sections: &mut Sections, info: &Info) {
    let config = &info.trial.config;
    let no_frames = |r: &ReplayError| matches!(r, ReplayError::NoFrames { .. });
    if let Some(odometry) = &info.odometry {
        let mended = info.trial.outcome.is_some() && info.trial.refused.iter().any(no_frames);
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
    let narrow = info.trial.refused.iter().find_map(|refusal| match refusal {
        ReplayError::GammaBeyondBeam { beam_width, .. } => Some(beam_width),
        _ => None,
    });
    if let Some(beam_width) = narrow {
        sections.add(
            "triple",
            "gamma",
            degrees(config.triple.gamma),
            format!(
                "deg; below the narrowest beam, {:.2} deg",
                beam_width.to_degrees()
            ),
        );
    }
}

fn sonars(sections: &mut Sections, info: &Info, obstacles: &[LogError]) {
    let beamless = |name: &str| {
        obstacles
            .iter()
            .any(|o| matches!(o, LogError::NoBeamWidth { sonar, .. } if sonar == name))
    };
    let without_beam = info.sonars.iter().filter(|s| beamless(&s.name)).count();
    let beam = "deg, full angle: see the data sheet";
    // One key for all, unless it is one sonar among many that lacks it.
    let for_all = without_beam > 1 || (without_beam == 1 && info.sonars.len() == 1);
    if for_all {
        sections.add(
            "sonars",
            "beam_width",
            degrees(PLACEHOLDER_BEAM_WIDTH),
            beam,
        );
    }
    let mut explained = false;
    for sonar in &info.sonars {
        let section = format!("sonar.{}", keys::quoted(&sonar.name));
        let missing = obstacles.iter().find_map(|obstacle| match obstacle {
            LogError::NoMount(missing) if missing.sonar == sonar.name => Some(missing),
            _ => None,
        });
        if let Some(missing) = missing {
            let frame = if missing.robot_frame.is_empty() {
                "the robot's frame".to_owned()
            } else {
                format!("`{}`", missing.robot_frame)
            };
            // The first one says what holds for all.
            let comments = if explained {
                Default::default()
            } else {
                [
                    format!("m in {frame}: measure these"),
                    "m, to the left".to_owned(),
                    "deg, counter-clockwise: where the beam looks".to_owned(),
                ]
            };
            explained = true;
            for (key, comment) in ["x", "y", "yaw"].into_iter().zip(comments) {
                sections.add(&section, key, Value::Float(0.0), comment);
            }
        }
        if !for_all && beamless(&sonar.name) {
            sections.add(
                &section,
                "beam_width",
                degrees(PLACEHOLDER_BEAM_WIDTH),
                beam,
            );
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
            // The first one says what holds for all.
            let comments = if index == 0 {
                [
                    "m in the robot's frame: measure these; any name will do for the sonar",
                    "m, to the left",
                    "deg, counter-clockwise: where its points lie, seen from the robot",
                    "deg, full angle: see the data sheet",
                    "m: see the data sheet; a point at this distance is no echo",
                ]
            } else {
                [""; 5]
            };
            let values = [
                ("x", Value::Float(0.0)),
                ("y", Value::Float(0.0)),
                (
                    "yaw",
                    Value::Float(libm::round(direction.to_degrees() * 10.0) / 10.0),
                ),
                ("beam_width", degrees(PLACEHOLDER_BEAM_WIDTH)),
                ("max_range", Value::Float(PLACEHOLDER_MAX_RANGE)),
            ];
            for ((key, value), comment) in values.into_iter().zip(comments) {
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
