//! Batch refinement at the end of the log: every confirmed feature from all the readings that it alone
//! explains, whether or not a label led to them.
//!
//! Labels come from neighbouring readings and often cannot tell a wall from a corner; so most readings
//! of a noisy log are never used, and near a wall's end some are used for the wrong one. The map
//! knows better: by the pose alone it says which feature should have echoed.

use std::collections::{BTreeMap, BTreeSet};

use super::ends;
use super::fusion::alike;
use crate::core::config;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{MapFeature, Point, Segment, Shape, Status};
use crate::core::tmam::fit::refit;
use crate::core::tmam::hypothesis::Gate;
use crate::core::tmam::prediction::{Association, MapPrediction, Reach};
use crate::core::tmam::residual::RangeResidual;

/// Rounds of assigning readings and fitting anew after which it ends in any case.
const MAX_ROUNDS: usize = 12;

/// With fewer readings of its own a feature stays as it was.
const FEWEST: usize = 4;

/// Chi2 with one degree of freedom that the readings of a feature may reach together, and beyond which
/// a feature does not explain those of another: one true feature in a thousand lies beyond.
pub const GATE: f64 = 10.83;

/// A feature that looks like another one needs this share of the readings that it explains to itself.
const OWN_SHARE: f64 = 0.1;

/// How far a wall may still be off, and reach across its corner, at first: metres. Readings of the
/// corner pull at it.
const AT_FIRST: Reach = Reach {
    beyond: 0.0,
    before: 0.5,
    off: 0.05,
    margin: 0.0,
};

/// Fits the confirmed features of a map anew to all readings; returns those that changed.
/// `ending` walls at their corners in between.
pub fn refine(
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
    let mut refined = features.to_vec();
    let mut owners: Vec<Option<u32>> = Vec::new();
    for round in 0..MAX_ROUNDS {
        let reach = if round < 2 { &at_first } else { &settled };
        let now = owners_of(arcs, &mut refined, reach, bounds.match_distance);
        if now == owners {
            break;
        }
        owners = now;
        let owned = owned(arcs, &owners);
        let none = Vec::new();
        for (feature, known) in refined.iter_mut().zip(features) {
            if feature.status == Status::Confirmed {
                let arcs = owned.get(&known.id).unwrap_or(&none);
                *feature = from_readings(feature, known, arcs);
            }
        }
        // A wall that came nearer to its corner may end there now.
        let points = confirmed_points(&refined);
        let confirmed = |f: &&mut MapFeature| ending && f.status == Status::Confirmed;
        for feature in refined.iter_mut().filter(confirmed) {
            feature.shape = ends::cut(feature.shape, &points);
        }
    }
    let changed = refined.into_iter().zip(features);
    changed
        .filter(|(now, before)| now != *before)
        .map(|(now, _)| now)
        .collect()
}

/// The one feature that explains each reading; features that look like others are doubted first.
fn owners_of(
    arcs: &[Arc],
    features: &mut [MapFeature],
    reach: &Reach,
    match_distance: f64,
) -> Vec<Option<u32>> {
    let mut associations = associated(features, arcs, reach);
    if doubt_doubles(features, &associations, match_distance) {
        associations = associated(features, arcs, reach);
    }
    associations.iter().map(Association::owner).collect()
}

fn associated(features: &[MapFeature], arcs: &[Arc], reach: &Reach) -> Vec<Association> {
    let prediction = MapPrediction::new(features, reach);
    arcs.iter().map(|arc| prediction.associate(arc)).collect()
}

/// Leaves tentative what looks like a stronger feature and explains next to nothing that others do not
/// explain as well, the weakest first; whether there was anything.
fn doubt_doubles(
    features: &mut [MapFeature],
    associations: &[Association],
    match_distance: f64,
) -> bool {
    let mut found = false;
    while let Some(doubled) = doubled(features, associations, match_distance) {
        for feature in features.iter_mut().filter(|f| f.id == doubled) {
            feature.status = Status::Tentative;
            found = true;
        }
    }
    found
}

fn doubled(
    features: &[MapFeature],
    associations: &[Association],
    match_distance: f64,
) -> Option<u32> {
    let mut explained: BTreeMap<u32, (usize, usize)> = BTreeMap::new();
    let confirmed = || features.iter().filter(|f| f.status == Status::Confirmed);
    let ids: BTreeSet<u32> = confirmed().map(|feature| feature.id).collect();
    for association in associations {
        let by = association.all().iter().filter(|id| ids.contains(id));
        let by: Vec<&u32> = by.collect();
        for id in &by {
            let (all, alone) = explained.entry(**id).or_default();
            *all += 1;
            *alone += usize::from(by.len() == 1);
        }
    }
    confirmed()
        .filter(|weak| {
            let (all, alone) = explained.get(&weak.id).copied().unwrap_or_default();
            alone as f64 <= OWN_SHARE * all as f64
        })
        .filter(|weak| {
            confirmed().any(|strong| {
                strong.id != weak.id
                    && strong.readings >= weak.readings
                    && alike(strong, weak, match_distance)
            })
        })
        .min_by_key(|weak| (weak.readings, weak.id))
        .map(|weak| weak.id)
}

/// The readings of each feature.
fn owned(arcs: &[Arc], owners: &[Option<u32>]) -> BTreeMap<u32, Vec<Arc>> {
    let mut owned: BTreeMap<u32, Vec<Arc>> = BTreeMap::new();
    for (arc, owner) in arcs.iter().zip(owners) {
        if let Some(id) = owner {
            owned.entry(*id).or_default().push(*arc);
        }
    }
    owned
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
    let unknowns = match fitted.shape {
        Shape::Line(_) | Shape::Point(_) => 2,
        Shape::Circle(_) => 3,
    };
    if fitted.chi2 >= Gate::new(GATE).at(arcs.len() - unknowns) {
        return *known;
    }
    let shape = match (fitted.shape, &known.shape) {
        (Shape::Line(line), Shape::Line(before)) => Shape::Line(
            line.reaching_over([line, *before].iter().flat_map(Segment::ends))
                .canonical(),
        ),
        (shape, _) => shape,
    };
    MapFeature {
        shape,
        readings: u32::try_from(arcs.len()).unwrap_or(u32::MAX),
        ..*known
    }
}

/// Whether a feature of the map explains the readings that another one was made of, all of them
/// inside their beams.
pub fn explains(shape: &Shape, arcs: &[Arc]) -> bool {
    let misfit = |arc: &Arc| {
        let residual = RangeResidual::of(shape, arc).filter(|r| r.is_in_beam(arc))?;
        Some(residual.chi2())
    };
    let chi2: Option<f64> = arcs.iter().map(misfit).sum();
    chi2.is_some_and(|chi2| chi2 < Gate::new(GATE).at(arcs.len()))
}

/// Where the confirmed points are.
pub fn confirmed_points(features: &[MapFeature]) -> Vec<Point> {
    let confirmed = features.iter().filter(|f| f.status == Status::Confirmed);
    confirmed
        .filter_map(|feature| match feature.shape {
            Shape::Point(point) => Some(point),
            Shape::Line(_) | Shape::Circle(_) => None,
        })
        .collect()
}

#[cfg(test)]
mod tests;
