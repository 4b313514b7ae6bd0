//! What a replay would refuse, as findings.

use super::facts::{ChannelFacts, Facts, missing_mounts, without_beam};
use super::finding::{Finding, Weight, names, which_sonars};
use super::trial::Replayable;
use crate::core::replay::ReplayError;
use crate::io::log::{LogError, NO_POSE, NO_RANGE};

const SKELETON: &str = "the skeleton below has the keys";

/// What was found, what it does and what to do.
type Told = (&'static str, String, &'static str, String);

/// Everything without which nothing can be replayed or judged.
pub fn findings(facts: &Facts, obstacles: &[LogError]) -> Vec<Finding> {
    let weight = if facts.replay.possible == Replayable::InPart {
        Weight::Serious
    } else {
        Weight::Blocking
    };
    let nothing_read = facts.channels.is_empty() && !facts.source.lost.is_empty();
    let mut told: Vec<Told> = Vec::new();
    if nothing_read {
        told.push((
            "nothing-read",
            "not one message of the log could be read".to_owned(),
            "there is nothing to replay",
            "see below what was lost and why".to_owned(),
        ));
    }
    let follows = |obstacle: &&LogError| {
        nothing_read
            && matches!(
                obstacle,
                LogError::NoRanges { .. } | LogError::NoOdometry { .. }
            )
    };
    let others = obstacles.iter().filter(|obstacle| !follows(obstacle));
    told.extend(others.filter_map(|obstacle| obstruction(facts, obstacle)));
    told.extend(mounts(facts, obstacles));
    told.extend(beams(facts, obstacles));
    told.extend(facts.replay.refused.iter().map(refusal));
    let outcome = facts.replay.outcome.as_ref();
    if outcome.is_some_and(|outcome| outcome.tally.echoes == 0) {
        told.push((
            "no-echo",
            "not one reading with a pose is an echo".to_owned(),
            "there are no arcs, so there is nothing to judge",
            "look at range, min_range and max_range of the sonars".to_owned(),
        ));
    }
    let told = told.into_iter();
    told.map(|(code, what, effect, mend)| Finding::new(weight, code, what, effect, mend))
        .collect()
}

/// `None` for what is told of all sonars together.
fn obstruction(facts: &Facts, obstacle: &LogError) -> Option<Told> {
    Some(match obstacle {
        LogError::NoRanges { asked, .. } => (
            "no-ranges",
            format!("the log has no range readings{}", because(asked)),
            "there is nothing to make arcs of",
            choose(facts, asked, "range"),
        ),
        LogError::NoOdometry {
            asked, passed_over, ..
        } => {
            let mut what = format!("the log has no odometry{}", because(asked));
            let mut mend = choose(facts, asked, "odometry");
            if !passed_over.is_empty() {
                what += "; transforms that move what the sonars' frame carries are none: ";
                what += &edges(passed_over);
                mend = format!(
                    "record the odometry; if the robot moves in one of these frames, set input.world_frame to it; {SKELETON}"
                );
            }
            ("no-odometry", what, "no reading can be placed", mend)
        }
        LogError::ManyOdometries { topics, .. } => (
            "many-odometries",
            format!(
                "there is more than one odometry topic: {}",
                topics.join(", ")
            ),
            "two tracks of one robot do not agree, and which one is right cannot be told",
            format!("choose one with --odom-topic or input.odometry_topics; {SKELETON}"),
        ),
        LogError::NoRobotFrame { topic, .. } => (
            "no-robot-frame",
            format!("the odometry on {topic} does not name the frame that it moves"),
            "the sonars' mounts cannot be found from it",
            format!("set input.robot_frame; {SKELETON}"),
        ),
        LogError::UnclearTransforms { moving, .. } => (
            "unclear-transforms",
            format!(
                "the log has no odometry messages, and several frames move by transforms: {}",
                names(moving.iter().map(|(_, child)| child.as_str()))
            ),
            "which of them is the robot cannot be told",
            format!("set input.robot_frame; {SKELETON}"),
        ),
        LogError::NoSuchFrame { key, moving, .. } => (
            "no-odometry",
            one_paragraph(obstacle),
            "no reading can be placed",
            format!("set {key} to one of them: {}", edges(moving)),
        ),
        LogError::UnplacedRing(ring) => (
            "no-mount",
            format!(
                "the points on {} do not say where the {} sonars are that they come from",
                ring.topic,
                ring.directions.len()
            ),
            "a point is the hit of the sonar on whose axis it lies, so the axes must be known",
            format!("give x, y, yaw and max_range of each under [sonar.\"NAME\"]; {SKELETON}"),
        ),
        LogError::NoMount(_) | LogError::NoBeamWidth { .. } => return None,
        other => ("refused", other.to_string(), "", String::new()),
    })
}

fn mounts(facts: &Facts, obstacles: &[LogError]) -> Option<Told> {
    let missing = missing_mounts(obstacles);
    let first = missing.first()?;
    let sonars: Vec<&str> = missing.iter().map(|m| m.sonar.as_str()).collect();
    let frames = match &*first.frames {
        [] => "the log has no transforms".to_owned(),
        frames => {
            let frames = names(frames.iter().map(String::as_str));
            format!("frames with a transform: {frames}")
        }
    };
    let which = which_sonars(&sonars, facts.sonars.len());
    Some((
        "no-mount",
        format!(
            "no mounting pose for {which}: of frame `{}`, {}; {frames}",
            first.frame, first.why
        ),
        "their arcs cannot be placed; an unknown mount is never taken for the robot's origin",
        format!(
            "record /tf_static, or give x, y and yaw of each under [sonar.\"NAME\"]; {SKELETON}"
        ),
    ))
}

fn beams(facts: &Facts, obstacles: &[LogError]) -> Option<Told> {
    let sonars = without_beam(obstacles);
    let which = which_sonars(&sonars, facts.sonars.len());
    (!sonars.is_empty()).then(|| {
        (
            "no-beam-width",
            format!("no beam width from {which}: field_of_view is no angle above 0"),
            "how wide an arc is decides which contact and intersection points count",
            format!("set sonars.beam_width (deg, full angle) from the data sheet; {SKELETON}"),
        )
    })
}

fn refusal(refusal: &ReplayError) -> Told {
    match refusal {
        ReplayError::GammaBeyondBeam {
            gamma,
            beam_width,
            sonar,
        } => (
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
        } => (
            "no-frames",
            format!(
                "none of {readings} range readings ({ranges}) has a pose from {samples} odometry \
                 samples ({odometry})"
            ),
            "no frame can be opened",
            (*advice).to_owned(),
        ),
        other => ("refused", other.to_string(), "", String::new()),
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
    let named = edges.iter();
    let named = named.map(|(parent, child)| format!("`{child}` in `{parent}`"));
    let named: Vec<String> = named.collect();
    names(named.iter().map(String::as_str))
}

fn because(asked: &[String]) -> String {
    if asked.is_empty() {
        String::new()
    } else {
        format!(" on the topics asked for ({})", asked.join(", "))
    }
}

/// How to get the ranges or the odometry that the log lacks.
fn choose(facts: &Facts, asked: &[String], role: &str) -> String {
    let (flag, hint) = match role {
        "range" => ("range", NO_RANGE),
        _ => ("odom", NO_POSE),
    };
    let channels = || facts.channels.iter();
    let of_role = |c: &&ChannelFacts| c.role == Some(role);
    let empty: Vec<&str> = channels()
        .filter(|c| of_role(c) && !c.is_unreadable())
        .map(|c| c.topic.as_str())
        .collect();
    if !asked.is_empty() {
        format!("ask for other topics with --{flag}-topic: the channels above are there")
    } else if channels().filter(of_role).any(ChannelFacts::is_unreadable) {
        format!("record the {role} channels in a form that is read")
    } else if !empty.is_empty() {
        format!("look at what publishes {}: {hint}", names(empty))
    } else if channels().any(ChannelFacts::is_untyped) {
        format!(
            "the log does not say of what type some channels are: name the type of those that hold {role} in the \
             configuration, [channel.\"/topic\"] type = \"...\"; {SKELETON}"
        )
    } else {
        format!("no channel above has a type that is read as {role}; docs/logs.md says which are")
    }
}
