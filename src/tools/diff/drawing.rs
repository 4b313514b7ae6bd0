//! Differences to look at: over the run of B where that is a log, else both maps over each other.

use std::io::Write;

use super::{Diff, DiffError, Side};
use crate::core::legible::inert_line;
use crate::core::replay::{Replay, ReplayError};
use crate::observe::drawing::{DrawnPair, Overlay};
use crate::observe::recording::{Recording, write_pairs};
use crate::tools::golden::{carried, drawn, headlines, notes, sections, sketched};

/// Lines of a section on the page beside the maps, at most.
const LISTED: usize = 20;

/// Writes the recording of these comparisons.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write(all: &[Diff], mut out: impl Write + Send) -> Result<(), DiffError> {
    let [
        Diff {
            b: Side { run: Some(run), .. },
            ..
        },
    ] = all
    else {
        let pairs: Vec<DrawnPair> = all.iter().map(Diff::pair).collect();
        return Ok(write_pairs(out, &pairs)?);
    };
    let over = all.iter().map(Diff::over).next().unwrap_or_default();
    let replay = Replay::new(&run.log, &run.config)?;
    let setting = replay.setting();
    let mut recording = Recording::new(Some(&mut out), None, setting, over)?;
    run.kept.show(&mut recording).map_err(ReplayError::from)?;
    let carried = carried(&setting, &run.outcome)?;
    recording.close(Some(&carried))?;
    Ok(())
}

impl Diff {
    /// What of A is drawn over the run of B.
    fn over(&self) -> Overlay {
        Overlay {
            notes: notes(&self.b.results, &self.found),
            about: format!(
                "## Differences of B, which is this run, from A\n\n{}\n\
                 The recording opens at the first, and the events list all as *DIFFERS*.\n\n\
                 | colour | what |\n|---|---|\n\
                 | dark teal | the map of A |\n\
                 | bright teal | of that map, what moved or is missing in B |\n\
                 | magenta | what moved or is new in B; arcs whose label changed, in their frame |\n\n",
                self.page()
            ),
            ..drawn(&self.a.results.map, &self.found)
        }
    }

    /// Both maps.
    fn pair(&self) -> DrawnPair {
        let name = |side: &Side| {
            let name = side.path.file_name().unwrap_or(side.path.as_os_str());
            inert_line(&name.to_string_lossy())
        };
        let [a, b] = [&self.a, &self.b].map(name);
        DrawnPair {
            title: if a == b { a } else { format!("{a} and {b}") },
            page: self.page(),
            b: self.b.results.map.iter().filter_map(sketched).collect(),
            over: drawn(&self.a.results.map, &self.found),
        }
    }

    /// The two sides, and what differs (Markdown).
    fn page(&self) -> String {
        let path = |side: &Side| inert_line(&side.path.display().to_string());
        let [a, b] = [&self.a, &self.b].map(path);
        let mut page = format!("A: `{a}`  \nB: `{b}`\n\n");
        let lines = headlines(&self.found, None).into_iter();
        let notes = self.notes.iter().map(|note| format!("note: {note}"));
        for line in lines.chain(notes) {
            page += &format!("- {line}\n");
        }
        let sections = sections(&self.found, true);
        for section in sections.iter().filter(|section| section.name != "cause") {
            page += &format!("\n```text\n{}```\n", section.listed(LISTED));
        }
        if sections.is_empty() {
            page += "\nNothing differs beyond the tolerances.\n";
        }
        page
    }
}
