//! How much of the plane the map view must show.

use std::collections::BTreeMap;

use crate::geometry::{Pose2, Vec2};
use crate::tmam::arc::Arc;

/// Cell of the histogram over echoes, metres.
const CELL: f64 = 0.25;
/// Share of the echoes that may lie outside at each edge: a few wild readings must not shrink
/// the map to a dot.
const OUTSIDE: f64 = 0.01;
/// Smallest half width, metres.
const LEAST: f64 = 0.5;

/// A box in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Least x and y.
    pub min: Vec2,
    /// Greatest x and y.
    pub max: Vec2,
}

/// Where the robot and nearly all of its echoes were.
#[derive(Debug, Default)]
pub struct Extent {
    path: Option<Bounds>,
    echoes: [BTreeMap<i64, u64>; 2],
    count: u64,
}

impl Extent {
    /// The robot was here.
    pub fn visit(&mut self, pose: &Pose2) {
        let here = pose.position();
        let path = self.path.get_or_insert(Bounds {
            min: here,
            max: here,
        });
        path.min = path.min.inf(&here);
        path.max = path.max.sup(&here);
    }

    /// Something echoed.
    pub fn echo(&mut self, arc: &Arc) {
        let at = arc.point_at(arc.world_from_sensor.yaw);
        if !(at.x.is_finite() && at.y.is_finite()) {
            return;
        }
        let [xs, ys] = &mut self.echoes;
        for (histogram, value) in [(xs, at.x), (ys, at.y)] {
            *histogram.entry((value / CELL).floor() as i64).or_default() += 1;
        }
        self.count += 1;
    }

    /// The box to show, with a margin.
    pub fn bounds(&self) -> Bounds {
        let origin = Vec2::zeros();
        let path = self.path.unwrap_or(Bounds {
            min: origin,
            max: origin,
        });
        let [xs, ys] = &self.echoes;
        let (x, y) = (self.span(xs), self.span(ys));
        let mut bounds = path;
        if let (Some((x0, x1)), Some((y0, y1))) = (x, y) {
            bounds.min = bounds.min.inf(&Vec2::new(x0, y0));
            bounds.max = bounds.max.sup(&Vec2::new(x1, y1));
        }
        let middle = (bounds.min + bounds.max) / 2.0;
        let half = ((bounds.max - bounds.min) / 2.0).map(|h| (1.1 * h).max(LEAST));
        Bounds {
            min: middle - half,
            max: middle + half,
        }
    }

    fn span(&self, histogram: &BTreeMap<i64, u64>) -> Option<(f64, f64)> {
        let outside = (OUTSIDE * self.count as f64) as u64;
        let low = beyond(histogram.iter(), outside)?;
        let high = beyond(histogram.iter().rev(), outside)?;
        Some((low as f64 * CELL, (high + 1) as f64 * CELL))
    }
}

/// The first cell with which more than `outside` echoes have passed.
fn beyond<'a>(mut cells: impl Iterator<Item = (&'a i64, &'a u64)>, outside: u64) -> Option<i64> {
    let mut passed = 0;
    cells
        .find(|(_, n)| {
            passed += **n;
            passed > outside
        })
        .map(|(cell, _)| *cell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::SonarId;
    use crate::tmam::arc::ArcId;

    fn echo(range: f64) -> Arc {
        Arc {
            id: ArcId {
                frame: 0,
                sonar: SonarId(0),
            },
            stamp_ns: 0,
            world_from_sensor: Pose2::IDENTITY,
            range,
            beam_width: 0.4,
            variance: 0.0,
        }
    }

    #[test]
    fn nothing_seen_still_gives_a_box() {
        let bounds = Extent::default().bounds();
        assert_eq!(bounds.min, Vec2::new(-LEAST, -LEAST));
        assert_eq!(bounds.max, Vec2::new(LEAST, LEAST));
    }

    #[test]
    fn a_wild_reading_does_not_shrink_the_map() {
        let mut extent = Extent::default();
        extent.visit(&Pose2::IDENTITY);
        for _ in 0..500 {
            extent.echo(&echo(3.0));
        }
        extent.echo(&echo(900.0));
        let bounds = extent.bounds();
        assert!(bounds.max.x > 3.0 && bounds.max.x < 4.0, "{bounds:?}");
    }
}
