//! What a person should know of a log, what it does to the map and what to do about it.

use std::collections::{BTreeMap, BTreeSet};

use super::facts::{ChannelFacts, Facts};
use super::finding::{Finding, Weight, names, percent, which_sonars};
use super::obstacles;
use super::odometry::OdometryFacts;
use super::sonars::SonarFacts;
use super::trial::{Replayable, wider_gap};
use crate::core::config::Sequence;
use crate::core::noise_estimate::{NoiseEstimate, VarianceFrom};
use crate::core::rounding::fixed;
use crate::core::statistics::{fraction, seconds};
use crate::core::wording::{counted, counted_with, seconds_between};
use crate::io::log::leaps::is_leap;
use crate::io::log::{LogError, TOO_WIDE, WIDEST_BEAM};
use Weight::{Blocking, Notable, Serious};

/// So many losses are named.
const NAMED_LOSSES: usize = 3;
/// From this share of readings without a pose on, a part of the map is missing.
const MANY_WITHOUT_POSE: f64 = 0.2;
/// So much more or less delay of the ranges than of the odometry is worth a word, seconds.
const SKEW: f64 = 0.1;
/// Stamps this far from the time of recording come from another clock, seconds.
const OTHER_CLOCK: f64 = 10.0;
/// A sonar in the air reaches no farther, metres.
const FARTHEST: f64 = 50.0;
/// A share of invalid readings, or of neighbours too far apart, that matters.
const MANY: f64 = 0.25;
/// So many echoes of a moving sensor say how often they repeat ...
const ENOUGH_ECHOES: u64 = 20;
/// ... which is no chance for a sonar with a fine raster from this share on ...
const REPEATS: f64 = 0.05;
/// ... and for one with a coarse raster, which sees a wall beside it as the same for long, from this on.
const QUANTISED_REPEATS: f64 = 0.5;
/// A raster finer than this is fine, metres.
const FINE: f64 = 0.002;
/// Finer noise than this is never too fine, metres: a raster hides it.
const FINEST_NOISE: f64 = 1e-3;
/// From so many arcs on, shares mean something.
const ENOUGH_ARCS: u64 = 20;
/// With fewer labelled arcs than this there is hardly a map.
const FEW: f64 = 0.05;
/// A reason that holds for more arcs than this is worth a word.
const MOST: f64 = 0.5;

/// Everything found, the weightiest first.
pub fn findings(facts: &Facts, obstacles: &[LogError], notes: &[String]) -> Vec<Finding> {
    let mut found = unread_channels(facts);
    found.extend(obstacles::findings(facts, obstacles));
    found.extend(losses(facts));
    if let Some(odometry) = &facts.odometry {
        let checks = [still, jump, without_pose, gaps, repeated_odometry];
        found.extend(checks.iter().filter_map(|check| check(facts, odometry)));
    }
    found.extend(clock_set(facts));
    found.extend(stamps(facts));
    found.extend(delays(facts));
    found.extend(sonars(facts));
    let checks = [one_mount, coarse_ranges, noise, few_labels];
    found.extend(checks.iter().filter_map(|check| check(facts)));
    let unsaid = unsaid(facts, notes, &found);
    found.extend(unsaid);
    found.sort_by_key(|finding| finding.weight);
    found
}

/// Channels of a known type in a form that is not read.
fn unread(facts: &Facts) -> impl Iterator<Item = &ChannelFacts> {
    facts
        .channels
        .iter()
        .filter(|channel| channel.is_unreadable())
}

fn unread_channels(facts: &Facts) -> Vec<Finding> {
    let mut by_problem: BTreeMap<&str, Vec<&ChannelFacts>> = BTreeMap::new();
    for channel in unread(facts) {
        let problem = channel.problem.as_deref().unwrap_or_default();
        by_problem.entry(problem).or_default().push(channel);
    }
    let role_is_met = |channel: &&ChannelFacts| match channel.role {
        Some("range") => !facts.sonars.is_empty(),
        Some("odometry") => facts.odometry.is_some(),
        _ => true,
    };
    let finding = |(problem, channels): (&str, Vec<&ChannelFacts>)| {
        let topics = names(channels.iter().map(|c| c.topic.as_str()));
        let verb = if channels.len() == 1 { "is" } else { "are" };
        let is_met = channels.iter().all(role_is_met);
        Finding::new(
            if is_met { Serious } else { Blocking },
            "unread-channel",
            format!("{topics} {verb} not read: {problem}"),
            "what they say is missing from the replay",
            if channels.iter().any(|channel| channel.wanted) {
                "a replay ends with exit code 3; record them as is said, or leave them out: --range-topic"
            } else {
                ""
            },
        )
    };
    by_problem.into_iter().map(finding).collect()
}

/// What of the file could not be read; of channels that are not read, there is a finding of their own.
fn losses(facts: &Facts) -> Option<Finding> {
    let unread: BTreeSet<&str> = unread(facts)
        .map(|channel| channel.topic.as_str())
        .collect();
    let of_channel = |loss: &str| {
        let mut ends = loss.match_indices(", ").map(|(end, _)| end);
        ends.any(|end| loss.get(..end).is_some_and(|topic| unread.contains(topic)))
    };
    let losses = facts.source.lost.iter().map(String::as_str);
    let losses: Vec<&str> = losses.filter(|loss| !of_channel(loss)).collect();
    let named = losses.get(..NAMED_LOSSES).unwrap_or(&losses).join("; ");
    let (parts, more) = match losses.len() {
        0 => return None,
        1 => ("one part".to_owned(), ""),
        n => (
            format!("{n} parts"),
            if n > NAMED_LOSSES { "; ..." } else { "" },
        ),
    };
    Some(Finding::new(
        Serious,
        "incomplete",
        format!("the log is not whole, {parts} could not be read: {named}{more}"),
        "what it held is missing from the map, and sequences break where it was",
        if facts.channels.is_empty() {
            ""
        } else {
            "everything else is used; a replay ends with exit code 3"
        },
    ))
}

fn still(facts: &Facts, odometry: &OdometryFacts) -> Option<Finding> {
    let frames = &facts.replay.config.frames;
    let is_still = odometry.distance < frames.step && odometry.turning < frames.step_angle;
    is_still.then(|| {
        Finding::new(
            Serious,
            "still",
            format!(
                "the robot does not move: {:.2} m and {:.1} deg in all",
                odometry.distance,
                odometry.turning.to_degrees()
            ),
            "arcs from one place tell nothing of walls and corners: they all fall into one frame",
            "look whether the odometry is the right one; lower frames.step for a crawling robot",
        )
    })
}

fn jump(facts: &Facts, odometry: &OdometryFacts) -> Option<Finding> {
    let jump = odometry.largest_jump?;
    let at = seconds(facts.source.start_ns, jump.stamp_ns);
    is_leap(jump.distance, jump.seconds).then(|| {
        Finding::new(
            Serious,
            "odometry-jump",
            format!(
                "the odometry jumps by {:.2} m in {:.3} s, at {} s",
                jump.distance,
                jump.seconds,
                fixed(at, 1)
            ),
            "the map before and after it does not fit together",
            format!(
                "replay the parts by themselves: --end {:.1}, then --start {:.1}",
                at.max(0.0),
                (at + jump.seconds).max(0.0)
            ),
        )
    })
}

fn without_pose(facts: &Facts, odometry: &OdometryFacts) -> Option<Finding> {
    let bound = facts.replay.config.frames.max_odometry_gap;
    let lost = odometry.readings - odometry.readings_with_pose;
    let share = fraction(lost, odometry.readings);
    let outside = odometry.readings_before + odometry.readings_after;
    (lost > 0).then(|| {
        Finding::new(
            if share > MANY_WITHOUT_POSE {
                Serious
            } else {
                Notable
            },
            "no-pose",
            format!(
                "{lost} of {} ({}) {} no pose: {} before the first odometry sample, {} \
                 after the last, {} in gaps wider than {bound} s",
                counted(odometry.readings, "reading"),
                percent(share),
                if lost == 1 { "has" } else { "have" },
                odometry.readings_before,
                odometry.readings_after,
                lost.saturating_sub(outside),
            ),
            "they are dropped",
            if wider_gap(odometry, bound).is_some() {
                "the odometry is slow: raise frames.max_odometry_gap (skeleton below), and know that \
                 poses between samples are straight lines"
            } else if outside * 2 > lost {
                "record odometry for as long as the sonars; check that their clocks agree"
            } else {
                "look at what interrupts the odometry"
            },
        )
    })
}

fn gaps(facts: &Facts, odometry: &OdometryFacts) -> Option<Finding> {
    let gap = odometry.longest_gap.filter(|_| odometry.gaps > 0)?;
    Some(Finding::new(
        Notable,
        "odometry-gaps",
        format!(
            "the odometry has {} wider than {} s; the longest is {:.1} s, at {} s",
            counted(odometry.gaps, "gap"),
            facts.replay.config.frames.max_odometry_gap,
            gap.seconds,
            seconds_between(facts.source.start_ns, gap.stamp_ns, 1)
        ),
        if odometry.readings_with_pose == odometry.readings {
            "none: no reading falls into them"
        } else {
            "readings in them have no pose"
        },
        "",
    ))
}

fn repeated_odometry(facts: &Facts, odometry: &OdometryFacts) -> Option<Finding> {
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

fn clock_set(facts: &Facts) -> Option<Finding> {
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

fn used<'f>(facts: &'f Facts, role: &'f str) -> impl Iterator<Item = &'f ChannelFacts> {
    let channels = facts.channels.iter();
    channels.filter(move |channel| channel.used && channel.role == Some(role))
}

fn stamps(facts: &Facts) -> Vec<Finding> {
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

/// How long ranges and odometry are under way; delays to a clock that was set say nothing of another.
fn delays(facts: &Facts) -> Option<Finding> {
    let delay = |role| {
        used(facts, role)
            .filter_map(|channel| Some((channel.stamped, channel.median_delay?)))
            .max_by_key(|(stamped, _)| *stamped)
            .map(|(_, delay)| delay)
    };
    let (of_ranges, of_odometry) = (delay("range")?, delay("odometry")?);
    let skew = of_ranges - of_odometry;
    if facts.clock_set.is_some() {
        return None;
    }
    if skew.abs() <= SKEW {
        return (of_ranges.abs() > OTHER_CLOCK).then(|| {
            Finding::new(
                Notable,
                "other-clock",
                format!("stamps lie {of_ranges:.0} s before the time of recording"),
                "none, if ranges and odometry share the clock: stamps count",
                "",
            )
        });
    }
    let odometry = facts.odometry.as_ref();
    let speed = odometry.map_or(0.0, |odometry| {
        odometry.distance / seconds(odometry.first_ns, odometry.last_ns)
    });
    let speed = if speed.is_finite() { speed } else { 0.0 };
    Some(Finding::new(
        Serious,
        "clock-skew",
        format!(
            "from stamp to recording ranges take {of_ranges:.3} s, odometry {of_odometry:.3} s"
        ),
        format!(
            "if the clocks differ and not the ways, readings meet the wrong poses: \
             {:.2} m off at the robot's mean speed",
            (speed * skew).abs()
        ),
        "synchronise the clocks of sonar driver and odometry, or stamp both on one computer",
    ))
}

/// What can be wrong with a sonar or with what came back to it.
struct SonarCheck {
    weight: Weight,
    code: &'static str,
    is_wrong: fn(&SonarFacts) -> bool,
    /// Told of the first sonar of which it holds.
    what: fn(&SonarFacts, &Sequence) -> String,
    effect: &'static str,
    mend: &'static str,
}

const TOO_FAR_APART: &str = "too-far-apart";

const SONAR_CHECKS: [SonarCheck; 8] = [
    SonarCheck {
        weight: Serious,
        code: "limits",
        is_wrong: SonarFacts::limits_are_senseless,
        what: |s, _| {
            let (min, max) = (s.min_range, s.max_range);
            format!("no echo fits between min_range {min} m and max_range {max} m")
        },
        effect: "every reading counts as no echo or as invalid",
        mend: "set min_range and max_range under [sonar.\"NAME\"] from the data sheet; the skeleton below has \
               the keys",
    },
    SonarCheck {
        weight: Serious,
        code: "beam-width",
        is_wrong: |s| s.beam_width.is_some_and(|w| w >= WIDEST_BEAM),
        what: |s, _| {
            let degrees = s.beam_width.unwrap_or(0.0).to_degrees();
            format!("the beam is {degrees:.0} deg wide")
        },
        effect: "points anywhere around the robot count, and labels mean little",
        mend: "field_of_view is in radians: does the driver write degrees? sonars.beam_width (deg) overrules \
               it; mend the driver",
    },
    SonarCheck {
        weight: Serious,
        code: "units",
        is_wrong: |s| s.median.is_some_and(|m| m > FARTHEST),
        what: |s, _| {
            let median = s.median.unwrap_or(0.0);
            format!("half of the echoes are farther than {median:.0} m")
        },
        effect: "the map is as much too large",
        mend: "ranges are metres: does the driver write centimetres or millimetres? Mend it there",
    },
    SonarCheck {
        weight: Serious,
        code: "repeats",
        is_wrong: repeats_too_often,
        what: |s, _| {
            let share = percent(s.repeated());
            format!("{share} of the echoes repeat the last one although the sensor moved")
        },
        effect: "equal ranges from different places look like a wall along the path",
        mend: "look whether the driver publishes faster than the sonar measures; record only new readings",
    },
    SonarCheck {
        weight: Serious,
        code: TOO_FAR_APART,
        is_wrong: |s| fraction(s.too_far_apart, s.readings) > MANY,
        what: |s, bounds| {
            format!(
                "{} of the neighbouring readings lie more than {} m or {} s apart",
                percent(fraction(s.too_far_apart, s.readings)),
                bounds.max_baseline,
                bounds.max_gap
            )
        },
        effect: "these break the sequence, and arcs at a break are not labelled (gap)",
        mend: "drive slower, let the sonars fire more often, or raise sequence.max_baseline or max_gap",
    },
    SonarCheck {
        weight: Notable,
        code: "invalid",
        is_wrong: |s| fraction(s.invalid, s.readings) > MANY,
        what: |s, _| {
            let share = percent(fraction(s.invalid, s.readings));
            format!("{share} of the readings mean nothing (NaN, -inf or below min_range)")
        },
        effect: "they are left out",
        mend: "look at min_range and at what the driver writes when nothing comes back (+inf would be right)",
    },
    SonarCheck {
        weight: Notable,
        code: "silent",
        is_wrong: |s| s.echoes == 0,
        what: |_, _| "not a single echo".to_owned(),
        effect: "the map has nothing from there",
        mend: "look at the wiring, or leave it out with --sensor",
    },
    SonarCheck {
        weight: Notable,
        code: "varies",
        is_wrong: |s| s.varies,
        what: |_, _| "beam width or range limits change during the log".to_owned(),
        effect: "each reading is taken with its own",
        mend: "",
    },
];

fn sonars(facts: &Facts) -> Vec<Finding> {
    let finding = |check: &SonarCheck| {
        let sonars = facts.sonars.iter();
        let wrong: Vec<&SonarFacts> = sonars.filter(|s| (check.is_wrong)(s)).collect();
        let which: Vec<&str> = wrong.iter().map(|s| s.name.as_str()).collect();
        let which = which_sonars(&which, facts.sonars.len());
        let what = (check.what)(wrong.first()?, &facts.replay.config.sequence);
        Some(Finding::new(
            check.weight,
            check.code,
            format!("{which}: {what}"),
            check.effect,
            check.mend,
        ))
    };
    // Times that come twice put readings of two places next to each other.
    let means_something =
        |check: &&SonarCheck| check.code != TOO_FAR_APART || facts.clock_set.is_none();
    let checks = SONAR_CHECKS.iter().filter(means_something);
    checks.filter_map(finding).collect()
}

fn repeats_too_often(sonar: &SonarFacts) -> bool {
    let coarse = sonar
        .resolution
        .is_none_or(|r| r.quantised && r.step > FINE);
    let bound = if coarse { QUANTISED_REPEATS } else { REPEATS };
    sonar.moved >= ENOUGH_ECHOES && sonar.repeated() > bound
}

fn one_mount(facts: &Facts) -> Option<Finding> {
    let mounts: Vec<_> = facts.sonars.iter().filter_map(|s| s.mount).collect();
    let same = mounts.array_windows().all(|[a, b]| a == b);
    (mounts.len() > 1 && same).then(|| {
        Finding::new(
            Serious,
            "one-mount",
            format!(
                "all {} sonars sit at the same place and look the same way",
                mounts.len()
            ),
            "a map from wrong mounts is wrong everywhere",
            "give the true mounts under [sonar.\"NAME\"], or mend the robot's transforms",
        )
    })
}

/// Whether the raster of the ranges hides what tells a wall from a corner: `d^2 / 2r`.
fn coarse_ranges(facts: &Facts) -> Option<Finding> {
    let step = facts.replay.config.frames.step;
    let sagitta = |range: f64, baseline: f64| baseline * baseline / (2.0 * range);
    let ratio = |sonar: &SonarFacts| {
        let raster = sonar.resolution.filter(|r| r.quantised)?.step;
        let (range, baseline) = (sonar.median?, sonar.baseline?.max(step));
        Some((raster / sagitta(range, baseline), raster, range, baseline))
    };
    let mut ratios: Vec<(f64, f64, f64, f64)> = facts.sonars.iter().filter_map(ratio).collect();
    if ratios.len() * 2 < facts.sonars.len() {
        return None;
    }
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = ratios.get(ratios.len() / 2);
    let &(_, raster, range, baseline) = middle.filter(|(ratio, ..)| *ratio > 0.5)?;
    // Where the difference is two steps of the raster.
    let wider = libm::sqrt(4.0 * raster * range);
    Some(Finding::new(
        Serious,
        "coarse-ranges",
        format!(
            "ranges come in steps of {:.1} mm; at {baseline:.2} m from arc to arc and {range:.2} m range, \
             a wall and a corner differ by {:.1} mm",
            raster * 1e3,
            sagitta(range, baseline) * 1e3
        ),
        "many labels depend on rounding",
        format!(
            "try a wider frames.step, of some {:.2} m; a driver that publishes finer ranges is better",
            libm::ceil(wider * 20.0) / 20.0
        ),
    ))
}

/// Whether the noise that is assumed is the noise that is there.
fn noise(facts: &Facts) -> Option<Finding> {
    let outcome = facts.replay.outcome.as_ref()?;
    let estimate = outcome.scattering.overall()?;
    let NoiseEstimate { sigma, ratio } = estimate;
    let measured = matches!(
        outcome.variance_from,
        VarianceFrom::Ranges | VarianceFrom::Nothing
    );
    if measured || estimate.is_as_expected() || (ratio < 1.0 && sigma < FINEST_NOISE) {
        return None;
    }
    let (weight, effect) = if ratio > 1.0 {
        (
            Serious,
            "readings that belong together seem not to: arcs stay unidentified (neither), and right \
             labels are called suspect",
        )
    } else {
        (
            Notable,
            "walls and corners seem to fit alike: arcs stay unidentified (ambiguous) for longer than \
             they need to",
        )
    };
    Some(Finding::new(
        weight,
        "noise",
        estimate.complaint(),
        effect,
        estimate.mend(outcome.variance_from),
    ))
}

/// Why most arcs have no label, and what helps, by the reason.
const REASONS: [(&str, &str, &str); 5] = [
    (
        "missing",
        "no echo came before or after",
        "look at max_range: sonars that look into the open rarely echo three times in a row",
    ),
    (
        "gap",
        "the readings before or after are too far away",
        "drive slower, or raise sequence.max_gap or sequence.max_baseline",
    ),
    (
        "turning",
        "the robot turned",
        "drive straight for longer, or raise triple.turn_tolerance or triple.bend_tolerance",
    ),
    (
        "wide",
        "neither angle is below gamma",
        "noise does that, and wrong mounts or poses; triple.gamma is the gate",
    ),
    (
        "ambiguous",
        "wall and corner fit alike",
        "the steps are short for the ranges: try a wider frames.step",
    ),
];

/// What is said of every other reason.
const NEITHER_FITS: (&str, &str) = (
    "no wall or corner fits the ranges inside the beam",
    "noise and targets that change do that, a beam width that is too small, and wrong mounts, \
     clocks or poses: look at the recording",
);

fn few_labels(facts: &Facts) -> Option<Finding> {
    // What placeholders give says nothing of the log.
    let outcome = facts.replay.outcome.as_ref();
    let outcome = outcome.filter(|_| facts.replay.possible == Replayable::Yes)?;
    let labelled = outcome.labelled("contact") + outcome.labelled("intersection");
    let arcs = labelled + outcome.labelled("unidentified");
    // The commonest; of equally common ones the first by name.
    let by_name = outcome.reasons.iter().rev();
    let (reason, count) = by_name.max_by_key(|(_, count)| **count)?;
    let few = fraction(labelled, arcs) < FEW;
    if arcs < ENOUGH_ARCS || !(few || fraction(*count, arcs) > MOST) {
        return None;
    }
    let known = REASONS.iter().find(|(name, ..)| name == reason);
    let (what, mend) = known.map_or(NEITHER_FITS, |(_, what, mend)| (what, mend));
    Some(Finding::new(
        if few { Serious } else { Notable },
        "few-labels",
        format!(
            "{} of {arcs} arcs are labelled; {} are not because {what} ({reason})",
            percent(fraction(labelled, arcs)),
            percent(fraction(*count, arcs)),
        ),
        "walls and corners in which they belong are missing from the map",
        mend,
    ))
}

/// What the reader noted and no other finding says.
fn unsaid(facts: &Facts, notes: &[String], found: &[Finding]) -> Vec<Finding> {
    const LEFT_OUT: &str = " left out: ";
    let problems: BTreeSet<&str> = unread(facts).filter_map(|c| c.problem.as_deref()).collect();
    let is_found = |code| found.iter().any(|finding| finding.code == code);
    let said = |note: &str| {
        let mut reasons = note
            .match_indices(LEFT_OUT)
            .filter_map(|(at, _)| note.get(at + LEFT_OUT.len()..));
        let repeats = note.contains("sonar's last value although the robot moved");
        note.contains("no stamp in the header")
            || (repeats && is_found("repeats"))
            || reasons.any(|reason| problems.contains(reason))
            || (note.contains(TOO_WIDE) && is_found("beam-width"))
    };
    let unsaid = notes.iter().filter(|note| !said(note));
    unsaid
        .map(|note| Finding::new(Notable, "note", note.as_str(), "", ""))
        .collect()
}
