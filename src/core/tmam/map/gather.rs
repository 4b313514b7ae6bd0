//! Gathering at the end of the log: every confirmed feature from all the readings that it alone
//! explains, whether or not a label led to them.
//!
//! Labels come from neighbouring readings and often cannot tell a wall from a corner; so most readings
//! of a noisy log are never used, and near a wall's end some are used for the wrong one. The map
//! knows better: by the pose alone it says which feature should have echoed.

use std::collections::BTreeMap;

use super::settle::confirmed_points;
use super::{alike, ends, signed_like, spanning};
use crate::core::config;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{MapFeature, Shape, Status};
use crate::core::tmam::fit::refit;
use crate::core::tmam::hypothesis::Gate;
use crate::core::tmam::prediction::{Association, MapPrediction, Reach};

/// Rounds of assigning readings and fitting anew after which it ends in any case.
const MAX_ROUNDS: usize = 12;

/// With fewer readings of its own a feature stays as it was.
const FEWEST: usize = 4;

/// Chi2 with one degree of freedom that the readings of a feature may reach together: one true
/// feature in a thousand lies beyond.
const GATE: f64 = 10.83;

/// A feature that looks like another one needs this share of the readings that it explains to itself.
const OWN_SHARE: f64 = 0.1;

/// How far a wall may still be off, and reach across its corner, at first: metres. Readings of the
/// corner pull at it.
const AT_FIRST: Reach = Reach {
    beyond: 0.0,
    before: 0.5,
    off: 0.05,
};

/// Fits the confirmed features of a map anew to all readings; returns those that changed.
/// `ending` walls at their corners in between.
pub fn gather(
    features: &[MapFeature],
    arcs: &[Arc],
    bounds: &config::Map,
    ending: bool,
) -> Vec<MapFeature> {
    let settled = Reach::of(bounds.max_wall_gap);
    let at_first = Reach {
        beyond: settled.beyond,
        ..AT_FIRST
    };
    let mut gathered = features.to_vec();
    let mut owners: Vec<Option<u32>> = Vec::new();
    for round in 0..MAX_ROUNDS {
        let reach = if round < 2 { &at_first } else { &settled };
        let claims = claims(&gathered, arcs, reach);
        if let Some(doubled) = doubled(&gathered, &claims, bounds.match_distance) {
            if let Some(feature) = gathered.iter_mut().find(|f| f.id == doubled) {
                feature.status = Status::Tentative;
            }
            continue;
        }
        let now: Vec<Option<u32>> = claims.iter().map(Association::owner).collect();
        if now == owners {
            break;
        }
        owners = now;
        for (feature, known) in gathered.iter_mut().zip(features) {
            if feature.status == Status::Confirmed {
                *feature = from_readings(feature, known, &owned(arcs, &owners, known.id));
            }
        }
        // A wall that came nearer to its corner may end there now.
        let points = confirmed_points(&gathered);
        let confirmed = |f: &&mut MapFeature| ending && f.status == Status::Confirmed;
        for feature in gathered.iter_mut().filter(confirmed) {
            feature.shape = ends::cut(feature.shape, &points);
        }
    }
    let changed = gathered.into_iter().zip(features);
    changed
        .filter(|(now, before)| now != *before)
        .map(|(now, _)| now)
        .collect()
}

fn claims(features: &[MapFeature], arcs: &[Arc], reach: &Reach) -> Vec<Association> {
    let prediction = MapPrediction::new(features, reach);
    arcs.iter().map(|arc| prediction.claims(arc)).collect()
}

/// The weakest feature that looks like a stronger one and explains next to nothing that others do
/// not explain as well.
fn doubled(features: &[MapFeature], claims: &[Association], match_distance: f64) -> Option<u32> {
    let mut explained: BTreeMap<u32, (usize, usize)> = BTreeMap::new();
    for claim in claims {
        for id in claim.all() {
            let (all, alone) = explained.entry(*id).or_default();
            *all += 1;
            *alone += usize::from(claim.all().len() == 1);
        }
    }
    let confirmed = || features.iter().filter(|f| f.status == Status::Confirmed);
    confirmed()
        .filter(|weak| {
            confirmed().any(|strong| {
                strong.id != weak.id
                    && strong.readings >= weak.readings
                    && alike(strong, weak, match_distance)
            })
        })
        .filter(|weak| {
            let (all, alone) = explained.get(&weak.id).copied().unwrap_or_default();
            alone as f64 <= OWN_SHARE * all as f64
        })
        .min_by_key(|weak| (weak.readings, weak.id))
        .map(|weak| weak.id)
}

/// The readings of one feature.
fn owned(arcs: &[Arc], owners: &[Option<u32>], id: u32) -> Vec<Arc> {
    let pairs = arcs.iter().zip(owners);
    pairs
        .filter(|(_, owner)| **owner == Some(id))
        .map(|(arc, _)| *arc)
        .collect()
}

/// A feature fitted to its readings, from where it is now; as it was `known` before where they do not
/// determine it, or do not agree.
fn from_readings(now: &MapFeature, known: &MapFeature, arcs: &[Arc]) -> MapFeature {
    if arcs.len() < FEWEST {
        return *known;
    }
    let Some(fitted) = refit(&now.shape, arcs) else {
        return *known;
    };
    if fitted.chi2 >= Gate::new(GATE).at(arcs.len() - 2) {
        return *known;
    }
    let shape = match (fitted.shape, &known.shape) {
        (Shape::Line(line), Shape::Line(before)) => {
            Shape::Line(spanning(line, &[line, signed_like(before, &line)]).canonical())
        }
        (shape, _) => shape,
    };
    MapFeature {
        shape,
        readings: u32::try_from(arcs.len()).unwrap_or(u32::MAX),
        ..*known
    }
}

#[cfg(test)]
mod tests;
