//! Which feature was which: pairs by nearness, never by place in a list.
//!
//! What is identical is paired first. Among the rest, pairs within the gates are chosen so that
//! there are as many as can be and their distances add up to the least (Kuhn-Munkres).

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

use pathfinding::kuhn_munkres::kuhn_munkres;
use pathfinding::matrix::Matrix;

use super::results::{Feature, Geometry};
use super::tolerance::Tolerance;
use crate::geometry::{Vec2, angle_between, unit, wrap_angle};

/// Frames that may lie between the runs of an extracted feature and of its partner.
const FRAMES_APART: u32 = 10;
/// Groups with more possible pairs than this are paired nearest first: the optimum of a thousand
/// features that all lie on each other would take minutes and mean nothing.
const MOST_CELLS: usize = 250_000;
/// A pair counts this much, less its distance.
const PAIR: i64 = 1_000_000_000;
/// Distances are counted in such parts of a gate.
const PARTS: f64 = 1e6;

/// Pairs of places in the two lists.
pub fn pairs(golden: &[Feature], actual: &[Feature], tolerance: &Tolerance) -> Vec<(usize, usize)> {
    let mut found = identical(golden, actual);
    let taken = |side: fn(&(usize, usize)) -> usize| -> Vec<usize> {
        let mut taken: Vec<usize> = found.iter().map(side).collect();
        taken.sort_unstable();
        taken
    };
    let (in_golden, in_actual) = (taken(|pair| pair.0), taken(|pair| pair.1));
    let free = |len: usize, taken: &[usize]| -> Vec<usize> {
        (0..len)
            .filter(|place| taken.binary_search(place).is_err())
            .collect()
    };
    let rows = free(golden.len(), &in_golden);
    let columns = free(actual.len(), &in_actual);
    let mut edges = Vec::new();
    for row in &rows {
        for column in &columns {
            if let (Some(g), Some(a)) = (golden.get(*row), actual.get(*column))
                && let Some(cost) = distance(g, a, tolerance)
            {
                edges.push(Edge {
                    row: *row,
                    column: *column,
                    cost,
                });
            }
        }
    }
    for group in groups(edges) {
        found.extend(assign(&group));
    }
    found.sort_unstable();
    found
}

/// Two features that may be one, and how far apart they are: 0 to some gates.
#[derive(Debug, Clone, Copy)]
struct Edge {
    row: usize,
    column: usize,
    cost: f64,
}

/// Features that did not change at all.
fn identical(golden: &[Feature], actual: &[Feature]) -> Vec<(usize, usize)> {
    let mut waiting = BTreeMap::<String, Vec<usize>>::new();
    let key = |f: &Feature| {
        f.geometry.map(|geometry| {
            format!(
                "{geometry:?} {:?} {:?} {:?} {}",
                f.sensor, f.frames, f.fate, f.readings
            )
        })
    };
    for (place, feature) in actual.iter().enumerate().rev() {
        if let Some(key) = key(feature) {
            waiting.entry(key).or_default().push(place);
        }
    }
    let partner = |feature: &Feature| waiting.get_mut(&key(feature)?)?.pop();
    golden
        .iter()
        .map(partner)
        .enumerate()
        .filter_map(|(place, partner)| Some((place, partner?)))
        .collect()
}

/// How far apart two features are, in gates; `None` where they cannot be one.
fn distance(golden: &Feature, actual: &Feature, tolerance: &Tolerance) -> Option<f64> {
    if golden.kind != actual.kind || golden.sensor != actual.sensor {
        return None;
    }
    let extracted = golden.sensor.is_some();
    let apart = match (golden.frames, actual.frames) {
        (Some(g), Some(a)) if extracted => frames_apart(g, a)?,
        _ => 0.0,
    };
    let gate = |way: f64, gate: f64| {
        let part = if gate > 0.0 {
            way.abs() / gate
        } else {
            way.abs() * f64::INFINITY
        };
        (part <= 1.0).then_some(part * part)
    };
    let near = match (&golden.geometry, &actual.geometry) {
        (
            Some(Geometry::Line {
                rho,
                theta,
                mid,
                half_length,
            }),
            Some(other @ Geometry::Line { .. }),
        ) => {
            let (offset, angle) = signed_like(other, *theta)?;
            let Geometry::Line {
                mid: m,
                half_length: h,
                ..
            } = other
            else {
                return None;
            };
            let along = unit(theta + FRAC_PI_2).dot(&(Vec2::from(*m) - Vec2::from(*mid)));
            gate(offset - rho, tolerance.pair_distance)?
                + gate(wrap_angle(angle - theta), tolerance.pair_angle)?
                + gate(along, half_length + h + tolerance.pair_distance)?
        }
        (Some(Geometry::Point { x, y }), Some(Geometry::Point { x: u, y: v })) => {
            gate(libm::hypot(u - x, v - y), tolerance.pair_distance)?
        }
        (None, None) => 0.0,
        _ => return None,
    };
    Some(near + apart)
}

/// A line's (rho, theta) under the sign that is nearer to a given normal.
pub fn signed_like(line: &Geometry, normal: f64) -> Option<(f64, f64)> {
    match line {
        Geometry::Line { rho, theta, .. } if angle_between(*theta, normal) > FRAC_PI_2 => {
            Some((-rho, wrap_angle(theta + PI)))
        }
        Geometry::Line { rho, theta, .. } => Some((*rho, *theta)),
        Geometry::Point { .. } => None,
    }
}

/// How far two runs lie apart, as a part of what may be: their gap must be small, and of two runs
/// that could be meant the one that begins and ends alike is.
fn frames_apart(golden: [u32; 2], actual: [u32; 2]) -> Option<f64> {
    let ([a, b], [c, d]) = (golden, actual);
    let gap = c.saturating_sub(b).max(a.saturating_sub(d));
    (gap <= FRAMES_APART).then(|| {
        let shift = a.abs_diff(c).min(1000) + b.abs_diff(d).min(1000);
        f64::from(shift) / 100.0
    })
}

/// Edges that share no feature with those of another group can be decided apart from them.
fn groups(edges: Vec<Edge>) -> Vec<Vec<Edge>> {
    fn root(parents: &mut BTreeMap<usize, usize>, of: usize) -> usize {
        let mut at = of;
        while let Some(parent) = parents.get(&at).copied().filter(|parent| *parent != at) {
            at = parent;
        }
        parents.insert(of, at);
        at
    }
    // Rows are even numbers, columns odd ones.
    let mut parents = BTreeMap::new();
    for edge in &edges {
        let (a, b) = (
            root(&mut parents, 2 * edge.row),
            root(&mut parents, 2 * edge.column + 1),
        );
        parents.insert(a.max(b), a.min(b));
    }
    let mut groups = BTreeMap::<usize, Vec<Edge>>::new();
    for edge in edges {
        let root = root(&mut parents, 2 * edge.row);
        groups.entry(root).or_default().push(edge);
    }
    groups.into_values().collect()
}

fn assign(group: &[Edge]) -> Vec<(usize, usize)> {
    let places = |side: fn(&Edge) -> usize| -> Vec<usize> {
        let mut places: Vec<usize> = group.iter().map(side).collect();
        places.sort_unstable();
        places.dedup();
        places
    };
    let (rows, columns) = (places(|e| e.row), places(|e| e.column));
    if rows.len().saturating_mul(columns.len()) > MOST_CELLS {
        return nearest_first(group);
    }
    // The solver wants no more rows than columns.
    let turned = rows.len() > columns.len();
    let (short, long) = if turned {
        (&columns, &rows)
    } else {
        (&rows, &columns)
    };
    let mut weights = Matrix::new(short.len(), long.len(), 0_i64);
    for edge in group {
        let (s, l) = if turned {
            (edge.column, edge.row)
        } else {
            (edge.row, edge.column)
        };
        if let (Ok(s), Ok(l)) = (short.binary_search(&s), long.binary_search(&l))
            && let Some(weight) = weights.get_mut((s, l))
        {
            *weight = PAIR - (edge.cost * PARTS) as i64;
        }
    }
    let (_, partners) = kuhn_munkres(&weights);
    partners
        .into_iter()
        .enumerate()
        .filter(|(s, l)| weights.get((*s, *l)).is_some_and(|weight| *weight > 0))
        .filter_map(|(s, l)| {
            let (s, l) = (*short.get(s)?, *long.get(l)?);
            Some(if turned { (l, s) } else { (s, l) })
        })
        .collect()
}

fn nearest_first(group: &[Edge]) -> Vec<(usize, usize)> {
    let mut edges = group.to_vec();
    edges.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let (mut rows, mut columns) = (BTreeMap::new(), BTreeMap::new());
    for edge in edges {
        if !rows.contains_key(&edge.row) && !columns.contains_key(&edge.column) {
            rows.insert(edge.row, edge.column);
            columns.insert(edge.column, edge.row);
        }
    }
    rows.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(xs: &[f64]) -> Vec<Feature> {
        xs.iter().map(|x| Feature::point(*x, 0.0)).collect()
    }

    #[test]
    fn the_sum_of_the_ways_is_the_least_and_the_order_does_not_matter() {
        // Nearest first would pair 0.2 with 0.15 and leave 0 without a partner in reach.
        let pairs_of = |g: &[f64], a: &[f64]| pairs(&points(g), &points(a), &Tolerance::default());
        assert_eq!(pairs_of(&[0.0, 0.2], &[0.15, 0.45]), [(0, 0), (1, 1)]);
        assert_eq!(pairs_of(&[0.2, 0.0], &[0.45, 0.15]), [(0, 0), (1, 1)]);
        assert_eq!(pairs_of(&[0.2, 0.0, 5.0], &[0.15]).len(), 1);
        assert_eq!(pairs_of(&[0.0], &[0.31]), []);
    }

    #[test]
    fn what_did_not_move_keeps_its_partner() {
        let (golden, actual) = (points(&[0.0, 0.1]), points(&[0.1, 0.2]));
        let found = pairs(&golden, &actual, &Tolerance::default());
        assert_eq!(found, [(0, 1), (1, 0)]);
    }

    #[test]
    fn one_line_under_both_signs_is_one_line() {
        let a = [Feature::line(0.01, 3.1, [0.0, 0.0], 1.0)];
        let b = [Feature::line(
            -0.02,
            3.12 - std::f64::consts::PI,
            [0.0, 0.0],
            1.0,
        )];
        let c = [Feature::line(
            0.01,
            3.1 - std::f64::consts::PI,
            [0.0, 0.0],
            1.0,
        )];
        for other in [b, c] {
            assert_eq!(pairs(&a, &other, &Tolerance::default()).len(), 1);
        }
    }

    #[test]
    fn segments_of_one_wall_that_lie_apart_are_two() {
        let a = [Feature::wall([0.0, 1.0], [1.0, 1.0])];
        let b = [Feature::wall([2.0, 1.0], [3.0, 1.0])];
        let c = [Feature::wall([0.5, 1.0], [1.5, 1.0])];
        assert!(pairs(&a, &b, &Tolerance::default()).is_empty());
        assert_eq!(pairs(&a, &c, &Tolerance::default()), [(0, 0)]);
    }

    #[test]
    fn hundreds_of_features_in_one_place_are_still_paired() {
        let many: Vec<f64> = (0..600).map(|i| f64::from(i) * 1e-5).collect();
        let moved: Vec<f64> = many.iter().map(|x| x + 0.02).collect();
        assert_eq!(
            pairs(&points(&many), &points(&moved), &Tolerance::default()).len(),
            600
        );
    }
}
