//! Runs that do not fit as a whole, in parts that do.
//!
//! Odometry drifts: along a wall of ten metres its line bends, and no single line fits the readings
//! any more, although every few metres of them do.

use super::{Fit, FitOptions, fit_line, fit_point};
use crate::core::ties;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Kind, Rejection};
use crate::core::tmam::run::Run;

/// Readings that a part has at least.
const SHORTEST_PART: usize = 8;

/// Places at which a break is tried, at most.
const MOST_BREAKS: usize = 64;

/// Fits a feature to the whole of a run.
pub fn fit_run(run: &Run, demands: &FitOptions) -> Fit {
    match run.kind {
        Kind::Line => fit_line(&run.associated, demands),
        Kind::Point => fit_point(&run.associated, demands),
    }
}

/// Fits a feature to a run; where the readings of a wall do not all fit, to its parts, as long as
/// any of them fits. Parts without a labelled arc are dropped.
pub fn fit_in_parts(run: Run, demands: &FitOptions) -> Vec<(Run, Fit)> {
    let whole = fit_run(&run, demands);
    let breaks = run.kind == Kind::Line && whole.rejection == Some(Rejection::Misfit);
    let Some(at) = best_break(&run.associated).filter(|_| breaks) else {
        return vec![(run, whole)];
    };
    let (before, after) = run.broken_at(at);
    let parts: Vec<(Run, Fit)> = [before, after]
        .into_iter()
        .filter(|part| !part.labelled.is_empty())
        .flat_map(|part| fit_in_parts(part, demands))
        .collect();
    if parts.iter().any(|(_, fit)| fit.rejection.is_none()) {
        parts
    } else {
        vec![(run, whole)]
    }
}

/// The first reading of the second of two parts that together fit best.
fn best_break(arcs: &[Arc]) -> Option<usize> {
    let last = arcs.len().checked_sub(SHORTEST_PART)?;
    let stride = arcs.len().div_ceil(MOST_BREAKS).max(1);
    let breaks = (SHORTEST_PART..=last).step_by(stride).filter_map(|at| {
        let (before, after) = arcs.split_at_checked(at)?;
        Some((chi2(before)? + chi2(after)?, at))
    });
    ties::first_least(breaks, ties::of_chi2).map(|(_, at)| at)
}

/// What is left of the readings after a line was fitted to all of them.
fn chi2(arcs: &[Arc]) -> Option<f64> {
    let to_the_end = FitOptions {
        converge: true,
        ..FitOptions::default()
    };
    let line = fit_line(arcs, &to_the_end).shape?;
    Some(
        arcs.iter()
            .map(|arc| (arc.range - line.distance(arc.center()), arc.variance))
            .map(|(residual, variance)| residual * residual / variance)
            .sum(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Vec2;
    use crate::core::tmam::fit::testing::{Gauss, SIGMA, arc};
    use crate::core::tmam::hypothesis::Gate;

    const READINGS: u32 = 60;

    fn strict() -> FitOptions {
        FitOptions {
            converge: true,
            misfits: Some(Gate::new(6.63)),
            mirrored: Some(13.0),
        }
    }

    /// Along a wall, every 10 cm, while the odometry says that the robot drifts away from it.
    fn run(drift: impl Fn(f64) -> f64) -> Run {
        let mut rng = Gauss::new(5);
        let associated: Vec<Arc> = (0..READINGS)
            .map(|k| {
                let x = 0.1 * f64::from(k);
                arc(k, Vec2::new(x, drift(x)), 1.5, 2.0 + SIGMA * rng.sample())
            })
            .collect();
        Run {
            kind: Kind::Line,
            labelled: associated[1..associated.len() - 1]
                .iter()
                .map(|arc| arc.id)
                .collect(),
            associated,
        }
    }

    #[test]
    fn a_wall_that_drift_bends_is_taken_in_parts() {
        let bent = run(|x| 0.004 * x * x);
        assert_eq!(fit_run(&bent, &strict()).rejection, Some(Rejection::Misfit));
        let parts = fit_in_parts(bent.clone(), &strict());
        assert!((2..=6).contains(&parts.len()), "{}", parts.len());
        let fitted = parts.iter().filter(|(_, fit)| fit.rejection.is_none());
        let kept: usize = fitted
            .map(|(part, fit)| part.associated.len() - fit.outliers.len())
            .sum();
        assert!(kept > 40, "{kept} of {READINGS}");
        let labelled: Vec<_> = parts.iter().flat_map(|(p, _)| p.labelled.clone()).collect();
        assert_eq!(labelled, bent.labelled, "in order, each once");
    }

    #[test]
    fn what_fits_stays_whole_and_what_never_fits_stays_rejected() {
        let straight = run(|_| 0.0);
        assert_eq!(fit_in_parts(straight, &strict()).len(), 1);
        let wild = run(|x| 0.3 * ((10.0 * x).round() % 2.0));
        let parts = fit_in_parts(wild, &strict());
        assert_eq!(parts.len(), 1);
        assert_eq!(parts[0].1.rejection, Some(Rejection::Misfit));
    }

    #[test]
    fn a_part_has_the_labels_of_its_readings() {
        let (before, after) = run(|_| 0.0).broken_at(20);
        assert_eq!((before.associated.len(), after.associated.len()), (20, 40));
        assert_eq!((before.labelled.len(), after.labelled.len()), (19, 39));
    }
}
