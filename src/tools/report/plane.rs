//! The plane of a map as SVG: where places are in the picture, on a metric grid.

use svg::node::element::{Circle, Line, Polyline, Rectangle, Style, Text};
use svg::{Document, Node};

use crate::core::geometry::Vec2;
use crate::core::rounding::fixed;
use crate::core::tmam::arc::Arc;
use crate::observe::metric_grid::{multiples, spacing};

/// Of the picture, in its own units.
const WIDTH: f64 = 1000.0;
/// A long and narrow drive is not drawn lower or higher than this.
const HEIGHTS: [f64; 2] = [240.0, 1000.0];
/// Room for the numbers of the grid.
const MARGIN: f64 = 36.0;
/// More places than this of a path are not told apart.
const MOST_PLACES: usize = 2000;

/// How the plane looks.
const STYLE: &str = "\
.ground{fill:#fff}.grid{stroke:#e3e6ea;stroke-width:1}.axis{stroke:#aab2bd;stroke-width:1}\
.number{fill:#6b7480;font:12px sans-serif;text-anchor:middle}\
.path{fill:none;stroke:#2f8657;stroke-width:1.5}";

/// The plane of the world in a picture.
pub struct Plane {
    min: Vec2,
    max: Vec2,
    /// Units of the picture in a metre.
    pub scale: f64,
    /// Room above, for words.
    above: f64,
}

impl Plane {
    /// With all these places in it, and so much room above.
    pub fn of(places: impl Iterator<Item = Vec2>, above: f64) -> Self {
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
            above,
        }
    }

    /// A picture of it, with the grid and a path.
    pub fn picture(&self, path: &[Vec2], style: &str) -> Document {
        let (width, height) = (WIDTH, self.height());
        let ground = Rectangle::new().set("width", width).set("height", height);
        let mut picture = Document::new()
            .set("viewBox", (0.0, 0.0, width, height))
            .set("role", "img")
            .add(Style::new(format!("{STYLE}{style}")))
            .add(ground.set("class", "ground"));
        self.grid(&mut picture);
        let every = path.len().div_ceil(MOST_PLACES).max(1);
        picture.append(self.strip(path.iter().copied().step_by(every), "path"));
        picture
    }

    fn height(&self) -> f64 {
        let [lowest, highest] = HEIGHTS;
        (self.scale * (self.max.y - self.min.y) + 2.0 * MARGIN)
            .clamp(lowest, highest)
            .round()
            + self.above
    }

    /// Right and down from the upper left corner.
    pub fn xy(&self, place: Vec2) -> [f64; 2] {
        let off = (place - self.min) * self.scale;
        let [x, y] = [MARGIN + off.x, self.height() - MARGIN - off.y];
        [x, y].map(|at| (at * 10.0).round() / 10.0)
    }

    pub fn line(&self, [from, to]: [Vec2; 2], class: &str) -> Line {
        let ([x1, y1], [x2, y2]) = (self.xy(from), self.xy(to));
        let line = Line::new().set("x1", x1).set("y1", y1);
        line.set("x2", x2).set("y2", y2).set("class", class)
    }

    pub fn strip(&self, places: impl Iterator<Item = Vec2>, class: &str) -> Polyline {
        let points = places.map(|place| {
            let [x, y] = self.xy(place);
            format!("{x},{y}")
        });
        let points = points.collect::<Vec<_>>().join(" ");
        Polyline::new().set("points", points).set("class", class)
    }

    pub fn dot(&self, place: Vec2, class: &str) -> Circle {
        let [x, y] = self.xy(place);
        let dot = Circle::new().set("cx", x).set("cy", y).set("r", 5);
        dot.set("class", class)
    }

    pub fn text(&self, place: Vec2, class: &str, text: String) -> Text {
        let [x, y] = self.xy(place);
        Text::new(text).set("x", x).set("y", y).set("class", class)
    }

    fn grid(&self, picture: &mut Document) {
        let Self { min, max, .. } = *self;
        let step = spacing((max - min).amax());
        let decimals = if step < 1.0 { 1 } else { 0 };
        let class = |at: f64| if at == 0.0 { "axis" } else { "grid" };
        let below = Vec2::new(0.0, -20.0 / self.scale);
        for x in multiples(min.x, max.x, step) {
            let ends = [Vec2::new(x, min.y), Vec2::new(x, max.y)];
            picture.append(self.line(ends, class(x)));
            let number = format!("{} m", fixed(x, decimals));
            picture.append(self.text(ends[0] + below, "number", number));
        }
        let left = Vec2::new(-16.0 / self.scale, -4.0 / self.scale);
        for y in multiples(min.y, max.y, step) {
            let ends = [Vec2::new(min.x, y), Vec2::new(max.x, y)];
            picture.append(self.line(ends, class(y)));
            let number = fixed(y, decimals);
            picture.append(self.text(ends[0] + left, "number", number));
        }
    }
}

/// Places along an arc.
pub fn sweep(arc: &Arc) -> Vec<Vec2> {
    const STEPS: u32 = 8;
    let right = arc.world_from_sensor.yaw - arc.beam_width / 2.0;
    let bearing = |i: u32| right + arc.beam_width * f64::from(i) / f64::from(STEPS);
    (0..=STEPS).map(|i| arc.point_at(bearing(i))).collect()
}
