//! Iterated least squares, (10) to (12): the loop that lines and points share.

mod consistency;
mod line;
mod parts;
mod point;
mod refit;
mod start;

pub use line::fit_line;
pub use parts::{fit_in_parts, fit_run};
pub use point::fit_point;
pub use refit::refit;

use nalgebra::{Matrix2, RowVector2, Vector2};

use self::start::Start;
use super::arc::{Arc, ArcId};
use super::feature::{Rejection, Shape};
use super::hypothesis::Gate;
use super::pair::Points;

/// Iterations after which (10) ends without having met the paper's stopping rule.
pub const MAX_ITERATIONS: u32 = 10;

/// The same where fits are iterated to their end.
const MAX_ITERATIONS_TO_THE_END: u32 = 50;

/// A step that is smaller than this, relative to the parameters, is the end.
const RELATIVE_STEP: f64 = 1e-9;

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

/// A determinant below this fraction of the squared trace leaves a direction undetermined.
const SINGULAR: f64 = 1e-12;

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

impl Fit {
    fn failed(rejection: Rejection, iterations: u32) -> Self {
        Self {
            shape: None,
            residual_rms: 0.0,
            iterations,
            converged: false,
            rejection: Some(rejection),
            outliers: Vec::new(),
        }
    }
}

/// An observation model `r = h(P) + w` with two parameters.
trait Observation {
    /// Predicted range of one arc and its derivative by the parameters; `None` where the model has
    /// no derivative.
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)>;

    /// Norm of a step with lengths in centimetres and angles in radians, as the paper adds them.
    fn step_norm(step: Vector2<f64>) -> f64;
}

/// An observation model for the readings of a run, with what it takes to find a start and to see
/// whether the estimate makes sense.
trait Model: Observation {
    /// The parameters that the points of a pair of arcs suggest, one for each side in the beams.
    fn starts(&self, points: &Points) -> [Option<Start>; 2];

    /// The mirror image at the line through two sensor centres.
    fn mirrored(&self, parameters: Vector2<f64>, first: &Arc, last: &Arc) -> Vector2<f64>;

    /// Whether the beam of an arc holds the feature, with `slack` radians on either side.
    fn in_beam(&self, parameters: Vector2<f64>, arc: &Arc, slack: f64) -> bool;

    /// Variance of the bearing at which the first arc sees the feature.
    fn bearing_variance(&self, estimate: &Estimate, first: &Arc) -> f64;
}

/// The estimate of (10) with its mean square error (12).
struct Estimate {
    parameters: Vector2<f64>,
    covariance: Matrix2<f64>,
    residual_rms: f64,
    iterations: u32,
    converged: bool,
    rejection: Option<Rejection>,
    outliers: Vec<ArcId>,
}

impl Estimate {
    fn fit(self, shape: Shape) -> Fit {
        Fit {
            shape: Some(shape),
            residual_rms: self.residual_rms,
            iterations: self.iterations,
            converged: self.converged,
            rejection: self.rejection,
            outliers: self.outliers,
        }
    }
}

/// Sum over the arcs of squared residuals, each divided by its variance; infinite where the model
/// cannot predict.
fn weighted_square_sum(model: &impl Observation, parameters: Vector2<f64>, arcs: &[Arc]) -> f64 {
    arcs.iter()
        .map(|arc| match model.predict(parameters, arc) {
            Some((h, _)) => (arc.range - h) * (arc.range - h) / arc.variance,
            None => f64::INFINITY,
        })
        .sum()
}

/// `J^T R^-1 J` and `J^T R^-1 (r - h)` at the given parameters, with `R = diag(sigma_i^2)`.
fn normal_equations(
    model: &impl Observation,
    parameters: Vector2<f64>,
    arcs: &[Arc],
) -> Option<(Matrix2<f64>, Vector2<f64>)> {
    let mut information = Matrix2::zeros();
    let mut gradient = Vector2::zeros();
    for arc in arcs {
        let (h, jacobian) = model.predict(parameters, arc)?;
        information += jacobian.transpose() * jacobian / arc.variance;
        gradient += jacobian.transpose() * ((arc.range - h) / arc.variance);
    }
    Some((information, gradient))
}

/// The inverse of an information matrix that determines both parameters.
fn invert(information: Matrix2<f64>) -> Option<Matrix2<f64>> {
    let (determinant, trace) = (information.determinant(), information.trace());
    let determined = trace.is_finite() && determinant > SINGULAR * trace * trace;
    determined.then(|| information.try_inverse()).flatten()
}

/// Iterates (10) until the stopping rule holds: the paper's, or that of a fit to its end.
fn iterate(
    model: &impl Observation,
    arcs: &[Arc],
    start: Vector2<f64>,
    to_the_end: bool,
) -> Result<Estimate, Fit> {
    let mut parameters = start;
    let cost_at_start = weighted_square_sum(model, parameters, arcs);
    let longest = if to_the_end {
        MAX_ITERATIONS_TO_THE_END
    } else {
        MAX_ITERATIONS
    };
    let mut iterations = 0;
    let mut converged = false;
    while !converged && iterations < longest {
        let step = normal_equations(model, parameters, arcs)
            .and_then(|(information, gradient)| Some(invert(information)? * gradient))
            .ok_or_else(|| Fit::failed(Rejection::Singular, iterations))?;
        parameters += step; // (10)
        iterations += 1;
        if !parameters.iter().all(|p| p.is_finite()) {
            return Err(Fit::failed(Rejection::Diverged, iterations));
        }
        converged = if to_the_end {
            step.norm() < RELATIVE_STEP * (1.0 + parameters.norm())
        } else {
            norm_below_one(model, step)
        };
    }
    let cost = weighted_square_sum(model, parameters, arcs);
    if !converged && (cost.is_nan() || cost > cost_at_start) {
        return Err(Fit::failed(Rejection::Diverged, iterations));
    }
    let covariance = normal_equations(model, parameters, arcs)
        .and_then(|(information, _)| invert(information)) // (12)
        .ok_or_else(|| Fit::failed(Rejection::Singular, iterations))?;
    Ok(Estimate {
        parameters,
        covariance,
        residual_rms: residual_rms(model, parameters, arcs),
        iterations,
        converged,
        rejection: None,
        outliers: Vec::new(),
    })
}

fn norm_below_one<M: Observation>(_: &M, step: Vector2<f64>) -> bool {
    M::step_norm(step) < 1.0
}

fn residual_rms(model: &impl Observation, parameters: Vector2<f64>, arcs: &[Arc]) -> f64 {
    let squares = arcs
        .iter()
        .filter_map(|arc| model.predict(parameters, arc).map(|(h, _)| arc.range - h))
        .map(|residual| residual * residual)
        .sum::<f64>();
    (squares / arcs.len().max(1) as f64).sqrt()
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
