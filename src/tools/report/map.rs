//! The map as SVG: where the robot went, the features with their ids, the suspects, on a metric grid.

use svg::node::element::Circle;
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
.suspect{fill:none;stroke:#d4002a;stroke-width:1.5;stroke-opacity:.5}\
.worst{fill:none;stroke:#d4002a;stroke-width:6}\
.id,.named{paint-order:stroke;stroke:#fff;stroke-width:3px}.id{fill:#1d5fa8;font:bold 14px sans-serif;text-anchor:middle}\
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
        Shape::Circle(circle) => circle.outline().collect(),
    });
    let arcs = suspects.iter().flat_map(sweep);
    let plane = Plane::of(path.iter().copied().chain(features).chain(arcs), 0.0);
    let mut picture = plane.picture(path, STYLE);
    for wall in world.iter().flat_map(|world| world.walls()) {
        picture.append(plane.line([wall.start, wall.end], "world"));
    }
    let mut ids: Vec<[f64; 2]> = Vec::new();
    for feature in map {
        let confirmed = feature.status == Status::Confirmed;
        let middle = match &feature.shape {
            Shape::Line(line) => {
                let class = if confirmed { "wall" } else { "tentative" };
                picture.append(plane.line(line.ends(), class));
                line.mid
            }
            Shape::Point(point) => {
                let [x, y] = plane.xy(point.position);
                let class = if confirmed { "corner" } else { "maybe" };
                let dot = Circle::new().set("cx", x).set("cy", y).set("r", 5);
                picture.append(dot.set("class", class));
                point.position
            }
            Shape::Circle(circle) => {
                let class = if confirmed { "wall" } else { "tentative" };
                picture.append(plane.strip(circle.outline(), class));
                circle.center
            }
        };
        let beside = middle + Vec2::new(10.0, 8.0) / plane.scale;
        let [x, y] = plane.xy(beside);
        let is_free = |[a, b]: &[f64; 2]| (a - x).abs() > ID[0] || (b - y).abs() > ID[1];
        if confirmed && ids.iter().all(is_free) {
            picture.append(plane.text(beside, "id", feature.id.to_string()));
            ids.push([x, y]);
        }
    }
    for (place, arc) in suspects.iter().enumerate().rev() {
        let class = if place == 0 { "worst" } else { "suspect" };
        picture.append(plane.strip(sweep(arc).into_iter(), class));
    }
    if let Some(worst) = suspects.first() {
        let at = worst.point_at(worst.world_from_sensor.yaw);
        let beside = at + Vec2::new(0.0, 14.0) / plane.scale;
        picture.append(plane.text(beside, "named", "worst suspect".to_owned()));
    }
    picture
}
