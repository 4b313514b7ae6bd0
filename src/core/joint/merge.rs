//! Which landmarks are one feature seen twice: those that agree under the joint covariance.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, Matrix2, Vector2};

use super::landmark::Landmark;
use crate::core::geometry::Vec2;
use crate::core::tmam::feature::Segment;

/// Squared Mahalanobis distance (two degrees of freedom) up to which two landmarks are one.
const GATE: f64 = 16.0;

/// The longest gap between two pieces of one wall, and the longest way between two points that are one,
/// metres.
const APART: f64 = 1.0;

/// The largest angle between two pieces of one wall, radians.
const TURNED: f64 = 0.5;

/// A second partner that fits almost as well leaves it open which one is right: its squared distance is
/// within this of the better one's.
const DECISIVE: f64 = 9.0;

/// Walls are not flat and corners not sharp, metres and radians.
const ROUGHNESS: f64 = 1e-3;

/// A landmark with where it is seen.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    pub landmark: Landmark,
    /// Of a line.
    pub extent: Option<Segment>,
    /// Its first parameter among the shared unknowns.
    pub at: usize,
}

/// Two landmarks that are one, by their places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    pub first: usize,
    pub second: usize,
    /// Squared Mahalanobis distance.
    pub distance: f64,
    /// The same and what the covariance leaves open: the lower, the surer.
    doubt: f64,
}

/// The pairs that are one, the surest first. Each is taken in before the next one is accepted; which are
/// near is looked at again when no landmark is left that has not changed.
pub fn pairs(seen: &[Seen], covariance: DMatrix<f64>) -> Vec<Pair> {
    let mut joint = Joint {
        seen: seen.iter().copied().map(Some).collect(),
        covariance,
    };
    let mut found = Vec::new();
    loop {
        let near = Near::of(&joint);
        let mut changed: BTreeSet<usize> = BTreeSet::new();
        for pair in near.clear() {
            let is_new = [pair.first, pair.second]
                .iter()
                .all(|at| !changed.contains(at));
            if is_new
                && joint
                    .distance_of(&pair)
                    .is_some_and(|(distance, _)| distance < GATE)
            {
                joint.unite(&pair);
                changed.extend([pair.first, pair.second]);
                found.push(pair);
            }
        }
        if changed.is_empty() {
            return found;
        }
    }
}

/// Landmarks with their joint covariance.
struct Joint {
    seen: Vec<Option<Seen>>,
    covariance: DMatrix<f64>,
}

/// The pairs of landmarks that are near to each other.
struct Near {
    distances: BTreeMap<(usize, usize), (f64, f64)>,
    partners: BTreeMap<usize, Vec<usize>>,
}

impl Near {
    fn of(joint: &Joint) -> Self {
        let mut near = Self {
            distances: BTreeMap::new(),
            partners: BTreeMap::new(),
        };
        let seen = || joint.seen.iter().enumerate();
        for (first, a) in seen().filter_map(|(at, seen)| Some((at, seen.as_ref()?))) {
            let others = seen().skip(first + 1);
            for (second, b) in others.filter_map(|(at, seen)| Some((at, seen.as_ref()?))) {
                if let Some(found) = joint.distance(a, b)
                    && found.0 < GATE + DECISIVE
                {
                    near.distances.insert((first, second), found);
                    near.partners.entry(first).or_default().push(second);
                    near.partners.entry(second).or_default().push(first);
                }
            }
        }
        near
    }

    fn distance(&self, a: usize, b: usize) -> Option<f64> {
        let found = self.distances.get(&(a.min(b), a.max(b)));
        found.map(|(distance, _)| *distance)
    }

    /// Those that are one and have no rival, the surest first.
    fn clear(&self) -> Vec<Pair> {
        let pairs = self.distances.iter();
        let mut clear: Vec<Pair> = pairs
            .map(|((first, second), (distance, doubt))| Pair {
                first: *first,
                second: *second,
                distance: *distance,
                doubt: *doubt,
            })
            .filter(|pair| pair.distance < GATE)
            .filter(|pair| !self.has_rival(pair.first, pair.second, pair.distance))
            .filter(|pair| !self.has_rival(pair.second, pair.first, pair.distance))
            .collect();
        // By whole millionths, so that rounding does not decide.
        let rank = |pair: &Pair| libm::rint(pair.doubt * 1e6);
        clear.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
        clear
    }

    /// Whether a landmark has another partner that fits almost as well as the chosen one, and is not the
    /// same as that.
    fn has_rival(&self, of: usize, chosen: usize, distance: f64) -> bool {
        let partners = self.partners.get(&of).into_iter().flatten();
        partners.filter(|rival| **rival != chosen).any(|rival| {
            let almost = |other: f64| other < distance + DECISIVE;
            let is_other = self
                .distance(*rival, chosen)
                .is_none_or(|apart| apart >= GATE);
            is_other && self.distance(of, *rival).is_some_and(almost)
        })
    }
}

/// How two landmarks differ.
struct Difference {
    apart: Vector2<f64>,
    covariance: Matrix2<f64>,
    by: [Matrix2<f64>; 2],
}

impl Joint {
    fn distance_of(&self, pair: &Pair) -> Option<(f64, f64)> {
        let [a, b] = [pair.first, pair.second].map(|at| self.seen.get(at)?.as_ref());
        self.distance(a?, b?)
    }

    fn distance(&self, a: &Seen, b: &Seen) -> Option<(f64, f64)> {
        let place = meeting_place(a, b)?;
        let Difference {
            apart, covariance, ..
        } = self.difference(a, b, place)?;
        if apart.x.abs() > APART || (a.extent.is_some() && apart.y.abs() > TURNED) {
            return None;
        }
        let inverse = covariance.try_inverse()?;
        let distance = apart.dot(&(inverse * apart));
        let doubt = distance + libm::log(covariance.determinant().max(f64::MIN_POSITIVE));
        Some((distance, doubt))
    }

    fn difference(&self, a: &Seen, b: &Seen, place: Vec2) -> Option<Difference> {
        let (apart, by) = a.landmark.difference(&b.landmark, place)?;
        let block = |row: usize, column: usize| self.covariance.fixed_view::<2, 2>(row, column);
        let [by_a, by_b] = by;
        let cross = by_a * block(a.at, b.at) * by_b.transpose();
        let covariance = by_a * block(a.at, a.at) * by_a.transpose()
            + by_b * block(b.at, b.at) * by_b.transpose()
            + cross
            + cross.transpose()
            + Matrix2::identity() * (ROUGHNESS * ROUGHNESS);
        Some(Difference {
            apart,
            covariance,
            by,
        })
    }

    /// Takes in that a pair is one, as a measurement of their difference.
    fn unite(&mut self, pair: &Pair) {
        let (Some(Some(a)), Some(Some(b))) =
            (self.seen.get(pair.first), self.seen.get(pair.second))
        else {
            return;
        };
        let (a, b) = (*a, *b);
        let difference = meeting_place(&a, &b).and_then(|place| self.difference(&a, &b, place));
        if let Some(Difference {
            apart,
            covariance,
            by: [by_a, by_b],
        }) = difference
            && let Some(inverse) = covariance.try_inverse()
        {
            // Covariance of every unknown with the difference.
            let with = self.covariance.fixed_columns::<2>(a.at) * by_a.transpose()
                + self.covariance.fixed_columns::<2>(b.at) * by_b.transpose();
            let gain = &with * inverse;
            let step = &gain * -apart;
            for seen in self.seen.iter_mut().flatten() {
                let moved = step.fixed_rows::<2>(seen.at);
                seen.landmark = seen.landmark.moved(moved.into_owned());
            }
            for axis in 0..2 {
                self.covariance
                    .ger(-1.0, &gain.column(axis), &with.column(axis), 1.0);
            }
        }
        let extent = match (a.extent, b.extent) {
            (Some(a), Some(b)) => Some(a.reaching_over([a, b].iter().flat_map(Segment::ends))),
            (a, _) => a,
        };
        if let Some(place) = self.seen.get_mut(pair.first).and_then(Option::as_mut) {
            place.extent = extent;
        }
        if let Some(place) = self.seen.get_mut(pair.second) {
            *place = None;
        }
    }
}

/// Where two landmarks of a kind are compared: the middle of the stretch on which both lines are seen, or
/// of the gap between them. `None` where they are too far apart to be one.
fn meeting_place(a: &Seen, b: &Seen) -> Option<Vec2> {
    match (&a.landmark, &b.landmark, a.extent, b.extent) {
        (Landmark::Point(a), Landmark::Point(b), _, _) => {
            ((a - b).norm() < APART).then(|| (a + b) / 2.0)
        }
        (Landmark::Line { .. }, Landmark::Line { .. }, Some(a), Some(b)) => {
            let along = a.along();
            let ways = |segment: &Segment| {
                let [first, second] = segment.ends().map(|end| end.dot(&along));
                [first.min(second), first.max(second)]
            };
            let ([low_a, high_a], [low_b, high_b]) = (ways(&a), ways(&b));
            let (from, to) = (low_a.max(low_b), high_a.min(high_b));
            let gap = from - to;
            let middle = along.dot(&a.mid);
            let place = a.mid + along * ((from + to) / 2.0 - middle);
            (gap < APART).then_some(place)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points with a standard deviation of 3 cm each, independent of each other.
    fn points(places: &[(f64, f64)]) -> (Vec<Seen>, DMatrix<f64>) {
        let seen = places.iter().enumerate().map(|(at, (x, y))| Seen {
            landmark: Landmark::Point(Vec2::new(*x, *y)),
            extent: None,
            at: 2 + 2 * at,
        });
        let size = 2 + 2 * places.len();
        (seen.collect(), DMatrix::identity(size, size) * 9e-4)
    }

    fn found(places: &[(f64, f64)]) -> Vec<(usize, usize)> {
        let (seen, covariance) = points(places);
        let pairs = pairs(&seen, covariance);
        pairs.iter().map(|pair| (pair.first, pair.second)).collect()
    }

    #[test]
    fn what_agrees_is_one() {
        assert_eq!(found(&[(0.0, 0.0), (0.05, 0.05), (3.0, 0.0)]), [(0, 1)]);
    }

    #[test]
    fn what_was_seen_three_times_is_one() {
        assert_eq!(found(&[(0.0, 0.0), (0.05, 0.0), (0.02, 0.04)]).len(), 2);
    }

    #[test]
    fn of_two_partners_that_fit_as_well_neither_is_taken() {
        assert!(found(&[(0.0, 0.0), (0.09, 0.0), (-0.1, 0.0)]).is_empty());
    }

    #[test]
    fn what_is_taken_in_moves_what_goes_with_it() {
        // The second and the third are known to be a metre apart, to the millimetre.
        let (seen, mut covariance) = points(&[(0.0, 0.0), (0.08, 0.0), (1.08, 0.0), (1.0, 0.0)]);
        for axis in 0..2 {
            let (b, c) = (4 + axis, 6 + axis);
            covariance[(b, c)] = 9e-4 - 1e-6;
            covariance[(c, b)] = 9e-4 - 1e-6;
        }
        let mut joint = Joint {
            seen: seen.iter().copied().map(Some).collect(),
            covariance,
        };
        let distance = |joint: &Joint| {
            let [c, d] = [2, 3].map(|at| joint.seen[at].unwrap());
            joint.distance(&c, &d).unwrap().0
        };
        let before = distance(&joint);
        joint.unite(&Pair {
            first: 0,
            second: 1,
            distance: 0.0,
            doubt: 0.0,
        });
        assert!(
            distance(&joint) < before / 2.0,
            "{before} {}",
            distance(&joint)
        );
    }
}
