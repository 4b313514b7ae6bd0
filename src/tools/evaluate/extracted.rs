//! Features of single runs, before fusion, against the truth.

use std::collections::BTreeMap;

use serde::Serialize;

use super::matching::{Errors, compare};
use super::truth::{Target, Truth};
use crate::core::tmam::feature::{Kind, Shape};
use crate::core::world::Reflector;

/// How the features extracted from single runs did, before fusion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ExtractedScore {
    /// Extracted features that were used.
    pub features: u64,
    /// Those whose readings all came from one wall, or point: their errors are the fit's alone.
    pub pure: u64,
    /// Those of which most readings came from one such.
    pub mostly: u64,
    /// The pure ones against what they came from.
    pub pure_errors: Errors,
    /// All that have a wall or point within the gates, against the nearest.
    pub near_errors: Errors,
}

/// One extracted feature and what its readings came from.
pub struct Extracted<'a> {
    /// The estimate.
    pub shape: &'a Shape,
    /// What its readings came from.
    pub targets: Vec<Target>,
}

impl ExtractedScore {
    /// Holds extracted features of one kind against the truth.
    pub fn new(kind: Kind, extracted: &[Extracted<'_>], truth: &Truth) -> Self {
        let mut score = Self::default();
        let (mut pure, mut near) = (Vec::new(), Vec::new());
        for feature in extracted.iter().filter(|e| e.shape.kind() == kind) {
            score.features += 1;
            let mut counts: BTreeMap<Reflector, usize> = BTreeMap::new();
            for target in &feature.targets {
                if let (Target::Reflector(of @ Reflector::Line(_)), Kind::Line)
                | (Target::Reflector(of @ Reflector::Point(_)), Kind::Point)
                | (Target::Reflector(of @ Reflector::Circle(_)), Kind::Circle) = (target, kind)
                {
                    *counts.entry(*of).or_default() += 1;
                }
            }
            if let Some((reflector, count)) = counts.into_iter().max_by_key(|(_, count)| *count) {
                let all = feature.targets.len();
                score.pure += u64::from(count == all);
                score.mostly += u64::from(2 * count > all);
                let compared = compare(feature.shape, reflector, truth.world());
                pure.extend(compared.filter(|_| count == all));
            }
            let candidates = truth.candidates(feature.shape);
            let nearest = candidates.min_by(|(.., a), (.., b)| a.total_cmp(b));
            near.extend(nearest.map(|(_, comparison, _)| comparison));
        }
        score.pure_errors = Errors::of(pure.iter());
        score.near_errors = Errors::of(near.iter());
        score
    }
}

#[cfg(test)]
mod tests {
    use super::super::map::testing::{line, truth};
    use super::*;

    #[test]
    fn a_run_is_of_what_its_readings_came_from() {
        let (wall, other) = (
            Target::Reflector(Reflector::Line(0)),
            Target::Reflector(Reflector::Line(1)),
        );
        let near = line(0, 2.02, 0.0, 1.0).shape;
        let far = line(1, 3.0, 0.0, 1.0).shape;
        let extracted = [
            Extracted {
                shape: &near,
                targets: vec![wall; 4],
            },
            Extracted {
                shape: &far,
                targets: vec![wall; 3],
            },
            Extracted {
                shape: &near,
                targets: vec![wall, wall, other],
            },
            Extracted {
                shape: &near,
                targets: vec![wall, other],
            },
        ];
        let score = ExtractedScore::new(Kind::Line, &extracted, &truth(3));
        assert_eq!((score.features, score.pure, score.mostly), (4, 2, 3));
        let pure = score.pure_errors.rho.unwrap();
        assert!(
            (pure.max - 1.0).abs() < 1e-9,
            "the far one counts: {pure:?}"
        );
        let near = score.near_errors.rho.unwrap();
        assert!(
            (near.max - 0.02).abs() < 1e-9,
            "the far one does not: {near:?}"
        );
        let points = ExtractedScore::new(Kind::Point, &extracted, &truth(3));
        assert_eq!(points, ExtractedScore::default());
    }
}
