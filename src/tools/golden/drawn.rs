//! Differences as something to draw.

use std::collections::BTreeMap;

use super::difference::{Comparison, Difference};
use super::results::{Feature, Geometry, Results};
use super::text::describe;
use crate::core::event::{Sonar, name_of};
use crate::core::replay::Outcome;
use crate::core::tmam::arc::Arc;
use crate::observe::drawing::{Overlay, Sketched};

/// More differences than this are counted, not listed.
const MOST_NOTES: usize = 500;

/// A map, and over it what differs from it; the gravest first.
pub fn drawn(golden: &[Feature], found: &Comparison) -> Overlay {
    let before = found.elsewhere().filter_map(|one| one.golden.as_ref());
    let now = found.elsewhere().filter_map(|one| one.actual.as_ref());
    Overlay {
        golden: golden.iter().filter_map(sketched).collect(),
        before: before.filter_map(sketched).collect(),
        now: now.filter_map(sketched).collect(),
        labels: labels(found),
        first_frame: found.first_frame(),
        ..Overlay::default()
    }
}

/// What of the map is elsewhere by most, as it is, or as it was where it is missing.
pub fn farthest(found: &Comparison) -> Option<Sketched> {
    let gravest = found.elsewhere().next()?;
    sketched(gravest.actual.as_ref().or(gravest.golden.as_ref())?)
}

/// The arcs of a run whose label changed.
pub fn relabelled(overlay: &Overlay, sonars: &[Sonar], outcome: &Outcome) -> Vec<Arc> {
    let arcs = outcome.reports.iter().map(|report| report.arc);
    let is_marked = |arc: &Arc| {
        let sonar = name_of(sonars, arc.id.sonar).to_owned();
        overlay.labels.contains_key(&(arc.id.frame, sonar))
    };
    arcs.filter(is_marked).collect()
}

/// A feature to be drawn, where it is somewhere.
pub fn sketched(feature: &Feature) -> Option<Sketched> {
    Some(Sketched {
        ends: feature.geometry.ends()?,
        is_point: matches!(feature.geometry, Geometry::Point { .. }),
        radius: match feature.geometry {
            Geometry::Circle { radius, .. } => radius,
            _ => 0.0,
        },
        name: feature.place(),
    })
}

/// What became of the label of an arc, by frame and sonar.
fn labels(found: &Comparison) -> BTreeMap<(u32, String), String> {
    let mut marks = BTreeMap::new();
    for run in found.differences.iter().filter_map(Difference::labels) {
        let what = match (run.golden, run.actual) {
            (Some(then), Some(now)) => format!("{} -> {}", then.name(), now.name()),
            (None, Some(now)) => format!("new, {}", now.name()),
            (_, None) => continue,
        };
        for frame in run.arcs.iter().filter_map(|arc| arc.frame) {
            marks.insert((frame, run.sensor.clone()), what.clone());
        }
    }
    marks
}

/// A line of the event log for every difference, at its frame and the stamp of that.
pub fn notes(actual: &Results, found: &Comparison) -> Vec<(u32, i64, String)> {
    let stamps = actual.labels.iter().flat_map(|labels| &labels.frame_stamps);
    let stamps: Vec<i64> = stamps.copied().collect();
    let Some(last) = stamps.last() else {
        return Vec::new();
    };
    let note = |frame: u32, text: String| {
        let at = usize::try_from(frame).unwrap_or(usize::MAX);
        (frame, *stamps.get(at).unwrap_or(last), text)
    };
    let mut notes: Vec<(u32, i64, String)> = (found.differences.iter().take(MOST_NOTES))
        .map(|one| {
            let frame = one.frames().map_or(0, |[first, _]| first);
            let how = if one.is_borderline() {
                "borderline: "
            } else {
                ""
            };
            note(frame, format!("DIFFERS {how}{}", describe(one)))
        })
        .collect();
    notes.sort_by_key(|(frame, ..)| *frame);
    let all = found.differences.len();
    if all > MOST_NOTES {
        let text = format!("DIFFERS in {all} places; {MOST_NOTES} of them are listed");
        notes.insert(0, note(0, text));
    }
    notes
}
