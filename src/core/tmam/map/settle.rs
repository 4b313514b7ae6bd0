//! The end of the log: what becomes of the map once all of it is known.

use super::{Map, alike, corners, ends, explained, gather};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{MapFeature, Point, Shape, Status};

impl Map {
    /// Doubts what one run alone gave, gathers readings, joins corners, and ends walls at them, as far
    /// as the rule says so. Returns what changed, in order; the last one of an id is what it is now.
    pub fn settle(&mut self, arcs: &[Arc]) -> Vec<MapFeature> {
        let mut settled = self.put(self.doubtful());
        settled.extend(self.end_walls());
        if self.departures.gather {
            let ending = self.departures.end_at_corners;
            settled.extend(self.put(gather::gather(&self.features, arcs, &self.bounds, ending)));
            settled.extend(self.end_walls());
        }
        if self.departures.join_corners {
            settled.extend(self.put(corners::join(&self.features)));
            settled.extend(self.end_walls());
        }
        settled
    }

    /// A feature of a single run stays tentative if another one with more support looks like it or
    /// explains all its readings.
    fn doubtful(&self) -> Vec<MapFeature> {
        let doubtful = |lone: &MapFeature, arcs: &[Arc]| {
            let stronger = |f: &&MapFeature| {
                f.status == Status::Confirmed && f.runs > 1 && f.readings > lone.readings
            };
            self.features.iter().filter(stronger).any(|other| {
                alike(other, lone, self.bounds.match_distance)
                    || explained::explains(&other.shape, arcs)
            })
        };
        let features = self.features.iter();
        features
            .filter(|f| f.status == Status::Confirmed)
            .filter(|f| self.lone.get(&f.id).is_some_and(|arcs| doubtful(f, arcs)))
            .map(|feature| MapFeature {
                status: Status::Tentative,
                ..*feature
            })
            .collect()
    }

    /// Registers features anew under the ids that they have.
    fn put(&mut self, changed: Vec<MapFeature>) -> Vec<MapFeature> {
        for changed in &changed {
            if let Some(feature) = self.features.iter_mut().find(|f| f.id == changed.id) {
                *feature = *changed;
            }
        }
        changed
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
}

/// Where the confirmed points are.
pub fn confirmed_points(features: &[MapFeature]) -> Vec<Point> {
    let confirmed = features.iter().filter(|f| f.status == Status::Confirmed);
    confirmed
        .filter_map(|feature| match feature.shape {
            Shape::Point(point) => Some(point),
            Shape::Line(_) => None,
        })
        .collect()
}
