//! The part of a log in which ranges are stamped later than they were.
//!
//! A golden file has the stamps of arcs, and of all readings a digest. By how much arcs are later at most is seen in
//! the former; of pings at one rate every multiple of their period looks alike, and which it is the digest tells: it
//! is that of the stamps with the delay taken out.

use super::super::profile::Stamps;
use super::super::results::Labels;
use crate::core::statistics::seconds;

/// Arcs later by more are others, nanoseconds.
const LATEST_NS: i64 = 2_000_000_000;
/// Delays that are tried, those first at which most arcs are found again.
const TRIED: usize = 12;
/// A part begins and ends at one of so many of the steps that are most unlike the others.
const BREAKS: usize = 6;

/// A part of a log that is stamped later, or earlier, than it was.
#[derive(Debug, Clone, PartialEq)]
pub struct LatePart {
    /// Its first and its last reading, by the stamps that they had, after the log's first one.
    pub seconds: [f64; 2],
    pub delay_ns: i64,
    pub sonars: Vec<String>,
}

impl LatePart {
    /// Of sonars, by name with the stamps as they were and are; `None` where these are not as they were but for one
    /// delay in one part, or not all at hand.
    pub fn of(
        sonars: &[(&str, &Stamps, &Stamps)],
        labels: [&Labels; 2],
        origin_ns: i64,
    ) -> Option<Self> {
        delays(sonars, labels).into_iter().find_map(|delay_ns| {
            let parts = sonars.iter().filter_map(|(sonar, then, now)| {
                let part = part(then, &now.all.0, delay_ns)?;
                Some((*sonar, part))
            });
            let parts: Vec<(&str, [i64; 2])> = parts.collect();
            let first = parts.iter().map(|(_, [first, _])| *first).min()?;
            let last = parts.iter().map(|(_, [_, last])| *last).max()?;
            Some(Self {
                seconds: [first, last].map(|at| seconds(origin_ns, at)),
                delay_ns,
                sonars: parts.iter().map(|(sonar, _)| (*sonar).to_owned()).collect(),
            })
        })
    }
}

/// By how much arcs may be later that are not where they were, the likeliest delay first.
fn delays(sonars: &[(&str, &Stamps, &Stamps)], labels: [&Labels; 2]) -> Vec<i64> {
    let mut moved = Vec::new();
    for (sonar, ..) in sonars {
        let stamps = |labels: &Labels| -> Vec<i64> {
            let arcs = labels.sonars.get(*sonar).into_iter().flatten();
            arcs.map(|arc| arc.stamp_ns).collect()
        };
        let [then, now] = labels.map(stamps);
        let is_only = |at: &i64, those: &[i64]| those.binary_search(at).is_err();
        let new: Vec<i64> = now
            .iter()
            .copied()
            .filter(|at| is_only(at, &then))
            .collect();
        for was in then.iter().filter(|at| is_only(at, &now)) {
            let from = new.partition_point(|at| *at < was.saturating_sub(LATEST_NS));
            let near = new.iter().skip(from);
            let near = near.take_while(|at| **at <= was.saturating_add(LATEST_NS));
            moved.extend(near.map(|is| is - was));
        }
    }
    moved.sort_unstable();
    let mut found: Vec<(usize, i64)> = Vec::new();
    for delay in moved {
        match found.last_mut() {
            Some((count, last)) if *last == delay => *count += 1,
            _ => found.push((1, delay)),
        }
    }
    found.sort_by_key(|(count, delay)| (std::cmp::Reverse(*count), delay.abs()));
    found
        .into_iter()
        .take(TRIED)
        .map(|(_, delay)| delay)
        .collect()
}

/// The first and the last stamp, as they were, of the part that is later by a delay.
fn part(then: &Stamps, now: &[i64], delay_ns: i64) -> Option<[i64; 2]> {
    let steps: Vec<i64> = now.array_windows().map(|[a, b]| b - a).collect();
    let mut sorted = steps.clone();
    sorted.sort_unstable();
    let usual = *sorted.get(sorted.len() / 2)?;
    let mut breaks: Vec<usize> = (1..).take(steps.len()).collect();
    breaks.sort_by_key(|at| {
        let step = steps.get(at - 1).copied().unwrap_or_default();
        std::cmp::Reverse((step - usual).abs())
    });
    breaks.truncate(BREAKS);
    breaks.push(now.len());
    breaks.sort_unstable();
    let pairs = breaks
        .iter()
        .flat_map(|from| breaks.iter().map(move |to| from..to));
    let mut parts = pairs.filter(|part| part.start < part.end);
    let part = parts.find(|part| {
        let restored = now.iter().enumerate().map(|(place, at)| {
            let is_later = (*part.start..*part.end).contains(&place);
            if is_later { at - delay_ns } else { *at }
        });
        Stamps::of(restored).digest == then.digest
    })?;
    let was = |place: usize| Some(now.get(place)? - delay_ns);
    Some([was(*part.start)?, was(part.end.checked_sub(1)?)?])
}

#[cfg(test)]
mod tests {
    use super::super::super::results::{LabelledArc, Mark};
    use super::*;

    fn labels(stamps: impl Iterator<Item = i64>) -> Labels {
        let arc = |stamp_ns| LabelledArc {
            stamp_ns,
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

    fn pings() -> impl Iterator<Item = i64> + Clone {
        (0..100).map(|ping| ping * 640_000_000)
    }

    /// What is found of pings that are late so, of which every third gives an arc, another one then and now.
    fn found(late: impl Fn(i64) -> i64 + Clone) -> Option<LatePart> {
        let (then, now) = (Stamps::of(pings()), Stamps::of(pings().map(late.clone())));
        let arcs = [
            labels(pings().step_by(3)),
            labels(pings().skip(1).step_by(2).map(late)),
        ];
        LatePart::of(&[("front", &then, &now)], [&arcs[0], &arcs[1]], 0)
    }

    #[test]
    fn a_late_part_is_measured() {
        let late = |at| match at {
            20_000_000_000..40_000_000_000 => at + 290_000_000,
            _ => at,
        };
        let part = found(late).unwrap();
        assert_eq!(part.delay_ns, 290_000_000);
        assert_eq!(part.seconds, [20.48, 39.68]);
        assert_eq!(part.sonars, ["front"]);
    }

    #[test]
    fn what_is_late_otherwise_is_no_part() {
        assert_eq!(found(|at| at + at / 100), None);
        assert_eq!(found(|at| at + at % 7_000_000), None);
    }
}
