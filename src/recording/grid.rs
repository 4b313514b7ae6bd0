//! A sweep to look at: a heat map for every pair of keys, or curves over a single one.

mod curve;
mod drawing;
mod heat;
mod layout;

use std::io::Write;

use rerun::TextDocument;

use super::Error;
use super::encode::RrdWriter;
use super::names::{fnv1a, named_ids};
use super::origin::Origin;
use super::table::put_static;
use crate::sweep::columns::{Column, columns};
use crate::sweep::{Sweep, json};
use drawing::Drawing;

/// Pictures of one pair of keys.
const MOST_PICTURES: usize = 4;
/// Pairs of keys that are drawn.
const MOST_PAIRS: usize = 6;
/// Cells in the table beside the pictures.
const ROWS: usize = 25;

/// Pictures that belong together, and what they are of.
struct Group {
    name: String,
    pictures: Vec<Picture>,
}

/// One picture under its title.
struct Picture {
    title: String,
    drawing: Drawing,
}

/// Writes the recording of a sweep.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write<W: Write>(out: W, sweep: &Sweep) -> Result<(), Error> {
    let mut content = Vec::new();
    json::write(&mut content, sweep)?;
    let [recording, blueprint] = named_ids(
        "tmam-sweep",
        &sweep.file,
        format!("sweep-{:016x}", fnv1a(&content)),
    );
    let mut out = RrdWriter::new(out, None, recording, blueprint, 0, Origin::default())?;
    put_static("/about", &about(sweep), &mut out)?;
    let groups = groups(sweep);
    for (place, picture) in groups.iter().flat_map(|group| &group.pictures).enumerate() {
        picture.drawing.put(&layout::entity(place), &mut out)?;
    }
    layout::put(&groups, &mut out)?;
    out.finish()?;
    Ok(())
}

/// What is drawn: of every pair of keys with several values, or of the only one.
fn groups(sweep: &Sweep) -> Vec<Group> {
    let axes = sweep.grid.axes();
    let swept: Vec<usize> = (0..axes.len())
        .filter(|axis| axes.get(*axis).is_some_and(|axis| axis.values.len() > 1))
        .collect();
    let pictures = |draw: &dyn Fn(&'static Column) -> Option<Picture>| {
        drawn(sweep).into_iter().filter_map(draw).collect()
    };
    if let [axis] = swept.as_slice() {
        return vec![Group {
            name: axes
                .get(*axis)
                .map_or_else(String::new, |axis| axis.short()),
            pictures: pictures(&|column| curve::draw(sweep, *axis, column)),
        }];
    }
    let mut groups = Vec::new();
    for (at, x) in swept.iter().enumerate() {
        for y in swept.iter().skip(at + 1) {
            if let (Some(along), Some(up)) = (axes.get(*x), axes.get(*y)) {
                groups.push(Group {
                    name: format!("{} and {}", along.short(), up.short()),
                    pictures: pictures(&|column| heat::draw(sweep, [*x, *y], column)),
                });
            }
        }
    }
    groups.truncate(MOST_PAIRS);
    groups
}

/// The columns that are drawn: what the cells are ranked by, and what tells most beside it.
fn drawn(sweep: &Sweep) -> Vec<&'static Column> {
    let told = ["bits", "explained_share", "suspect_share", "labelled_share"];
    let mut drawn: Vec<&'static Column> = Vec::new();
    let told = told
        .iter()
        .filter_map(|name| columns(sweep.with_truth).find(|column| column.name == *name));
    let ranked = sweep.ranked_by.iter().copied();
    for column in ranked.chain(told) {
        let tells = sweep.cells.iter().any(|cell| {
            let score = cell.score.as_ref().ok();
            score.is_some_and(|score| (column.of)(score).is_some())
        });
        if tells && column.name != "sound_share" && drawn.iter().all(|c| c.name != column.name) {
            drawn.push(column);
        }
    }
    drawn.truncate(MOST_PICTURES);
    drawn
}

fn about(sweep: &Sweep) -> TextDocument {
    let columns = drawn(sweep);
    let heads: Vec<String> = sweep.grid.axes().iter().map(layout::name).collect();
    let heads = heads
        .into_iter()
        .chain(columns.iter().map(|c| c.heading().to_owned()));
    let mut text = format!("# Sweep of {}\n\n", sweep.file);
    let mut row = |cells: Vec<String>| {
        text.push_str(&format!("| {} |\n", cells.join(" | ")));
    };
    let heads: Vec<String> = heads.collect();
    let rule = vec!["---:".to_owned(); heads.len()];
    row(heads);
    row(rule);
    for cell in sweep.cells.iter().take(ROWS) {
        let Ok(score) = &cell.score else { break };
        let values = sweep
            .grid
            .values(cell.index)
            .into_iter()
            .map(|v| v.to_string());
        row(values
            .chain(columns.iter().map(|c| c.text(score)))
            .collect());
    }
    let failed = sweep.failed();
    text.push_str(&format!(
        "\n{} cells, of which {failed} could not be replayed; the best come first, {}.\n\n{HOW_TO_READ}",
        sweep.cells.len(),
        if sweep.with_truth { "by the truth" } else { "without the truth" },
    ));
    TextDocument::from_markdown(text)
}

const HOW_TO_READ: &str = "\
## How to read it

Every picture shows one number of the table for every cell of the grid. In heat maps yellow is the best cell \
and dark blue the worst, whichever way is better; where more than two keys were swept, a place shows the best \
cell behind it. Grey could not be replayed. The white frame, or line, is the cell that is best by the ranking.

**bits** - what it takes to write down a reading to the millimetre when the map is known, the map included. A \
wrong mount or a late clock puts readings beside the walls that other readings made, or doubles the walls; \
both cost bits. **explained** - share of the arcs that the noise-aware map explains. **suspect** - share of the \
labels that their own readings contradict.
";
