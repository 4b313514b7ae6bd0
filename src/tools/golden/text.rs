//! Differences in words.

use std::path::Path;

use super::difference::{
    Change, Difference, FeatureDifference, LabelChange, LabelRun, Set, State, Value,
};
use super::results::{Feature, Geometry, Labels, Margin, Mark};
use crate::core::geometry::{Vec2, unit};
use crate::core::legible::inert_line;
use crate::core::wording::counted;

/// A difference in one line: what it was, what it is, by how much, and where to look; `recording` is
/// where it can be looked at. Names in it may come from a log, and are made legible.
pub fn describe(difference: &Difference, recording: Option<&Path>) -> String {
    inert_line(&in_words(difference, recording))
}

fn in_words(difference: &Difference, recording: Option<&Path>) -> String {
    match difference {
        Difference::Log { golden, actual } => {
            let short = |digest: &str| digest.get(..12).unwrap_or(digest).to_owned();
            format!(
                "the log does not hold the events that were blessed: sha256 {} -> {}",
                short(golden),
                short(actual)
            )
        }
        Difference::Noise(noise) => format!("range noise: {}", change(noise)),
        Difference::Sonar(sonar) => {
            let changes: Vec<String> = sonar.changes.iter().map(change).collect();
            format!("{}: {}", sonar.sensor, changes.join("; "))
        }
        Difference::Feature(feature) => {
            format!(
                "{}{}",
                feature_text(feature),
                look(feature.frames(), recording)
            )
        }
        Difference::Labels(run) => format!("{}{}", run_text(run), look(run.frames(), recording)),
    }
}

fn look(frames: Option<[u32; 2]>, recording: Option<&Path>) -> String {
    let Some([first, last]) = frames else {
        return String::new();
    };
    let span = in_frames([first, last]);
    match recording {
        Some(path) => format!(", {span}, rerun {} at frame {first}", path.display()),
        None => format!(", {span}"),
    }
}

/// `frame 118` or `frames 118-164`.
pub fn in_frames([first, last]: [u32; 2]) -> String {
    if first == last {
        format!("frame {first}")
    } else {
        format!("frames {first}-{last}")
    }
}

fn feature_text(difference: &FeatureDifference) -> String {
    let Some(feature) = difference.feature() else {
        return "a feature".to_owned();
    };
    let name = name(feature, difference.set);
    match difference.state() {
        State::Missing => format!("{name} is missing{}", place(feature)),
        State::New => format!("{name} is new{}", place(feature)),
        State::Changed => {
            let changes: Vec<String> = difference.changes.iter().map(change).collect();
            format!("{name}: {}", changes.join("; "))
        }
    }
}

fn name(feature: &Feature, set: Set) -> String {
    let kind = feature.kind.name();
    match (set, &feature.sensor) {
        (Set::Map, _) => format!("{kind} {}", feature.id),
        (Set::Extracted, Some(sensor)) => format!("extracted {kind} {} of {sensor}", feature.id),
        (Set::Extracted, None) => format!("extracted {kind} {}", feature.id),
    }
}

fn place(feature: &Feature) -> String {
    let place = match &feature.geometry {
        Some(Geometry::Line {
            rho,
            theta,
            mid,
            half_length,
        }) => {
            let along = unit(theta + std::f64::consts::FRAC_PI_2) * *half_length;
            let mid = Vec2::from(*mid);
            let end = |at: Vec2| format!("({:.3}, {:.3})", at.x + 0.0, at.y + 0.0);
            format!(
                ": rho {rho:.4} m, theta {:.2} deg, {} to {}",
                theta.to_degrees(),
                end(mid + along * -1.0),
                end(mid + along)
            )
        }
        Some(Geometry::Point { x, y }) => format!(": x {x:.4}, y {y:.4} m"),
        None => match &feature.fate {
            Some(fate) => format!(": {fate}"),
            None => String::new(),
        },
    };
    match feature.readings {
        0 => place,
        n => format!("{place}, {}", counted(n.into(), "reading")),
    }
}

/// `rho 1.2043 -> 1.2391 m (+0.0348, tolerance 0.010)`.
fn change(change: &Change) -> String {
    let what = change.what;
    match &change.value {
        Value::Length {
            golden,
            actual,
            delta,
            tolerance,
        } => {
            let tolerance = decimals(*tolerance);
            let n = digits(*delta, &tolerance, 4);
            format!("{what} {golden:.n$} -> {actual:.n$} m ({delta:+.n$}, tolerance {tolerance})")
        }
        Value::Angle {
            golden,
            actual,
            delta,
            tolerance,
        } => {
            let tolerance = decimals(tolerance.to_degrees());
            let [golden, actual, delta] = [golden, actual, delta].map(|x| x.to_degrees());
            let n = digits(delta, &tolerance, 2);
            format!("{what} {golden:.n$} -> {actual:.n$} deg ({delta:+.n$}, tolerance {tolerance})")
        }
        Value::Deviation {
            golden,
            actual,
            delta,
            tolerance,
        } => {
            let tolerance = ((tolerance * 1e4).round() / 100.0).to_string();
            let percent = delta * 100.0;
            let n = digits(percent, &tolerance, 0);
            format!("{what} {golden:.6} -> {actual:.6} ({percent:+.n$} %, tolerance {tolerance} %)")
        }
        Value::Count {
            golden,
            actual,
            tolerance,
        } => format!(
            "{what} {golden} -> {actual} ({:+}, tolerance {tolerance})",
            i64::from(*actual) - i64::from(*golden)
        ),
        Value::Word { golden, actual } => format!("{what} {golden} -> {actual}"),
    }
}

/// How many decimals show that `delta` is more than the tolerance as it is written: `least`, where that
/// is enough.
fn digits(delta: f64, tolerance: &str, least: usize) -> usize {
    const MOST: usize = 7;
    let allowed: f64 = tolerance.parse().unwrap_or_default();
    let shown = |n: usize| format!("{:.n$}", delta.abs()).parse().unwrap_or(f64::NAN);
    (least..MOST).find(|n| shown(*n) > allowed).unwrap_or(MOST)
}

/// Three decimals, or as many as show what there is.
fn decimals(x: f64) -> String {
    if x == 0.0 || x >= 0.0005 {
        format!("{x:.3}")
    } else {
        format!("{x}")
    }
}

fn run_text(run: &LabelRun) -> String {
    let n = run.arcs.len();
    let arcs = counted(n as u64, "arc");
    let sensor = &run.sensor;
    match run.change {
        LabelChange::Flipped {
            golden,
            actual,
            reason,
        } => {
            let why = reason.map_or_else(String::new, |reason| format!(" ({reason})"));
            format!(
                "{sensor}: {arcs} {} -> {}{why}{}",
                golden.name(),
                actual.name(),
                margins(run)
            )
        }
        LabelChange::Gone(mark) => {
            format!("{sensor}: {arcs} gone, {} before{}", mark.name(), at(run))
        }
        LabelChange::New(mark) => format!("{sensor}: {arcs} new, {}{}", mark.name(), at(run)),
    }
}

fn at(run: &LabelRun) -> String {
    run.arcs
        .first()
        .map_or_else(String::new, |arc| format!(", stamp {} ns", arc.stamp_ns))
}

fn margins(run: &LabelRun) -> String {
    let margins = || run.arcs.iter().filter_map(|arc| arc.margin);
    let by_value = |a: &Margin, b: &Margin| a.value().total_cmp(&b.value());
    let (Some(least), Some(most)) = (margins().min_by(by_value), margins().max_by(by_value)) else {
        return String::new();
    };
    let (number, unit): (fn(Margin) -> String, _) = match least {
        Margin::Angle(_) => (
            |margin| format!("{:.3}", margin.value().to_degrees()),
            "deg",
        ),
        Margin::Chi2(_) => (|margin| format!("{:.2}", margin.value()), "chi2"),
    };
    match (number(least), number(most)) {
        (least, most) if least == most => format!(", margin {least} {unit}"),
        (least, most) => format!(", margins {least} to {most} {unit}"),
    }
}

/// How the numbers of labels changed: `contact 240 -> 231, ...`.
pub fn counts(golden: &Labels, actual: &Labels) -> String {
    let (golden, actual) = (golden.counts(), actual.counts());
    Mark::ALL
        .map(|mark| {
            let [then, now] =
                [&golden, &actual].map(|counts| counts.get(&mark).copied().unwrap_or(0));
            match then == now {
                true => format!("{} {now}", mark.name()),
                false => format!("{} {then} -> {now}", mark.name()),
            }
        })
        .join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_just_out_of_tolerance_does_not_read_as_within() {
        let length = |golden: f64, actual: f64| {
            change(&Change {
                what: "rho",
                value: Value::Length {
                    golden,
                    actual,
                    delta: actual - golden,
                    tolerance: 0.01,
                },
            })
        };
        assert_eq!(
            length(0.0071, -0.00294),
            "rho 0.00710 -> -0.00294 m (-0.01004, tolerance 0.010)"
        );
        assert_eq!(
            length(1.2043, 1.2391),
            "rho 1.2043 -> 1.2391 m (+0.0348, tolerance 0.010)"
        );
        let (golden, actual) = (0.0_f64, 0.0100873);
        let angle = Value::Angle {
            golden,
            actual,
            delta: actual,
            tolerance: 0.01,
        };
        let angle = change(&Change {
            what: "theta",
            value: angle,
        });
        assert_eq!(angle, "theta 0.00 -> 0.58 deg (+0.58, tolerance 0.573)");
    }
}
