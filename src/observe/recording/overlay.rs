//! What tools hand over, drawn over the run: where things were or should be, and what is wrong.

use rerun::components::TextLogLevel;
use rerun::{Color, LineStrips2D, Points2D, TextDocument};

use super::canvas::{Canvas, Dot, Moment, Row, Strip};
use super::entity::{Entity, Look, Paint};
use super::style;
use crate::core::tmam::arc::Arc;
use crate::observe::drawing::{Overlay, Sketched, Truth};
use crate::observe::viewer::Error;

/// With more names than this on the map, none could be read.
const MOST_NAMES: usize = 16;

/// A kind of sketches that are there all the time: where they are, and how they look.
struct Layer<'a> {
    sketched: &'a [Sketched],
    /// Of lines, and of points.
    paths: [&'static str; 2],
    radii: [f32; 2],
    color: Color,
    order: f32,
    named: bool,
}

/// Draws what holds at all times, and says in the event log what is to be said there.
pub fn put(overlay: &Overlay, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    if let Some(truth) = &overlay.truth {
        return put_truth(truth, canvas);
    }
    if *overlay == Overlay::default() {
        return Ok(());
    }
    let [golden, before, now] = [&overlay.golden, &overlay.before, &overlay.now];
    let paths = ["/world/golden/lines", "/world/golden/points"];
    Layer::new(paths, golden, [4.5, 6.5], style::GOLDEN, 3.5).put(canvas)?;
    let paths = [
        "/world/differences/before/lines",
        "/world/differences/before/points",
    ];
    let layer = Layer::new(paths, before, [4.0, 6.0], style::BEFORE, 8.3);
    layer.named().put(canvas)?;
    let paths = [
        "/world/differences/now/lines",
        "/world/differences/now/points",
    ];
    let layer = Layer::new(paths, now, [3.0, 5.0], style::NOW, 8.6);
    layer.named().put(canvas)?;
    canvas.put_look(Entity::ChangedLabels)?;
    for (frame, stamp_ns, text) in &overlay.notes {
        let at = Moment::new(*frame, *stamp_ns);
        canvas.note(at, TextLogLevel::ERROR, text.clone())?;
    }
    canvas.flush()
}

fn put_truth(truth: &Truth, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let page = TextDocument::from_markdown(truth.page.as_str());
    canvas.put("/evaluation", &page)?;
    let radii = [6.0, 9.0];
    let paths = ["/world/truth/walls", "/world/truth/points"];
    Layer::new(paths, &truth.real, radii, style::TRUTH, 0.2).put(canvas)?;
    let paths = ["/world/truth/missed_walls", "/world/truth/missed_points"];
    Layer::new(paths, &truth.missed, radii, style::REJECTED, 0.4).put(canvas)?;
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
    canvas.row(entity, at, Row::Strips(marks))
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
            let ends = one.ends.map(|end| origin.xy(end));
            Strip::named(ends.to_vec(), one.name.clone())
        };
        Row::Strips(lines.map(strip).collect())
    };
    let points = truth.spurious.iter().filter(|one| one.is_point);
    let points = points.map(|one| Dot::named(origin.xy(one.ends[0]), one.name.clone()));
    let points = Row::Dots(points.collect());
    canvas.row(Entity::Errors, at, lines(&truth.errors))?;
    canvas.row(Entity::SpuriousLines, at, lines(&truth.spurious))?;
    canvas.row(Entity::SpuriousPoints, at, points)
}

impl<'a> Layer<'a> {
    fn new(
        paths: [&'static str; 2],
        sketched: &'a [Sketched],
        radii: [f32; 2],
        color: Color,
        order: f32,
    ) -> Self {
        Self {
            sketched,
            paths,
            radii,
            color,
            order,
            named: false,
        }
    }

    /// The same with names, if they are few enough.
    fn named(self) -> Self {
        let named = self.sketched.len() <= MOST_NAMES;
        Self { named, ..self }
    }

    fn put(&self, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        let origin = canvas.origin;
        let of = |points: bool| {
            let all = self.sketched.iter();
            all.filter(move |one| one.is_point == points)
        };
        let names = |points: bool| of(points).map(|one| one.name.as_str());
        let ([lines, points], paint) = (self.radii, Paint::All(self.color));
        let look = Look::strips(lines, paint, self.order).shown(self.named);
        let ends = of(false).map(|one| one.ends.map(|end| origin.xy(end)));
        let strips = LineStrips2D::new(ends).with_labels(names(false));
        canvas.put(self.paths[0], &look.of_strips(strips))?;
        let look = Look::dots(points, paint, self.order).shown(self.named);
        let places = of(true).map(|one| origin.xy(one.ends[0]));
        let dots = Points2D::new(places).with_labels(names(true));
        canvas.put(self.paths[1], &look.of_dots(dots))
    }
}
