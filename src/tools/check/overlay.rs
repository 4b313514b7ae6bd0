//! Differences as something to draw.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use crate::core::geometry::{Vec2, unit};
use crate::core::wording::counted;
use crate::observe::drawing::{Overlay, Sketched};
use crate::tools::golden::{
    Comparison, Difference, Feature, FeatureDifference, Geometry, Golden, LabelChange, LabelRun,
    Results, Set, describe,
};

/// More differences than this are counted, not listed.
const MOST_NOTES: usize = 500;

/// What to draw over the run of a log that differs.
pub fn overlay(
    golden: &Golden,
    actual: &Results,
    comparison: &Comparison,
    around: Option<u32>,
) -> Overlay {
    let elsewhere = || (comparison.features(Set::Map)).filter(|one| one.is_elsewhere());
    // What is in no frame, as another log's events, is looked for in all of them.
    let everywhere = (comparison.differences.iter()).any(|one| one.frames().is_none());
    let only = around
        .filter(|_| !everywhere)
        .map(|around| windows(comparison, around))
        .filter(|windows| !windows.is_empty());
    Overlay {
        golden: golden.results.map.iter().filter_map(sketched).collect(),
        before: elsewhere()
            .filter_map(|one| sketched(one.golden.as_ref()?))
            .collect(),
        now: elsewhere().filter_map(now).collect(),
        labels: labels(comparison),
        notes: notes(actual, comparison),
        first_frame: comparison.first_frame().or(Some(0)),
        about: about(golden, comparison, around, only.is_some()),
        only,
        truth: None,
    }
}

/// A feature as it is, by the name that the differences give it: that of the golden file.
fn now(one: &FeatureDifference) -> Option<Sketched> {
    let now = one.actual.as_ref()?;
    let sketched = sketched(now)?;
    let name = match &one.golden {
        Some(golden) if golden.id != now.id => {
            format!("{} {} (now {})", golden.kind.name(), golden.id, now.id)
        }
        _ => sketched.name,
    };
    Some(Sketched { name, ..sketched })
}

fn sketched(feature: &Feature) -> Option<Sketched> {
    let ends = match feature.geometry.as_ref()? {
        Geometry::Line {
            theta,
            mid,
            half_length,
            ..
        } => {
            let along = unit(theta + FRAC_PI_2) * *half_length;
            [Vec2::from(*mid) - along, Vec2::from(*mid) + along]
        }
        Geometry::Point { x, y } => [Vec2::new(*x, *y); 2],
    };
    Some(Sketched {
        ends,
        is_point: matches!(feature.geometry, Some(Geometry::Point { .. })),
        name: format!("{} {}", feature.kind.name(), feature.id),
    })
}

fn labels(comparison: &Comparison) -> BTreeMap<(u32, String), String> {
    let mut marks = BTreeMap::new();
    for run in comparison.labels().chain(&comparison.borderline) {
        let what = match run.change {
            LabelChange::Flipped { golden, actual, .. } => {
                format!("{} -> {}", golden.name(), actual.name())
            }
            LabelChange::New(mark) => format!("new, {}", mark.name()),
            LabelChange::Gone(_) => continue,
        };
        for frame in run.arcs.iter().filter_map(|arc| arc.frame) {
            marks.insert((frame, run.sensor.clone()), what.clone());
        }
    }
    marks
}

fn notes(actual: &Results, comparison: &Comparison) -> Vec<(u32, i64, String)> {
    let stamp = |frame: u32| {
        let stamps = actual
            .labels
            .as_ref()
            .map(|labels| labels.frame_stamps.as_slice());
        let at = usize::try_from(frame).unwrap_or(usize::MAX);
        stamps
            .and_then(|stamps| stamps.get(at).or(stamps.last()))
            .copied()
    };
    let at = |frames: Option<[u32; 2]>| {
        let frame = frames.map_or(0, |[first, _]| first);
        Some((frame, stamp(frame)?))
    };
    let borderline = |run: &LabelRun| Difference::Labels(run.clone());
    let near: Vec<Difference> = comparison.borderline.iter().map(borderline).collect();
    let clear = comparison.differences.iter().map(|one| (one, ""));
    let mut notes: Vec<(u32, i64, String)> = clear
        .chain(near.iter().map(|one| (one, "borderline: ")))
        .take(MOST_NOTES)
        .filter_map(|(one, how)| {
            let (frame, stamp_ns) = at(one.frames())?;
            Some((
                frame,
                stamp_ns,
                format!("DIFFERS {how}{}", describe(one, None)),
            ))
        })
        .collect();
    notes.sort_by_key(|(frame, ..)| *frame);
    let all = comparison.differences.len() + comparison.borderline.len();
    if let (Some((frame, stamp_ns)), true) = (at(None), all > MOST_NOTES) {
        let text = format!("DIFFERS in {all} places; {MOST_NOTES} of them are listed");
        notes.insert(0, (frame, stamp_ns, text));
    }
    notes
}

/// The frames of the differences, and `around` more on either side.
fn windows(comparison: &Comparison, around: u32) -> Vec<[u32; 2]> {
    let near = comparison.borderline.iter().filter_map(LabelRun::frames);
    let clear = comparison.differences.iter().filter_map(Difference::frames);
    let mut windows: Vec<[u32; 2]> = clear
        .chain(near)
        // A wall that was seen all along is shown where it begins and where it ends.
        .flatten()
        .map(|frame| [frame.saturating_sub(around), frame.saturating_add(around)])
        .collect();
    windows.sort_unstable();
    let mut merged: Vec<[u32; 2]> = Vec::new();
    for [first, last] in windows {
        match merged.last_mut() {
            Some([_, end]) if first <= end.saturating_add(1) => *end = last.max(*end),
            _ => merged.push([first, last]),
        }
    }
    merged
}

fn about(golden: &Golden, comparison: &Comparison, around: Option<u32>, narrowed: bool) -> String {
    let mut text = format!(
        "## Differences from the golden file\n\n\
         **{}**, listed as *DIFFERS* in the events; the recording opens at the first. \
         The golden file was blessed with tmam {}.\n\n\
         | colour | what |\n|---|---|\n\
         | dark teal | the map of the golden file |\n\
         | bright teal | of that map, what moved or is missing, as it was |\n\
         | magenta | what moved or is new, as it is; arcs whose label changed, in their frame |\n\n\
         The time cursor is held at the first difference by a loop over that frame: drag it, or turn the loop off to play.\n\n",
        counted(comparison.differences.len() as u64, "difference"),
        golden.tool.version,
    );
    // Writing to a string cannot fail.
    let _ = match around {
        Some(around) if narrowed => write!(
            text,
            "Only {around} frames around the ends of each difference are recorded; the map is complete.\n\n"
        ),
        Some(_) => text.write_str(
            "All frames are recorded, for a difference is in none of its own: of a sonar or of the log's events.\n\n",
        ),
        None => Ok(()),
    };
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::golden::{Mark, StrayedArc, Tolerance, compare};

    #[test]
    fn only_what_is_elsewhere_is_drawn_as_that_and_by_the_name_in_the_text() {
        let wall = |id, y, readings| Feature {
            id,
            readings,
            ..Feature::wall([0.0, y], [4.0, y])
        };
        let results = |map| Results {
            map,
            ..Results::default()
        };
        let then = results(vec![
            wall(10, 1.0, 20),
            wall(11, 3.0, 20),
            wall(12, 9.0, 20),
        ]);
        let actual = results(vec![
            wall(11, 1.05, 20),
            wall(12, 3.0, 40),
            wall(13, -5.0, 20),
        ]);
        let comparison = compare(&then, &actual, &Tolerance::default());
        assert_eq!(comparison.differences.len(), 4);
        let golden = Golden::new(None, None, Tolerance::default(), then);
        let over = overlay(&golden, &actual, &comparison, None);
        let names = |all: &[Sketched]| all.iter().map(|one| one.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&over.before), ["line 10", "line 12"]);
        assert_eq!(names(&over.now), ["line 10 (now 11)", "line 13"]);
    }

    #[test]
    fn differences_in_no_frame_are_shown_in_all_of_them() {
        let golden = Golden::new(None, None, Tolerance::default(), Results::default());
        let mut comparison = Comparison::default();
        let log = || String::new();
        comparison.differences.push(Difference::Log {
            golden: log(),
            actual: log(),
        });
        let shown = |comparison: &Comparison| {
            let over = overlay(&golden, &Results::default(), comparison, Some(2));
            assert_eq!(over.about.contains("Only 2 frames"), !over.shows(0));
            assert_eq!(over.about.contains("All frames"), over.shows(0));
            [0, 500, 999].map(|frame| over.shows(frame))
        };
        assert_eq!(shown(&comparison), [true; 3]);
        let arc = StrayedArc {
            stamp_ns: 0,
            frame: Some(500),
            margin: None,
        };
        let labels = Difference::Labels(LabelRun {
            sensor: "left".to_owned(),
            change: LabelChange::New(Mark::Contact),
            arcs: vec![arc],
        });
        // Nor does one that is in a frame beside them hide them.
        comparison.differences.push(labels);
        assert_eq!(shown(&comparison), [true; 3]);
        comparison.differences.remove(0);
        assert_eq!(shown(&comparison), [false, true, false]);
    }
}
