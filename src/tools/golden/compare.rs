//! Results against results.
//!
//! Features are paired by nearness, never by place in a list. What is identical is paired first. Among
//! the rest, pairs within the gates are chosen so that there are as many as can be and their distances
//! add up to the least.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;

use super::cause::{causes, delays};
use super::difference::{
    Change, ChangeUnit, Comparison, Difference, FeatureDifference, FindingDifference, LabelRun,
    NumberChange, State, StrayedArc,
};
use super::results::{Feature, Geometry, LabelledArc, Labels, Mark, RangeSigma, Results};
use super::tolerance::Tolerance;
use crate::core::assignment::assign;
use crate::core::geometry::{Vec2, unit, wrap_angle};
use crate::core::statistics::seconds;
use crate::core::tmam::label::Kind;
use crate::core::tmam::report::Margin;
use ChangeUnit::{Count, Metres, Radians, Relative};

/// What `actual` has otherwise than `golden`, beyond the tolerance.
///
/// Features are paired by nearness, lines with lines and points with points, never by id or place in a list;
/// labels by sonar and stamp, where both sides have labels. The gravest differences of each kind come first.
pub fn compare(golden: &Results, actual: &Results, tolerance: &Tolerance) -> Comparison {
    let logs = golden.log.as_ref().zip(actual.log.as_ref());
    let labels = golden.labels.as_ref().zip(actual.labels.as_ref());
    let causes = logs.map_or_else(Vec::new, |(then, now)| {
        causes(then, now, labels.map(|(then, now)| [then, now]))
    });
    let mut differences: Vec<Difference> = causes.into_iter().map(Difference::Cause).collect();
    let noise = noise(golden.noise, actual.noise, tolerance);
    differences.extend(noise.map(|change| Difference::Noise { changes: [change] }));
    if let (Some(then), Some(now)) = (&golden.findings, &actual.findings) {
        differences.extend(findings(then, now).map(Difference::Finding));
    }
    let frame_at = |seconds: f64| actual.frame_at(seconds);
    let features = |golden, actual| {
        let mut found: Vec<FeatureDifference> =
            features(golden, actual, tolerance, &frame_at).collect();
        found.sort_by(FeatureDifference::graver_first);
        found.into_iter().map(Box::new)
    };
    differences.extend(features(&golden.map, &actual.map).map(Difference::Map));
    let extracted = features(&golden.extracted, &actual.extracted);
    differences.extend(extracted.map(Difference::Extracted));
    if let Some((golden, actual)) = labels {
        let delays = logs.map_or_else(BTreeMap::new, |(then, now)| delays(then, now));
        let origin = logs.and_then(|(_, now)| now.origin_ns());
        let (mut clear, mut near) = label_runs(golden, actual, &delays, tolerance);
        for run in clear.iter_mut().chain(&mut near) {
            let first = run.arcs.first().map(|arc| arc.stamp_ns);
            run.at = origin.zip(first).map(|(from, to)| seconds(from, to));
        }
        clear.sort_by(LabelRun::graver_first);
        near.sort_by(LabelRun::graver_first);
        differences.extend(clear.into_iter().map(Difference::Labels));
        differences.extend(near.into_iter().map(Difference::Borderline));
    }
    Comparison {
        differences,
        label_counts: labels.map(|(golden, actual)| [golden.counts(), actual.counts()]),
        quality: golden
            .quality
            .zip(actual.quality)
            .map(|(then, now)| [then, now]),
        tolerance: *tolerance,
    }
}

/// What a replay warns of now and did not, and the other way round.
fn findings(
    then: &BTreeMap<String, String>,
    now: &BTreeMap<String, String>,
) -> impl Iterator<Item = FindingDifference> {
    let only = |state, these: &BTreeMap<String, String>, those: &BTreeMap<String, String>| {
        let found = these.iter().filter(|(code, _)| !those.contains_key(*code));
        let found = found.map(|(code, text)| FindingDifference {
            state,
            code: code.clone(),
            text: text.clone(),
        });
        found.collect::<Vec<_>>()
    };
    let new = only(State::New, now, then);
    new.into_iter().chain(only(State::Missing, then, now))
}

/// The change of a number, where it is beyond the tolerance.
fn number(
    what: &'static str,
    unit: ChangeUnit,
    golden: f64,
    actual: f64,
    tolerance: f64,
) -> Option<Change> {
    /// Rounding on either side is no difference.
    const ROUNDING: f64 = 1.5e-6;
    let moved = match unit {
        Radians => wrap_angle(actual - golden),
        _ => actual - golden,
    };
    let (allowed, delta) = match unit {
        Relative => (tolerance * golden.abs(), moved / golden.abs().max(1e-6)),
        _ => (tolerance, moved),
    };
    (moved.abs() > allowed + ROUNDING).then_some(Change::Number(NumberChange {
        what,
        unit,
        golden,
        actual,
        delta,
        tolerance,
    }))
}

fn word(what: &'static str, golden: String, actual: String) -> Change {
    Change::Word {
        what,
        golden,
        actual,
    }
}

/// How the noise differs, where both sides record it.
fn noise(golden: RangeSigma, actual: RangeSigma, tolerance: &Tolerance) -> Option<Change> {
    let words = |noise| match noise {
        RangeSigma::Measured(sigma) => format!("measured {:.1} mm", sigma * 1e3),
        _ => "said by messages or configuration".to_owned(),
    };
    match (golden, actual) {
        (RangeSigma::Measured(then), RangeSigma::Measured(now)) => {
            number("measured sigma", Relative, then, now, tolerance.sigma)
        }
        (RangeSigma::Unknown, _) | (_, RangeSigma::Unknown) => None,
        (then, now) => (then != now).then(|| word("noise", words(then), words(now))),
    }
}

/// Features that changed or are missing, in the order of `golden`, then the new ones.
fn features<'a>(
    golden: &'a [Feature],
    actual: &'a [Feature],
    tolerance: &'a Tolerance,
    frame_at: &'a dyn Fn(f64) -> Option<u32>,
) -> impl Iterator<Item = FeatureDifference> {
    let partners: BTreeMap<usize, usize> = pairs(golden, actual, tolerance).into_iter().collect();
    let paired: BTreeSet<usize> = partners.values().copied().collect();
    let known = golden
        .iter()
        .enumerate()
        .filter_map(move |(place, feature)| {
            let partner = partners.get(&place).and_then(|place| actual.get(*place));
            let changes = partner.map(|partner| changes(feature, partner, tolerance));
            if changes.as_ref().is_some_and(Vec::is_empty) {
                return None;
            }
            FeatureDifference::new(
                Some(feature),
                partner,
                changes.unwrap_or_default(),
                frame_at,
            )
        });
    let unpaired = actual.iter().enumerate();
    let unpaired = unpaired.filter(move |(place, _)| !paired.contains(place));
    known.chain(
        unpaired.filter_map(move |(_, new)| {
            FeatureDifference::new(None, Some(new), Vec::new(), frame_at)
        }),
    )
}

/// Results to be held from now on: what is within tolerance stays as it was written.
pub fn settled(golden: &Results, actual: Results, tolerance: &Tolerance) -> Results {
    let settle = |golden: &[Feature], actual: &[Feature]| {
        let mut settled = actual.to_vec();
        for (was, is) in pairs(golden, actual, tolerance) {
            if let (Some(was), Some(is)) = (golden.get(was), settled.get_mut(is))
                && changes(was, is, tolerance).is_empty()
                // Files from before hold no times.
                && was.seconds.is_some() == is.seconds.is_some()
            {
                *is = was.clone();
            }
        }
        settled
    };
    let known = golden.findings.clone().unwrap_or_default();
    let findings = actual.findings.map(|found| {
        let settled = found.into_iter().map(|(code, text)| {
            let text = known.get(&code).cloned().unwrap_or(text);
            (code, text)
        });
        settled.collect()
    });
    Results {
        map: settle(&golden.map, &actual.map),
        extracted: settle(&golden.extracted, &actual.extracted),
        findings,
        ..actual
    }
}

/// What moved beyond its tolerance between a feature and its partner.
fn changes(golden: &Feature, actual: &Feature, tolerance: &Tolerance) -> Vec<Change> {
    let (extent, position) = (tolerance.extent, tolerance.position);
    let moved = match (&golden.geometry, &actual.geometry) {
        (Geometry::Line(then), Geometry::Line(now)) => {
            let (rho, theta) = now.signed_like(then.theta);
            let half = then.half_length;
            let along = |mid: [f64; 2]| unit(then.theta + FRAC_PI_2).dot(&Vec2::from(mid));
            vec![
                number("rho", Metres, then.rho, rho, tolerance.rho),
                number("theta", Radians, then.theta, theta, tolerance.theta),
                number("middle", Metres, along(then.mid), along(now.mid), extent),
                number("half length", Metres, half, now.half_length, extent),
            ]
        }
        (Geometry::Point { x, y }, Geometry::Point { x: u, y: v }) => vec![
            number("x", Metres, *x, *u, position),
            number("y", Metres, *y, *v, position),
        ],
        (
            Geometry::Circle { x, y, radius },
            Geometry::Circle {
                x: u,
                y: v,
                radius: r,
            },
        ) => vec![
            number("x", Metres, *x, *u, position),
            number("y", Metres, *y, *v, position),
            number("radius", Metres, *radius, *r, position),
        ],
        _ => Vec::new(),
    };
    let mut changes: Vec<Change> = moved.into_iter().flatten().collect();
    let names = match golden.kind() {
        Kind::Line => ["sigma rho", "sigma theta"],
        Kind::Point => ["sigma x", "sigma y"],
        Kind::Circle => ["sigma centre", "sigma radius"],
    };
    // Of a feature that moved, nobody wants to read that its covariance moved, too.
    if let (true, Some(then), Some(now)) = (changes.is_empty(), golden.sigma, actual.sigma) {
        for ((what, then), now) in names.into_iter().zip(then).zip(now) {
            changes.extend(number(what, Relative, then, now, tolerance.sigma));
        }
    }
    let [then, now, readings] =
        [golden.readings, actual.readings, tolerance.readings].map(f64::from);
    changes.extend(number("readings", Count, then, now, readings));
    if golden.fate != actual.fate {
        let fate = |fate: &Option<String>| fate.clone().unwrap_or_else(|| "unknown".to_owned());
        changes.push(word("outcome", fate(&golden.fate), fate(&actual.fate)));
    }
    changes
}

/// Frames that may lie between the runs of an extracted feature and of its partner, and seconds.
const APART: (f64, f64) = (10.0, 5.0);

/// Pairs of places in the two lists.
pub fn pairs(golden: &[Feature], actual: &[Feature], tolerance: &Tolerance) -> Vec<(usize, usize)> {
    let mut found = identical(golden, actual);
    let (rows, columns): (BTreeSet<usize>, BTreeSet<usize>) = found.iter().copied().unzip();
    let free = |features: &'_ [Feature], taken: &BTreeSet<usize>| -> Vec<usize> {
        (0..features.len())
            .filter(|place| !taken.contains(place))
            .collect()
    };
    let columns = free(actual, &columns);
    let mut costs = Vec::new();
    for row in free(golden, &rows) {
        for column in &columns {
            if let (Some(g), Some(a)) = (golden.get(row), actual.get(*column))
                && let Some(cost) = distance(g, a, tolerance)
            {
                costs.push((row, *column, cost));
            }
        }
    }
    found.extend(assign(golden.len(), actual.len(), &costs));
    found.sort_unstable();
    found
}

/// Features that did not change at all.
fn identical(golden: &[Feature], actual: &[Feature]) -> Vec<(usize, usize)> {
    let key = |f: &Feature| {
        let (geometry, sensor, fate) = (f.geometry, &f.sensor, &f.fate);
        (!f.is_unfitted()).then(|| {
            let (seconds, readings) = (f.seconds, f.readings);
            format!("{geometry:?} {sensor:?} {seconds:?} {fate:?} {readings}")
        })
    };
    let mut waiting = BTreeMap::<String, Vec<usize>>::new();
    for (place, feature) in actual.iter().enumerate().rev() {
        if let Some(key) = key(feature) {
            waiting.entry(key).or_default().push(place);
        }
    }
    let mut partner = |feature: &Feature| waiting.get_mut(&key(feature)?)?.pop();
    let paired = golden.iter().enumerate();
    paired
        .filter_map(|(place, feature)| Some((place, partner(feature)?)))
        .collect()
}

/// How far apart two features are, in gates; `None` where they cannot be one.
fn distance(golden: &Feature, actual: &Feature, tolerance: &Tolerance) -> Option<f64> {
    if golden.kind() != actual.kind() || golden.sensor != actual.sensor {
        return None;
    }
    let apart = match (
        (golden.seconds, actual.seconds),
        (golden.frames, actual.frames),
    ) {
        _ if golden.sensor.is_none() => 0.0,
        ((Some(g), Some(a)), _) => apart(g, a, APART.1)?,
        (_, (Some(g), Some(a))) => apart(g.map(f64::from), a.map(f64::from), APART.0)?,
        _ => 0.0,
    };
    let gate = |way: f64, gate: f64| {
        let part = if gate > 0.0 {
            way.abs() / gate
        } else {
            way.abs() * f64::INFINITY
        };
        (part <= 1.0).then_some(part * part)
    };
    let near = match (&golden.geometry, &actual.geometry) {
        (Geometry::Line(then), Geometry::Line(now)) => {
            let (rho, theta) = now.signed_like(then.theta);
            let way = Vec2::from(now.mid) - Vec2::from(then.mid);
            let reach = then.half_length + now.half_length + tolerance.pair_distance;
            gate(rho - then.rho, tolerance.pair_distance)?
                + gate(wrap_angle(theta - then.theta), tolerance.pair_angle)?
                + gate(unit(then.theta + FRAC_PI_2).dot(&way), reach)?
        }
        (Geometry::Point { x, y }, Geometry::Point { x: u, y: v }) => {
            gate(libm::hypot(u - x, v - y), tolerance.pair_distance)?
        }
        (
            Geometry::Circle { x, y, radius },
            Geometry::Circle {
                x: u,
                y: v,
                radius: r,
            },
        ) => {
            gate(libm::hypot(u - x, v - y), tolerance.pair_distance)?
                + gate(r - radius, tolerance.pair_distance)?
        }
        (Geometry::Unfitted { .. }, Geometry::Unfitted { .. }) => 0.0,
        _ => return None,
    };
    Some(near + apart)
}

/// How far two runs lie apart, as a part of what may be: their gap must be small, and of two runs
/// that could be meant the one that begins and ends alike is.
fn apart([a, b]: [f64; 2], [c, d]: [f64; 2], most: f64) -> Option<f64> {
    let gap = (c - b).max(a - d);
    (gap <= most).then(|| ((a - c).abs() + (b - d).abs()).min(200.0 * most) / (10.0 * most))
}

/// The labels that differ, and those that flipped with less than the tolerance to spare. An arc is
/// known by its sonar and its stamp, which may come later than it did.
fn label_runs(
    golden: &Labels,
    actual: &Labels,
    delays: &BTreeMap<String, i64>,
    tolerance: &Tolerance,
) -> (Vec<LabelRun>, Vec<LabelRun>) {
    let (mut clear, mut near): (Vec<LabelRun>, Vec<LabelRun>) = Default::default();
    let sonars: BTreeSet<&String> = golden.sonars.keys().chain(actual.sonars.keys()).collect();
    for sonar in sonars {
        let arcs = |labels: &'_ Labels| labels.sonars.get(sonar).cloned().unwrap_or_default();
        // An arc goes on with a run only where the one before it did the same.
        let mut going = None;
        let mut before = arcs(golden);
        let delay = delays.get(sonar).copied().unwrap_or_default();
        for arc in &mut before {
            arc.stamp_ns = arc.stamp_ns.saturating_add(delay);
        }
        for (then, now) in by_stamp(&before, &arcs(actual)) {
            let [was, is]: [Option<Mark>; 2] = [then, now].map(|arc| arc.map(|arc| arc.mark));
            let Some(arc) = now.or(then).filter(|_| was != is) else {
                going = None;
                continue;
            };
            let flipped = was.is_some() && is.is_some();
            let margin = arc.margin.filter(|_| flipped);
            let is_near = margin.is_some_and(|margin| is_borderline(margin, tolerance));
            let change = (was, is, arc.reason.filter(|_| flipped), is_near);
            let runs = if is_near { &mut near } else { &mut clear };
            if going != Some(change) {
                runs.push(LabelRun {
                    state: State::of(&was, &is),
                    sensor: sonar.clone(),
                    golden: was,
                    actual: is,
                    reason: change.2,
                    frames: None,
                    at: None,
                    arcs: Vec::new(),
                });
            }
            let frame = arc.frame.or_else(|| actual.frame_at(arc.stamp_ns));
            if let Some(run) = runs.last_mut() {
                run.push(StrayedArc::new(arc.stamp_ns, frame, margin));
            }
            going = Some(change);
        }
    }
    (clear, near)
}

fn is_borderline(margin: Margin, tolerance: &Tolerance) -> bool {
    match margin {
        Margin::Angle(radians) => radians.abs() < tolerance.borderline,
        Margin::Chi2(chi2) => chi2.abs() < tolerance.borderline_chi2,
    }
}

/// The arcs of two lists, those of one stamp together.
fn by_stamp(
    golden: &[LabelledArc],
    actual: &[LabelledArc],
) -> Vec<(Option<LabelledArc>, Option<LabelledArc>)> {
    let (mut golden, mut actual) = (golden.iter().peekable(), actual.iter().peekable());
    let mut pairs = Vec::new();
    loop {
        let order = match (golden.peek(), actual.peek()) {
            (Some(g), Some(a)) => g.stamp_ns.cmp(&a.stamp_ns),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) => return pairs,
        };
        pairs.push((
            golden.next_if(|_| order.is_le()).copied(),
            actual.next_if(|_| order.is_ge()).copied(),
        ));
    }
}

#[cfg(test)]
mod tests;
