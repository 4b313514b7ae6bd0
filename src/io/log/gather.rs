//! Collects what the messages of a log say, channel by channel.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use nalgebra::Isometry3;

use super::channels::Message;
use super::description;
use super::message::{Content, HitsMessage, MOST_SONARS, RangeMessage, Role, TransformMessage};
use super::namespaces::Namespaces;
use super::odometry::{Odometry, stamp};
use super::sonars::{Source, SourceKey};
use super::transforms::Origin;
use crate::core::config::{Config, StampsFrom};
use crate::core::event::{RangeReading, Readings, SonarId};
use crate::core::wording::counted;

/// Topic and frame of a message that stands in for all that is missing.
pub const STAND_IN: &str = "(none)";

/// A ring whose messages have more forms turns, or has as many beams as it likes.
const MOST_FORMS: usize = 4;

/// No more messages than this are odd, and only among more than ten times as many.
const FEW: u64 = 3;

/// The messages of one topic and frame.
#[derive(Debug, Clone, Default)]
struct Heard {
    /// The forms that they have.
    forms: Vec<Form>,
    /// The place of each sonar in the list of all, by its element and form.
    places: BTreeMap<(Option<usize>, usize), usize>,
}

/// How many ranges a message has, and where its first and its last beam look.
type Form = (usize, Isometry3<f64>, Isometry3<f64>);

/// More descriptions than this are passed over: a robot has one.
const MOST_DESCRIPTIONS: usize = 16;

/// Everything said so far.
#[derive(Debug, Clone, Default)]
pub struct Gatherer {
    /// Every sonar, in the order of their first readings.
    pub sources: Vec<Source>,
    heard: Vec<Heard>,
    /// Their places by topic and frame.
    heard_index: BTreeMap<String, BTreeMap<String, usize>>,
    /// Messages without a range, by topic.
    empty: BTreeMap<String, u64>,
    /// Each with the place of its sonar in `sources` for an id.
    pub readings: Readings,
    /// Whether there are more sonars than can be told apart.
    pub crowded: bool,
    pub tracks: BTreeMap<String, Odometry>,
    /// Transforms, by the namespaces of their topics.
    pub namespaces: Namespaces,
    /// Points of sonar rings, with the topic and the time they were recorded.
    pub hits: Vec<(String, i64, HitsMessage)>,
    /// What is taken for the stamps of readings.
    range_stamps: StampsFrom,
    odometry_stamps: StampsFrom,
    from_speeds: bool,
    descriptions: usize,
    last_description: String,
    pub notes: Vec<String>,
    /// Those that are used whatever odometry is chosen.
    pub messages: u64,
    pub unstamped: u64,
}

impl Gatherer {
    /// Nothing said yet; of the configuration, what is taken for stamps matters.
    pub fn new(config: &Config) -> Self {
        Self {
            range_stamps: config.input.range_stamps,
            odometry_stamps: config.input.odometry_stamps,
            from_speeds: config.input.odometry_from_speeds,
            ..Self::default()
        }
    }

    /// Takes what one message says.
    pub fn take(&mut self, message: Message<'_>, log_time: u64) {
        let (role, topic) = (message.role, message.topic);
        let logged_ns = i64::try_from(log_time).unwrap_or(i64::MAX);
        match message.content {
            Content::Ranges(ranges) => {
                self.messages += 1;
                self.unstamped += u64::from(ranges.first().is_some_and(|r| r.stamp_ns == 0));
                if ranges.is_empty() {
                    *self.empty.entry(topic.to_owned()).or_default() += 1;
                }
                let Some(first) = ranges.first().map(|range| range.frame_id.clone()) else {
                    return;
                };
                let heard = self.heard_at(topic, &first);
                let form = self.form(heard, &ranges);
                for range in ranges {
                    let heard = match range.frame_id == first {
                        true => heard,
                        false => self.heard_at(topic, &range.frame_id),
                    };
                    self.take_range_of(heard, topic, logged_ns, range, form);
                }
            }
            Content::Odometry(odometry) => {
                self.take_odometry(role, topic, logged_ns, odometry);
            }
            Content::Transforms(transforms) => {
                self.messages += 1;
                let origin = if topic.ends_with("tf_static") {
                    Origin::Fixed
                } else {
                    Origin::Moving
                };
                let no_odometry = |track: &Odometry| track.role != Role::Odometry;
                let may_move = origin == Origin::Moving && self.tracks.values().all(no_odometry);
                let frames = self.namespaces.of(topic);
                for transform in transforms {
                    if may_move {
                        frames.moving.take(topic, logged_ns, &transform);
                    }
                    frames.transforms.add(transform, origin);
                }
            }
            Content::Hits(hits) => self.hits.push((topic.to_owned(), logged_ns, hits)),
            Content::Crowd(_) => {}
            // A latched topic repeats what it said.
            Content::Description(urdf) if urdf == self.last_description => self.messages += 1,
            Content::Description(_) if self.descriptions >= MOST_DESCRIPTIONS => {}
            Content::Description(urdf) => self.take_description(topic, urdf),
        }
    }

    fn take_description(&mut self, topic: &str, urdf: String) {
        self.descriptions += 1;
        match description::fixed_joints(&urdf) {
            Ok(joints) => {
                self.messages += 1;
                let frames = self.namespaces.of(topic);
                for joint in joints {
                    frames.transforms.add(joint, Origin::Description);
                }
            }
            Err(error) => self.notes.push(format!(
                "the robot's description on {topic} is left out: {error}"
            )),
        }
        self.last_description = urdf;
    }

    /// The number of a message's form among those of its topic and frame; 0 where its beams have frames of
    /// their own.
    fn form(&mut self, heard: usize, ranges: &[RangeMessage<'_>]) -> usize {
        let (Some(first), Some(last)) = (ranges.first(), ranges.last()) else {
            return 0;
        };
        if ranges.iter().any(|range| range.frame_id != first.frame_id) {
            return 0;
        }
        let form = (ranges.len(), first.frame_from_beam, last.frame_from_beam);
        let Some(Heard { forms: known, .. }) = self.heard.get_mut(heard) else {
            return 0;
        };
        let place = known.iter().position(|other| *other == form);
        let place = place.unwrap_or_else(|| {
            if known.len() <= MOST_FORMS {
                known.push(form);
            }
            known.len() - 1
        });
        if place < MOST_FORMS { place } else { 0 }
    }

    /// Where in the list the messages of a topic and frame are.
    fn heard_at(&mut self, topic: &str, frame: &str) -> usize {
        let known = self.heard_index.get(topic);
        if let Some(place) = known.and_then(|frames| frames.get(frame)) {
            return *place;
        }
        let place = self.heard.len();
        let frames = self.heard_index.entry(topic.to_owned()).or_default();
        frames.insert(frame.to_owned(), place);
        self.heard.push(Heard::default());
        place
    }

    /// Takes a reading of a message of some form, or of none.
    pub fn take_range(
        &mut self,
        topic: &str,
        logged_ns: i64,
        range: RangeMessage<'_>,
        form: usize,
    ) {
        let heard = self.heard_at(topic, &range.frame_id);
        self.take_range_of(heard, topic, logged_ns, range, form);
    }

    fn take_range_of(
        &mut self,
        heard: usize,
        topic: &str,
        logged_ns: i64,
        range: RangeMessage<'_>,
        form: usize,
    ) {
        let next = self.sources.len();
        let Some(heard) = self.heard.get_mut(heard) else {
            return;
        };
        let index = match heard.places.entry((range.element, form)) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(_) if next == MOST_SONARS => {
                self.crowded = true;
                return;
            }
            Entry::Vacant(new) => {
                new.insert(next);
                let key = SourceKey {
                    topic: topic.to_owned(),
                    frame: range.frame_id.into_owned(),
                    element: range.element,
                    form,
                };
                self.sources.push(Source::new(&key, range.frame_from_beam));
                next
            }
        };
        let (Some(source), Ok(id)) = (self.sources.get_mut(index), u16::try_from(index)) else {
            return;
        };
        source.turned |= source.frame_from_beam != range.frame_from_beam;
        source.readings += 1;
        source.infrared |= range.infrared;
        source.in_degrees |= range.in_degrees;
        source.learn(range.beam_width, range.likely_beam_width);
        // The beams of a ring share their message's stamp.
        if range.element.is_none_or(|element| element == 0) {
            source.clock.take(range.stamp_ns, logged_ns);
        }
        self.readings.push(RangeReading {
            stamp_ns: match self.range_stamps {
                StampsFrom::Message => stamp(range.stamp_ns, logged_ns),
                StampsFrom::Recording => logged_ns,
            }
            .saturating_add(range.delay_ns),
            sonar: SonarId(id),
            range: range.range,
            min_range: range.min_range,
            max_range: range.max_range,
            beam_width: range.beam_width,
            variance: range.variance,
        });
    }

    fn take_odometry(
        &mut self,
        role: Role,
        topic: &str,
        logged_ns: i64,
        mut pose: TransformMessage<'_>,
    ) {
        if self.odometry_stamps == StampsFrom::Recording {
            pose.stamp_ns = logged_ns;
        }
        if role == Role::Odometry {
            self.namespaces.forget_motion();
        }
        if let Some(track) = self.tracks.get_mut(topic) {
            return track.take(logged_ns, &pose);
        }
        let mut track = Odometry::new(role, self.from_speeds);
        track.take(logged_ns, &pose);
        self.tracks.insert(topic.to_owned(), track);
    }

    /// Leaves out the few messages that are unlike all others of their topic, which says of each what is lost.
    /// What is left of a sonar is one source, whatever forms its messages have.
    pub fn leave_out_odd(&mut self) -> Vec<String> {
        let mut messages = BTreeMap::<(&str, &str, usize), u64>::new();
        for Source { key, readings, .. } in &self.sources {
            let most = messages.entry((&key.topic, &key.frame, key.form));
            let most = most.or_default();
            *most = (*most).max(*readings);
        }
        let mut topics = BTreeMap::<&str, (u64, u64)>::new();
        for ((topic, ..), count) in &messages {
            let (all, most) = topics.entry(topic).or_default();
            (*all, *most) = (*all + count, (*most).max(*count));
        }
        messages.retain(|(topic, frame, _), count| {
            let (all, most) = topics.get(topic).copied().unwrap_or_default();
            let frames = self.heard_index.get(*topic);
            let place = frames.and_then(|frames| frames.get(*frame));
            let heard = place.and_then(|place| self.heard.get(*place));
            let turns = heard.is_some_and(|heard| heard.forms.len() > MOST_FORMS);
            !turns && *count <= FEW && most > 10 * *count && 10 * (all - most) < all
        });
        let is_odd = |key: &SourceKey| messages.contains_key(&(&*key.topic, &*key.frame, key.form));
        let odd: Vec<bool> = self.sources.iter().map(|s| is_odd(&s.key)).collect();
        let mut losses = Vec::new();
        for ((topic, frame, form), count) in &messages {
            let of =
                |s: &&Source| (&*s.key.topic, &*s.key.frame, s.key.form) == (*topic, *frame, *form);
            losses.push(format!(
                "{} on {topic} left out: its frame (`{frame}`), its number of ranges ({}) or its bearings are not \
                 those of all others",
                counted(*count, "message"),
                self.sources.iter().filter(of).count()
            ));
        }
        let mut lost: u64 = messages.values().sum();
        for (topic, count) in std::mem::take(&mut self.empty) {
            if topics.contains_key(&*topic) {
                let what = counted(count, "message");
                losses.push(format!("{what} on {topic} without a range left out"));
                lost += count;
            }
        }
        self.messages -= lost;
        self.forget_places();
        let all = std::mem::take(&mut self.sources).into_iter().zip(odd);
        let ids: Vec<Option<u16>> =
            (all.map(|(source, is_odd)| self.keep(source, is_odd))).collect();
        self.renumber(&ids);
        losses
    }

    /// The sonars are to be numbered anew.
    fn forget_places(&mut self) {
        self.heard.iter_mut().for_each(|heard| heard.places.clear());
    }

    /// The place of a source that is not odd, which may be one with what is known already.
    fn keep(&mut self, mut source: Source, is_odd: bool) -> Option<u16> {
        if is_odd {
            return None;
        }
        source.key.form = 0;
        let next = self.sources.len();
        let SourceKey {
            topic,
            frame,
            element,
            ..
        } = &source.key;
        let heard = self.heard_at(topic, frame);
        let heard = self.heard.get_mut(heard)?;
        let place = *heard.places.entry((*element, 0)).or_insert(next);
        match self.sources.get_mut(place) {
            Some(known) => known.join(&source),
            None => self.sources.push(source),
        }
        u16::try_from(place).ok()
    }

    /// Puts one invented message in the place of all that the log says in a role, to see past what stands
    /// in a replay's way.
    pub fn stand_in(&mut self, role: Role) {
        match role {
            Role::Range => {
                self.sources.clear();
                self.forget_places();
                self.readings.clear();
                self.hits.clear();
                let reading = RangeMessage {
                    max_range: 1.0,
                    beam_width: 1.0,
                    ..RangeMessage::plain(0, STAND_IN, f64::NAN)
                };
                self.take_range(STAND_IN, 0, reading, 0);
            }
            Role::Odometry => {
                self.tracks.clear();
                let sample = TransformMessage {
                    parent_from_child: Some(Isometry3::identity()),
                    ..TransformMessage::default()
                };
                self.take_odometry(role, STAND_IN, 0, sample);
            }
            Role::Pose | Role::Transform | Role::Description => {}
        }
    }

    /// Leaves out the ranges on some topics; how many sonars these are.
    pub fn leave_out_ranges(&mut self, is_left_out: impl Fn(&str) -> bool) -> usize {
        self.forget_places();
        let all = std::mem::take(&mut self.sources).into_iter();
        let mut count = 0;
        let mut keep = |source: Source| {
            let is_left_out = is_left_out(&source.key.topic);
            count += usize::from(is_left_out);
            self.keep(source, is_left_out)
        };
        let ids: Vec<Option<u16>> = all.map(&mut keep).collect();
        self.renumber(&ids);
        self.hits.retain(|(topic, ..)| !is_left_out(topic));
        count
    }

    /// Gives readings the new places of their sonars, and leaves out those of sonars that have none.
    fn renumber(&mut self, ids: &[Option<u16>]) {
        self.readings.retain_mut(|reading| {
            let id = ids.get(reading.sonar.index()).copied().flatten();
            reading.sonar = id.map_or(reading.sonar, SonarId);
            id.is_some()
        });
    }

    /// Forgets every odometry but one.
    pub fn keep_odometry(&mut self, topic: &str) {
        self.tracks.retain(|known, _| known == topic);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scan of so many beams from a bearing on, radians.
    fn scan(beams: usize, from: f64) -> Content<'static> {
        let beam = |element| RangeMessage {
            element: Some(element),
            frame_from_beam: Isometry3::rotation(nalgebra::Vector3::z() * (from + element as f64)),
            ..RangeMessage::plain(1, "ring", 1.0)
        };
        Content::Ranges((0..beams).map(beam).collect())
    }

    fn gathered(scans: impl IntoIterator<Item = Content<'static>>) -> (Gatherer, Vec<String>) {
        let mut gatherer = Gatherer::default();
        for content in scans {
            let (role, topic) = (Role::Range, "/scan");
            gatherer.take(
                Message {
                    role,
                    topic,
                    content,
                },
                1,
            );
        }
        let losses = gatherer.leave_out_odd();
        (gatherer, losses)
    }

    #[test]
    fn an_odd_scan_is_a_loss_of_itself() {
        let usual = std::iter::repeat_with(|| scan(16, 0.0)).take(40);
        let odd = [scan(16, 0.5), scan(64, 0.0), scan(0, 0.0)];
        let (gatherer, losses) = gathered(odd.into_iter().chain(usual));
        assert_eq!((gatherer.sources.len(), gatherer.readings.len()), (16, 640));
        assert_eq!((gatherer.messages, losses.len()), (40, 3), "{losses:?}");
        let first = &gatherer.sources[0];
        assert!(first.frame_from_beam == Isometry3::identity() && !first.turned);
        assert!(
            losses[1].contains("its number of ranges (64)"),
            "{losses:?}"
        );
        assert!(losses[2].contains("without a range"), "{losses:?}");
    }

    #[test]
    fn a_ring_that_turns_is_one_ring() {
        for turns in [2, 40] {
            let (gatherer, losses) = gathered((0..40).map(|k| scan(16, f64::from(k % turns))));
            assert_eq!((gatherer.sources.len(), gatherer.readings.len()), (16, 640));
            assert!(
                losses.is_empty() && gatherer.sources[0].turned,
                "{losses:?}"
            );
            assert_eq!(gatherer.sources[0].readings, 40);
        }
    }
}
