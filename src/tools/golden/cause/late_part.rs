//! The part of a log in which ranges are stamped later than they were, told by the stamps of the arcs.

use super::super::results::{LabelledArc, Labels};
use crate::core::statistics::seconds;

/// Arcs later by more are others, nanoseconds.
const LATEST_NS: i64 = 2_000_000_000;
/// This share of the arcs whose stamps are gone is found again at one delay, at least.
const FOUND: f64 = 0.25;
/// A delay is as good as the best one when it finds this share of what that does: of pings at one rate every multiple
/// of their period finds nearly all.
const AS_GOOD: f64 = 0.8;
/// Fewer arcs show no part.
const FEWEST: usize = 5;

/// A part of a log that is stamped later, or earlier, than it was.
#[derive(Debug, Clone, PartialEq)]
pub struct LatePart {
    /// Its first and its last arc, by the stamps that they had, after the log's first reading.
    pub seconds: [f64; 2],
    pub delay_ns: i64,
    /// The sonars whose arcs are there.
    pub sonars: Vec<String>,
}

impl LatePart {
    /// Of these sonars; `None` where their arcs are not as they were but for one delay in one part.
    pub fn of(sonars: &[&str], labels: [&Labels; 2], origin_ns: i64) -> Option<Self> {
        let mut moved = Vec::new();
        let (mut gone, mut stayed) = (0, 0);
        for sonar in sonars {
            let [then, now] = labels.map(|labels| stamps(labels, sonar));
            let only = |these: &[i64], those: &[i64]| {
                let these = these.iter().copied();
                these
                    .filter(|at| those.binary_search(at).is_err())
                    .collect::<Vec<_>>()
            };
            let (lost, new) = (only(&then, &now), only(&now, &then));
            gone += lost.len();
            stayed += then.len() - lost.len();
            for was in lost {
                let from = new.partition_point(|at| *at < was.saturating_sub(LATEST_NS));
                let near = new.iter().skip(from);
                let near = near.take_while(|at| **at <= was.saturating_add(LATEST_NS));
                moved.extend(near.map(|is| (is - was, was, *sonar)));
            }
        }
        moved.sort_unstable();
        let mut found: Vec<(usize, i64)> = Vec::new();
        for (delay, ..) in &moved {
            match found.last_mut() {
                Some((count, last)) if last == delay => *count += 1,
                _ => found.push((1, *delay)),
            }
        }
        let most = found.iter().map(|(count, _)| *count).max()?;
        if most < FEWEST || (most as f64) < FOUND * gone as f64 || stayed < FEWEST {
            return None;
        }
        let good = found
            .iter()
            .filter(|(count, _)| *count as f64 >= AS_GOOD * most as f64);
        let (_, delay_ns) = good.copied().min_by_key(|(_, delay)| delay.abs())?;
        let part = || moved.iter().filter(|(delay, ..)| *delay == delay_ns);
        let mut sonars: Vec<String> = part().map(|(.., sonar)| (*sonar).to_owned()).collect();
        sonars.sort_unstable();
        sonars.dedup();
        let (first, last) = (part().next()?.1, part().next_back()?.1);
        Some(Self {
            seconds: [first, last].map(|at| seconds(origin_ns, at)),
            delay_ns,
            sonars,
        })
    }
}

/// When the arcs of a sonar were, in order.
fn stamps(labels: &Labels, sonar: &str) -> Vec<i64> {
    let arcs = labels.sonars.get(sonar).into_iter().flatten();
    arcs.map(|arc: &LabelledArc| arc.stamp_ns).collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::results::Mark;
    use super::*;

    fn labels(stamps: impl Iterator<Item = i64>) -> Labels {
        let arc = |ms| LabelledArc {
            stamp_ns: ms * 1_000_000,
            mark: Mark::Contact,
            frame: None,
            margin: None,
            reason: None,
        };
        Labels {
            sonars: [("front".to_owned(), stamps.map(arc).collect())].into(),
            frame_stamps: Vec::new(),
        }
    }

    #[test]
    fn a_late_part_is_measured() {
        let pings = || (0..100).map(|ping| ping * 640);
        let then = labels(pings());
        let late = |at: i64| {
            if (20_000..40_000).contains(&at) {
                at + 290
            } else {
                at
            }
        };
        let part = LatePart::of(&["front"], [&then, &labels(pings().map(late))], 0).unwrap();
        assert_eq!(part.delay_ns, 290_000_000);
        assert_eq!(part.seconds, [20.48, 39.68]);
        assert_eq!(part.sonars, ["front"]);
        // Half of the arcs are others, as frames open elsewhere.
        let some = pings().filter(|at| at / 640 % 3 > 0).map(late);
        let part = LatePart::of(&["front"], [&then, &labels(some)], 0).unwrap();
        assert_eq!(part.delay_ns, 290_000_000);
    }

    #[test]
    fn what_is_late_otherwise_is_no_part() {
        let pings = || (0..100).map(|ping| ping * 640);
        let then = labels(pings());
        let all = labels(pings().map(|at| at + 290));
        assert_eq!(LatePart::of(&["front"], [&then, &all], 0), None);
        let faster = labels(pings().map(|at| at + at / 100));
        assert_eq!(LatePart::of(&["front"], [&then, &faster], 0), None);
        assert_eq!(LatePart::of(&[], [&then, &then], 0), None);
    }
}
