//! Puts together what the messages of a log say: sonars with names and mounts, readings and odometry in
//! stamp order.

use std::collections::{BTreeMap, BTreeSet};

use super::channels::ChannelReport;
use super::container::Loss;
use super::error::LogError;
use super::gather::Gatherer;
use super::leaps::{spread_jumps, take_out_jumps};
use super::message::Role;
use super::namespaces::{Frames, is_in};
use super::odometry::{Chosen, Circumstances, Odometry};
use super::sonars::Placing;
use super::stamps::{self, Clock, ClockSet, LeftOut};
use super::tracks::one_track;
use super::traits::Traits;
use super::transforms::TransformTree;
use super::{channels as found, hits, repeats};
use crate::core::calibrate::change::Change;
use crate::core::config::channel::of_topic;
use crate::core::config::{Config, Jumps};
use crate::core::event::Events;
use crate::core::legible::one_line;
use crate::core::log::Log;
use crate::core::pattern::is_chosen;
use crate::core::wording::{counted, counted_with, few};

/// A log that can be replayed.
#[derive(Debug)]
pub struct Finished {
    /// It; what was left out is among its losses.
    pub log: Log,
    /// What its channels are.
    pub channels: Vec<ChannelReport>,
    /// How the clock of its stamps was set while it was recorded.
    pub clock_set: Option<ClockSet>,
    /// What kept sonars out.
    pub left_out: Vec<LogError>,
    /// The topic that says where the robot was.
    pub odometry_topic: String,
    /// What the log says besides.
    pub traits: Traits,
}

/// Why a log cannot be replayed.
#[derive(Debug)]
pub struct Stopped {
    /// What is missing.
    pub error: LogError,
    /// What a person should know of the log all the same.
    notes: Vec<String>,
}

impl Stopped {
    /// The error with all that was found before it.
    pub fn into_error(self, losses: &[Loss]) -> LogError {
        self.error.noting(in_lines(self.notes)).after(losses)
    }
}

/// Each as one line: a name in it cannot look like another one.
fn in_lines(texts: Vec<String>) -> Vec<String> {
    let lines = texts.iter().map(|text| one_line(text).into_owned());
    lines.collect()
}

/// Puts what was gathered together.
///
/// # Errors
/// When something is missing without which nothing can be replayed.
pub fn assemble(
    gatherer: Gatherer,
    file: String,
    config: &Config,
    channels: Vec<ChannelReport>,
    losses: &[Loss],
) -> Result<Finished, Box<Stopped>> {
    let mut notes = Vec::new();
    put_together(gatherer, file, config, channels, losses, &mut notes)
        .map_err(|error| Box::new(Stopped { error, notes }))
}

fn put_together(
    mut gathered: Gatherer,
    file: String,
    config: &Config,
    mut channels: Vec<ChannelReport>,
    losses: &[Loss],
    notes: &mut Vec<String>,
) -> Result<Finished, LogError> {
    notes.append(&mut gathered.notes);
    let no_ranges = |channels: &[ChannelReport]| LogError::NoRanges {
        file: file.clone(),
        asked: config.input.range_topics.clone(),
        found: found::candidates(channels, &[Role::Range]),
    };
    if gathered.crowded {
        return Err(LogError::TooManySonars { file });
    }
    if gathered.readings.is_empty() && gathered.hits.is_empty() {
        for channel in channels.iter_mut() {
            let is_empty = channel.used && channel.role == Some(Role::Range);
            if is_empty && channel.problem.is_none() {
                channel.problem = Some(found::NO_RANGE.to_owned());
            }
        }
        return Err(no_ranges(&channels));
    }
    let odd = gathered.leave_out_odd();
    let frames = choose_frames(&mut gathered, config, &channels, notes);
    let mut odometry = choose_odometry(&mut gathered, &frames, &file, config, &mut channels)?;
    let robot_frame = config
        .input
        .robot_frame
        .clone()
        .unwrap_or_else(|| odometry.robot_frame.clone());
    let unplaced = hits::take(
        &mut gathered,
        &frames.transforms,
        config,
        &robot_frame,
        &odometry.world_frame,
        &mut channels,
    );
    if gathered.crowded {
        return Err(LogError::TooManySonars { file });
    }
    if gathered.readings.is_empty() {
        return Err(unplaced.unwrap_or_else(|| no_ranges(&channels)));
    }
    notes.append(&mut gathered.notes);
    notes.extend(found::on_channels(&channels));
    note(&gathered, &frames, config, &channels, &odometry, notes);
    let mut lost = found::on_losses(losses, &channels);
    lost.extend(odd);
    lost.append(&mut odometry.losses);
    lost.extend(without_pose(&odometry));
    let names = frames.transforms.frames().into_iter();
    let names = names.map(str::to_owned).collect();
    let mut placing = Placing {
        frames: &names,
        odometry_topic: &odometry.topic,
        world_frame: &odometry.world_frame,
        robot_frame: &robot_frame,
        transforms: &frames.transforms,
        config,
    };
    let unturned = frames.transforms.with_unturned();
    let unturned = unturned.filter(|_| !placing.places_any(&gathered.sources));
    notes.extend(unturned.as_ref().unwrap_or(&frames.transforms).note());
    if let Some(transforms) = &unturned {
        placing.transforms = transforms;
        let taken: Vec<String> = transforms.unturned().map(|f| format!("`{f}`")).collect();
        notes.push(format!(
            "the quaternions of the transforms of {} are zero, and no sonar has another mount; they are taken for \
             frames that are not turned",
            few(&taken)
        ));
    }
    let placed = match placing.place(&gathered.sources, gathered.readings, notes) {
        Ok(placed) => placed,
        Err(error) => {
            // Messages that could not be read may have held what is missing.
            notes.extend(lost.into_iter().skip(losses.len()));
            return Err(error);
        }
    };
    let (sonars, mut readings, mut left_out) = (placed.sonars, placed.readings, placed.left_out);
    lost.extend(placed.losses);
    let names = || sonars.iter().map(|sonar| sonar.name.as_str());
    notes.extend(idle("input.sonars", &config.input.sonars, "sonar", names()));
    left_out.extend(unplaced);
    let mut samples = odometry.samples;
    samples.sort_by_key(|sample| sample.stamp_ns);
    if let Some(track) = config.input.odometry_track {
        samples = one_track(samples, track);
        odometry.traits.forget_speeds();
    }
    let topic = &odometry.topic;
    let astray = LeftOut::astray(samples.iter().map(|s| s.stamp_ns), topic);
    lost.extend(astray.map(|it| it.take_out(|stays| samples.retain(|_| stays()))));
    let far = LeftOut::far(&samples, topic);
    lost.extend(far.map(|it| it.take_out(|stays| samples.retain(|_| stays()))));
    let astray = LeftOut::astray(readings.iter().map(|r| r.stamp_ns), "range topics");
    lost.extend(astray.map(|it| it.take_out(|stays| readings.retain_mut(|_| stays()))));
    notes.extend(stamps::twins(&readings));
    let ranges: Vec<&Clock> = gathered
        .sources
        .iter()
        .map(|source| &source.clock)
        .collect();
    let clock_set = stamps::jump(&ranges, &odometry.clock)
        .or_else(|| stamps::returned(&ranges, &odometry.clock));
    if let Some(jumps) = config.input.odometry_jumps {
        let twice = clock_set.as_ref().map_or(&[][..], |set| &set.twice);
        match jumps {
            Jumps::Keep => {}
            Jumps::TakeOut => take_out_jumps(&mut samples, twice),
            Jumps::Spread => spread_jumps(&mut samples, twice),
        }
        odometry.traits.forget_speeds();
    }
    let mut time_notes: Vec<String> = clock_set.iter().map(ClockSet::text).collect();
    time_notes.extend(stamps::backward(&ranges, &odometry.clock));
    time_notes.extend(stamps::uncovered(
        &readings,
        &samples,
        &config.frames,
        config.input.range_delay,
    ));
    let repeating = repeats::find(&readings, &samples, config.input.range_delay, sonars.len());
    let dropped = config.input.drop_repeats;
    notes.extend(repeats::note(&readings, &repeating, &sonars, dropped));
    if dropped {
        let mut repeating = repeating.into_iter();
        readings.retain_mut(|_| repeating.next() != Some(true));
    }
    let mut events = Events {
        sonars,
        readings,
        odometry: samples,
    };
    events.sort();
    Change::of_configuration(config, &events.sonars).apply(&mut events);
    let log = Log {
        file,
        events,
        messages: gathered.messages + odometry.messages,
        losses: in_lines(lost),
        time_notes,
        notes: in_lines(std::mem::take(notes)),
    };
    Ok(Finished {
        log,
        channels,
        clock_set,
        left_out,
        traits: Traits {
            unturned: unturned
                .iter()
                .flat_map(TransformTree::unturned)
                .map(str::to_owned)
                .collect(),
            poses: odometry.traits,
            mounts: placed.traits,
            world_frame: odometry.world_frame,
            robot_frame,
        },
        odometry_topic: odometry.topic,
    })
}

/// What a person should know of what is used.
fn note(
    gathered: &Gatherer,
    frames: &Frames,
    config: &Config,
    channels: &[ChannelReport],
    odometry: &Chosen,
    notes: &mut Vec<String>,
) {
    let is_used = |key: &String| {
        let is_its = |c: &ChannelReport| {
            let of_it = of_topic(&config.channel, &c.topic);
            of_it.is_some_and(|fields| config.channel.get(key) == Some(fields))
        };
        channels.iter().any(is_its)
    };
    let unused = config.channel.keys().filter(|topic| !is_used(topic));
    notes.extend(unused.map(|topic| {
        format!("the configuration describes channel `{topic}`, which the log does not have")
    }));
    let input = &config.input;
    let topics = || channels.iter().map(|channel| channel.topic.as_str());
    for (key, patterns) in [
        ("input.range_topics", &input.range_topics),
        ("input.odometry_topics", &input.odometry_topics),
        ("input.transform_topics", &input.transform_topics),
    ] {
        notes.extend(idle(key, patterns, "topic", topics()));
    }
    let transforms = &frames.transforms;
    let frame = input.robot_frame.as_deref();
    let frames = transforms.frames();
    let of_ranges = || gathered.sources.iter().map(|source| &*source.key.frame);
    let is_idle = |frame: &&str| {
        odometry.robot_frame != *frame
            && !frames.contains(frame)
            && !of_ranges().any(|of| of == *frame)
    };
    notes.extend(frame.filter(is_idle).map(|frame| {
        format!(
            "input.robot_frame = `{frame}` changes nothing: no odometry, transform or range names that frame"
        )
    }));
    let unstamped = gathered.unstamped + odometry.unstamped;
    if unstamped > 0 {
        notes.push(format!(
            "{} no stamp in the header; the time of recording is taken",
            counted_with(unstamped, "message", "has", "have")
        ));
    }
    if odometry.role == Role::Pose && config.input.odometry_topics.is_empty() {
        notes.push(format!(
            "the log has no odometry; the poses on {} are taken for it",
            odometry.topic
        ));
    }
    notes.extend(odometry.notes.iter().cloned());
}

/// That patterns of the configuration match nothing of the log.
fn idle<'a>(
    key: &str,
    patterns: &[String],
    what: &str,
    names: impl Iterator<Item = &'a str>,
) -> Option<String> {
    let names: Vec<&str> = names.collect();
    let is_idle = |pattern: &&String| {
        let pattern = std::slice::from_ref(*pattern);
        !names.iter().any(|name| is_chosen(pattern, name))
    };
    let idle: Vec<String> = patterns
        .iter()
        .filter(is_idle)
        .map(|pattern| format!("`{pattern}`"))
        .collect();
    (!idle.is_empty()).then(|| {
        format!(
            "{key}: {} {} no {what} of the log",
            few(&idle),
            if idle.len() == 1 { "matches" } else { "match" }
        )
    })
}

/// That poses were left out, which are no poses.
fn without_pose(odometry: &Chosen) -> Option<String> {
    let what = match odometry.role {
        Role::Transform => "transform",
        _ => "odometry message",
    };
    (odometry.unusable > 0).then(|| {
        format!(
            "{} on {} without a pose (NaN, farther off than 100,000 km, or a quaternion of zero) left out",
            counted(odometry.unusable, what),
            odometry.topic
        )
    })
}

/// The frames of the one robot that is replayed. Ranges of other robots are left out, unless they are asked for.
fn choose_frames(
    gathered: &mut Gatherer,
    config: &Config,
    channels: &[ChannelReport],
    notes: &mut Vec<String>,
) -> Frames {
    let input = &config.input;
    let tracks = gathered.tracks.keys().map(String::as_str).collect();
    let are_asked_for = !input.transform_topics.is_empty();
    let namespaces = std::mem::take(&mut gathered.namespaces);
    let chosen = namespaces.choose(channels, &tracks, are_asked_for);
    notes.extend(chosen.note);
    if input.range_topics.is_empty() && !chosen.others.is_empty() {
        let is_other = |topic: &str| chosen.others.iter().any(|name| is_in(topic, name));
        let sonars = gathered.leave_out_ranges(is_other);
        if sonars > 0 {
            let others: Vec<String> = chosen.others.into_iter().collect();
            notes.push(format!(
                "the ranges of {} in {} are another robot's than the odometry that is used, and left out; \
                 --range-topic chooses others",
                counted(sonars as u64, "sonar"),
                few(&others)
            ));
        }
    }
    chosen.frames
}

/// The one topic that says where the robot was. One that the configuration describes is meant
/// to be used; poses serve where there is no odometry, or where the configuration asks for them;
/// and transforms where there are no poses, or fewer of them.
fn choose_odometry(
    gathered: &mut Gatherer,
    of_robot: &Frames,
    file: &str,
    config: &Config,
    channels: &mut [ChannelReport],
) -> Result<Chosen, LogError> {
    let tracks = &mut gathered.tracks;
    let by_type = config.input.odometry_topics.is_empty();
    if by_type
        && tracks
            .keys()
            .any(|topic| of_topic(&config.channel, topic).is_some())
    {
        tracks.retain(|topic, _| of_topic(&config.channel, topic).is_some());
    }
    let is_odometry = |track: &Odometry| track.role == Role::Odometry;
    let has_odometry = tracks.values().any(is_odometry);
    if by_type && has_odometry {
        tracks.retain(|_, track| is_odometry(track));
    }
    let transforms = &of_robot.transforms;
    let of_ranges = gathered
        .sources
        .iter()
        .map(|source| source.key.frame.as_str());
    let of_clouds = gathered
        .hits
        .iter()
        .map(|(_, _, cloud)| cloud.frame_id.as_str());
    let frames: BTreeSet<&str> = of_ranges.chain(of_clouds).collect();
    let circumstances = Circumstances {
        file,
        config,
        transforms,
        carriers: (frames.into_iter())
            .filter_map(|frame| transforms.carrier(frame, ""))
            .collect(),
        poses: tracks.values().map(Odometry::len).max().unwrap_or(0),
        start_ns: gathered
            .readings
            .iter()
            .map(|reading| reading.stamp_ns)
            .min(),
    };
    let by_transforms = match has_odometry {
        true => None,
        false => of_robot.moving.odometry(&circumstances)?,
    };
    let chosen = match by_transforms {
        Some(chosen) => chosen,
        None => {
            let chosen = only_track(tracks, file, config, channels)?;
            chosen.ok_or_else(|| LogError::NoOdometry {
                file: file.to_owned(),
                asked: config.input.odometry_topics.clone(),
                found: found::candidates(channels, &[Role::Odometry, Role::Pose, Role::Transform]),
                passed_over: of_robot.moving.passed_over(&circumstances),
            })?
        }
    };
    for channel in channels {
        let says_where = matches!(channel.role, Some(Role::Odometry | Role::Pose));
        channel.used &= !says_where || channel.topic == chosen.topic;
    }
    Ok(chosen)
}

/// The one topic with poses, in the frame that is asked for.
fn only_track(
    tracks: &mut BTreeMap<String, Odometry>,
    file: &str,
    config: &Config,
    channels: &mut [ChannelReport],
) -> Result<Option<Chosen>, LogError> {
    if let Some(frame) = &config.input.world_frame {
        let found: Vec<(String, String)> = tracks.values().flat_map(Odometry::edges).collect();
        tracks
            .values_mut()
            .for_each(|track| track.keep_world(frame));
        if !found.is_empty() && tracks.values().all(|track| track.len() == 0) {
            return Err(LogError::NoSuchFrame {
                file: file.to_owned(),
                frame: frame.clone(),
                key: "input.world_frame",
                moving: found,
            });
        }
        if tracks.len() > 1 {
            tracks.retain(|_, track| track.len() > 0);
        }
    }
    if tracks.len() > 1 {
        return Err(LogError::ManyOdometries {
            file: file.to_owned(),
            topics: tracks.keys().cloned().collect(),
        });
    }
    for (topic, _) in tracks.iter().filter(|(_, track)| track.len() == 0) {
        found::refuse(channels, topic, found::NO_POSE.to_owned());
    }
    Ok(tracks
        .pop_first()
        .and_then(|(topic, track)| track.choose(topic)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::channels::Message;
    use crate::io::log::message::{Content, RangeMessage, TransformMessage};

    #[test]
    fn poses_are_not_used_where_transforms_say_where_the_robot_was() {
        let pose = |stamp_ns: i64, parent: &str, child: &str| TransformMessage {
            stamp_ns,
            parent: parent.to_owned().into(),
            child: child.to_owned().into(),
            parent_from_child: Some(nalgebra::Isometry3::translation(stamp_ns as f64, 0.0, 0.0)),
            ..TransformMessage::default()
        };
        let range = RangeMessage {
            beam_width: 0.4,
            ..RangeMessage::plain(2, "base_link", 1.0)
        };
        let mut said = vec![
            (Role::Range, "/range", Content::Ranges(vec![range])),
            (Role::Pose, "/pose", Content::Odometry(pose(1, "map", ""))),
        ];
        said.extend((1..9).map(|k| {
            let moved = Content::Transforms(vec![pose(k, "odom", "base_link")]);
            (Role::Transform, "/tf", moved)
        }));
        let mut gatherer = Gatherer::default();
        for (role, topic, content) in said {
            let message = Message {
                role,
                topic,
                content,
            };
            gatherer.take(message, 1);
        }
        let channel = ChannelReport {
            id: 1,
            topic: "/pose".to_owned(),
            type_name: String::new(),
            encoding: String::new(),
            role: Some(Role::Pose),
            used: true,
            messages: 1,
            undecoded: 0,
            problem: None,
            wanted: false,
        };
        let config = Config::default();
        let found = assemble(gatherer, "f".to_owned(), &config, vec![channel], &[]).unwrap();
        assert_eq!(found.odometry_topic, "/tf");
        assert!(!found.channels[0].used);
    }
}
