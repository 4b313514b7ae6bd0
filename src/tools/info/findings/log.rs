//! What is wrong with the file, its channels and their clocks.

use std::collections::{BTreeMap, BTreeSet};

use super::{Finding, Info, Weight, names};
use crate::core::wording::counted_with;
use crate::io::log::TOO_WIDE;
use crate::tools::info::channels::ChannelFacts;

/// So much more or less delay of the ranges than of the odometry is worth a word, seconds.
const SKEW: f64 = 0.1;
/// Stamps this far from the time of recording come from another clock, seconds.
const OTHER_CLOCK: f64 = 10.0;
/// So many losses are named.
const NAMED_LOSSES: usize = 3;

/// Channels of a known type in a form that is not read.
pub fn channels(info: &Info, findings: &mut Vec<Finding>) {
    let mut by_problem: BTreeMap<&str, Vec<&ChannelFacts>> = BTreeMap::new();
    for channel in info.channels.iter().filter(|c| c.is_unreadable()) {
        let problem = channel.problem.as_deref().unwrap_or_default();
        by_problem.entry(problem).or_default().push(channel);
    }
    for (problem, channels) in by_problem {
        let role_is_met = |role: Option<&str>| match role {
            Some("range") => !info.sonars.is_empty(),
            Some("odometry") => info.odometry.is_some(),
            _ => true,
        };
        let weight = if channels.iter().all(|channel| role_is_met(channel.role)) {
            Weight::Serious
        } else {
            Weight::Blocking
        };
        let topics = names(channels.iter().map(|c| c.topic.as_str()));
        let verb = if channels.len() == 1 { "is" } else { "are" };
        findings.push(Finding::new(
            weight,
            "unread-channel",
            format!("{topics} {verb} not read: {problem}"),
            "what they say is missing from the replay",
            if channels.iter().any(|channel| channel.wanted) {
                "a replay ends with exit code 3; record them as is said, or leave them out: --range-topic"
            } else {
                ""
            },
        ));
    }
}

/// What of the file could not be read.
pub fn losses(info: &Info, findings: &mut Vec<Finding>) {
    // Of channels that are not read, there is a finding of their own.
    let unread = info.channels.iter().filter(|c| c.is_unreadable());
    let unread: BTreeSet<&str> = unread.map(|channel| channel.topic.as_str()).collect();
    let of_channel = |loss: &str| {
        let mut starts = loss
            .match_indices(", ")
            .filter_map(|(end, _)| loss.get(..end));
        starts.any(|start| unread.contains(start))
    };
    let losses: Vec<&String> = (info.losses.iter())
        .filter(|loss| !of_channel(loss))
        .collect();
    if losses.is_empty() {
        return;
    }
    let mut what = format!(
        "the log is not whole, {} could not be read",
        match losses.len() {
            1 => "one part".to_owned(),
            n => format!("{n} parts"),
        }
    );
    for (loss, mark) in losses.iter().take(NAMED_LOSSES).zip([": ", "; ", "; "]) {
        what.push_str(mark);
        what.push_str(loss);
    }
    if losses.len() > NAMED_LOSSES {
        what.push_str("; ...");
    }
    findings.push(Finding::new(
        Weight::Serious,
        "incomplete",
        what,
        "what it held is missing from the map, and sequences break where it was",
        if info.channels.is_empty() {
            ""
        } else {
            "everything else is used; a replay ends with exit code 3"
        },
    ));
}

/// Stamps.
pub fn clocks(info: &Info, findings: &mut Vec<Finding>) {
    if let Some(set) = &info.clock_set {
        findings.push(Finding::new(
            Weight::Serious,
            "clock-jump",
            set.what.as_str(),
            "readings meet the poses of another time, or none; the log seems longer or shorter than it is",
            if set.advice.is_empty() {
                "replay the parts by themselves with --start and --end"
            } else {
                &set.advice
            },
        ));
    }
    let used = |role: &'static str| {
        info.channels
            .iter()
            .filter(move |channel| channel.used && channel.role == Some(role))
    };
    for (role, what) in [("range", "range"), ("odometry", "odometry")] {
        let sum = |of: fn(&ChannelFacts) -> u64| used(role).map(of).sum::<u64>();
        let unstamped = sum(|c| c.unstamped);
        if unstamped > 0 {
            findings.push(Finding::new(
                Weight::Serious,
                "unstamped",
                format!(
                    "{} no stamp (0)",
                    counted_with(unstamped, &format!("{what} message"), "carries", "carry")
                ),
                "the time of recording is taken: it is late by what the message was under way, and \
                 the arcs shift along the path",
                "let the driver stamp its messages",
            ));
        }
        let backward = sum(|c| c.backward_stamps);
        // What follows from a clock that was set is told with it.
        if backward > 0 && info.clock_set.is_none() {
            findings.push(Finding::new(
                Weight::Notable,
                "backward-stamps",
                format!(
                    "{} stamped earlier than the one before",
                    counted_with(backward, &format!("{what} message"), "is", "are")
                ),
                "they are taken in stamp order; if the clock was set back, two times overlap",
                "look at the clock synchronisation of the robot's computers",
            ));
        }
        let disordered = sum(|c| c.out_of_order);
        if disordered > 0 && info.clock_set.is_none() {
            findings.push(Finding::new(
                Weight::Notable,
                "out-of-order",
                format!(
                    "{} in the file behind later ones",
                    counted_with(disordered, &format!("{what} message"), "lies", "lie")
                ),
                "none: they are taken in stamp order",
                "",
            ));
        }
    }
    // Delays to a clock that was set say nothing of another clock.
    if info.clock_set.is_none() {
        delays(info, used("range"), used("odometry"), findings);
    }
}

fn delays<'a>(
    info: &Info,
    ranges: impl Iterator<Item = &'a ChannelFacts>,
    odometry: impl Iterator<Item = &'a ChannelFacts>,
    findings: &mut Vec<Finding>,
) {
    let delay = |channels: &mut dyn Iterator<Item = &'a ChannelFacts>| {
        channels
            .filter_map(|channel| Some((channel.stamped, channel.median_delay?)))
            .max_by_key(|(stamped, _)| *stamped)
            .map(|(_, delay)| delay)
    };
    let mut ranges = ranges;
    let mut odometry = odometry;
    let (of_ranges, of_odometry) = (delay(&mut ranges), delay(&mut odometry));
    let (Some(of_ranges), Some(of_odometry)) = (of_ranges, of_odometry) else {
        return;
    };
    let skew = of_ranges - of_odometry;
    if skew.abs() > SKEW {
        let speed = info.odometry.as_ref().map_or(0.0, |odometry| {
            odometry.distance
                / super::super::statistics::seconds(odometry.first_ns, odometry.last_ns)
        });
        let shift = if speed.is_finite() {
            (speed * skew).abs()
        } else {
            0.0
        };
        findings.push(Finding::new(
            Weight::Serious,
            "clock-skew",
            format!(
                "from stamp to recording ranges take {of_ranges:.3} s, odometry {of_odometry:.3} s"
            ),
            format!(
                "if the clocks differ and not the ways, readings meet the wrong poses: \
                 {:.2} m off at the robot's mean speed",
                shift
            ),
            "synchronise the clocks of sonar driver and odometry, or stamp both on one computer",
        ));
    } else if of_ranges.abs() > OTHER_CLOCK {
        findings.push(Finding::new(
            Weight::Notable,
            "other-clock",
            format!("stamps lie {of_ranges:.0} s before the time of recording"),
            "none, if ranges and odometry share the clock: stamps count",
            "",
        ));
    }
}

/// What the reader noted and no other finding says.
pub fn notes(info: &Info, notes: &[String], findings: &mut Vec<Finding>) {
    let said = |note: &str| {
        let of_channel = |channel: &ChannelFacts| {
            let problem = channel.problem.as_deref().unwrap_or_default();
            channel.is_unreadable() && note.ends_with(&format!(" left out: {problem}"))
        };
        let repeats = note.contains("sonar's last value although the robot moved");
        note.contains("no stamp in the header")
            || (repeats && findings.iter().any(|finding| finding.code == "repeats"))
            || info.channels.iter().any(of_channel)
            || (note.contains(TOO_WIDE) && findings.iter().any(|f| f.code == "beam-width"))
    };
    let unsaid: Vec<&String> = notes.iter().filter(|note| !said(note)).collect();
    for note in unsaid {
        findings.push(Finding::new(Weight::Notable, "note", note.as_str(), "", ""));
    }
}
