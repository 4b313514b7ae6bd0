//! Features fitted to runs of readings, and known ones fitted anew.
//!
//! Odometry drifts: along a wall of ten metres its line bends, and no single line fits the readings
//! any more, although every few metres of them do. So a run that does not fit as a whole is fitted in
//! parts that do.

mod circle;
mod estimate;
mod model;

pub use estimate::FitOptions;

use self::circle::estimate_circle;
use self::estimate::{estimate, fit_to_the_end};
use self::model::{CartesianPoint, LineFromEitherSide, LocalLine, Model};
use super::arc::{Arc, ArcId};
use super::circle::{CircleFit, covariance};
use super::feature::{Circle, Kind, Rejection, Shape};
use super::gauss_newton::chi2;
use super::run::Run;
use crate::core::ties;

/// Readings that a part has at least.
const SHORTEST_PART: usize = 8;

/// Places at which a break is tried, at most.
const MOST_BREAKS: usize = 64;

/// The end of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The estimate in the world; `None` where there was none to speak of.
    pub shape: Option<Shape>,
    /// Root mean square of range minus prediction, metres.
    pub residual_rms: f64,
    /// Iterations of (10) that were made.
    pub iterations: u32,
    /// Whether the stopping rule was met.
    pub converged: bool,
    /// Why it must not be registered, if so.
    pub rejection: Option<Rejection>,
    /// Readings that were left out.
    pub outliers: Vec<ArcId>,
}

/// Fits a line to the arcs of a run; estimate and covariance in the world.
pub fn fit_line(arcs: &[Arc], options: &FitOptions) -> Fit {
    fit(LocalLine::new, arcs, options)
}

/// Fits a point to the arcs of a run; estimate and covariance in the world.
pub fn fit_point(arcs: &[Arc], options: &FitOptions) -> Fit {
    fit(|_| CartesianPoint, arcs, options)
}

fn fit<M: Model>(model: impl Fn(&Arc) -> M, arcs: &[Arc], options: &FitOptions) -> Fit {
    let model = arcs.first().map(model);
    let failed = (Rejection::NoStart, 0);
    let found = (model.as_ref().ok_or(failed))
        .and_then(|model| Ok((model, estimate(model, arcs, options)?)));
    match found {
        Ok((model, estimate)) => {
            let used = |arc: &&Arc| !estimate.outliers.contains(&arc.id);
            let used: Vec<Arc> = arcs.iter().filter(used).copied().collect();
            Fit {
                shape: Some(model.shape(&estimate, &used)),
                residual_rms: estimate.residual_rms,
                iterations: estimate.iterations,
                converged: estimate.converged,
                rejection: estimate.rejection,
                outliers: estimate.outliers,
            }
        }
        Err((rejection, iterations)) => Fit {
            shape: None,
            residual_rms: 0.0,
            iterations,
            converged: false,
            rejection: Some(rejection),
            outliers: Vec::new(),
        },
    }
}

/// Fits a circle to the arcs of a run; estimate and covariance in the world.
pub fn fit_circle(arcs: &[Arc], options: &FitOptions) -> Fit {
    let estimate = estimate_circle(arcs, options);
    Fit {
        shape: estimate.circle.map(Shape::Circle),
        residual_rms: estimate.residual_rms,
        iterations: estimate.iterations,
        converged: estimate.circle.is_some(),
        rejection: estimate.rejection,
        outliers: estimate.outliers,
    }
}

/// Fits a feature to the whole of a run.
pub fn fit_run(run: &Run, options: &FitOptions) -> Fit {
    match run.kind {
        Kind::Line => fit_line(&run.associated, options),
        Kind::Point => fit_point(&run.associated, options),
        Kind::Circle => fit_circle(&run.associated, options),
    }
}

/// Fits a feature to a run; where the readings of a wall do not all fit, to its parts, as long as
/// any of them fits. Parts without a labelled arc are dropped.
pub fn fit_in_parts(run: Run, options: &FitOptions) -> Vec<(Run, Fit)> {
    let whole = fit_run(&run, options);
    let breaks = run.kind == Kind::Line && whole.rejection == Some(Rejection::Misfit);
    let Some(at) = breaks.then(|| best_break(&run.associated)).flatten() else {
        return vec![(run, whole)];
    };
    let (before, after) = run.broken_at(at);
    let parts: Vec<(Run, Fit)> = [before, after]
        .into_iter()
        .filter(|part| !part.labelled.is_empty())
        .flat_map(|part| fit_in_parts(part, options))
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
        Some((chi2_of_line(before)? + chi2_of_line(after)?, at))
    });
    ties::first_least(breaks, ties::of_chi2).map(|(_, at)| at)
}

/// What is left of the readings after a line was fitted to all of them.
fn chi2_of_line(arcs: &[Arc]) -> Option<f64> {
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

/// A feature after it was fitted anew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refit {
    /// Where it is now; a line reaches from the first to the last place that a reading came from.
    pub shape: Shape,
    /// Squared residuals, each divided by its variance.
    pub chi2: f64,
}

/// Fits a feature to readings of any sonars, starting from where it is; `None` where they do not
/// determine it.
pub fn refit(shape: &Shape, arcs: &[Arc]) -> Option<Refit> {
    let (shape, chi2) = match shape {
        Shape::Line(segment) => {
            let model = LineFromEitherSide::of(segment);
            let start = segment.about(segment.mid).0;
            let found = fit_to_the_end(&model, arcs, start).ok()?;
            let misfit = chi2(&model, found.parameters, arcs);
            (model.shape(&found, arcs), misfit)
        }
        Shape::Point(point) => {
            let found = fit_to_the_end(&CartesianPoint, arcs, point.position).ok()?;
            let misfit = chi2(&CartesianPoint, found.parameters, arcs);
            (CartesianPoint.shape(&found, arcs), misfit)
        }
        Shape::Circle(circle) => {
            let fit = CircleFit::from(circle.parameters(), arcs)?;
            let fit = fit.is_cylinder().then_some(fit)?;
            let covariance = covariance(&fit.parameters, arcs)?;
            let circle = Circle::of(fit.parameters, covariance);
            (Shape::Circle(circle), fit.chi2)
        }
    };
    Some(Refit { shape, chi2 })
}

#[cfg(test)]
pub(crate) mod testing {
    use crate::core::event::SonarId;
    use crate::core::geometry::{Pose2, Vec2};
    use crate::core::tmam::arc::{Arc, ArcId};

    pub const SIGMA: f64 = 0.003;

    pub fn arc(frame: u32, sensor: Vec2, yaw: f64, range: f64) -> Arc {
        Arc {
            id: ArcId {
                frame,
                sonar: SonarId(0),
            },
            stamp_ns: 0,
            world_from_sensor: Pose2::new(sensor.x, sensor.y, yaw),
            range,
            beam_width: 0.5,
            variance: SIGMA * SIGMA,
        }
    }

    /// Normal deviates for the Monte Carlo tests, the same in every run.
    pub struct Gauss(rand_chacha::ChaCha8Rng);

    impl Gauss {
        pub fn new(seed: u64) -> Self {
            Self(rand_core::SeedableRng::seed_from_u64(seed))
        }

        pub fn sample(&mut self) -> f64 {
            let mut uniform = || {
                let bits = rand_core::Rng::next_u64(&mut self.0) >> 11;
                (bits as f64 + 0.5) / (1u64 << 53) as f64
            };
            (-2.0 * libm::log(uniform())).sqrt() * libm::cos(std::f64::consts::TAU * uniform())
        }
    }
}

#[cfg(test)]
mod tests;
