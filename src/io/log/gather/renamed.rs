//! Transforms of one frame under several names: damaged ones, a track that was renamed, and rivals.

use super::moving::{Course, Edge};
use super::track::{Chosen, Odometry};
use crate::core::event::OdometrySample;
use crate::core::geometry::angle_between;
use crate::core::wording::{counted, seconds_between};
use crate::io::log::strays::is_handful;

/// A track that goes on under another name does so within this time, nanoseconds, ...
const SOON: i64 = 1_000_000_000;
/// ... this way, metres, ...
const NEAR: f64 = 0.3;
/// ... and this turn, radians.
const TURN: f64 = 0.5;

/// Whether a transform is another one whose frames a few damaged messages name otherwise. `is_circle`
/// tells whether it hangs the frame that the usual one moves in on the frame that it moves.
pub fn is_stray(
    one: (&Edge, &Course),
    usual: (&Edge, &Course),
    is_circle: impl Fn() -> bool,
) -> bool {
    let ((a, one), (b, usual)) = (one, usual);
    one.topic == usual.topic
        && is_handful(one.track.len(), usual.track.len())
        && ((a.1 == b.1 && a.0 != b.0)
            || (a.1 == b.0 && is_circle())
            || (a.1 != b.1 && resembles(&a.0, &b.0) && resembles(&a.1, &b.1)))
}

/// Longer names are alike only where they are equal: comparing takes the product of their lengths.
const LONGEST: usize = 64;

/// Whether two names differ in some letters at the most.
fn resembles(a: &str, b: &str) -> bool {
    let longest = a.len().max(b.len());
    a == b || (longest <= LONGEST && strsim::levenshtein(a, b) * 3 <= longest)
}

/// A track of the robot, with the frames that it names.
#[derive(Debug)]
pub struct Claim {
    world: String,
    robot: String,
    track: Odometry,
}

impl Claim {
    /// That of a transform that moves the robot.
    pub fn forwards((world, robot): &Edge, course: &Course) -> Self {
        Self {
            world: world.clone(),
            robot: robot.clone(),
            track: course.track.clone(),
        }
    }

    /// That of a transform from the robot to what it moves in.
    pub fn turned((robot, world): &Edge, course: &Course) -> Self {
        Self {
            world: world.clone(),
            robot: robot.clone(),
            track: course.track.clone().turned_round(),
        }
    }

    /// Where it is, by how many transforms, and from when to when.
    fn told(&self, start_ns: i64) -> String {
        let at = |end: Option<i64>| seconds_between(start_ns, end.unwrap_or(start_ns), 1);
        let samples = self.track.in_order();
        format!(
            "`{}` in `{}` by {} from {} s to {} s",
            self.robot,
            self.world,
            counted(self.track.len() as u64, "transform"),
            at(samples.first().map(|sample| sample.stamp_ns)),
            at(samples.last().map(|sample| sample.stamp_ns))
        )
    }
}

/// A track, with what was done about the robot's tracks under other names.
#[derive(Debug)]
pub struct Joined {
    track: Odometry,
    robot: String,
    losses: Vec<String>,
    notes: Vec<String>,
    /// Whether another track says something else of the same time.
    pub contradicted: bool,
}

impl Joined {
    /// The odometry that it gives.
    pub fn choose(self, topic: String) -> Option<Chosen> {
        let mut chosen = self.track.choose(topic)?;
        // The sonars sit on this one, however many transforms name another.
        chosen.robot_frame = self.robot;
        chosen.notes.extend(self.notes);
        chosen.losses.extend(self.losses);
        Some(chosen)
    }
}

/// A track, with its strays and with those under other names where it goes on under them; what of the
/// others is not used is told. Times are told from `start_ns` on.
pub fn joined(
    claim: Claim,
    strays: impl Iterator<Item = Claim>,
    rivals: impl Iterator<Item = Claim>,
    start_ns: Option<i64>,
) -> Joined {
    let start_ns = start_ns.or_else(|| claim.track.in_order().first().map(|s| s.stamp_ns));
    let taken = claim.told(start_ns.unwrap_or_default());
    let (mut track, robot) = (claim.track, claim.robot);
    let mut rivals: Vec<Claim> = rivals.collect();
    // One after the other, as each may go on where another one ended.
    let mut known = track.in_order();
    while let Some(next) = (rivals.iter()).position(|rival| Meeting::of(&known, rival).goes_on) {
        let mut rival = rivals.remove(next);
        rival.track.retain(|sample| !is_doubled(&known, sample));
        track.absorb(rival.track);
        known = track.in_order();
    }
    let mut joined = Joined {
        track,
        robot,
        losses: Vec::new(),
        notes: Vec::new(),
        contradicted: false,
    };
    for stray in strays {
        joined.track.absorb(stray.track);
    }
    for rival in rivals {
        let meeting = Meeting::of(&known, &rival);
        let is_doubled = meeting.doubled_ns > SOON;
        let left = rival.told(start_ns.unwrap_or_default());
        if rival.robot != joined.robot {
            // Another robot, or a part of this one, moves at the same time.
            if !is_doubled && meeting.alone > 0 {
                joined.losses.push(format!(
                    "the robot moves as {taken}, which are used; {left}, which do not go on where the others \
                     are, may be the same one by another name and are left out"
                ));
            }
            continue;
        }
        joined.contradicted |= is_doubled || meeting.alone == 0;
        let advice = format!(
            "`input.world_frame = {}` takes the latter instead",
            toml::Value::from(rival.world.as_str())
        );
        if meeting.alone > 0 && !is_doubled {
            joined.losses.push(format!(
                "the robot moves as {taken}, which are used, and as {left}, which do not go on where the others \
                 are and are left out; {advice}"
            ));
        } else if meeting.alone > 0 {
            joined.losses.push(format!(
                "the robot moves in two frames at the same time: as {taken}, which are used, and as {left}, which \
                 are left out, {} of them at times that the former lack; {advice}",
                meeting.alone
            ));
        } else {
            joined.notes.push(format!(
                "the robot moves in two frames at the same time: as {taken}, which are used, and as {left}, which \
                 are not; {advice}"
            ));
        }
    }
    joined
}

/// How one track meets another one.
struct Meeting {
    /// For how long both say where the robot was, nanoseconds.
    doubled_ns: i64,
    /// Samples of the other one at times of which the first one says nothing.
    alone: usize,
    /// Whether the other one goes on where the first one ends or pauses, or before it.
    goes_on: bool,
}

impl Meeting {
    /// Of samples in stamp order and a track.
    fn of(known: &[OdometrySample], rival: &Claim) -> Self {
        let samples = rival.track.in_order();
        let (mut doubled_ns, mut alone, mut added) = (0_i64, 0, 0_usize);
        let (mut meets, mut agrees) = (false, true);
        let mut before: Option<&OdometrySample> = None;
        for (index, sample) in samples.iter().enumerate() {
            let (left, right) = neighbours(known, sample.stamp_ns);
            let is_soon = |other: &&OdometrySample| apart(other, sample) <= SOON;
            if left.filter(is_soon).is_none() && right.filter(is_soon).is_none() {
                alone += 1;
            }
            if is_doubled(known, sample) {
                let nearest = [left, right].into_iter().flatten();
                let nearest = nearest.min_by_key(|other| apart(other, sample));
                agrees &= nearest.is_none_or(|other| is_near(other, sample));
                if let Some(before) = before {
                    doubled_ns = doubled_ns.saturating_add(apart(before, sample));
                }
                before = Some(sample);
                continue;
            }
            (before, added) = (None, added + 1);
            // Its neighbours in time, where they are of the known track.
            let previous = index.checked_sub(1).and_then(|index| samples.get(index));
            let following = samples.get(index + 1);
            let left = left.filter(|l| previous.is_none_or(|p| p.stamp_ns <= l.stamp_ns));
            let right = right.filter(|r| following.is_none_or(|f| f.stamp_ns >= r.stamp_ns));
            for other in [left, right].into_iter().flatten().filter(is_soon) {
                meets = true;
                agrees &= is_near(other, sample);
            }
        }
        Self {
            doubled_ns,
            alone,
            goes_on: added > 0 && meets && agrees && doubled_ns <= SOON,
        }
    }
}

/// The samples before or at a time, and behind it.
fn neighbours(
    samples: &[OdometrySample],
    stamp_ns: i64,
) -> (Option<&OdometrySample>, Option<&OdometrySample>) {
    let place = samples.partition_point(|sample| sample.stamp_ns <= stamp_ns);
    let left = place.checked_sub(1).and_then(|left| samples.get(left));
    (left, samples.get(place))
}

/// Whether samples in stamp order already say where the robot was at the time of another one.
fn is_doubled(known: &[OdometrySample], sample: &OdometrySample) -> bool {
    match neighbours(known, sample.stamp_ns) {
        (Some(left), _) if left.stamp_ns == sample.stamp_ns => true,
        (Some(left), Some(right)) => apart(left, right) <= SOON,
        _ => false,
    }
}

fn apart(a: &OdometrySample, b: &OdometrySample) -> i64 {
    b.stamp_ns.saturating_sub(a.stamp_ns).saturating_abs()
}

fn is_near(a: &OdometrySample, b: &OdometrySample) -> bool {
    let (from, to) = (&a.world_from_robot, &b.world_from_robot);
    (to.position() - from.position()).norm() <= NEAR && angle_between(to.yaw, from.yaw) <= TURN
}
