//! Circles fitted to runs.

use super::estimate::FitOptions;
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::circle::{
    CircleFit, FEWEST, Parameters, chi2, circle_range, covariance, is_held,
};
use crate::core::tmam::feature::{Circle, Rejection};

/// One in so many readings of a run may be an outlier.
const READINGS_PER_OUTLIER: usize = 5;
/// Chi2 by which a reading may lie off: three standard deviations.
const FORETOLD: f64 = 9.0;
/// Standard deviations of its own by which a centre may lie outside a beam that it came from.
const BEAM_SIGMAS: f64 = 3.0;
/// A mirror image nearer than this is the circle itself, metres.
const APART: f64 = 1e-4;

/// The end of a fit.
pub struct CircleEstimate {
    /// In the world; `None` where there was none to speak of.
    pub circle: Option<Circle>,
    /// Root mean square of range minus prediction, metres.
    pub residual_rms: f64,
    pub iterations: u32,
    /// Why it must not be registered, if so.
    pub rejection: Option<Rejection>,
    /// Readings that were left out.
    pub outliers: Vec<ArcId>,
}

/// The best circle that the options allow.
pub fn estimate_circle(arcs: &[Arc], options: &FitOptions) -> CircleEstimate {
    let mut kept = arcs.to_vec();
    let mut outliers: Vec<ArcId> = Vec::new();
    let most = if options.misfits.is_some() {
        arcs.len() / READINGS_PER_OUTLIER
    } else {
        0
    };
    let mut found = CircleFit::best(&kept);
    while let Some(fit) = found
        && outliers.len() < most
        && kept.len() > FEWEST
    {
        let misfit = |arc: &Arc| chi2(&fit.parameters, std::slice::from_ref(arc));
        let off = kept.iter().map(misfit).enumerate();
        let worst = off.max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((at, _)) = worst.filter(|(_, misfit)| *misfit > FORETOLD) else {
            break;
        };
        outliers.push(kept.remove(at).id);
        found = CircleFit::from(fit.parameters, &kept);
    }
    outliers.sort();
    let none = |rejection, iterations| CircleEstimate {
        circle: None,
        residual_rms: 0.0,
        iterations,
        rejection: Some(rejection),
        outliers: Vec::new(),
    };
    let Some(fit) = found else {
        return none(Rejection::NoStart, 0);
    };
    let Some(covariance) = covariance(&fit.parameters, &kept).filter(|_| fit.is_cylinder()) else {
        return none(Rejection::Singular, fit.iterations);
    };
    let circle = Circle {
        center: fit.parameters.xy(),
        radius: fit.parameters.z,
        covariance,
    };
    CircleEstimate {
        circle: Some(circle),
        residual_rms: rms(&fit.parameters, &kept),
        iterations: fit.iterations,
        rejection: rejection(&circle, &fit, &kept, options),
        outliers,
    }
}

/// Why a fit is not to be registered.
fn rejection(
    circle: &Circle,
    fit: &CircleFit,
    arcs: &[Arc],
    options: &FitOptions,
) -> Option<Rejection> {
    let gate = options
        .misfits
        .map(|gate| gate.at(arcs.len().saturating_sub(3)));
    if gate.is_some_and(|gate| fit.chi2 >= gate) {
        return Some(Rejection::Misfit);
    }
    let (first, last) = (arcs.first()?, arcs.last()?);
    let away = circle.center - first.center();
    let off = circle.covariance.fixed_view::<2, 2>(0, 0).trace().sqrt() / away.norm();
    let slack = if options.misfits.is_some() {
        (BEAM_SIGMAS * off).min(first.beam_width / 2.0)
    } else {
        0.0
    };
    if !is_held(&fit.parameters, arcs, slack) {
        return Some(Rejection::OutsideBeams);
    }
    let lead = options.mirrored?;
    let path = last.center() - first.center();
    let along = path / path.norm().max(f64::MIN_POSITIVE);
    let mirrored = first.center() + along * (2.0 * along.dot(&away)) - away;
    let start = Parameters::new(mirrored.x, mirrored.y, circle.radius);
    let double = CircleFit::from(start, arcs)?;
    let is_double = (double.parameters - fit.parameters).norm() > APART
        && double.chi2 - fit.chi2 < lead
        && is_held(&double.parameters, arcs, slack);
    is_double.then_some(Rejection::Mirrored)
}

/// Root mean square of what remains, metres.
fn rms(circle: &Parameters, arcs: &[Arc]) -> f64 {
    let off = |arc: &Arc| Some(arc.range - circle_range(circle, arc.center())?.0);
    let squares = arcs.iter().filter_map(off).map(|off| off * off);
    (squares.sum::<f64>() / arcs.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::tmam::circle::testing::passing;
    use crate::core::tmam::fit::testing::Gauss;
    use crate::core::tmam::hypothesis::Gate;

    #[test]
    fn noisy_circles_are_off_as_their_covariance_says_and_outliers_are_left_out() {
        let options = FitOptions {
            converge: true,
            misfits: Some(Gate::new(6.63)),
            mirrored: None,
        };
        let mut noise = Gauss::new(7);
        let (mut sum, mut fits) = (0.0, 0);
        for _ in 0..300 {
            let mut arcs = passing(1.0, 0.3, 1.2, 0.1);
            for arc in &mut arcs {
                arc.range += arc.variance.sqrt() * noise.sample();
            }
            arcs[7].range += 0.2;
            let fit = estimate_circle(&arcs, &options);
            assert!(fit.outliers.contains(&arcs[7].id));
            let Some(circle) = fit.circle.filter(|_| fit.rejection.is_none()) else {
                continue;
            };
            let off = Parameters::new(0.0, 1.3, 0.3)
                - Parameters::new(circle.center.x, circle.center.y, circle.radius);
            sum += off.dot(&(circle.covariance.try_inverse().unwrap() * off)) / 3.0;
            fits += 1;
        }
        assert!(fits > 280, "{fits}");
        let nees = sum / f64::from(fits);
        assert!((0.8..1.4).contains(&nees), "{nees}");
    }
}
