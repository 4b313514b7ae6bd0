//! Fusion of extracted features with the registered ones.

mod ends;
mod explained;
mod gather;
mod information;
mod paper;

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use super::arc::Arc;
use super::feature::{Action, MapFeature, Point, Segment, Shape, Status};
use crate::config::{Config, Departures, Map as Bounds};
use crate::geometry::{angle_between, unit};

/// The registered features.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    features: Vec<MapFeature>,
    next_id: u32,
    /// The readings of features that a single run gave.
    lone: BTreeMap<u32, Vec<Arc>>,
    bounds: Bounds,
    departures: Departures,
}

/// What became of a feature in the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Fused {
    /// Whether it is new.
    pub action: Action,
    /// The map feature it went into, as it is now.
    pub feature: MapFeature,
    /// Map features that turned out to be the same, and are gone.
    pub absorbed: Vec<u32>,
}

impl Map {
    /// An empty map.
    pub fn new(config: &Config) -> Self {
        Self {
            features: Vec::new(),
            next_id: 0,
            lone: BTreeMap::new(),
            bounds: config.map.clone(),
            departures: config.departures(),
        }
    }

    /// Every registered feature, by id.
    pub fn features(&self) -> &[MapFeature] {
        &self.features
    }

    /// Fuses a feature that a run of associated readings gave with the nearest match, or registers it
    /// as a new one.
    pub fn add(&mut self, shape: Shape, associated: &[Arc]) -> Fused {
        let readings = u32::try_from(associated.len()).unwrap_or(u32::MAX);
        let at = self.nearest(&shape, None);
        if let Some(known) = at.and_then(|at| self.features.get(at)).copied() {
            return self.merge(known, shape, readings);
        }
        let mut feature = MapFeature {
            id: self.next_id,
            shape,
            readings,
            runs: 1,
            status: Status::Confirmed,
        };
        feature.status = self.status(&feature);
        self.next_id = self.next_id.saturating_add(1);
        self.features.push(feature);
        if self.departures.confirm {
            self.lone.insert(feature.id, associated.to_vec());
        }
        Fused {
            action: Action::Registered(feature.id),
            feature,
            absorbed: Vec::new(),
        }
    }

    /// The end of the log: a feature of a single run stays tentative if another one with more
    /// support looks like it or explains all its readings. Returns what changed.
    pub fn settle(&mut self, arcs: &[Arc]) -> Vec<MapFeature> {
        let doubtful = |lone: &MapFeature, arcs: &[Arc]| {
            let stronger = |f: &&MapFeature| {
                f.status == Status::Confirmed && f.runs > 1 && f.readings > lone.readings
            };
            self.features.iter().filter(stronger).any(|other| {
                alike(other, lone, self.bounds.match_distance)
                    || explained::explains(&other.shape, arcs)
            })
        };
        let confirmed = self
            .features
            .iter()
            .filter(|f| f.status == Status::Confirmed);
        let mut settled: Vec<MapFeature> = confirmed
            .filter(|f| self.lone.get(&f.id).is_some_and(|arcs| doubtful(f, arcs)))
            .map(|feature| MapFeature {
                status: Status::Tentative,
                ..*feature
            })
            .collect();
        self.put(&settled);
        settled.extend(self.end_walls());
        if self.departures.gather {
            let gathered = gather::gather(&self.features, arcs, &self.bounds);
            self.put(&gathered);
            settled.extend(gathered);
            settled.extend(self.end_walls());
        }
        settled
    }

    fn put(&mut self, changed: &[MapFeature]) {
        for changed in changed {
            if let Some(feature) = self.features.iter_mut().find(|f| f.id == changed.id) {
                *feature = *changed;
            }
        }
    }

    /// Ends walls at the confirmed points on them.
    fn end_walls(&mut self) -> Vec<MapFeature> {
        if !self.departures.end_at_corners {
            return Vec::new();
        }
        let points = confirmed_points(&self.features);
        let mut changed = Vec::new();
        for feature in &mut self.features {
            let cut = ends::cut(feature.shape, &points);
            if cut != feature.shape {
                feature.shape = cut;
                changed.push(*feature);
            }
        }
        changed
    }

    fn merge(&mut self, known: MapFeature, shape: Shape, readings: u32) -> Fused {
        let mut feature = MapFeature {
            shape: self.fuse(&known, &shape, readings),
            readings: known.readings.saturating_add(readings),
            runs: known.runs.saturating_add(1),
            ..known
        };
        let absorbed = if self.departures.merge {
            self.absorb(&mut feature)
        } else {
            Vec::new()
        };
        feature.status = self.status(&feature);
        self.lone.remove(&feature.id);
        if let Some(place) = self.features.iter_mut().find(|f| f.id == feature.id) {
            *place = feature;
        }
        Fused {
            action: Action::Merged(feature.id),
            feature,
            absorbed,
        }
    }

    /// Takes up every other feature that is the same now that `feature` has changed.
    fn absorb(&mut self, feature: &mut MapFeature) -> Vec<u32> {
        let mut absorbed = Vec::new();
        while let Some(at) = self.nearest(&feature.shape, Some(feature.id)) {
            let other = self.features.remove(at);
            feature.shape = self.fuse(feature, &other.shape, other.readings);
            feature.readings = feature.readings.saturating_add(other.readings);
            feature.runs = feature.runs.saturating_add(other.runs);
            self.lone.remove(&other.id);
            absorbed.push(other.id);
        }
        absorbed
    }

    /// The place of the nearest feature within the gates, but for the one with the id `except`.
    fn nearest(&self, shape: &Shape, except: Option<u32>) -> Option<usize> {
        let others = self.features.iter().enumerate();
        others
            .filter(|(_, known)| Some(known.id) != except)
            .filter_map(|(at, known)| Some((self.distance(shape, known)?, at)))
            .min_by(|(a, _), (b, _)| a.total_cmp(b))
            .map(|(_, at)| at)
    }

    /// How far a feature is from a registered one; `None` beyond the gates.
    fn distance(&self, shape: &Shape, known: &MapFeature) -> Option<f64> {
        if self.departures.fuse_by_information {
            information::distance(shape, &known.shape, self.bounds.max_wall_gap)
                .filter(|distance| *distance < self.bounds.gate)
        } else {
            paper::deviation(shape, known, self.bounds.match_distance)
        }
    }

    fn fuse(&self, known: &MapFeature, shape: &Shape, readings: u32) -> Shape {
        if self.departures.fuse_by_information {
            information::fuse(&known.shape, shape)
        } else {
            paper::fuse(known, shape, readings)
        }
    }

    fn status(&self, feature: &MapFeature) -> Status {
        let supported = feature.runs >= self.bounds.confirm_runs
            || feature.readings >= self.bounds.confirm_readings;
        if supported || !self.departures.confirm {
            Status::Confirmed
        } else {
            Status::Tentative
        }
    }
}

/// How many features of a map look like another one: lines that overlap within 5 cm and 5 degrees,
/// points within `match_distance`. The gates of (24) and (25), a standard deviation wide, leave
/// such duplicates.
pub fn duplicates(features: &[MapFeature], match_distance: f64) -> usize {
    features
        .iter()
        .enumerate()
        .filter(|(place, feature)| {
            features
                .iter()
                .take(*place)
                .any(|other| alike(other, feature, match_distance))
        })
        .count()
}

fn confirmed_points(features: &[MapFeature]) -> Vec<Point> {
    let confirmed = features.iter().filter(|f| f.status == Status::Confirmed);
    confirmed
        .filter_map(|feature| match feature.shape {
            Shape::Point(point) => Some(point),
            Shape::Line(_) => None,
        })
        .collect()
}

fn alike(a: &MapFeature, b: &MapFeature, match_distance: f64) -> bool {
    match (&a.shape, &b.shape) {
        (Shape::Line(a), Shape::Line(b)) => coincide(a, b),
        (Shape::Point(a), Shape::Point(b)) => (a.position - b.position).norm() < match_distance,
        _ => false,
    }
}

fn coincide(a: &Segment, b: &Segment) -> bool {
    let offset = unit(a.theta).dot(&b.mid) - a.rho;
    let way = unit(a.theta + FRAC_PI_2).dot(&(b.mid - a.mid)).abs();
    let tilt = angle_between(a.theta, signed_like(b, a).theta);
    offset.abs() < 0.05 && tilt < 5_f64.to_radians() && way < a.half_length + b.half_length
}

/// The segment under the sign of (rho, theta) that is nearer to the other's.
fn signed_like(segment: &Segment, other: &Segment) -> Segment {
    if angle_between(segment.theta, other.theta) > FRAC_PI_2 {
        segment.flipped()
    } else {
        *segment
    }
}

/// The segment with the extent of the given ones, projected on its line.
fn spanning(line: Segment, segments: &[Segment]) -> Segment {
    let along = unit(line.theta + FRAC_PI_2);
    let (low, high) = segments
        .iter()
        .flat_map(Segment::ends)
        .map(|end| end.dot(&along))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), way| {
            (low.min(way), high.max(way))
        });
    Segment {
        mid: unit(line.theta) * line.rho + along * ((low + high) / 2.0),
        half_length: (high - low) / 2.0,
        ..line
    }
}

/// By how much two segments overlap along the first one's line, metres; negative where there is a
/// gap between them.
fn overlap(a: &Segment, b: &Segment) -> f64 {
    let along = unit(a.theta + FRAC_PI_2);
    let way = along.dot(&(b.mid - a.mid)).abs();
    a.half_length + b.half_length - way
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Rule;
    use crate::geometry::Vec2;
    use crate::tmam::fit::testing::arc;
    use nalgebra::Matrix2;
    use proptest::prelude::*;

    fn segment(rho: f64, theta: f64, way: f64, half_length: f64, sigma: [f64; 2]) -> Segment {
        let along = unit(theta + FRAC_PI_2);
        let c = 0.3 * sigma[0] * sigma[1];
        Segment {
            rho,
            theta,
            covariance: Matrix2::new(sigma[0] * sigma[0], c, c, sigma[1] * sigma[1]),
            mid: unit(theta) * rho + along * way,
            half_length,
        }
        .canonical()
    }

    fn only(map: &Map) -> MapFeature {
        assert_eq!(map.features().len(), 1, "{:?}", map.features());
        map.features()[0]
    }

    fn line(feature: &MapFeature) -> Segment {
        match feature.shape {
            Shape::Line(segment) => segment,
            Shape::Point(_) => panic!("a point"),
        }
    }

    /// A run of so many readings.
    fn readings(n: u32) -> Vec<Arc> {
        (0..n).map(|k| arc(k, Vec2::zeros(), 0.0, 1.0)).collect()
    }

    fn map_of(segments: &[(Segment, u32)]) -> Map {
        let mut map = Map::new(&Config::with_rule(Rule::Paper));
        for (segment, n) in segments {
            map.add(Shape::Line(*segment), &readings(*n));
        }
        map
    }

    proptest! {
        /// Walls through the origin, where rho changes sign with the noise, included.
        #[test]
        fn two_merges_in_either_order_give_the_same_line(
            rho in -0.02..3.0, theta in -3.2..3.2,
            e in prop::array::uniform4(-0.01..0.01),
            n in prop::array::uniform3(3u32..20),
        ) {
            let sigma = [0.05, 0.05];
            let a = segment(rho, theta, 0.0, 0.5, sigma);
            let b = segment(rho + e[0], theta + e[1], 0.2, 0.4, sigma);
            let c = segment(rho + e[2], theta + e[3], -0.3, 0.6, sigma);
            let one = only(&map_of(&[(a, n[0]), (b, n[1]), (c, n[2])]));
            let two = only(&map_of(&[(a, n[0]), (c, n[2]), (b, n[1])]));
            prop_assert_eq!(one.readings, two.readings);
            let (one, two) = (line(&one), signed_like(&line(&two), &line(&one)));
            prop_assert!((one.rho - two.rho).abs() < 1e-9);
            prop_assert!(angle_between(one.theta, two.theta) < 1e-9);
            prop_assert!((one.covariance - two.covariance).norm() < 1e-12);
            // The ends are projected twice, so they agree to the second order of the angles.
            prop_assert!((one.mid - two.mid).norm() < 1e-3 && (one.half_length - two.half_length).abs() < 1e-3);
        }

        #[test]
        fn the_sign_of_rho_and_theta_does_not_matter(rho in 0.0..3.0, theta in -3.2..3.2, e in prop::array::uniform2(-0.01..0.01), n in 3u32..20) {
            let a = segment(rho, theta, 0.0, 0.5, [0.05, 0.05]);
            let b = segment(rho + e[0], theta + e[1], 0.2, 0.4, [0.05, 0.05]);
            let plain = line(&only(&map_of(&[(a, 5), (b, n)])));
            let flipped = line(&only(&map_of(&[(a, 5), (b.flipped(), n)])));
            prop_assert!((plain.rho - flipped.rho).abs() < 1e-12);
            prop_assert!(angle_between(plain.theta, flipped.theta) < 1e-12);
            prop_assert!((plain.mid - flipped.mid).norm() < 1e-9);
            prop_assert!((plain.covariance - flipped.covariance).norm() < 1e-12);
            prop_assert!(plain.rho >= 0.0);
        }

        #[test]
        fn two_merges_in_either_order_give_the_same_point(e in prop::array::uniform4(-0.05..0.05), n in prop::array::uniform3(3u32..20)) {
            let point = |x: f64, y: f64| Shape::Point(Point { position: Vec2::new(1.0 + x, y), covariance: Matrix2::identity() * 1e-4 });
            let (a, b, c) = (point(0.0, 0.0), point(e[0], e[1]), point(e[2], e[3]));
            let fused = |order: [(Shape, u32); 3]| {
                let mut map = Map::new(&Config::with_rule(Rule::Paper));
                for (shape, n) in order { map.add(shape, &readings(n)); }
                match only(&map).shape { Shape::Point(p) => p, Shape::Line(_) => panic!("a line") }
            };
            let one = fused([(a, n[0]), (b, n[1]), (c, n[2])]);
            let two = fused([(a, n[0]), (c, n[2]), (b, n[1])]);
            prop_assert!((one.position - two.position).norm() < 1e-12);
            prop_assert!((one.covariance - two.covariance).norm() < 1e-12);
        }
    }

    #[test]
    fn equation_25_compares_squares() {
        // 5 cm apart with 4 cm of deviation each: 0.05 > 0.0032, as the paper prints it, would not
        // match, nor would -0.05 < 0.0032 ever fail.
        let sigma = [0.04, 0.05];
        let a = segment(2.0, 0.3, 0.0, 0.5, sigma);
        assert_eq!(
            map_of(&[(a, 4), (segment(2.05, 0.3, 0.0, 0.5, sigma), 4)])
                .features()
                .len(),
            1
        );
        assert_eq!(
            map_of(&[(a, 4), (segment(2.06, 0.3, 0.0, 0.5, sigma), 4)])
                .features()
                .len(),
            2
        );
        assert_eq!(
            map_of(&[(a, 4), (segment(1.94, 0.3, 0.0, 0.5, sigma), 4)])
                .features()
                .len(),
            2
        );
    }

    #[test]
    fn lines_that_do_not_overlap_stay_apart() {
        let sigma = [0.05, 0.05];
        let a = segment(2.0, 0.3, 0.0, 0.5, sigma);
        let b = segment(2.0, 0.3, 1.1, 0.5, sigma);
        assert_eq!(map_of(&[(a, 4), (b, 4)]).features().len(), 2);
    }

    #[test]
    fn the_fused_segment_spans_both() {
        let sigma = [0.05, 0.05];
        let a = segment(2.0, 0.3, 0.0, 0.5, sigma);
        let b = segment(2.0, 0.3, 0.8, 0.5, sigma);
        let fused = line(&only(&map_of(&[(a, 4), (b, 4)])));
        assert!(
            (fused.half_length - 0.9).abs() < 1e-12,
            "{}",
            fused.half_length
        );
    }

    #[test]
    fn the_nearest_match_wins_and_ids_stay() {
        let mut map = Map::new(&Config::with_rule(Rule::Paper));
        let point = |x: f64| {
            Shape::Point(Point {
                position: Vec2::new(x, 0.0),
                covariance: Matrix2::identity(),
            })
        };
        assert_eq!(
            map.add(point(0.0), &readings(3)).action,
            Action::Registered(0)
        );
        assert_eq!(
            map.add(point(0.3), &readings(3)).action,
            Action::Registered(1)
        );
        assert_eq!(map.add(point(0.18), &readings(3)).action, Action::Merged(1));
        assert_eq!(map.add(point(0.05), &readings(3)).action, Action::Merged(0));
        assert_eq!(
            map.add(point(0.6), &readings(3)).action,
            Action::Registered(2)
        );
    }
}
