//! The map as SVG: where the robot went, the features with their ids, the suspects, on a metric grid.

use svg::node::element::Text;
use svg::{Document, Node};

use super::plane::{Plane, sweep};
use crate::core::geometry::Vec2;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{MapFeature, Shape, Status};
use crate::core::world::World;

/// Width and height of an id: one that would cover another is left out.
const ID: [f64; 2] = [26.0, 14.0];

/// How it looks.
const STYLE: &str = "\
.world{stroke:#cfe0d4;stroke-width:10;stroke-linecap:round}\
.wall{stroke:#15181d;stroke-width:4;stroke-linecap:round}.corner{fill:#c77700;stroke:#fff}\
.tentative{stroke:#9aa2ae;stroke-width:3;stroke-linecap:round}.maybe{fill:#9aa2ae}\
.stretch{fill:none;stroke:#d4002a;stroke-width:4;stroke-dasharray:3 5}.start{fill:#2f8657;stroke:#fff}\
.suspect{fill:none;stroke:#d4002a;stroke-width:1.5;stroke-opacity:.5}\
.worst{fill:none;stroke:#d4002a;stroke-width:6}\
.id,.named{paint-order:stroke;stroke:#fff;stroke-width:3px}.id{fill:#1d5fa8;font:bold 14px sans-serif;text-anchor:middle}\
.named{fill:#d4002a;font:bold 14px sans-serif}.left{text-anchor:end}";

/// Draws a map: along `path`, and the `stretch` of it that is explained least, with the arcs of the suspects, the
/// worst first; below all else the walls that there really are, where they are known.
pub fn draw(
    path: &[Vec2],
    stretch: &[Vec2],
    map: &[MapFeature],
    suspects: &[Arc],
    world: Option<&World>,
) -> Document {
    let features = map.iter().flat_map(|feature| match &feature.shape {
        Shape::Line(line) => line.ends().to_vec(),
        Shape::Point(point) => vec![point.position],
        Shape::Circle(circle) => circle.outline().collect(),
    });
    let arcs = suspects.iter().flat_map(sweep);
    let plane = Plane::of(path.iter().copied().chain(features).chain(arcs), 0.0);
    let mut picture = plane.picture(path, STYLE);
    for wall in world.iter().flat_map(|world| world.walls()) {
        picture.append(plane.line([wall.start, wall.end], "world"));
    }
    if !stretch.is_empty() {
        picture.append(plane.strip(stretch.iter().copied(), "stretch"));
    }
    if let Some(start) = path.first() {
        picture.append(plane.dot(*start, "start"));
    }
    for feature in map {
        let confirmed = feature.status == Status::Confirmed;
        match &feature.shape {
            Shape::Line(line) => {
                let class = if confirmed { "wall" } else { "tentative" };
                picture.append(plane.line(line.ends(), class));
            }
            Shape::Point(point) => {
                let class = if confirmed { "corner" } else { "maybe" };
                picture.append(plane.dot(point.position, class));
            }
            Shape::Circle(circle) => {
                let class = if confirmed { "wall" } else { "tentative" };
                picture.append(plane.strip(circle.outline(), class));
            }
        }
    }
    for (place, arc) in suspects.iter().enumerate().rev() {
        let class = if place == 0 { "worst" } else { "suspect" };
        picture.append(plane.strip(sweep(arc).into_iter(), class));
    }
    let confirmed = map
        .iter()
        .filter(|feature| feature.status == Status::Confirmed);
    let middles: Vec<(u32, Vec2)> = confirmed
        .map(|feature| (feature.id, feature.shape.middle()))
        .collect();
    let mut ids: Vec<[f64; 2]> = Vec::new();
    for (id, middle) in &middles {
        let beside = middle + Vec2::new(10.0, 8.0) / plane.scale;
        let [x, y] = plane.xy(beside);
        let is_free = |[a, b]: &[f64; 2]| (a - x).abs() > ID[0] || (b - y).abs() > ID[1];
        if ids.iter().all(is_free) {
            picture.append(plane.text(beside, "id", id.to_string()));
            ids.push([x, y]);
        }
    }
    if let Some(worst) = suspects.first() {
        picture.append(name_worst(worst, &middles, &plane));
    }
    picture
}

/// Names the worst suspect beyond that end of its arc which is farther from the features.
fn name_worst(worst: &Arc, features: &[(u32, Vec2)], plane: &Plane) -> Text {
    let yaw = worst.world_from_sensor.yaw;
    let middle = worst.point_at(yaw);
    let ends = [-0.5, 0.5].map(|half| worst.point_at(yaw + half * worst.beam_width));
    let clearance = |end: Vec2| {
        let off = features.iter().map(|(_, place)| (place - end).norm());
        off.fold(f64::INFINITY, f64::min)
    };
    let [right, left] = ends;
    let end = if clearance(right) < clearance(left) {
        left
    } else {
        right
    };
    let away = (end - middle).try_normalize(0.0).unwrap_or_default();
    let beside = end + Vec2::new(10.0, 14.0).component_mul(&away) / plane.scale;
    let class = if away.x < 0.0 { "named left" } else { "named" };
    plane.text(beside, class, "worst suspect".to_owned())
}
