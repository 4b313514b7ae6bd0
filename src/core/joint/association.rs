//! Which arcs came from which feature.

use std::collections::BTreeMap;

use super::landmark::Landmark;
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::{Action, MapFeature, Status};
use crate::core::tmam::prediction::{MapPrediction, Reach};
use crate::core::tmam::step::Extraction;

/// Features of a map, and which arcs each of them explains.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Association {
    /// By id.
    pub features: Vec<MapFeature>,
    /// The feature of each arc that has one.
    pub owners: BTreeMap<ArcId, u32>,
    /// The same by the runs of the replay: walls reach as far as these, too.
    pub by_runs: BTreeMap<ArcId, u32>,
}

impl Association {
    /// That of a replay: an arc belongs to the feature that the run of its label gave, or to the one
    /// that a run beside it gave where no other did.
    pub fn of_replay(extractions: &[&Extraction], map: &[MapFeature]) -> Self {
        let mut absorbed: BTreeMap<u32, u32> = BTreeMap::new();
        for extraction in extractions {
            if let Some(feature) = extraction.map_feature {
                absorbed.extend(extraction.absorbed.iter().map(|gone| (*gone, feature.id)));
            }
        }
        let now = |mut id: u32| {
            while let Some(by) = absorbed.get(&id) {
                id = *by;
            }
            id
        };
        let mut labelled: BTreeMap<ArcId, u32> = BTreeMap::new();
        let mut beside: BTreeMap<ArcId, Option<u32>> = BTreeMap::new();
        for extraction in extractions {
            let (Action::Registered(id) | Action::Merged(id)) = extraction.action else {
                continue;
            };
            let id = now(id);
            let used = |arc: &&ArcId| !extraction.outliers.contains(arc);
            labelled.extend(
                extraction
                    .labelled
                    .iter()
                    .filter(used)
                    .map(|arc| (*arc, id)),
            );
            for arc in extraction.associated.iter().filter(used) {
                let known = beside.entry(*arc).or_insert(Some(id));
                *known = known.filter(|known| *known == id);
            }
        }
        let mut owners: BTreeMap<ArcId, u32> = beside
            .into_iter()
            .filter_map(|(arc, id)| Some((arc, id?)))
            .collect();
        owners.extend(labelled);
        owners.retain(|_, id| map.binary_search_by_key(id, |f| f.id).is_ok());
        Self {
            features: map.to_vec(),
            by_runs: owners.clone(),
            owners,
        }
    }

    /// A feature by its id.
    pub fn feature(&self, id: u32) -> Option<&MapFeature> {
        let at = self.features.binary_search_by_key(&id, |f| f.id);
        self.features.get(at.ok()?)
    }

    /// Whether a feature takes part in the estimate: circles do not, and stay where the replay puts them.
    pub fn is_landmark(&self, id: u32) -> bool {
        (self.feature(id)).is_some_and(|feature| Landmark::of(&feature.shape).is_some())
    }

    /// How many arcs each feature has, and the first of them.
    pub fn counts(&self) -> BTreeMap<u32, (usize, ArcId)> {
        let mut counts = BTreeMap::new();
        for (arc, owner) in &self.owners {
            counts.entry(*owner).or_insert((0, *arc)).0 += 1;
        }
        counts
    }

    /// Two features are one: `gone` goes into `kept`. It is confirmed where either was, or where so many
    /// runs agree.
    pub fn merge(&mut self, kept: u32, gone: u32, confirm_runs: u32) {
        let Some(at) = self.features.iter().position(|f| f.id == gone) else {
            return;
        };
        let other = self.features.remove(at);
        if let Some(feature) = self.features.iter_mut().find(|f| f.id == kept) {
            feature.runs = feature.runs.saturating_add(other.runs);
            if feature.runs >= confirm_runs || other.status == Status::Confirmed {
                feature.status = Status::Confirmed;
            }
        }
        let owners = self.owners.values_mut().chain(self.by_runs.values_mut());
        owners
            .filter(|owner| **owner == gone)
            .for_each(|owner| *owner = kept);
    }

    /// The arcs that each feature alone explains, where the features are now; `arcs` are at the poses as
    /// they are estimated now. An arc that several explain stays with the one that it had.
    pub fn gathered(&self, arcs: &[Arc], reach: &Reach) -> Self {
        let all: Vec<MapFeature> = (self.features.iter())
            .map(|feature| MapFeature {
                status: Status::Confirmed,
                ..*feature
            })
            .collect();
        let prediction = MapPrediction::new(&all, reach);
        let owner = |arc: &Arc| {
            let association = prediction.associate(arc);
            let before = self.owners.get(&arc.id).copied();
            let kept =
                before.filter(|id| !association.is_near_end() && association.all().contains(id));
            association.owner().or(kept)
        };
        Self {
            owners: (arcs.iter())
                .filter_map(|arc| Some((arc.id, owner(arc)?)))
                .collect(),
            features: self.features.clone(),
            by_runs: self.by_runs.clone(),
        }
    }
}
