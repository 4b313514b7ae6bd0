//! A sweep to look at: a heat map for every pair of keys, or curves over a single one.

mod curve;
mod drawing;
mod heat;
mod layout;
mod marks;
mod page;

use std::io::Write;

use super::Error;
use super::encode::RrdWriter;
use super::names::{fnv1a, named_ids};
use super::origin::Origin;
use super::table::put_static;
use crate::tools::sweep::columns::{Column, columns};
use crate::tools::sweep::{Sweep, json};
use drawing::Drawing;

/// Pictures of one pair of keys.
const MOST_PICTURES: usize = 4;
/// Pairs of keys that are drawn.
const MOST_PAIRS: usize = 6;

/// Pictures that belong together, and what they are of.
struct Group {
    name: String,
    pictures: Vec<Picture>,
}

/// One picture under its title.
struct Picture {
    title: String,
    /// Whether it shows the same number everywhere.
    is_flat: bool,
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
    put_static("/about", &page::page(sweep, &drawn(sweep)), &mut out)?;
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
    // Those that show something come first, the one that is open above all.
    groups.sort_by_key(|group| group.pictures.iter().all(|picture| picture.is_flat));
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

#[cfg(test)]
mod tests;
