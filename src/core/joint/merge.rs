//! Which landmarks are one feature seen twice: those that agree under the joint covariance.

use nalgebra::{DMatrix, Matrix2, Vector2};

use super::landmark::Landmark;
use crate::core::geometry::Vec2;
use crate::core::ties;
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

/// The pairs that are one, the surest first; each is taken in before the next one is looked for.
pub fn pairs(seen: &[Seen], covariance: DMatrix<f64>) -> Vec<Pair> {
    let mut joint = Joint {
        seen: seen.iter().copied().map(Some).collect(),
        covariance,
    };
    let mut found = Vec::new();
    while let Some(pair) = joint.surest() {
        joint.unite(&pair);
        found.push(pair);
    }
    found
}

/// Landmarks with their joint covariance.
struct Joint {
    seen: Vec<Option<Seen>>,
    covariance: DMatrix<f64>,
}

/// How two landmarks differ.
struct Difference {
    apart: Vector2<f64>,
    covariance: Matrix2<f64>,
    by: [Matrix2<f64>; 2],
}

impl Joint {
    fn surest(&self) -> Option<Pair> {
        let mut close: Vec<Pair> = Vec::new();
        for (first, a) in self.seen.iter().enumerate() {
            for (second, b) in self.seen.iter().enumerate().skip(first + 1) {
                if let (Some(a), Some(b)) = (a, b)
                    && let Some((distance, doubt)) = self.distance(a, b)
                    && distance < GATE + DECISIVE
                {
                    close.push(Pair {
                        first,
                        second,
                        distance,
                        doubt,
                    });
                }
            }
        }
        let near = close.iter().filter(|pair| pair.distance < GATE);
        let clear = near.filter(|pair| !self.is_ambiguous(pair, &close));
        let surest = clear.map(|pair| (pair.doubt, *pair));
        ties::first_least(surest, |_, _| 1e-6).map(|(_, pair)| pair)
    }

    /// Whether one of the two has another partner that fits almost as well, and is not the same as the
    /// first.
    fn is_ambiguous(&self, pair: &Pair, close: &[Pair]) -> bool {
        let partner = |of: usize, other: &Pair| match other {
            Pair { first, second, .. } if *first == of => Some(*second),
            Pair { first, second, .. } if *second == of => Some(*first),
            _ => None,
        };
        let rival = |of: usize, chosen: usize| {
            close.iter().any(|other| {
                partner(of, other).is_some_and(|rival| {
                    rival != chosen
                        && other.distance < pair.distance + DECISIVE
                        && !self.are_near(rival, chosen)
                })
            })
        };
        rival(pair.first, pair.second) || rival(pair.second, pair.first)
    }

    fn are_near(&self, a: usize, b: usize) -> bool {
        match (self.seen.get(a), self.seen.get(b)) {
            (Some(Some(a)), Some(Some(b))) => self
                .distance(a, b)
                .is_some_and(|(distance, _)| distance < GATE),
            _ => false,
        }
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
