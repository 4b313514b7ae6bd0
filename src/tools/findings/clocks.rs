//! Clocks of ranges and of odometry that do not agree: one is ahead, one runs faster, one is coarse. Each has its
//! own cause, and the delay in the middle is the same for all.

use super::examined::{Examined, in_words};
use super::facts::{ChannelFacts, Facts};
use super::finding::{Finding, Weight};
use super::stamps::used;
use crate::core::statistics::seconds;

/// So much more or less delay of the ranges than of the odometry is worth a word, seconds.
const SKEW: f64 = 0.1;
/// Stamps this far from the time of recording come from another clock, seconds.
const OTHER_CLOCK: f64 = 10.0;
/// Stamps that are all multiples of one of these are coarse, seconds.
const COARSE: [f64; 4] = [10.0, 1.0, 0.5, 0.1];
/// A share of the stamps that is all of them, but for damage.
const ALL: f64 = 0.95;
const ODOMETRY_BY_RECORDING: &str = "input.odometry_stamps = \"recording\"";
/// Stamped by the recording, ranges are late by what they take under way, and the key says so.
const BY_RECORDING: &str = "input.range_stamps = \"recording\"";

/// A clock by the busiest channel that it stamps.
struct Clock<'a> {
    channel: &'a ChannelFacts,
    delay: f64,
}

/// How long ranges and odometry are under way; delays to a clock that was set say nothing of another.
pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let facts = of.facts;
    let (ranges, odometry) = (clock(facts, "range")?, clock(facts, "odometry")?);
    if facts.clock_set.is_some() {
        return set(of);
    }
    coarse(of, &ranges, "ranges")
        .or_else(|| coarse(of, &odometry, "odometry"))
        .or_else(|| running(of, &ranges, &odometry))
        .or_else(|| ahead(of, &ranges, &odometry))
        .or_else(|| uneven(of, &ranges, &odometry))
        .or_else(|| other(&ranges))
}

fn clock<'a>(facts: &'a Facts, role: &'a str) -> Option<Clock<'a>> {
    let clocks = used(facts, role).filter_map(|channel| {
        let delay = channel.median_delay?;
        Some(Clock { channel, delay })
    });
    clocks.max_by_key(|clock| clock.channel.stamped)
}

/// A clock that was set while the log was recorded, where the times of recording fit together.
fn set(of: &Examined<'_>) -> Option<Finding> {
    let both = format!("{BY_RECORDING}\n{ODOMETRY_BY_RECORDING}");
    let tried = of.best(&[
        BY_RECORDING.to_owned(),
        ODOMETRY_BY_RECORDING.to_owned(),
        both,
    ])?;
    Some(
        Finding::new(
            Weight::Serious,
            "set-stamps",
            "the clock of the stamps was set while they were recorded, and that of the recording was not",
            "readings meet the poses of other times",
            format!("for this log {}{tried}", tried.named()),
        )
        .with(Some(tried)),
    )
}

/// Stamps in whole seconds (kevinmcaleer/snakeros#27).
fn coarse(of: &Examined<'_>, clock: &Clock<'_>, role: &str) -> Option<Finding> {
    let events = &of.survey.log.events;
    let (key, stamps): (_, Vec<i64>) = match role {
        "odometry" => (
            ODOMETRY_BY_RECORDING,
            events
                .odometry
                .iter()
                .map(|sample| sample.stamp_ns)
                .collect(),
        ),
        _ => (
            BY_RECORDING,
            events
                .readings
                .iter()
                .map(|reading| reading.stamp_ns)
                .collect(),
        ),
    };
    let is_on = |step: &f64| {
        let step_ns = libm::round(step * 1e9) as i64;
        let on = stamps.iter().filter(|stamp| *stamp % step_ns == 0).count();
        on as f64 > ALL * stamps.len() as f64 && clock.channel.delay_spread > 0.7 * step
    };
    let step = COARSE.into_iter().find(is_on)?;
    let tried = of.tried(key);
    let by_recording = format!("{key}{}", in_words(tried.as_ref()));
    let delays = used(of.facts, if role == "odometry" { role } else { "range" })
        .filter_map(|channel| channel.extreme_delay);
    Some(Finding::new(
        Weight::Serious,
        "coarse-stamps",
        format!(
            "the {role} {} stamped in whole steps of {step} s, and recorded up to {:.2} s later",
            if role == "odometry" { "is" } else { "are" },
            delays.fold(0.0, f64::max)
        ),
        match role {
            "odometry" => "the robot seems to leap from step to step",
            _ => "readings meet the pose of the last full step, and walls come in stairs",
        },
        format!("let the driver stamp to the nanosecond; for this log {by_recording}"),
    )
    .with(tried))
}

/// A clock that runs faster or slower than the other.
fn running(of: &Examined<'_>, ranges: &Clock<'_>, odometry: &Clock<'_>) -> Option<Finding> {
    let (growth, about) = ranges.channel.delay_growth?;
    let (of_odometry, _) = odometry.channel.delay_growth.unwrap_or_default();
    let rate = growth - of_odometry;
    let first = used(of.facts, "range")
        .map(|channel| channel.first_ns)
        .min()?;
    let last = used(of.facts, "range")
        .map(|channel| channel.last_ns)
        .max()?;
    let lasted = seconds(first, last);
    let grown = rate * lasted;
    if grown.abs() < SKEW || grown.abs() < 3.0 * about {
        return None;
    }
    let keys = [
        BY_RECORDING.to_owned(),
        format!("input.range_clock_rate = {:.5}", -rate),
        ODOMETRY_BY_RECORDING.to_owned(),
    ];
    let tried = of.best(&keys);
    Some(Finding::new(
        Weight::Serious,
        "clock-rate",
        format!(
            "the clock of the ranges runs {:.2} % {} than that of the odometry: in {lasted:.1} s they come {:.2} s \
             apart",
            100.0 * rate.abs(),
            if rate > 0.0 { "slower" } else { "faster" },
            grown.abs()
        ),
        "readings meet poses that are the more wrong the longer the log is",
        match &tried {
            Some(tried) => format!(
                "synchronise the clocks again and again; for this log {}{tried}",
                tried.keys
            ),
            None => "synchronise the clocks again and again".to_owned(),
        },
    )
    .with(tried))
}

/// A clock that is ahead of the other, or behind it.
fn ahead(of: &Examined<'_>, ranges: &Clock<'_>, odometry: &Clock<'_>) -> Option<Finding> {
    let skew = ranges.delay - odometry.delay;
    if skew.abs() <= SKEW {
        return None;
    }
    let speed = of.facts.odometry.as_ref().map_or(0.0, |odometry| {
        odometry.distance / seconds(odometry.first_ns, odometry.last_ns)
    });
    let speed = if speed.is_finite() { speed } else { 0.0 };
    let delay = of.survey.config.input.range_delay - skew;
    let key = format!("input.range_delay = {delay:.3}");
    let both = format!("{BY_RECORDING}\n{ODOMETRY_BY_RECORDING}");
    let keys = [
        key,
        BY_RECORDING.to_owned(),
        ODOMETRY_BY_RECORDING.to_owned(),
        both,
    ];
    let replayed = of.facts.replay.outcome.as_ref();
    let tried = replayed.and_then(|_| of.best(&keys));
    Some(Finding::new(
        Weight::Serious,
        "clock-skew",
        format!(
            "from stamp to recording ranges take {:.3} s and odometry {:.3} s",
            ranges.delay, odometry.delay
        ),
        format!(
            "if the clocks differ and not the ways, readings meet the wrong poses: {:.2} m off at the robot's mean \
             speed",
            (speed * skew).abs()
        ),
        match &tried {
            Some(tried) => format!("the clocks differ: set {}{tried}, and synchronise them", tried.named()),
            None => {
                "synchronise the clocks of sonar driver and odometry, or stamp both on one computer"
                    .to_owned()
            }
        },
    )
    .with(tried))
}

/// Stamps that come and go about the time of recording, while the other's do not: parts of a second in another unit,
/// a busy computer that stamps late.
fn uneven(of: &Examined<'_>, ranges: &Clock<'_>, odometry: &Clock<'_>) -> Option<Finding> {
    let [theirs, its] = [ranges, odometry].map(|clock| clock.channel.delay_spread);
    if (theirs - its).abs() < SKEW {
        return None;
    }
    let keys = [BY_RECORDING, ODOMETRY_BY_RECORDING].map(str::to_owned);
    let tried = of.best(&keys)?;
    Some(
        Finding::new(
            Weight::Serious,
            "uneven-stamps",
            format!(
                "from stamp to recording ranges take now longer and now shorter: nine of ten within {theirs:.2} s, \
                 odometry within {its:.2} s"
            ),
            "readings meet the poses of other times",
            format!("look at what stamps them; for this log {}{tried}", tried.keys),
        )
        .with(Some(tried)),
    )
}

/// Stamps of another clock than the recording's, as since boot.
fn other(ranges: &Clock<'_>) -> Option<Finding> {
    (ranges.delay.abs() > OTHER_CLOCK).then(|| {
        Finding::new(
            Weight::Notable,
            "other-clock",
            format!(
                "stamps lie {:.0} s {} the time of recording",
                ranges.delay.abs(),
                if ranges.delay > 0.0 {
                    "before"
                } else {
                    "behind"
                }
            ),
            "none, if ranges and odometry share the clock: stamps count",
            "",
        )
    })
}
