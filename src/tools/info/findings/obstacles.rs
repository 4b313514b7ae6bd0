//! What a replay would refuse.

use super::{Finding, Info, Weight, which_sonars};
use crate::core::replay::ReplayError;
use crate::io::log::{LogError, MissingMount};
use crate::tools::info::Verdict;
use crate::tools::info::channels::ChannelFacts;

const SKELETON: &str = "the skeleton below has the keys";

/// Everything without which nothing can be replayed or judged.
pub fn findings(info: &Info, obstacles: &[LogError], findings: &mut Vec<Finding>) {
    let weight = if info.verdict == Verdict::InPart {
        Weight::Serious
    } else {
        Weight::Blocking
    };
    let mut block = |code, what: String, effect: &str, mend: String| {
        findings.push(Finding::new(weight, code, what, effect, mend));
    };
    let nothing_read = info.channels.is_empty() && !info.losses.is_empty();
    if nothing_read {
        block(
            "nothing-read",
            "not one message of the log could be read".to_owned(),
            "there is nothing to replay",
            "see below what was lost and why".to_owned(),
        );
    }
    for obstacle in obstacles {
        match obstacle {
            LogError::NoRanges { .. } | LogError::NoOdometry { .. } if nothing_read => {}
            LogError::NoRanges { asked, .. } => block(
                "no-ranges",
                format!("the log has no range readings{}", because(asked)),
                "there is nothing to make arcs of",
                choose(info, asked, "range"),
            ),
            LogError::NoOdometry {
                asked, passed_over, ..
            } => block(
                "no-odometry",
                format!(
                    "the log has no odometry{}{}",
                    because(asked),
                    carried(passed_over)
                ),
                "no reading can be placed",
                if passed_over.is_empty() {
                    choose(info, asked, "odometry")
                } else {
                    format!(
                        "record the odometry; if the robot moves in one of these frames, set input.world_frame to it; {SKELETON}"
                    )
                },
            ),
            LogError::ManyOdometries { topics, .. } => block(
                "many-odometries",
                format!(
                    "there is more than one odometry topic: {}",
                    topics.join(", ")
                ),
                "two tracks of one robot do not agree, and which one is right cannot be told",
                format!("choose one with --odom-topic or input.odometry_topics; {SKELETON}"),
            ),
            LogError::NoRobotFrame { topic, .. } => block(
                "no-robot-frame",
                format!("the odometry on {topic} does not name the frame that it moves"),
                "the sonars' mounts cannot be found from it",
                format!("set input.robot_frame; {SKELETON}"),
            ),
            LogError::UnclearTransforms { moving, .. } => block(
                "unclear-transforms",
                format!(
                    "the log has no odometry messages, and several frames move by transforms: {}",
                    super::names(moving.iter().map(|(_, child)| child.as_str()))
                ),
                "which of them is the robot cannot be told",
                format!("set input.robot_frame; {SKELETON}"),
            ),
            LogError::NoSuchFrame { key, moving, .. } => block(
                "no-odometry",
                one_paragraph(obstacle),
                "no reading can be placed",
                format!("set {key} to one of them: {}", edges(moving)),
            ),
            LogError::UnplacedRing(ring) => block(
                "no-mount",
                format!(
                    "the points on {} do not say where the {} sonars are that they come from",
                    ring.topic,
                    ring.directions.len()
                ),
                "a point is the hit of the sonar on whose axis it lies, so the axes must be known",
                format!("give x, y, yaw and max_range of each under [sonar.\"NAME\"]; {SKELETON}"),
            ),
            LogError::NoMount(_) | LogError::NoBeamWidth { .. } => {}
            other => block("refused", other.to_string(), "", String::new()),
        }
    }
    mounts(info, obstacles, &mut block);
    beams(info, obstacles, &mut block);
    for refusal in &info.trial.refused {
        refused(refusal, &mut block);
    }
    let silent = info.trial.outcome.as_ref();
    if silent.is_some_and(|outcome| outcome.tally.echoes == 0) {
        block(
            "no-echo",
            "not one reading with a pose is an echo".to_owned(),
            "there are no arcs, so there is nothing to judge",
            "look at range, min_range and max_range of the sonars".to_owned(),
        );
    }
}

fn mounts(
    info: &Info,
    obstacles: &[LogError],
    block: &mut impl FnMut(&'static str, String, &str, String),
) {
    let missing: Vec<&MissingMount> = obstacles
        .iter()
        .filter_map(|obstacle| match obstacle {
            LogError::NoMount(missing) => Some(&**missing),
            _ => None,
        })
        .collect();
    let Some(first) = missing.first() else {
        return;
    };
    let sonars: Vec<&str> = missing.iter().map(|m| m.sonar.as_str()).collect();
    let frames = match &*first.frames {
        [] => "the log has no transforms".to_owned(),
        frames => format!(
            "frames with a transform: {}",
            super::names(frames.iter().map(String::as_str))
        ),
    };
    let frame = &first.frame;
    block(
        "no-mount",
        format!(
            "no mounting pose for {}: of frame `{frame}`, {}; {frames}",
            which_sonars(&sonars, info.sonars.len()),
            first.why
        ),
        "their arcs cannot be placed; an unknown mount is never taken for the robot's origin",
        format!(
            "record /tf_static, or give x, y and yaw of each under [sonar.\"NAME\"]; {SKELETON}"
        ),
    );
}

fn beams(
    info: &Info,
    obstacles: &[LogError],
    block: &mut impl FnMut(&'static str, String, &str, String),
) {
    let sonars: Vec<&str> = obstacles
        .iter()
        .filter_map(|obstacle| match obstacle {
            LogError::NoBeamWidth { sonar, .. } => Some(sonar.as_str()),
            _ => None,
        })
        .collect();
    if !sonars.is_empty() {
        block(
            "no-beam-width",
            format!(
                "no beam width from {}: field_of_view is no angle above 0",
                which_sonars(&sonars, info.sonars.len())
            ),
            "how wide an arc is decides which contact and intersection points count",
            format!("set sonars.beam_width (deg, full angle) from the data sheet; {SKELETON}"),
        );
    }
}

fn refused(refusal: &ReplayError, block: &mut impl FnMut(&'static str, String, &str, String)) {
    match refusal {
        ReplayError::GammaBeyondBeam {
            gamma,
            beam_width,
            sonar,
        } => block(
            "gamma-beyond-beam",
            format!(
                "triple.gamma is {:.2} deg; the beam of sonar {sonar} is only {:.2} deg wide",
                gamma.to_degrees(),
                beam_width.to_degrees()
            ),
            "a gate that no angle can miss labels arcs of which nothing is known",
            format!("give a triple.gamma below the beam width; {SKELETON}"),
        ),
        ReplayError::NoFrames {
            readings,
            ranges,
            samples,
            odometry,
            advice,
        } => block(
            "no-frames",
            format!(
                "none of {readings} range readings ({ranges}) has a pose from {samples} odometry \
                 samples ({odometry})"
            ),
            "no frame can be opened",
            (*advice).to_owned(),
        ),
        other => block("refused", other.to_string(), "", String::new()),
    }
}

/// Without its list of items, which a finding words otherwise.
fn one_paragraph(error: &LogError) -> String {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default();
    first.trim_end_matches(':').to_owned()
}

/// `a in b, c in d and 3 more`.
fn edges(edges: &[(String, String)]) -> String {
    let named: Vec<String> = edges
        .iter()
        .map(|(parent, child)| format!("`{child}` in `{parent}`"))
        .collect();
    super::names(named.iter().map(String::as_str))
}

fn carried(passed_over: &[(String, String)]) -> String {
    if passed_over.is_empty() {
        return String::new();
    }
    format!(
        "; transforms that move what the sonars' frame carries are none: {}",
        edges(passed_over)
    )
}

fn because(asked: &[String]) -> String {
    if asked.is_empty() {
        String::new()
    } else {
        format!(" on the topics asked for ({})", asked.join(", "))
    }
}

fn choose(info: &Info, asked: &[String], role: &str) -> String {
    let unread = |c: &ChannelFacts| c.is_unreadable() && c.role == Some(role);
    let is_empty = |c: &&ChannelFacts| c.role == Some(role) && !c.is_unreadable();
    let empty: Vec<&str> = info
        .channels
        .iter()
        .filter(is_empty)
        .map(|c| c.topic.as_str())
        .collect();
    let flag = if role == "range" { "range" } else { "odom" };
    if !asked.is_empty() {
        format!("ask for other topics with --{flag}-topic: the channels above are there")
    } else if info.channels.iter().any(unread) {
        format!("record the {role} channels in a form that is read")
    } else if !empty.is_empty() {
        let what = if role == "range" {
            crate::io::log::NO_RANGE
        } else {
            crate::io::log::NO_POSE
        };
        format!(
            "look at what publishes {}: {what}",
            super::names(empty.into_iter())
        )
    } else if info.channels.iter().any(ChannelFacts::is_untyped) {
        format!(
            "the log does not say of what type some channels are: name the type of those that hold {role} in the \
             configuration, [channel.\"/topic\"] type = \"...\"; {SKELETON}"
        )
    } else {
        format!("no channel above has a type that is read as {role}; docs/logs.md says which are")
    }
}
