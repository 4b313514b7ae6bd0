//! What is otherwise about a log, named and measured: the cause of all that differs after it.

mod late_part;

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use serde::Serialize;

use super::profile::{LogInfo, OdometryProfile, SonarProfile, Stamps};
use super::results::Labels;
use crate::core::geometry::wrap_angle;
use crate::core::rounding::fixed;
use crate::core::wording::{counted, few};
use late_part::LatePart;

/// One thing that is otherwise than it was.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Cause {
    /// A name for machines, `mounts`.
    pub code: &'static str,
    /// What it is and by how much.
    pub text: String,
    /// Whether it is a difference by itself, even where nothing follows from it.
    #[serde(skip)]
    pub fails: bool,
}

/// Lengths, angles and shares that differ by less are rounding.
const ROUNDING: f64 = 2e-6;
/// A scale or an offset explains other ranges of all sonars where it leaves at most this share of their square.
const UNEXPLAINED: f64 = 0.05;
/// The same of some sonars: what moved a sonar changes its ranges nearly so, too.
const UNEXPLAINED_OF_SOME: f64 = 1e-3;

/// A sonar of both logs, as it was and as it is.
struct Pair<'a> {
    name: &'a str,
    then: &'a SonarProfile,
    now: &'a SonarProfile,
}

/// What is otherwise about a log, what brings about the rest first. `labels`, where there are any on both sides, tell
/// in which part of it arcs are later.
pub fn causes(then: &LogInfo, now: &LogInfo, labels: Option<[&Labels; 2]>) -> Vec<Cause> {
    let (Some(before), Some(after)) = (&then.sonars, &now.sonars) else {
        let is_same = then.events_sha256 == now.events_sha256;
        let digits = |info: &LogInfo| info.events_sha256.chars().take(12).collect::<String>();
        return Vec::from_iter((!is_same).then(|| Cause {
            code: "log",
            text: format!(
                "the log holds other events, sha256 {} -> {}; which is not recorded",
                digits(then),
                digits(now)
            ),
            fails: true,
        }));
    };
    let pairs: Vec<Pair<'_>> = before
        .iter()
        .filter_map(|(name, then)| {
            let now = after.get(name)?;
            Some(Pair { name, then, now })
        })
        .collect();
    let odometry = then.odometry.as_ref().zip(now.odometry.as_ref());
    let restamped = (pairs.iter()).map(|pair| (pair.name, &pair.then.stamps, &pair.now.stamps));
    let restamped: Vec<_> = restamped
        .filter(|(_, then, now)| is_uneven(then, now))
        .collect();
    let late_part = labels.and_then(|both| LatePart::of(&restamped, both, then.origin_ns()?));
    let parts = [
        ("sonars", come_and_gone(before, after)),
        ("mounts", grouped(&pairs, "mount", mount)),
        ("beams", grouped(&pairs, "beam", beam)),
        ("stamps", stamps(&pairs, odometry, late_part.as_ref())),
        ("readings", lost(&pairs)),
        ("ranges", ranges(&pairs)),
        (
            "odometry",
            odometry.and_then(|(then, now)| driven(then, now)),
        ),
        ("variances", grouped(&pairs, "variance", variance)),
    ];
    let equal = parts.iter().filter(|(_, text)| text.is_none());
    let equal: Vec<&str> = equal.map(|(code, _)| *code).collect();
    let mut causes: Vec<Cause> = parts
        .iter()
        .filter_map(|(code, text)| {
            Some(Cause {
                code,
                text: format!("{code}: {}", text.as_ref()?),
                fails: true,
            })
        })
        .collect();
    if causes.is_empty() && then.events_sha256 != now.events_sha256 {
        causes.push(Cause {
            code: "digits",
            text: "the log's numbers differ in their last digits".to_owned(),
            fails: true,
        });
    }
    if let (Some(first), false) = (causes.first_mut(), equal.is_empty()) {
        first.text += &format!(" (unchanged: {})", equal.join(", "));
    }
    causes
}

/// By how much the stamps of each sonar are later that else are what they were, nanoseconds.
pub fn delays(then: &LogInfo, now: &LogInfo) -> BTreeMap<String, i64> {
    let (Some(then), Some(now)) = (&then.sonars, &now.sonars) else {
        return BTreeMap::new();
    };
    let delay = |(name, then): (&String, &SonarProfile)| {
        let now = now.get(name)?;
        let is_same = then.stamps.digest == now.stamps.digest;
        is_same.then(|| (name.clone(), later(&then.stamps, &now.stamps)))
    };
    then.iter().filter_map(delay).collect()
}

/// Whether there are as many as there were, at other distances.
fn is_uneven(then: &Stamps, now: &Stamps) -> bool {
    then.count == now.count && then.digest != now.digest
}

fn later(then: &Stamps, now: &Stamps) -> i64 {
    now.first_ns.saturating_sub(then.first_ns)
}

type Sonars = BTreeMap<String, SonarProfile>;

fn come_and_gone(then: &Sonars, now: &Sonars) -> Option<String> {
    let only = |these: &Sonars, those: &Sonars| -> BTreeSet<String> {
        let names = these.keys().filter(|name| !those.contains_key(*name));
        names.cloned().collect()
    };
    let (mut gone, mut new) = (only(then, now), only(now, then));
    let mut said = Vec::new();
    for (name, was) in then {
        let same = now.iter().find(|(other, is)| {
            *other != name && is.digest == was.digest && is.echoes > 0 && now.get(name) != Some(*is)
        });
        let Some((other, _)) = same else { continue };
        if gone.contains(name) && new.remove(other) {
            gone.remove(name);
            said.push(format!("{name} is called {other}"));
        } else if then.get(other).map(|it| &it.digest) == now.get(name).map(|it| &it.digest)
            && name < other
        {
            said.push(format!("{name} and {other} are swapped"));
        }
    }
    for (names, word) in [(gone, "gone"), (new, "new")] {
        let names: Vec<String> = names.into_iter().collect();
        let verb = if names.len() == 1 { "is" } else { "are" };
        if !names.is_empty() {
            said.push(format!("{} {verb} {word}", few(&names)));
        }
    }
    (!said.is_empty()).then(|| said.join("; "))
}

/// What changed in the same way, with the sonars of which it did; what most share first.
fn grouped(
    pairs: &[Pair<'_>],
    what: &str,
    change: fn(&SonarProfile, &SonarProfile) -> Option<String>,
) -> Option<String> {
    const SHOWN: usize = 3;
    let mut groups = BTreeMap::<String, Vec<String>>::new();
    for pair in pairs {
        if let Some(text) = change(pair.then, pair.now) {
            groups.entry(text).or_default().push(pair.name.to_owned());
        }
    }
    let mut groups: Vec<(String, Vec<String>)> = groups.into_iter().collect();
    groups.sort_by_key(|(_, names)| std::cmp::Reverse(names.len()));
    let more = groups.len().saturating_sub(SHOWN);
    let mut said: Vec<String> = (groups.iter().take(SHOWN))
        .map(|(text, names)| match names.len() {
            n if n == pairs.len() && n > 1 => format!("{text}, of all {n} sonars"),
            _ => format!("{what} of {}: {text}", few(names)),
        })
        .collect();
    if more > 0 {
        said.push(format!("{more} more"));
    }
    (!groups.is_empty()).then(|| said.join("; "))
}

fn differs(then: f64, now: f64) -> bool {
    (now - then).abs() > ROUNDING
}

fn mount(then: &SonarProfile, now: &SonarProfile) -> Option<String> {
    let [x, y, yaw] = then.mount;
    let [u, v, turned] = now.mount;
    let turn = wrap_angle(turned - yaw);
    let mut moved: Vec<String> = [("x", u - x), ("y", v - y)]
        .into_iter()
        .filter(|(_, by)| by.abs() > ROUNDING)
        .map(|(axis, by)| format!("{axis} {by:+.3} m"))
        .collect();
    if turn.abs() > ROUNDING {
        moved.push(format!("yaw {:+.2} deg", turn.to_degrees()));
    }
    (!moved.is_empty()).then(|| moved.join(", "))
}

fn beam(then: &SonarProfile, now: &SonarProfile) -> Option<String> {
    let limits = [("least range", 0), ("greatest range", 1)].into_iter();
    let limits = limits.filter_map(|(what, place)| {
        let [then, now] = [then, now].map(|of| of.limits.get(place).copied().flatten());
        changed(what, then, now, "m", 1.0)
    });
    let width = changed(
        "width",
        then.beam_width,
        now.beam_width,
        "deg",
        1_f64.to_degrees(),
    );
    let said: Vec<String> = width.into_iter().chain(limits).collect();
    (!said.is_empty()).then(|| said.join(", "))
}

fn variance(then: &SonarProfile, now: &SonarProfile) -> Option<String> {
    // What follows from other ranges is no change of its own.
    const SHARE: f64 = 0.02;
    let sigma = |of: &SonarProfile| of.variance.map(|variance| variance.max(0.0).sqrt());
    let (before, after) = (sigma(then)?, sigma(now)?);
    let is_said = (before > 0.0) != (after > 0.0);
    let is_other = (after - before).abs() > SHARE * before;
    (is_said || is_other)
        .then(|| changed("sigma in messages", Some(before), Some(after), "mm", 1e3))
        .flatten()
}

fn changed(
    what: &str,
    then: Option<f64>,
    now: Option<f64>,
    unit: &str,
    factor: f64,
) -> Option<String> {
    let is_other = match (then, now) {
        (Some(then), Some(now)) => differs(then, now),
        _ => then.is_some() != now.is_some(),
    };
    let shown = |number: Option<f64>| {
        number.map_or_else(|| "none".to_owned(), |number| fixed(number * factor, 3))
    };
    is_other.then(|| format!("{what} {} -> {} {unit}", shown(then), shown(now)))
}

/// Clocks: all of them, those of the ranges against that of the odometry, those of some sonars.
fn stamps(
    pairs: &[Pair<'_>],
    odometry: Option<(&OdometryProfile, &OdometryProfile)>,
    late_part: Option<&LatePart>,
) -> Option<String> {
    /// What lasts as long as before was not stretched, seconds.
    const LASTS: f64 = 1e-3;
    let of_one = |then: &Stamps, now: &Stamps| {
        let whole = then.count == now.count;
        let stretch = now.lasts - then.lasts;
        (whole && stretch.abs() <= LASTS).then(|| later(then, now))
    };
    let delays: Vec<(&str, i64)> = pairs
        .iter()
        .filter_map(|pair| Some((pair.name, of_one(&pair.then.stamps, &pair.now.stamps)?)))
        .collect();
    let of_odometry = odometry.and_then(|(then, now)| of_one(&then.stamps, &now.stamps));
    let mut sorted: Vec<i64> = delays.iter().map(|(_, delay)| *delay).collect();
    sorted.sort_unstable();
    let common = sorted.get(sorted.len() / 2).copied();
    let mut said = Vec::new();
    match (common, of_odometry) {
        (Some(ranges), Some(poses)) if ranges == poses && ranges != 0 => {
            said.push(format!("all are {}", late(ranges)));
        }
        (Some(0) | None, Some(poses)) if poses != 0 => {
            said.push(format!("odometry is {} against the ranges", late(poses)));
        }
        (Some(ranges), _) if ranges != 0 => {
            let rest = of_odometry.map(|poses| ranges - poses).unwrap_or(ranges);
            said.push(format!("ranges are {} against odometry", late(rest)));
        }
        _ => {}
    }
    let others = delays.iter().filter(|(_, delay)| Some(*delay) != common);
    let mut by_delay = BTreeMap::<i64, Vec<String>>::new();
    for (name, delay) in others {
        let rest = delay - common.unwrap_or_default();
        by_delay.entry(rest).or_default().push((*name).to_owned());
    }
    for (delay, names) in by_delay.iter().take(3) {
        let verb = if names.len() == 1 { "is" } else { "are" };
        let than = if names.len() < pairs.len() {
            " against the other sonars"
        } else {
            ""
        };
        said.push(format!("{} {verb} {}{than}", few(names), late(*delay)));
    }
    let stretched = pairs.iter().filter(|pair| {
        let (then, now) = (&pair.then.stamps, &pair.now.stamps);
        then.count == now.count && then.lasts > 0.0 && (now.lasts - then.lasts).abs() > LASTS
    });
    let stretched: Vec<&Pair<'_>> = stretched.collect();
    if let Some(part) = late_part {
        let [from, to] = part.seconds.map(|seconds| fixed(seconds, 1));
        let who = match part.sonars.len() {
            n if n == pairs.len() && n > 1 => "ranges are".to_owned(),
            1 => format!("{} is", few(&part.sonars)),
            _ => format!("{} are", few(&part.sonars)),
        };
        said.push(format!(
            "{who} {} from {from} to {to} s, and else as before",
            late(part.delay_ns)
        ));
    } else if let Some(pair) = stretched.first() {
        let (then, now) = (pair.then.stamps.lasts, pair.now.stamps.lasts);
        let share = (now / then - 1.0) * 100.0;
        let of = match stretched.len() {
            n if n == pairs.len() => "the clock of the ranges".to_owned(),
            n => counted(n as u64, "sonar clock"),
        };
        said.push(format!(
            "{of} runs otherwise: {then:.3} -> {now:.3} s from first to last ({share:+.3} %)"
        ));
    }
    if said.is_empty() {
        let uneven = pairs
            .iter()
            .filter(|pair| is_uneven(&pair.then.stamps, &pair.now.stamps));
        match uneven.count() as u64 {
            0 => {}
            n => said.push(format!(
                "{} stamped unevenly, from the same first to the same last stamp",
                crate::core::wording::counted_with(n, "sonar", "is", "are")
            )),
        }
        if odometry.is_some_and(|(then, now)| is_uneven(&then.stamps, &now.stamps)) {
            said.push("odometry is stamped otherwise, as many samples as before".to_owned());
        }
    }
    (!said.is_empty()).then(|| said.join("; "))
}

fn late(delay_ns: i64) -> String {
    let seconds = (delay_ns as f64 * 1e-9).abs();
    let amount = match seconds {
        s if s < 1.0 => format!("{} ms", fixed(s * 1e3, 1)),
        s => format!("{} s", fixed(s, 3)),
    };
    format!(
        "{amount} {}",
        if delay_ns > 0 { "later" } else { "earlier" }
    )
}

/// Readings that are gone or new.
fn lost(pairs: &[Pair<'_>]) -> Option<String> {
    let other = pairs
        .iter()
        .filter(|pair| pair.then.stamps.count != pair.now.stamps.count);
    let other: Vec<&Pair<'_>> = other.collect();
    let sum = |of: fn(&Pair<'_>) -> u64| other.iter().map(|pair| of(pair)).sum::<u64>();
    let (then, now) = (
        sum(|pair| pair.then.stamps.count),
        sum(|pair| pair.now.stamps.count),
    );
    let of = match other.as_slice() {
        [] => return None,
        all if all.len() == pairs.len() && all.len() > 1 => format!("all {} sonars", all.len()),
        some => {
            let names: Vec<String> = some.iter().map(|pair| pair.name.to_owned()).collect();
            few(&names)
        }
    };
    let ends = |stamps: &Stamps| (stamps.first_ns as f64 * 1e-9, stamps.lasts);
    let first = other.first()?;
    let ((begins, lasts), (begins_now, lasts_now)) =
        (ends(&first.then.stamps), ends(&first.now.stamps));
    let start = begins_now - begins;
    let end = start + lasts_now - lasts;
    /// What begins or ends by so many seconds otherwise was cut.
    const CUT: f64 = 1.0;
    let mut cut = String::new();
    if start > CUT {
        cut += &format!(", they begin {start:.1} s later");
    }
    if end < -CUT {
        cut += &format!(", they end {:.1} s earlier", -end);
    }
    let change = if now < then {
        format!("{} lost", then - now)
    } else {
        format!("{} more", now - then)
    };
    Some(format!("{then} -> {now} of {of} ({change}{cut})"))
}

/// Ranges: scaled, offset, noisier, or other ones.
fn ranges(pairs: &[Pair<'_>]) -> Option<String> {
    // Of a sonar that lost readings, the rest is not to be told.
    let comparable = pairs
        .iter()
        .filter(|pair| pair.then.stamps.count == pair.now.stamps.count);
    let comparable: Vec<&Pair<'_>> = comparable.collect();
    let other: Vec<&Pair<'_>> = comparable
        .iter()
        .copied()
        .filter(|pair| pair.then.digest != pair.now.digest)
        .collect();
    if other.is_empty() {
        return None;
    }
    let (who, unexplained) = match other.len() {
        n if n == comparable.len() && n > 1 => (format!("of all {n} sonars"), UNEXPLAINED),
        _ => {
            let names: Vec<String> = other.iter().map(|pair| pair.name.to_owned()).collect();
            (format!("of {}", few(&names)), UNEXPLAINED_OF_SOME)
        }
    };
    let silent = other
        .iter()
        .filter(|pair| pair.then.echoes > 0 && pair.now.echoes == 0);
    let silent: Vec<&Pair<'_>> = silent.copied().collect();
    if !silent.is_empty() {
        let echoes: u64 = silent.iter().map(|pair| pair.then.echoes).sum();
        let names: Vec<String> = silent.iter().map(|pair| pair.name.to_owned()).collect();
        return Some(format!("echoes {echoes} -> 0 of {}", few(&names)));
    }
    // Means and spreads, as they were and as they are, with what one offset moves of each.
    let numbers = || {
        other.iter().flat_map(|pair| {
            let (then, now) = (pair.then, pair.now);
            [(then.mean, now.mean, 1.0), (then.spread, now.spread, 0.0)]
        })
    };
    let sum = |of: &dyn Fn((f64, f64, f64)) -> f64| numbers().map(of).sum::<f64>();
    let moved = sum(&|(then, now, _)| (now - then) * (now - then));
    let scale = sum(&|(then, now, _)| then * now) / sum(&|(then, ..)| then * then);
    let offset = sum(&|(then, now, part)| part * (now - then)) / other.len() as f64;
    let unscaled = sum(&|(then, now, _)| (now - scale * then) * (now - scale * then));
    let off = |(then, now, part): (f64, f64, f64)| {
        let rest = now - then - part * offset;
        rest * rest
    };
    let not_offset = sum(&off);
    /// Ranges whose mean moves by less are where they were, metres.
    const STILL: f64 = 1e-3;
    let is_moved = moved > other.len() as f64 * STILL * STILL;
    if is_moved && unscaled.min(not_offset) <= unexplained * moved {
        return Some(match unscaled <= not_offset {
            true => format!(
                "scaled by {scale:.4} ({:+.2} %), {who}",
                (scale - 1.0) * 100.0
            ),
            false => format!("offset by {:+.1} mm, {who}", offset * 1e3),
        });
    }
    let mean = |of: fn(&Pair<'_>) -> f64| {
        other.iter().map(|pair| of(pair)).sum::<f64>() / other.len() as f64
    };
    let (rough, rougher) = (
        mean(|pair| pair.then.roughness),
        mean(|pair| pair.now.roughness),
    );
    let sum = |of: fn(&Pair<'_>) -> u64| other.iter().map(|pair| of(pair)).sum::<u64>();
    let (echoes, now) = (sum(|pair| pair.then.echoes), sum(|pair| pair.now.echoes));
    let mut said = Vec::new();
    /// Ranges are noisier from this share of more roughness on.
    const NOISIER: f64 = 0.2;
    if (rougher - rough).abs() > NOISIER * rough {
        said.push(format!(
            "they scatter by {:.1} -> {:.1} mm from one to the next",
            rough * 1e3,
            rougher * 1e3
        ));
    }
    if echoes != now {
        said.push(format!("echoes {echoes} -> {now}"));
    }
    let (then, now) = (mean(|pair| pair.then.mean), mean(|pair| pair.now.mean));
    /// A mean that moves by less is where it was, metres.
    const SAME: f64 = 5e-5;
    if (now - then).abs() > SAME {
        said.push(format!("mean {then:.4} -> {now:.4} m"));
    } else if said.is_empty() {
        said.push("other ones, with the same mean".to_owned());
    }
    Some(format!("{}, {who}", said.join(", ")))
}

/// Odometry: lost, scaled, begun elsewhere, or driven otherwise.
fn driven(then: &OdometryProfile, now: &OdometryProfile) -> Option<String> {
    let (count, samples) = (then.stamps.count, now.stamps.count);
    if count == samples && then.digest == now.digest {
        return None;
    }
    let mut said = Vec::new();
    if count != samples {
        said.push(format!("{count} -> {samples} samples"));
    }
    let path = format!("path {:.2} -> {:.2} m", then.path, now.path);
    let ratio = |then: f64, now: f64| if then > 0.0 { now / then - 1.0 } else { 0.0 };
    let (longer, turned) = (ratio(then.path, now.path), ratio(then.turned, now.turned));
    let [x, y, yaw] = then.end;
    let [u, v, heading] = now.end;
    let (reach, reached) = (libm::hypot(x, y), libm::hypot(u, v));
    /// A path is scaled where turns, and the end on a way that leads away, agree with that.
    const SCALED: f64 = 1e-3;
    let percent = |share: f64| format!("{:+.2} %", share * 100.0);
    let [before, after] = [then.turned, now.turned].map(f64::to_degrees);
    let in_all = format!("{before:.0} -> {after:.0} deg in all");
    let end_scales = (reached - reach * (1.0 + longer)).abs() <= 0.3 * then.path * longer.abs();
    let is_same = |a: f64, b: f64| (a - b).abs() <= 1e-4;
    let is_same_way = is_same(longer, 0.0)
        && is_same(turned, 0.0)
        && is_same(x, u)
        && is_same(y, v)
        && is_same(wrap_angle(yaw - heading), 0.0);
    let begins_elsewhere = (then.start.iter().zip(now.start)).any(|(a, b)| differs(*a, b));
    if is_same_way && begins_elsewhere {
        let at = |[x, y, yaw]: [f64; 3]| format!("({x:.3}, {y:.3}) m, {:.2} deg", yaw.to_degrees());
        said.push(format!(
            "it begins at {} -> {}, and the map with it; the way is the same",
            at(then.start),
            at(now.start)
        ));
    } else if longer.abs() > SCALED && turned.abs() < 0.2 * longer.abs() && end_scales {
        said.push(format!("distances {} ({path})", percent(longer)));
    } else if turned.abs() > SCALED
        && longer.abs() < 0.1 * turned.abs()
        && turns_scaled(then, now, turned)
    {
        said.push(format!("turns {} ({in_all}; {path})", percent(turned)));
    } else if !is_same_way {
        let off = libm::hypot(u - x, v - y);
        let turn = wrap_angle(heading - yaw).to_degrees();
        let also = match turned.abs() > SCALED {
            true => format!(", turns {in_all}"),
            false => String::new(),
        };
        said.push(format!(
            "{path}{also}, it ends {off:.2} m and {turn:+.1} deg from where it did"
        ));
    } else if said.is_empty() {
        said.push(format!("other poses on the same way, {path}"));
    }
    Some(said.join(", "))
}

/// Whether all turns are wider by a share, as then is what they come to; of that the whole turns are not known. A
/// heading that scatters adds up to more as well, but comes to anything.
fn turns_scaled(then: &OdometryProfile, now: &OdometryProfile, share: f64) -> bool {
    /// Headings that differ by less are the same, radians.
    const SAME: f64 = 1e-3;
    let ([.., net], [.., net_now]) = (then.end, now.end);
    /// Of so many whole turns one way, what is left of them says nothing any more.
    const MOST: f64 = 100.0;
    let most = libm::ceil(then.turned / TAU).min(MOST) as i32;
    let mut nets = (-most..=most).map(|whole| net + f64::from(whole) * TAU);
    nets.any(|net| {
        let is_off = wrap_angle(net_now - (1.0 + share) * net).abs();
        net.abs() <= then.turned + SAME && is_off <= SAME
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A drive of 18 m with five turns by 90 deg, one of them back, of which each is wider by `more`.
    fn drive(more: f64, scatter: f64) -> OdometryProfile {
        let quarter = 90_f64.to_radians() * (1.0 + more);
        OdometryProfile {
            stamps: Stamps::of([0, 100_000_000_000].into_iter()),
            start: [1.0, 1.0, 0.0],
            end: [more, more, wrap_angle(3.0 * quarter + scatter)],
            path: 18.0,
            turned: 5.0 * quarter + 20.0 * scatter,
            digest: format!("{more} {scatter}"),
        }
    }

    #[test]
    fn a_sonar_that_was_moved_has_no_scale() {
        let now = |mean: f64, spread: f64| SonarProfile {
            mean,
            spread,
            digest: "now".to_owned(),
            ..profile()
        };
        let (then, other) = (profile(), profile());
        let said = |now: &SonarProfile| {
            let pairs = [("front", &then, now), ("rear", &other, &other)];
            let pairs = pairs.map(|(name, then, now)| Pair { name, then, now });
            ranges(&pairs).unwrap()
        };
        // Of a log in which the sonar sat 7 cm further back.
        let moved = said(&now(1.163839, 0.63347));
        assert_eq!(moved, "mean 1.1848 -> 1.1638 m, of front");
        let scaled = said(&now(1.184777 * 0.97, 0.639668 * 0.97));
        assert_eq!(scaled, "scaled by 0.9700 (-3.00 %), of front");
        let offset = said(&now(1.184777 + 0.03, 0.639668));
        assert_eq!(offset, "offset by +30.0 mm, of front");
    }

    fn profile() -> SonarProfile {
        SonarProfile {
            mount: [0.2, 0.0, 0.0],
            beam_width: None,
            limits: [None; 2],
            variance: None,
            stamps: Stamps::of(0..17),
            echoes: 17,
            mean: 1.184777,
            spread: 0.639668,
            roughness: 0.2,
            digest: "then".to_owned(),
        }
    }

    #[test]
    fn a_heading_that_scatters_is_no_scale_of_turns() {
        let said = |now: OdometryProfile| driven(&drive(0.0, 0.0), &now).unwrap();
        for more in [0.03, -0.02, 0.4] {
            let scaled = said(drive(more, 0.0));
            let begins = format!("turns {:+.2} % (450 -> ", more * 100.0);
            assert!(scaled.starts_with(&begins), "{scaled}");
        }
        let scattering = said(drive(0.0, 0.07));
        assert_eq!(
            scattering,
            "path 18.00 -> 18.00 m, turns 450 -> 530 deg in all, it ends 0.00 m and +4.0 deg from where it did"
        );
    }
}
