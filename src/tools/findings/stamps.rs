//! What is odd about the stamps of messages.

use super::facts::{ChannelFacts, Facts};
use super::finding::{Finding, Weight};
use super::odometry::OdometryFacts;
use crate::core::wording::counted_with;
use Weight::{Notable, Serious};

pub fn repeated_odometry(facts: &Facts, odometry: &OdometryFacts) -> Option<Finding> {
    let of_odometry = |c: &&ChannelFacts| c.used && c.topic == odometry.topic;
    let channels = facts.channels.iter().filter(of_odometry);
    let repeated: u64 = channels.map(|c| c.repeated_stamps).sum();
    (repeated > 0).then(|| {
        Finding::new(
            Notable,
            "repeated-odometry",
            format!(
                "{} the stamp of the one before",
                counted_with(repeated, "odometry sample", "carries", "carry")
            ),
            "the first of them is taken for a reading at that instant",
            "look whether two nodes publish the odometry",
        )
    })
}

pub fn clock_set(facts: &Facts) -> Option<Finding> {
    let set = facts.clock_set.as_ref()?;
    Some(Finding::new(
        Serious,
        "clock-jump",
        set.what.as_str(),
        "readings meet the poses of another time, or none; the log seems longer or shorter than it is",
        if set.advice.is_empty() {
            "replay the parts by themselves with --start and --end"
        } else {
            &set.advice
        },
    ))
}

/// What can be wrong with the stamps of a channel's messages.
struct StampCheck {
    weight: Weight,
    code: &'static str,
    of: fn(&ChannelFacts) -> u64,
    /// The verb for one message and for several, and what follows it.
    words: [&'static str; 3],
    effect: &'static str,
    mend: &'static str,
}

const STAMP_CHECKS: [StampCheck; 3] = [
    StampCheck {
        weight: Serious,
        code: "unstamped",
        of: |c| c.unstamped,
        words: ["carries", "carry", "no stamp (0)"],
        effect: "the time of recording is taken: it is late by what the message was under way, and the \
                 arcs shift along the path",
        mend: "let the driver stamp its messages",
    },
    StampCheck {
        weight: Notable,
        code: "backward-stamps",
        of: |c| c.backward_stamps,
        words: ["is", "are", "stamped earlier than the one before"],
        effect: "they are taken in stamp order; if the clock was set back, two times overlap",
        mend: "look at the clock synchronisation of the robot's computers",
    },
    StampCheck {
        weight: Notable,
        code: "out-of-order",
        of: |c| c.out_of_order,
        words: ["lies", "lie", "in the file behind later ones"],
        effect: "none: they are taken in stamp order",
        mend: "",
    },
];

pub fn used<'f>(facts: &'f Facts, role: &'f str) -> impl Iterator<Item = &'f ChannelFacts> {
    let channels = facts.channels.iter();
    channels.filter(move |channel| channel.used && channel.role == Some(role))
}

pub fn check(facts: &Facts) -> Vec<Finding> {
    let mut found = Vec::new();
    for role in ["range", "odometry"] {
        // What follows from a clock that was set is told with it.
        let checks = STAMP_CHECKS.iter();
        for check in checks.filter(|check| check.weight == Serious || facts.clock_set.is_none()) {
            let count: u64 = used(facts, role).map(check.of).sum();
            let [one, many, what] = check.words;
            let told = counted_with(count, &format!("{role} message"), one, many);
            found.extend((count > 0).then(|| {
                Finding::new(
                    check.weight,
                    check.code,
                    format!("{told} {what}"),
                    check.effect,
                    check.mend,
                )
            }));
        }
    }
    found
}
