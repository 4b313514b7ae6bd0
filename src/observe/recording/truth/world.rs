//! What is drawn of the world, and how truth and errors look.

use std::io::Write;

use rerun::{LineStrips2D, Points2D};

use super::super::Error;
use super::super::encode::RrdWriter;
use super::super::style::{self, order, ui};
use super::super::table::put_static;
use crate::core::wording::counted;
use crate::core::world::Reflector;
use crate::tools::evaluate::{Evaluation, Truth};

/// The walls and points that are really there.
pub fn put_world<W: Write>(truth: &Truth, out: &mut RrdWriter<W>) -> Result<(), Error> {
    let walls = all(truth.world().walls().len(), Reflector::Line);
    let points = all(truth.world().points().len(), Reflector::Point);
    put_walls("/world/truth/walls", truth, &walls, out)?;
    put_points("/world/truth/points", truth, &points, out)
}

/// Those that the final map misses.
pub fn put_missed<W: Write>(
    truth: &Truth,
    evaluation: &Evaluation,
    out: &mut RrdWriter<W>,
) -> Result<(), Error> {
    let map = &evaluation.map;
    let missed = [&map.lines, &map.points].map(|kind| {
        let missed = kind.missed.iter();
        missed.map(|missed| missed.reflector).collect::<Vec<_>>()
    });
    let [walls, points] = &missed;
    put_walls("/world/truth/missed_walls", truth, walls, out)?;
    put_points("/world/truth/missed_points", truth, points, out)
}

fn all(count: usize, of: fn(usize) -> Reflector) -> Vec<Reflector> {
    (0..count).map(of).collect()
}

fn put_walls<W: Write>(
    path: &str,
    truth: &Truth,
    which: &[Reflector],
    out: &mut RrdWriter<W>,
) -> Result<(), Error> {
    let (origin, mut strips) = (out.origin(), Vec::new());
    for reflector in which {
        if let Reflector::Line(index) = reflector
            && let Some(wall) = truth.world().walls().get(*index)
        {
            let name = format!(
                "wall {index} ({})",
                counted(truth.echoes(*reflector), "echo")
            );
            strips.push(([wall.start, wall.end].map(|end| origin.xy(end)), name));
        }
    }
    let (strips, names): (Vec<_>, Vec<_>) = strips.into_iter().unzip();
    let what = LineStrips2D::update_fields()
        .with_strips(strips)
        .with_labels(names);
    put_static(path, &what, out)
}

fn put_points<W: Write>(
    path: &str,
    truth: &Truth,
    which: &[Reflector],
    out: &mut RrdWriter<W>,
) -> Result<(), Error> {
    let (origin, mut dots) = (out.origin(), Vec::new());
    for reflector in which {
        if let Reflector::Point(index) = reflector
            && let Some(point) = truth.world().points().get(*index)
        {
            let name = format!(
                "point {index} ({})",
                counted(truth.echoes(*reflector), "echo")
            );
            dots.push((origin.xy(*point), name));
        }
    }
    let (dots, names): (Vec<_>, Vec<_>) = dots.into_iter().unzip();
    let what = Points2D::update_fields()
        .with_positions(dots)
        .with_labels(names);
    put_static(path, &what, out)
}

/// How truth and errors look.
pub fn put_styles<W: Write>(out: &mut RrdWriter<W>) -> Result<(), Error> {
    for (path, color, width, height) in [
        ("walls", style::TRUTH, 6.0, order::TRUTH),
        ("missed_walls", style::REJECTED, 6.0, order::MISSED),
        ("wrong_labels", style::WRONG, 5.0, order::WRONG),
        ("spurious_lines", style::WRONG, 2.5, order::SPURIOUS),
        ("errors", style::ERROR, 1.0, order::SPURIOUS),
    ] {
        let look = LineStrips2D::update_fields()
            .with_radii([ui(width)])
            .with_colors([color])
            .with_show_labels(false)
            .with_draw_order(height);
        put_static(format!("/world/truth/{path}"), &look, out)?;
    }
    for (path, color, width, height) in [
        ("points", style::TRUTH, 9.0, order::TRUTH),
        ("missed_points", style::REJECTED, 9.0, order::MISSED),
        ("spurious_points", style::WRONG, 4.5, order::SPURIOUS),
    ] {
        let look = Points2D::update_fields()
            .with_radii([ui(width)])
            .with_colors([color])
            .with_show_labels(false)
            .with_draw_order(height);
        put_static(format!("/world/truth/{path}"), &look, out)?;
    }
    Ok(())
}
