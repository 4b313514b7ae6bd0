//! Whether all readings of a run come from the one feature that was fitted to them.

use super::start::start;
use super::{Estimate, Fit, FitOptions, Model, iterate, weighted_square_sum};
use crate::core::ties;
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::Rejection;
use crate::core::tmam::hypothesis::Gate;

/// One in so many readings of a run may be an outlier.
const READINGS_PER_OUTLIER: usize = 5;

/// Standard deviations of its own by which a feature may lie outside a beam that it came from.
const BEAM_SIGMAS: f64 = 3.0;

/// Chi2 by which a reading may lie off what the others foretell: three standard deviations.
const FORETOLD: f64 = 9.0;

/// How many readings are cut off an end at once.
const LONGEST_TRIM: usize = 6;

/// A mirror image nearer than this is the feature itself, metres and radians: fits of what lies
/// straight ahead hardly get nearer to their end.
const APART: f64 = 1e-4;

/// How many readings are left in any case.
const FEWEST_LEFT: usize = 4;

/// The best estimate that the demands allow.
pub fn estimate(model: &impl Model, arcs: &[Arc], demands: &FitOptions) -> Result<Estimate, Fit> {
    let mut kept = arcs.to_vec();
    let left_out = match demands.misfits {
        Some(_) => leave_out(model, &mut kept),
        None => Vec::new(),
    };
    let start = start(model, &kept).ok_or_else(|| Fit::failed(Rejection::NoStart, 0))?;
    let mut estimate = iterate(model, &kept, start, demands.converge)?;
    let mut slack = 0.0;
    if let (Some(gate), Some(first)) = (demands.misfits, kept.first()) {
        let allowed = gate.at(kept.len().saturating_sub(2));
        let chi2 = weighted_square_sum(model, estimate.parameters, &kept);
        if chi2 >= allowed || 2 * kept.len() < arcs.len() {
            estimate.rejection = Some(Rejection::Misfit);
        }
        slack = slack_of(model, &estimate, first);
    }
    let held = |arc: &Arc| model.in_beam(estimate.parameters, arc, slack);
    if !kept.iter().all(held) {
        estimate.rejection = estimate.rejection.or(Some(Rejection::OutsideBeams));
    }
    if demands
        .mirrored
        .is_some_and(|lead| has_double(model, &estimate, &kept, lead))
    {
        estimate.rejection = estimate.rejection.or(Some(Rejection::Mirrored));
    }
    estimate.outliers = left_out;
    Ok(estimate)
}

/// Readings to leave out of a run: so many at its start and at its end, or a single one.
#[derive(Debug, Clone, Copy)]
enum Cut {
    Ends(usize, usize),
    Single(usize),
}

/// Leaves out what the other readings do not foretell: single outliers, and the ends of a run. Where
/// a wall ends in a corner, ranges pass from the one to the other so smoothly that windows reach
/// across.
fn leave_out(model: &impl Model, kept: &mut Vec<Arc>) -> Vec<ArcId> {
    let gate = Gate::new(FORETOLD);
    let most_singles = kept.len() / READINGS_PER_OUTLIER;
    let (mut left_out, mut singles) = (Vec::new(), 0);
    while kept.len() > FEWEST_LEFT
        && let Some(cut) = best_cut(model, kept, &gate, singles < most_singles)
    {
        match cut {
            Cut::Ends(left, right) => {
                let last = kept.len() - right;
                left_out.extend(kept.drain(last..).map(|arc| arc.id));
                left_out.extend(kept.drain(..left).map(|arc| arc.id));
            }
            Cut::Single(at) => {
                left_out.push(kept.remove(at).id);
                singles += 1;
            }
        }
    }
    left_out.sort();
    left_out
}

/// The cut after which chi2 falls most beyond what so many readings foretell, if there is one.
fn best_cut(model: &impl Model, kept: &[Arc], gate: &Gate, single: bool) -> Option<Cut> {
    let fit = |arcs: &[Arc]| {
        let estimate = iterate(model, arcs, start(model, arcs)?, true).ok()?;
        let chi2 = weighted_square_sum(model, estimate.parameters, arcs);
        Some((estimate.parameters, chi2))
    };
    let (parameters, all) = fit(kept)?;
    let slack = |a: f64, b: f64| ties::of_chi2(a.abs(), b.abs());
    let longest = LONGEST_TRIM.min(kept.len().saturating_sub(FEWEST_LEFT));
    let ends = (1..=longest)
        .flat_map(|n| [(n, 0), (0, n)])
        .filter_map(|(left, right)| {
            let rest = kept.get(left..kept.len() - right)?;
            Some((
                all - fit(rest)?.1 - gate.at(left + right),
                Cut::Ends(left, right),
            ))
        });
    let misfit = |arc: &Arc| weighted_square_sum(model, parameters, std::slice::from_ref(arc));
    let most_off = kept.iter().map(|arc| -misfit(arc)).zip(0..);
    let worst = ties::first_least(most_off, slack)
        .filter(|_| single)
        .and_then(|(_, at)| {
            let mut rest = kept.to_vec();
            rest.remove(at);
            Some((all - fit(&rest)?.1 - gate.at(1), Cut::Single(at)))
        });
    // The one at an end is a single one as well, and counts as such.
    let lacks = worst
        .into_iter()
        .chain(ends)
        .map(|(excess, cut)| (-excess, cut));
    ties::first_least(lacks, slack)
        .filter(|(lacks, _)| *lacks < 0.0)
        .map(|(_, cut)| cut)
}

/// By how much a feature may lie outside a beam, radians.
fn slack_of(model: &impl Model, estimate: &Estimate, first: &Arc) -> f64 {
    BEAM_SIGMAS * model.bearing_variance(estimate, first).max(0.0).sqrt()
}

/// Whether the mirror image at the robot's path lies in the beams and fits as well.
fn has_double(model: &impl Model, estimate: &Estimate, arcs: &[Arc], lead: f64) -> bool {
    let (Some(first), Some(last)) = (arcs.first(), arcs.last()) else {
        return false;
    };
    let start = model.mirrored(estimate.parameters, first, last);
    let Ok(double) = iterate(model, arcs, start, true) else {
        return false;
    };
    let cost = |of: &Estimate| weighted_square_sum(model, of.parameters, arcs);
    // At the edge of a beam, noise alone says which of the two it holds.
    let slack = slack_of(model, &double, first);
    let apart = (double.parameters - estimate.parameters).norm() > APART;
    apart
        && cost(&double) - cost(estimate) < lead
        && arcs
            .iter()
            .all(|arc| model.in_beam(double.parameters, arc, slack))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::{Vec2, unit};
    use crate::core::tmam::fit::testing::{Gauss, SIGMA, arc};
    use crate::core::tmam::fit::{fit_line, fit_point};

    /// Every 12 cm along x, looking left, with noise.
    fn arcs(range: impl Fn(Vec2) -> f64, n: u32, seed: u64) -> Vec<Arc> {
        let mut rng = Gauss::new(seed);
        (0..n)
            .map(|k| {
                let sensor = Vec2::new(0.12 * f64::from(k), 0.0);
                arc(k, sensor, 1.5, range(sensor) + SIGMA * rng.sample())
            })
            .collect()
    }

    fn strict() -> FitOptions {
        FitOptions {
            converge: true,
            misfits: Some(Gate::new(6.63)),
            mirrored: Some(13.0),
        }
    }

    #[test]
    fn readings_of_the_corner_behind_a_wall_are_cut_off() {
        // The wall ends at x = 1; from there on its end echoes.
        let end = Vec2::new(1.0, 2.0);
        let run = arcs(|s| if s.x < 1.0 { 2.0 } else { (end - s).norm() }, 13, 1);
        let fit = fit_line(&run, &strict());
        assert_eq!(fit.rejection, None);
        let cut: Vec<u32> = fit.outliers.iter().map(|arc| arc.frame).collect();
        assert!(cut.iter().all(|frame| *frame > 8), "{cut:?}");
        assert!(cut.contains(&12) && cut.contains(&11), "{cut:?}");
        assert!(fit_line(&run, &FitOptions::default()).outliers.is_empty());
    }

    #[test]
    fn a_few_outliers_are_left_out_and_many_are_a_misfit() {
        let mut run = arcs(|_| 2.0, 12, 2);
        run[5].range += 0.1;
        let fit = fit_line(&run, &strict());
        assert_eq!(fit.rejection, None);
        assert!(fit.outliers.contains(&run[5].id), "{:?}", fit.outliers);
        assert!(fit.outliers.len() <= 2, "{:?}", fit.outliers);
        for at in [3, 4, 6, 7] {
            run[at].range += 0.1 * at as f64;
        }
        assert_eq!(fit_line(&run, &strict()).rejection, Some(Rejection::Misfit));
    }

    #[test]
    fn what_fits_on_either_side_of_the_path_is_not_registered() {
        let corner = Vec2::new(2.0, 0.35);
        let mut run = arcs(|s| (corner - s).norm(), 5, 3);
        for arc in &mut run {
            arc.world_from_sensor.yaw = 0.0;
        }
        let fit = fit_point(&run, &strict());
        assert_eq!(fit.rejection, Some(Rejection::Mirrored), "{fit:?}");
        // Looking to one side only, the beam tells.
        let corner = Vec2::new(0.4, 2.0);
        let fit = fit_point(&arcs(|s| (corner - s).norm(), 6, 3), &strict());
        assert_eq!(fit.rejection, None);
    }

    #[test]
    fn a_feature_at_the_edge_of_a_beam_is_not_lost_to_the_noise() {
        let at_edge = unit(1.5 - 0.25) * 2.0;
        let mut rejected = 0;
        for seed in 0..20 {
            let run = arcs(|s| (at_edge - s).norm(), 4, seed);
            let edge =
                |demands| fit_point(&run, &demands).rejection == Some(Rejection::OutsideBeams);
            assert!(!edge(strict()));
            rejected += u32::from(edge(FitOptions::default()));
        }
        assert!(rejected > 0, "the paper's rule has no slack");
    }

    #[test]
    fn a_wall_at_the_edge_of_a_beam_has_its_double_at_the_other_edge() {
        // Looking ahead with a beam of 180 degrees, along a wall: noise tilts it in or out of the beam.
        for seed in 0..10 {
            let mut arcs = arcs(|_| 2.0, 12, seed);
            for arc in &mut arcs {
                arc.world_from_sensor.yaw = 0.0;
                arc.beam_width = std::f64::consts::PI;
            }
            let demands = FitOptions {
                converge: true,
                misfits: Some(Gate::new(6.63)),
                mirrored: Some(13.0),
            };
            let fit = fit_line(&arcs, &demands);
            assert!(
                matches!(
                    fit.rejection,
                    Some(Rejection::Mirrored | Rejection::NoStart)
                ),
                "{seed}: {fit:?}"
            );
        }
    }
}
