//! Lines through many places, by a Hough transform.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::regression::line_through;
use super::rival::Found;
use crate::core::geometry::{Vec2, unit};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::Shape;

/// Directions of normals, over half a turn.
const ANGLES: i32 = 90;
/// A cell of distances, metres.
const OFFSET: f64 = 0.05;
/// Places that a line needs.
const PLACES: usize = 10;
/// How long it has to be, metres.
const LENGTH: f64 = 0.5;
/// Lines at most.
const MOST: usize = 200;

/// The lines through places, each with the arc that it stands on; the one with most places first. A line
/// ends where for `longest_gap` metres there is none.
pub fn lines(places: &[(Vec2, Arc)], longest_gap: f64) -> Vec<Found> {
    let mut left: Vec<(Vec2, Arc)> = places.to_vec();
    let mut cells = BTreeMap::<(i32, i64), usize>::new();
    for (place, _) in &left {
        for cell in cells_of(*place) {
            *cells.entry(cell).or_default() += 1;
        }
    }
    let mut found = Vec::new();
    for _ in 0..MOST {
        // Of equally many the first.
        let best = cells
            .iter()
            .fold((PLACES - 1, None), |best, (cell, count)| {
                if *count > best.0 {
                    (*count, Some(*cell))
                } else {
                    best
                }
            });
        let Some((angle, offset)) = best.1 else {
            break;
        };
        let normal = unit(normal_of(angle));
        let middle = (offset as f64 + 0.5) * OFFSET;
        let (on, rest): (Vec<_>, Vec<_>) = left
            .into_iter()
            .partition(|(place, _)| (place.dot(&normal) - middle).abs() <= OFFSET);
        for cell in on.iter().flat_map(|(place, _)| cells_of(*place)) {
            if let Some(count) = cells.get_mut(&cell) {
                *count = count.saturating_sub(1);
            }
        }
        // What rounding puts beside its own cell must not be found for ever.
        cells.remove(&(angle, offset));
        left = rest;
        found.extend(
            stretches(on, normal, longest_gap)
                .into_iter()
                .filter_map(line),
        );
    }
    found
}

/// The cells that a place votes for, one an angle.
fn cells_of(place: Vec2) -> impl Iterator<Item = (i32, i64)> {
    (0..ANGLES).map(move |angle| {
        let offset = place.dot(&unit(normal_of(angle)));
        (angle, (offset / OFFSET).floor() as i64)
    })
}

fn normal_of(angle: i32) -> f64 {
    f64::from(angle) * PI / f64::from(ANGLES)
}

/// Places in the order along a line, apart where there is a gap.
fn stretches(mut on: Vec<(Vec2, Arc)>, normal: Vec2, longest_gap: f64) -> Vec<Vec<(Vec2, Arc)>> {
    let along = Vec2::new(-normal.y, normal.x);
    on.sort_by(|(a, _), (b, _)| a.dot(&along).total_cmp(&b.dot(&along)));
    let mut stretches: Vec<Vec<(Vec2, Arc)>> = Vec::new();
    for one in on {
        let way = one.0.dot(&along);
        let joins = |last: &&mut Vec<(Vec2, Arc)>| {
            let end = last.last().map(|(place, _)| place.dot(&along));
            end.is_some_and(|end| way - end <= longest_gap)
        };
        match stretches.last_mut().filter(joins) {
            Some(last) => last.push(one),
            None => stretches.push(vec![one]),
        }
    }
    stretches
}

fn line(stretch: Vec<(Vec2, Arc)>) -> Option<Found> {
    let places: Vec<Vec2> = stretch.iter().map(|(place, _)| *place).collect();
    let line = line_through(&places)?;
    let is_line = stretch.len() >= PLACES && 2.0 * line.half_length >= LENGTH;
    is_line.then(|| Found {
        shape: Shape::Line(line),
        arcs: stretch.into_iter().map(|(_, arc)| arc).collect(),
    })
}
