//! What the map lies on: a metric grid with its numbers, and the axes of the odometry frame.

use rerun::{LineStrips2D, Points2D};

use super::canvas::Canvas;
use super::entity::{Look, Paint};
use super::plane::Bounds;
use super::style;
use crate::core::geometry::Vec2;
use crate::core::rounding::fixed;
use crate::observe::metric_grid::{multiples, spacing};
use crate::observe::viewer::Error;

/// Lays the grid under this part of the world, which is drawn at an entity.
pub fn put(world: &str, bounds: &Bounds, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let Bounds { min, max } = *bounds;
    let origin = canvas.origin;
    let step = spacing((max - min).amax());
    let xs = multiples(min.x, max.x, step);
    let ys = multiples(min.y, max.y, step);
    let upright = |x: f64| [Vec2::new(x, min.y), Vec2::new(x, max.y)];
    let level = |y: f64| [Vec2::new(min.x, y), Vec2::new(max.x, y)];
    let is_axis = |at: &&f64| **at == 0.0;
    for (path, axes, color) in [("lines", false, style::GRID), ("axes", true, style::AXES)] {
        let uprights = xs.iter().filter(|x| is_axis(x) == axes);
        let levels = ys.iter().filter(|y| is_axis(y) == axes);
        let lines = (uprights.map(|x| upright(*x))).chain(levels.map(|y| level(*y)));
        let lines = lines.map(|line| line.map(|end| origin.xy(end)));
        let look = Look::strips(0.5, Paint::All(color), 0.1);
        canvas.put(
            format!("{world}/grid/{path}"),
            &look.of_strips(LineStrips2D::new(lines)),
        )?;
    }
    let decimals = if step < 1.0 { 1 } else { 0 };
    let number = |at: &f64| fixed(*at, decimals);
    let inside = min + (max - min) * 0.03;
    let below = xs
        .iter()
        .map(|x| (Vec2::new(*x, inside.y), format!("x {} m", number(x))));
    let left = ys
        .iter()
        .map(|y| (Vec2::new(inside.x, *y), format!("y {} m", number(y))));
    let (places, names): (Vec<_>, Vec<_>) = below.chain(left).unzip();
    let places = places.into_iter().map(|place| origin.xy(place));
    let look = Look::dots(0.5, Paint::All(style::GRID_NUMBERS), 0.1).shown(true);
    let numbers = Points2D::new(places).with_labels(names);
    canvas.put(format!("{world}/grid/numbers"), &look.of_dots(numbers))
}
