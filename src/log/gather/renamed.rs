//! Transforms of one frame under several names: damaged ones, a track that was renamed, and rivals.

use super::moving::{Course, Edge, Moving};
use super::track::Odometry;
use crate::event::OdometrySample;
use crate::geometry::angle_between;
use crate::log::strays::is_handful;
use crate::wording::{counted, seconds_between};

/// A track that goes on under another name does so within this time, nanoseconds, ...
const SOON: i64 = 1_000_000_000;
/// ... this way, metres, ...
const NEAR: f64 = 0.3;
/// ... and this turn, radians.
const TURN: f64 = 0.5;

/// Whether a transform is another one whose frames a few damaged messages name otherwise.
pub fn is_stray(one: (&Edge, &Course), usual: (&Edge, &Course)) -> bool {
    let ((a, one), (b, usual)) = (one, usual);
    one.topic == usual.topic
        && is_handful(one.track.len(), usual.track.len())
        && ((a.1 == b.1 && a.0 != b.0)
            || (a.1 != b.1 && resembles(&a.0, &b.0) && resembles(&a.1, &b.1)))
}

/// Longer names are alike only where they are equal: comparing takes the product of their lengths.
const LONGEST: usize = 64;

/// Whether two names differ in some letters at the most.
fn resembles(a: &str, b: &str) -> bool {
    let longest = a.len().max(b.len());
    a == b || (longest <= LONGEST && strsim::levenshtein(a, b) * 3 <= longest)
}

/// A track, with what was done about the same frame under other names.
#[derive(Debug)]
pub struct Joined {
    pub track: Odometry,
    pub losses: Vec<String>,
    pub notes: Vec<String>,
}

/// A track, with that of the same frame under other names where these are damaged or where it goes on
/// under them; what of the others is not used is told. Times are told from `start_ns` on.
pub fn joined(
    edge: &Edge,
    course: &Course,
    moving: &Moving,
    rivals: &[(&Edge, &Course)],
    start_ns: Option<i64>,
) -> Joined {
    let mut track = course.track.clone();
    let mut rivals: Vec<(&Edge, &Course)> = rivals
        .iter()
        .copied()
        .filter(|(other, course)| *other != edge && other.1 == edge.1 && course.moved)
        .collect();
    // One after the other, as each may go on where another one ended.
    while let Some(next) = rivals
        .iter()
        .position(|(_, other)| is_continued(&track, &other.track))
    {
        track.absorb(rivals.remove(next).1.track.clone());
    }
    let strays = moving
        .courses()
        .filter(|other| is_stray(*other, (edge, course)));
    for (_, stray) in strays {
        track.absorb(stray.track.clone());
    }
    let mut joined = Joined {
        track,
        losses: Vec::new(),
        notes: Vec::new(),
    };
    let own = course.track.ends();
    let start_ns = start_ns.or(own.map(|(first, _)| first.stamp_ns));
    for (other, rival) in rivals {
        let (Some(start_ns), Some(own), Some(theirs)) = (start_ns, own, rival.track.ends()) else {
            continue;
        };
        let told = |(parent, _): &Edge, course: &Course, ends: Ends| {
            format!(
                "in `{parent}` by {} from {} s to {} s",
                counted(course.track.len() as u64, "transform"),
                seconds_between(start_ns, ends.0.stamp_ns, 1),
                seconds_between(start_ns, ends.1.stamp_ns, 1)
            )
        };
        let (taken, left) = (told(edge, course, own), told(other, rival, theirs));
        let child = &edge.1;
        let advice = format!(
            "`input.world_frame = {}` takes the latter instead",
            toml::Value::from(other.0.as_str())
        );
        if theirs.0.stamp_ns > own.1.stamp_ns || theirs.1.stamp_ns < own.0.stamp_ns {
            joined.losses.push(format!(
                "`{child}` moves {taken}, which are used, and {left}, which do not go on where the others are \
                 and are left out; {advice}"
            ));
        } else {
            joined.notes.push(format!(
                "`{child}` moves in two frames at the same time: {taken}, which are used, and {left}, which are \
                 not; {advice}"
            ));
        }
    }
    joined
}

/// First and last by stamp.
type Ends = (OdometrySample, OdometrySample);

/// Whether one track goes on where the other one ends, in either order.
fn is_continued(one: &Odometry, other: &Odometry) -> bool {
    let (Some(one), Some(other)) = (one.ends(), other.ends()) else {
        return false;
    };
    let follows = |a: &OdometrySample, b: &OdometrySample| {
        let soon = (0..=SOON).contains(&b.stamp_ns.saturating_sub(a.stamp_ns));
        let (from, to) = (&a.world_from_robot, &b.world_from_robot);
        soon && (to.position() - from.position()).norm() <= NEAR
            && angle_between(to.yaw, from.yaw) <= TURN
    };
    follows(&one.1, &other.0) || follows(&other.1, &one.0)
}
