//! What tools hand over, drawn over the run: where things were or should be, and what is wrong.

use rerun::components::TextLogLevel;
use rerun::{Color, LineStrips2D, Points2D, TextDocument};

use super::canvas::{Canvas, Dot, Moment, Shown, Strip};
use super::entity::{Entity, Look, Paint};
use super::style;
use crate::core::tmam::arc::Arc;
use crate::observe::drawing::{DrawnTruth, Overlay, Sketched};
use crate::observe::viewer::Error;

/// With more names than this on the map, none could be read.
const MOST_NAMES: usize = 16;

/// Draws what holds at all times, and says in the event log what is to be said there.
pub fn put(overlay: &Overlay, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    if let Some(truth) = &overlay.truth {
        return put_truth(truth, canvas);
    }
    if *overlay == Overlay::default() {
        return Ok(());
    }
    put_maps("/world", overlay, canvas)?;
    canvas.put_look(Entity::ChangedLabels)?;
    for (frame, stamp_ns, text) in &overlay.notes {
        let at = Moment::new(*frame, *stamp_ns);
        canvas.note(at, TextLogLevel::ERROR, text.clone())?;
    }
    canvas.flush()
}

/// Draws a map below a world, and what of it moved or is missing, moved or is new.
pub fn put_maps(world: &str, overlay: &Overlay, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    for (at, sketched, radii, look) in [
        (
            "golden",
            &overlay.golden,
            [4.5, 6.5],
            (style::GOLDEN, 3.5, false),
        ),
        (
            "differences/before",
            &overlay.before,
            [4.0, 6.0],
            (style::BEFORE, 8.3, true),
        ),
        (
            "differences/now",
            &overlay.now,
            [3.0, 5.0],
            (style::NOW, 8.6, true),
        ),
    ] {
        let at = format!("{world}/{at}");
        put_layer([&at, "lines", "points"], sketched, radii, look, canvas)?;
    }
    Ok(())
}

fn put_truth(truth: &DrawnTruth, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let page = TextDocument::from_markdown(truth.page.as_str());
    canvas.put("/evaluation", &page)?;
    let (at, radii) = ("/world/truth", [6.0, 9.0]);
    let look = (style::TRUTH, 0.2, false);
    put_layer([at, "walls", "points"], &truth.real, radii, look, canvas)?;
    let look = (style::REJECTED, 0.4, false);
    let path = [at, "missed_walls", "missed_points"];
    put_layer(path, &truth.missed, radii, look, canvas)?;
    for entity in [
        Entity::WrongLabels,
        Entity::Errors,
        Entity::SpuriousLines,
        Entity::SpuriousPoints,
    ] {
        canvas.put_look(entity)?;
    }
    Ok(())
}

/// Marks the arcs of a frame whose label changed or is wrong.
pub fn mark(
    overlay: &Overlay,
    at: Moment,
    arcs: &[Arc],
    canvas: &mut Canvas<'_>,
) -> Result<(), Error> {
    let (entity, labels) = match &overlay.truth {
        Some(truth) => (Entity::WrongLabels, &truth.wrong),
        None => (Entity::ChangedLabels, &overlay.labels),
    };
    if labels.is_empty() {
        return Ok(());
    }
    let mut marks = Vec::new();
    for arc in arcs {
        let sonar = canvas.sonar(arc.id.sonar).to_owned();
        let Some(what) = labels.get(&(arc.id.frame, sonar.clone())) else {
            continue;
        };
        if entity == Entity::WrongLabels {
            let text = format!("wrong label: {sonar} {what}");
            canvas.note(at, TextLogLevel::WARN, text)?;
        }
        let name = format!("{sonar}: {what}");
        marks.push(Strip::named(canvas.origin.sweep(arc), name));
    }
    canvas.row(entity, at, Shown::Strips(marks))
}

/// Draws what is wrong with the final map.
pub fn finish(overlay: &Overlay, at: Moment, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let Some(truth) = &overlay.truth else {
        return Ok(());
    };
    let origin = canvas.origin;
    let lines = |sketched: &[Sketched]| {
        let lines = sketched.iter().filter(|one| !one.is_point);
        let strip = |one: &Sketched| {
            let places = one.places().into_iter().map(|place| origin.xy(place));
            Strip::named(places.collect(), one.name.clone())
        };
        Shown::Strips(lines.map(strip).collect())
    };
    let points = truth.spurious.iter().filter(|one| one.is_point);
    let points = points.map(|one| Dot::named(origin.xy(one.ends[0]), one.name.clone()));
    let points = Shown::Dots(points.collect());
    canvas.row(Entity::Errors, at, lines(&truth.errors))?;
    canvas.row(Entity::SpuriousLines, at, lines(&truth.spurious))?;
    canvas.row(Entity::SpuriousPoints, at, points)
}

/// Sketches that are there all the time, lines and points below an entity: how large they are, their colour
/// and order, and whether they have names where these are few enough.
pub fn put_layer(
    [at, lines, points]: [&str; 3],
    sketched: &[Sketched],
    radii: [f32; 2],
    (color, order, named): (Color, f32, bool),
    canvas: &mut Canvas<'_>,
) -> Result<(), Error> {
    let (origin, paint) = (canvas.origin, Paint::All(color));
    let named = named && sketched.len() <= MOST_NAMES;
    let of = |points: bool| sketched.iter().filter(move |one| one.is_point == points);
    let names = |points: bool| of(points).map(|one| one.name.as_str());
    let look = Look::strips(radii[0], paint, order).shown(named);
    let places = |one: &Sketched| -> Vec<[f32; 2]> {
        let places = one.places().into_iter();
        places.map(|place| origin.xy(place)).collect()
    };
    let strips = LineStrips2D::new(of(false).map(places)).with_labels(names(false));
    canvas.put(format!("{at}/{lines}"), &look.of_strips(strips))?;
    let look = Look::dots(radii[1], paint, order).shown(named);
    let places = of(true).map(|one| origin.xy(one.ends[0]));
    let dots = Points2D::new(places).with_labels(names(true));
    canvas.put(format!("{at}/{points}"), &look.of_dots(dots))
}
