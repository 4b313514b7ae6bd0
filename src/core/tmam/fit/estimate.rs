//! The estimate from the readings of a run, and whether they all come from the one feature.

use nalgebra::Vector2;

use super::model::{Estimate, Model};
use crate::core::geometry::angle_between;
use crate::core::ties;
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::Rejection;
use crate::core::tmam::gauss_newton::{Advance, Failure, Observation, chi2, covariance, iterate};
use crate::core::tmam::hypothesis::Gate;
use crate::core::tmam::pair::Points;

/// What is asked of a fit beyond the paper.
#[derive(Debug, Clone, Copy, Default)]
pub struct FitOptions {
    /// It is iterated to its end, not until a step is below a centimetre.
    pub converge: bool,
    /// All readings must fit within this gate, but for a few outliers.
    pub misfits: Option<Gate>,
    /// The mirror image at the robot's path must be worse by this much in chi2.
    pub mirrored: Option<f64>,
}

/// Iterations after which (10) ends without having met the paper's stopping rule.
const MAX_ITERATIONS: u32 = 10;

/// The same where fits are iterated to their end.
const MAX_ITERATIONS_TO_THE_END: u32 = 50;

/// A step that is smaller than this, relative to the parameters, is the end.
const RELATIVE_STEP: f64 = 1e-9;

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

/// The best estimate that the options allow.
///
/// # Errors
/// When there is none to speak of.
pub fn estimate(
    model: &impl Model,
    arcs: &[Arc],
    options: &FitOptions,
) -> Result<Estimate, Failure> {
    let mut kept = arcs.to_vec();
    let left_out = match options.misfits {
        Some(_) => leave_out(model, &mut kept),
        None => Vec::new(),
    };
    let start = start(model, &kept).ok_or((Rejection::NoStart, 0))?;
    let mut estimate = if options.converge {
        fit_to_the_end(model, &kept, start)?
    } else {
        fit_by_the_paper(model, &kept, start)?
    };
    let mut slack = 0.0;
    if let (Some(gate), Some(first)) = (options.misfits, kept.first()) {
        let allowed = gate.at(kept.len().saturating_sub(2));
        let misfit = chi2(model, estimate.parameters, &kept);
        if misfit >= allowed || 2 * kept.len() < arcs.len() {
            estimate.rejection = Some(Rejection::Misfit);
        }
        slack = slack_of(model, &estimate, first);
    }
    let held = |arc: &Arc| model.in_beam(estimate.parameters, arc, slack);
    if !kept.iter().all(held) {
        estimate.rejection = estimate.rejection.or(Some(Rejection::OutsideBeams));
    }
    if options
        .mirrored
        .is_some_and(|lead| has_double(model, &estimate, &kept, lead))
    {
        estimate.rejection = estimate.rejection.or(Some(Rejection::Mirrored));
    }
    estimate.outliers = left_out;
    Ok(estimate)
}

/// Where the iteration starts: the points of the first and the last arc, else those of the first
/// neighbouring pair that has any. Of two sides the one with the smaller residuals is taken; sides
/// that fit equally well (on a straight path a line and its mirror image do) are told apart by the
/// beam axis, and left comes before right.
fn start(model: &impl Model, arcs: &[Arc]) -> Option<Vector2<f64>> {
    let (first, last) = (arcs.first()?, arcs.last()?);
    let neighbours = arcs
        .windows(2)
        .filter_map(|w| Some((w.first()?, w.last()?)));
    let sides = std::iter::once((first, last))
        .chain(neighbours)
        .map(|(a, b)| model.suggesting(&Points::of(a, b)))
        .find(|sides| sides.iter().any(Option::is_some))?;
    let starts = sides.into_iter().flatten().map(|point| {
        let parameters = model.through(&point);
        let off_axis = angle_between(point.bearing_a, first.world_from_sensor.yaw);
        (chi2(model, parameters, arcs), (off_axis, parameters))
    });
    let best = starts.reduce(|left, right| {
        let slack = ties::of_chi2(left.0, right.0);
        let right_is_better = if (left.0 - right.0).abs() <= slack {
            ties::below(right.1.0, left.1.0, ties::ANGLE)
        } else {
            right.0 < left.0
        };
        if right_is_better { right } else { left }
    })?;
    Some(best.1.1)
}

/// Iterates (10) until the paper's stopping rule holds.
fn fit_by_the_paper(
    model: &impl Model,
    arcs: &[Arc],
    start: Vector2<f64>,
) -> Result<Estimate, Failure> {
    let ends = |_, step| model.step_norm(step) < 1.0;
    fit_until(model, arcs, start, MAX_ITERATIONS, ends)
}

/// Iterates (10) to its end.
///
/// # Errors
/// As [`iterate`].
pub fn fit_to_the_end(
    model: &impl Observation,
    arcs: &[Arc],
    start: Vector2<f64>,
) -> Result<Estimate, Failure> {
    let ends =
        |next: Vector2<f64>, step: Vector2<f64>| step.norm() < RELATIVE_STEP * (1.0 + next.norm());
    fit_until(model, arcs, start, MAX_ITERATIONS_TO_THE_END, ends)
}

fn fit_until(
    model: &impl Observation,
    arcs: &[Arc],
    start: Vector2<f64>,
    longest: u32,
    ends: impl Fn(Vector2<f64>, Vector2<f64>) -> bool,
) -> Result<Estimate, Failure> {
    let found = iterate(model, arcs, start, longest, |parameters, step| {
        let next = parameters + step; // (10)
        if ends(next, step) {
            Advance::Last(next)
        } else {
            Advance::To(next)
        }
    })?;
    let cost = chi2(model, found.parameters, arcs);
    if !found.converged && (cost.is_nan() || cost > chi2(model, start, arcs)) {
        return Err((Rejection::Diverged, found.iterations));
    }
    let singular = (Rejection::Singular, found.iterations);
    let squares = arcs.iter().filter_map(|arc| {
        let (range, _) = model.predict(found.parameters, arc)?;
        Some((arc.range - range) * (arc.range - range))
    });
    Ok(Estimate {
        parameters: found.parameters,
        covariance: covariance(model, found.parameters, arcs).ok_or(singular)?,
        residual_rms: (squares.sum::<f64>() / arcs.len().max(1) as f64).sqrt(),
        iterations: found.iterations,
        converged: found.converged,
        rejection: None,
        outliers: Vec::new(),
    })
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
        let estimate = fit_to_the_end(model, arcs, start(model, arcs)?).ok()?;
        let misfit = chi2(model, estimate.parameters, arcs);
        Some((estimate.parameters, misfit))
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
    let misfit = |arc: &Arc| chi2(model, parameters, std::slice::from_ref(arc));
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
    let Ok(double) = fit_to_the_end(model, arcs, start) else {
        return false;
    };
    let cost = |of: &Estimate| chi2(model, of.parameters, arcs);
    // At the edge of a beam, noise alone says which of the two it holds.
    let slack = slack_of(model, &double, first);
    let apart = (double.parameters - estimate.parameters).norm() > APART;
    apart
        && cost(&double) - cost(estimate) < lead
        && arcs
            .iter()
            .all(|arc| model.in_beam(double.parameters, arc, slack))
}
