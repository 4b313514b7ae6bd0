//! Comparisons to look at: of each pair of results both maps over each other, and what differs.

use std::io::Write;

use rerun::TextDocument;
use rerun::blueprint::components::{ContainerKind, PanelState};
use rerun::external::re_sdk_types::blueprint::archetypes::TimePanelBlueprint;

use super::blueprint::{Part, show_only};
use super::canvas::Canvas;
use super::encode::{RrdWriter, fnv1a, named_ids};
use super::plane::{Bounds, PlaneOrigin, upright};
use super::{ground, overlay, style};
use crate::observe::drawing::DrawnPair;
use crate::observe::viewer::Error;

/// Pairs that are drawn, at most: those that differ before the others.
const MOST: usize = 24;
/// More of them than this lie behind each other, as tabs.
const BESIDE: usize = 4;

// Views and containers.
const PAIRS: u128 = 1 << 33;
const ROOT: Part = Part::container(PAIRS | 1);
const MAPS: Part = Part::container(PAIRS | 2);
const ABOUT: Part = Part::view(PAIRS | 3);

/// Writes the recording of comparisons.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write_pairs(mut out: impl Write + Send, pairs: &[DrawnPair]) -> Result<(), Error> {
    let mut shown: Vec<&DrawnPair> = pairs.iter().collect();
    shown.sort_by_key(|pair| pair.over.before.is_empty() && pair.over.now.is_empty());
    shown.truncate(MOST);
    let digest = fnv1a(format!("{pairs:?}").as_bytes());
    let title = shown.first().map_or("", |pair| &pair.title);
    let ids = named_ids("tmam-diff", title, format!("diff-{digest:016x}"));
    let file = RrdWriter::new(Some(&mut out), None, ids, digest)?;
    let mut canvas = Canvas::new(file, 0, PlaneOrigin::default(), &[]);
    canvas.put("/about", &page(&shown, pairs.len()))?;
    let mut views = Vec::new();
    for (pair, place) in shown.into_iter().zip(0..) {
        let id = Part::view(PAIRS | (0x1000 + place));
        draw(pair, &format!("/pairs/{place}"), id, &mut canvas)?;
        views.push(id);
    }
    canvas.view(ABOUT, "TextDocument", "What differs", &["+ /about"])?;
    let kind = match views.len() {
        0..=BESIDE => ContainerKind::Grid,
        _ => ContainerKind::Tabs,
    };
    canvas.container(MAPS, kind, &views, &[])?;
    let columns = [MAPS, ABOUT];
    canvas.container(ROOT, ContainerKind::Horizontal, &columns, &[1.6, 1.0])?;
    canvas.window(ROOT)?;
    let hidden = TimePanelBlueprint::new().with_state(PanelState::Hidden);
    canvas.part("time_panel", &hidden)?;
    canvas.close()?;
    Ok(())
}

/// Draws a pair in a world and a view of its own.
fn draw(pair: &DrawnPair, world: &str, id: Part, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let over = &pair.over;
    let all = [&over.golden, &pair.b, &over.before, &over.now];
    let places = || all.into_iter().flatten().flat_map(|one| one.ends);
    canvas.origin = places()
        .next()
        .map_or_else(PlaneOrigin::default, PlaneOrigin::of);
    canvas.put(world.to_owned(), &upright())?;
    let bounds = Bounds::of(places());
    ground::put(world, &bounds, canvas)?;
    overlay::put_maps(world, over, canvas)?;
    let (at, look) = (format!("{world}/map"), (style::WALL, 4.0, false));
    let paths = [at.as_str(), "lines", "points"];
    overlay::put_layer(paths, &pair.b, [1.5, 3.0], look, canvas)?;
    canvas.view(id, "2D", &pair.title, &[&format!("+ {world}/**")])?;
    show_only(canvas, id, bounds.seen_from(canvas.origin))
}

fn page(shown: &[&DrawnPair], count: usize) -> TextDocument {
    let mut text = String::from(
        "| colour | what |\n|---|---|\n\
         | dark teal | map A |\n\
         | white | map B |\n\
         | bright teal | of A, what moved or is missing in B |\n\
         | magenta | what moved or is new in B |\n\n",
    );
    if count > shown.len() {
        text += &format!("{} of {count} pairs are shown.\n\n", shown.len());
    }
    for pair in shown {
        text += &format!("## {}\n\n{}\n", pair.title, pair.page);
    }
    TextDocument::from_markdown(text)
}
