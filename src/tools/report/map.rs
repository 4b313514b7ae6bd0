//! The map as SVG: where the robot went, the features with their ids, the suspects, on a metric grid.

use svg::node::element::{Circle, Line, Polyline, Rectangle, Text};
use svg::{Document, Node};

use crate::core::geometry::Vec2;
use crate::core::rounding::fixed;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{MapFeature, Shape, Status};
use crate::core::world::World;
use crate::observe::metric_grid::{multiples, spacing};

/// Of the picture, in its own units.
const WIDTH: f64 = 1000.0;
/// A long and narrow drive is not drawn lower or higher than this.
const HEIGHTS: [f64; 2] = [240.0, 1000.0];
/// Room for the numbers of the grid.
const MARGIN: f64 = 36.0;
/// More places than this of the path are not told apart.
const MOST_PLACES: usize = 2000;

/// The plane of the world in the picture.
struct Projection {
    min: Vec2,
    max: Vec2,
    scale: f64,
}

impl Projection {
    /// Of all these places.
    fn of(places: impl Iterator<Item = Vec2>) -> Self {
        let finite = places.filter(|place| place.iter().all(|x| x.is_finite()));
        let bounds = finite.map(|place| (place, place));
        let bounds = bounds.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
        let (min, max) = bounds.unwrap_or((Vec2::zeros(), Vec2::zeros()));
        let room = (0.05 * (max - min).amax()).max(0.5);
        let (min, max) = (min.add_scalar(-room), max.add_scalar(room));
        let size = max - min;
        let [_, highest] = HEIGHTS;
        let across = (WIDTH - 2.0 * MARGIN) / size.x;
        let up = (highest - 2.0 * MARGIN) / size.y;
        Self {
            min,
            max,
            scale: across.min(up),
        }
    }

    fn height(&self) -> f64 {
        let [lowest, highest] = HEIGHTS;
        (self.scale * (self.max.y - self.min.y) + 2.0 * MARGIN).clamp(lowest, highest)
    }

    /// Right and down from the upper left corner.
    fn xy(&self, place: Vec2) -> [f64; 2] {
        let off = (place - self.min) * self.scale;
        let [x, y] = [MARGIN + off.x, self.height() - MARGIN - off.y];
        [x, y].map(|at| (at * 10.0).round() / 10.0)
    }

    fn line(&self, [from, to]: [Vec2; 2], class: &str) -> Line {
        let ([x1, y1], [x2, y2]) = (self.xy(from), self.xy(to));
        let line = Line::new().set("x1", x1).set("y1", y1);
        line.set("x2", x2).set("y2", y2).set("class", class)
    }

    fn strip(&self, places: impl Iterator<Item = Vec2>, class: &str) -> Polyline {
        let points = places.map(|place| {
            let [x, y] = self.xy(place);
            format!("{x},{y}")
        });
        let points = points.collect::<Vec<_>>().join(" ");
        Polyline::new().set("points", points).set("class", class)
    }

    fn text(&self, place: Vec2, class: &str, text: String) -> Text {
        let [x, y] = self.xy(place);
        Text::new(text).set("x", x).set("y", y).set("class", class)
    }
}

/// How it looks.
const STYLE: &str = "\
.ground{fill:#fff}.grid{stroke:#e3e6ea;stroke-width:1}.axis{stroke:#aab2bd;stroke-width:1}\
.number{fill:#6b7480;font:12px sans-serif;text-anchor:middle}\
.world{stroke:#cfe0d4;stroke-width:10;stroke-linecap:round}.path{fill:none;stroke:#2f8657;stroke-width:1.5}\
.wall{stroke:#15181d;stroke-width:4;stroke-linecap:round}.corner{fill:#c77700;stroke:#fff}\
.tentative{stroke:#9aa2ae;stroke-width:3;stroke-linecap:round}.maybe{fill:#9aa2ae}\
.suspect{fill:none;stroke:#d4002a;stroke-width:1.5;stroke-opacity:.5}\
.worst{fill:none;stroke:#d4002a;stroke-width:6}\
.id{fill:#1d5fa8;font:bold 14px sans-serif;text-anchor:middle}\
.named{fill:#d4002a;font:bold 14px sans-serif;text-anchor:middle}";

/// Draws a map: along `path`, with the arcs of the suspects, the worst first; below all else the walls that
/// there really are, where they are known.
pub fn draw(
    path: &[Vec2],
    map: &[MapFeature],
    suspects: &[Arc],
    world: Option<&World>,
) -> Document {
    let features = map.iter().flat_map(|feature| match &feature.shape {
        Shape::Line(line) => line.ends().to_vec(),
        Shape::Point(point) => vec![point.position],
    });
    let arcs = suspects.iter().flat_map(sweep);
    let projection = Projection::of(path.iter().copied().chain(features).chain(arcs));
    let (width, height) = (WIDTH, projection.height());
    let mut picture = Document::new()
        .set("viewBox", (0.0, 0.0, width, height))
        .set("role", "img")
        .add(svg::node::element::Style::new(STYLE));
    let ground = Rectangle::new().set("width", width).set("height", height);
    picture.append(ground.set("class", "ground"));
    grid(&projection, &mut picture);
    let every = path.len().div_ceil(MOST_PLACES).max(1);
    picture.append(projection.strip(path.iter().copied().step_by(every), "path"));
    for wall in world.iter().flat_map(|world| world.walls()) {
        picture.append(projection.line([wall.start, wall.end], "world"));
    }
    for feature in map {
        let confirmed = feature.status == Status::Confirmed;
        let middle = match &feature.shape {
            Shape::Line(line) => {
                let class = if confirmed { "wall" } else { "tentative" };
                picture.append(projection.line(line.ends(), class));
                line.mid
            }
            Shape::Point(point) => {
                let [x, y] = projection.xy(point.position);
                let class = if confirmed { "corner" } else { "maybe" };
                let dot = Circle::new().set("cx", x).set("cy", y).set("r", 5);
                picture.append(dot.set("class", class));
                point.position
            }
        };
        if confirmed {
            let beside = middle + Vec2::new(10.0, 8.0) / projection.scale;
            picture.append(projection.text(beside, "id", feature.id.to_string()));
        }
    }
    for (place, arc) in suspects.iter().enumerate().rev() {
        let class = if place == 0 { "worst" } else { "suspect" };
        picture.append(projection.strip(sweep(arc).into_iter(), class));
    }
    if let Some(worst) = suspects.first() {
        let at = worst.point_at(worst.world_from_sensor.yaw);
        let beside = at + Vec2::new(0.0, 14.0) / projection.scale;
        picture.append(projection.text(beside, "named", "worst suspect".to_owned()));
    }
    picture
}

/// Places along an arc.
fn sweep(arc: &Arc) -> Vec<Vec2> {
    const STEPS: u32 = 8;
    let right = arc.world_from_sensor.yaw - arc.beam_width / 2.0;
    let bearing = |i: u32| right + arc.beam_width * f64::from(i) / f64::from(STEPS);
    (0..=STEPS).map(|i| arc.point_at(bearing(i))).collect()
}

fn grid(projection: &Projection, picture: &mut Document) {
    let Projection { min, max, .. } = *projection;
    let step = spacing((max - min).amax());
    let decimals = if step < 1.0 { 1 } else { 0 };
    let class = |at: f64| if at == 0.0 { "axis" } else { "grid" };
    let below = Vec2::new(0.0, -20.0 / projection.scale);
    for x in multiples(min.x, max.x, step) {
        let ends = [Vec2::new(x, min.y), Vec2::new(x, max.y)];
        picture.append(projection.line(ends, class(x)));
        let number = format!("{} m", fixed(x, decimals));
        picture.append(projection.text(ends[0] + below, "number", number));
    }
    let left = Vec2::new(-16.0 / projection.scale, -4.0 / projection.scale);
    for y in multiples(min.y, max.y, step) {
        let ends = [Vec2::new(min.x, y), Vec2::new(max.x, y)];
        picture.append(projection.line(ends, class(y)));
        let number = fixed(y, decimals);
        picture.append(projection.text(ends[0] + left, "number", number));
    }
}
