//! A sweep to look at: a heat map for every pair of keys, or curves over a single one.

mod curve;
mod drawing;
mod heat;

use std::fmt::Write as _;
use std::io::Write;

use rerun::TextDocument;
use rerun::blueprint::components::{ContainerKind, PanelState, VisualBounds2D as VisualBounds};
use rerun::datatypes::Range2D;
use rerun::external::re_sdk_types::blueprint::archetypes::{TimePanelBlueprint, VisualBounds2D};

use self::drawing::{ABOVE, BELOW, HEIGHT, LEFT, Picture, RIGHT, WIDTH};
use super::blueprint::Part;
use super::canvas::Canvas;
use super::encode::{RrdWriter, fnv1a, named_ids};
use super::plane::PlaneOrigin;
use crate::observe::drawing::DrawnGrid;
use crate::observe::viewer::Error;

/// Pairs of keys that are drawn.
const MOST_PAIRS: usize = 6;

/// Pictures that belong together, and what they are of.
struct Group {
    name: String,
    pictures: Vec<Picture>,
}

/// Writes the recording of a sweep.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write_grid(mut out: impl Write + Send, grid: &DrawnGrid) -> Result<(), Error> {
    let digest = fnv1a(&grid.content);
    let recording = format!("sweep-{digest:016x}");
    let ids = named_ids("tmam-sweep", &grid.file, recording);
    let file = RrdWriter::new(Some(&mut out), None, ids, digest)?;
    let mut canvas = Canvas::new(file, 0, PlaneOrigin::default(), &[]);
    canvas.put("/about", &page(grid))?;
    let groups = groups(grid);
    let pictures = groups.iter().flat_map(|group| &group.pictures);
    for (place, picture) in pictures.enumerate() {
        picture.drawing.put(&entity(place), &mut canvas)?;
    }
    put_layout(&groups, &mut canvas)?;
    canvas.close()?;
    Ok(())
}

/// Where a picture is in the recording.
fn entity(picture: usize) -> String {
    format!("/pictures/{picture}")
}

/// What is drawn: of every pair of keys, or of the only one.
fn groups(grid: &DrawnGrid) -> Vec<Group> {
    let columns = 0..grid.columns.len();
    if let [axis] = grid.axes.as_slice() {
        return vec![Group {
            name: axis.short.clone(),
            pictures: columns
                .filter_map(|column| curve::draw(grid, column))
                .collect(),
        }];
    }
    let mut groups = Vec::new();
    for (x, along) in grid.axes.iter().enumerate() {
        for (y, up) in grid.axes.iter().enumerate().skip(x + 1) {
            let pictures = columns.clone();
            let pictures = pictures.filter_map(|column| heat::draw(grid, [x, y], column));
            groups.push(Group {
                name: format!("{} and {}", along.short, up.short),
                pictures: pictures.collect(),
            });
        }
    }
    // Those that show something come first, the one that is open above all.
    groups.sort_by_key(|group| group.pictures.iter().all(|picture| picture.is_flat));
    groups.truncate(MOST_PAIRS);
    groups
}

// Views and containers.
const GRID: u128 = 1 << 32;
const ROOT: Part = Part::container(GRID | 1);
const GROUPS: Part = Part::container(GRID | 2);
const ABOUT: Part = Part::view(GRID | 3);

/// Writes the blueprint.
fn put_layout(groups: &[Group], w: &mut Canvas<'_>) -> Result<(), Error> {
    w.view(ABOUT, "TextDocument", "Best cells", &["+ /about"])?;
    let mut pictures = 0..;
    let mut tabs = Vec::new();
    for (place, group) in groups.iter().enumerate() {
        let mut views = Vec::new();
        for (picture, next) in group.pictures.iter().zip(&mut pictures) {
            let id = Part::view(GRID | (0x1000 + next as u128));
            let query = format!("+ {}/**", entity(next));
            w.view(id, "2D", &picture.title, &[&query])?;
            let bounds = VisualBounds2D::new(VisualBounds(Range2D {
                x_range: [-f64::from(LEFT), f64::from(WIDTH + RIGHT)].into(),
                y_range: [-f64::from(ABOVE), f64::from(HEIGHT + BELOW)].into(),
            }));
            w.property(id, "VisualBounds2D", &bounds)?;
            views.push(id);
        }
        let id = Part::container(GRID | (0x100 + place as u128));
        w.container(id, ContainerKind::Grid, &views, &[])?;
        w.name(id, &group.name)?;
        tabs.push(id);
    }
    w.container(GROUPS, ContainerKind::Tabs, &tabs, &[])?;
    let columns = [GROUPS, ABOUT];
    w.container(ROOT, ContainerKind::Horizontal, &columns, &[1.6, 1.0])?;
    w.window(ROOT)?;
    let hidden = TimePanelBlueprint::new().with_state(PanelState::Hidden);
    w.part("time_panel", &hidden)
}

/// Cells in the table.
const ROWS: usize = 20;
/// Width of the table in characters, each column with a gap behind it: more would be cut.
const TABLE_WIDTH: usize = 72;
const GAP: usize = 2;

/// The page beside the pictures: the best cells, what follows, and how to read it.
fn page(grid: &DrawnGrid) -> TextDocument {
    let failed = grid.cells.iter().filter(|cell| cell.numbers.is_none());
    let failed = match failed.count() {
        0 => String::new(),
        n => format!("; {n} could not be replayed"),
    };
    TextDocument::from_markdown(format!(
        "# Sweep of {}\n\n{}\n{}\n{} of {} cells, the best first, {}{failed}. `--csv` has all of them with every \
         column.\n\n{HOW_TO_READ}",
        grid.file,
        grid.conclusion,
        table(grid),
        grid.cells.len().min(ROWS),
        grid.cells.len(),
        grid.ranked_by,
    ))
}

/// The best cells, in as many columns as have room: first the keys, then what cells are ranked by.
fn table(grid: &DrawnGrid) -> String {
    // A name with a bar would end its column.
    let keys = grid.axes.iter().map(|axis| axis.heading.replace('|', "/"));
    let heads = keys.chain(grid.columns.iter().map(|column| column.heading.clone()));
    let mut rows = vec![heads.collect::<Vec<String>>()];
    for cell in grid.cells.iter().take(ROWS) {
        let Some(numbers) = &cell.numbers else { break };
        let values = grid.axes.iter().zip(&cell.places);
        let values = values.filter_map(|(axis, place)| axis.values.get(*place));
        let values = values.map(ToString::to_string);
        let numbers = grid.columns.iter().zip(numbers);
        let numbers = numbers.map(|(column, number)| column.text(*number));
        rows.push(values.chain(numbers).collect());
    }
    let fitting = fitting(&rows);
    let mut text = String::new();
    for (place, row) in rows.iter().enumerate() {
        let cells = row.get(..fitting).unwrap_or(row);
        // Writing into a string cannot fail.
        let _ = writeln!(text, "| {} |", cells.join(" | "));
        if place == 0 {
            let _ = writeln!(text, "|{}", " ---: |".repeat(cells.len()));
        }
    }
    text
}

/// How many columns have room; one at least.
fn fitting(rows: &[Vec<String>]) -> usize {
    let count = rows.first().map_or(0, Vec::len);
    let mut taken = 0;
    let fits = |column: &usize| {
        let cells = rows.iter().filter_map(|row| row.get(*column));
        taken += GAP + cells.map(|text| text.chars().count()).max().unwrap_or(0);
        taken <= TABLE_WIDTH
    };
    (0..count).take_while(fits).count().max(1)
}

const HOW_TO_READ: &str = include_str!("grid/page.md");

#[cfg(test)]
mod tests;
