//! What to draw over the run of a log that differs, and how much of the run.

use std::fmt::Write as _;

use crate::core::wording::counted;
use crate::observe::drawing::Overlay;
use crate::tools::golden::{Comparison, Difference, Golden, Results, drawn, headlines, notes};

/// What to draw over the run of a log that differs.
pub fn overlay(
    golden: &Golden,
    actual: &Results,
    found: &Comparison,
    around: Option<u32>,
) -> Overlay {
    // What is in no frame, as another log's events, is looked for in all of them.
    let mut failing = found.differences.iter().filter(|one| one.fails(true));
    let everywhere = failing.any(|one| one.frames().is_none());
    let only = around
        .filter(|_| !everywhere)
        .map(|around| windows(found, around))
        .filter(|windows| !windows.is_empty());
    Overlay {
        notes: notes(actual, found),
        about: about(golden, found, around, only.is_some()),
        only,
        ..drawn(&golden.results.map, found)
    }
}

/// The frames of the differences, and `around` more on either side.
fn windows(found: &Comparison, around: u32) -> Vec<[u32; 2]> {
    let frames = found.differences.iter().filter_map(Difference::frames);
    // A wall that was seen all along is shown where it begins and where it ends.
    let mut windows: Vec<[u32; 2]> = (frames.flatten())
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

fn about(golden: &Golden, found: &Comparison, around: Option<u32>, narrowed: bool) -> String {
    let clear = found.differences.iter().filter(|one| one.fails(false));
    let mut text = format!(
        "## Differences from the golden file\n\n{}\n\
         **{}**, listed as *DIFFERS* in the events; the recording opens at the first. \
         The golden file was blessed with tmam {}.\n\n\
         | colour | what |\n|---|---|\n\
         | dark teal | the map of the golden file |\n\
         | bright teal | of that map, what moved or is missing, as it was |\n\
         | magenta | what moved or is new, as it is; arcs whose label changed, in their frame |\n\n\
         The time cursor is held at the first difference by a loop over that frame: drag it, or turn the loop off to play.\n\n",
        headlines(found, None)
            .iter()
            .map(|line| format!("- {line}\n"))
            .collect::<String>(),
        counted(clear.count() as u64, "difference"),
        golden.written_by.version,
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
    use crate::observe::drawing::Sketched;
    use crate::tools::golden::{Feature, LabelRun, Mark, State, StrayedArc, Tolerance, compare};

    #[test]
    fn only_what_is_elsewhere_is_drawn_as_that_by_its_place() {
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
        let golden = Golden::new(None, Tolerance::default(), then);
        let over = overlay(&golden, &actual, &comparison, None);
        let names = |all: &[Sketched]| all.iter().map(|one| one.name.clone()).collect::<Vec<_>>();
        let at = |y: f64| format!("line (0.00, {y:.2}) to (4.00, {y:.2}) m");
        assert_eq!(names(&over.before), [at(9.0), at(1.0)]);
        assert_eq!(names(&over.now), [at(-5.0), at(1.05)]);
    }

    #[test]
    fn differences_in_no_frame_are_shown_in_all_of_them() {
        let golden = Golden::new(None, Tolerance::default(), Results::default());
        let mut comparison = Comparison::default();
        comparison.differences.push(Difference::Requirement {
            text: String::new(),
        });
        let shown = |comparison: &Comparison| {
            let over = overlay(&golden, &Results::default(), comparison, Some(2));
            assert_eq!(over.about.contains("Only 2 frames"), !over.shows(0));
            assert_eq!(over.about.contains("All frames"), over.shows(0));
            [0, 500, 999].map(|frame| over.shows(frame))
        };
        assert_eq!(shown(&comparison), [true; 3]);
        let labels = Difference::Labels(LabelRun {
            state: State::New,
            sensor: "left".to_owned(),
            golden: None,
            actual: Some(Mark::Contact),
            reason: None,
            frames: Some([500, 500]),
            at: None,
            arcs: vec![StrayedArc::new(0, Some(500), None)],
        });
        // Nor does one that is in a frame beside them hide them.
        comparison.differences.push(labels);
        assert_eq!(shown(&comparison), [true; 3]);
        comparison.differences.remove(0);
        assert_eq!(shown(&comparison), [false, true, false]);
    }
}
