//! Iterated least squares, (10) to (12): the loop that lines and points share.

mod line;
mod point;

pub use line::fit_line;
pub use point::fit_point;

use nalgebra::{Matrix2, RowVector2, Vector2};

use super::arc::{Arc, BEAM_SLACK};
use super::feature::{Rejection, Shape};
use super::pair::{PairPoint, Points};

/// Iterations after which (10) ends without having met the stopping rule.
pub const MAX_ITERATIONS: u32 = 10;

/// A determinant below this fraction of the squared trace leaves a direction undetermined.
const SINGULAR: f64 = 1e-12;

/// The end of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
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
}

impl Fit {
    fn failed(rejection: Rejection, iterations: u32) -> Self {
        Self {
            shape: None,
            residual_rms: 0.0,
            iterations,
            converged: false,
            rejection: Some(rejection),
        }
    }
}

/// An observation model `r = h(P) + w` with two parameters.
trait Model {
    /// Predicted range of one arc and its derivative by the parameters; `None` where the model has
    /// no derivative.
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)>;

    /// The parameters that the points of a pair of arcs suggest, one for each side in the beams.
    fn starts(&self, points: &Points) -> [Option<Start>; 2];

    /// Norm of a step with lengths in centimetres and angles in radians, as the paper adds them.
    fn step_norm(step: Vector2<f64>) -> f64;
}

/// Parameters to start from and how far they lie from the axes of the two beams, radians.
#[derive(Debug, Clone, Copy)]
struct Start {
    parameters: Vector2<f64>,
    off_axis: f64,
}

impl Start {
    fn at(parameters: Vector2<f64>, point: &PairPoint, first: &Arc) -> Self {
        let off_axis = crate::geometry::angle_between(point.bearing_a, first.world_from_sensor.yaw);
        Self {
            parameters,
            off_axis,
        }
    }
}

/// The estimate of (10) with its mean square error (12).
struct Estimate {
    parameters: Vector2<f64>,
    covariance: Matrix2<f64>,
    residual_rms: f64,
    iterations: u32,
    converged: bool,
}

/// Where the iteration starts: the points of the first and the last arc, else those of the first
/// neighbouring pair that has any. Of two sides the one with the smaller residuals is taken; sides
/// that fit equally well (on a straight path a line and its mirror image do) are told apart by the
/// beam axis.
fn start(model: &impl Model, arcs: &[Arc]) -> Option<Vector2<f64>> {
    let (first, last) = (arcs.first()?, arcs.last()?);
    let neighbours = arcs
        .windows(2)
        .filter_map(|w| Some((w.first()?, w.last()?)));
    let sides = std::iter::once((first, last))
        .chain(neighbours)
        .map(|(a, b)| model.starts(&Points::of(a, b)))
        .find(|sides| sides.iter().any(Option::is_some))?;
    let cost = |start: &Start| weighted_square_sum(model, start.parameters, arcs);
    match sides {
        [Some(left), Some(right)] => {
            let (cost_left, cost_right) = (cost(&left), cost(&right));
            let equal = (cost_left - cost_right).abs() <= 1e-9 * (1.0 + cost_left.min(cost_right));
            let right_is_better = if equal {
                right.off_axis < left.off_axis - BEAM_SLACK
            } else {
                cost_right < cost_left
            };
            Some(if right_is_better { right } else { left }.parameters)
        }
        [side, None] | [None, side] => side.map(|start| start.parameters),
    }
}

/// Sum over the arcs of squared residuals, each divided by its variance; infinite where the model
/// cannot predict.
fn weighted_square_sum(model: &impl Model, parameters: Vector2<f64>, arcs: &[Arc]) -> f64 {
    arcs.iter()
        .map(|arc| match model.predict(parameters, arc) {
            Some((h, _)) => (arc.range - h) * (arc.range - h) / arc.variance,
            None => f64::INFINITY,
        })
        .sum()
}

/// `J^T R^-1 J` and `J^T R^-1 (r - h)` at the given parameters, with `R = diag(sigma_i^2)`.
fn normal_equations(
    model: &impl Model,
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

/// Iterates (10) from the model's start until the paper's stopping rule holds.
fn iterate(model: &impl Model, arcs: &[Arc]) -> Result<Estimate, Fit> {
    let Some(mut parameters) = start(model, arcs) else {
        return Err(Fit::failed(Rejection::NoStart, 0));
    };
    let cost_at_start = weighted_square_sum(model, parameters, arcs);
    let mut iterations = 0;
    let mut converged = false;
    while !converged && iterations < MAX_ITERATIONS {
        let step = normal_equations(model, parameters, arcs)
            .and_then(|(information, gradient)| Some(invert(information)? * gradient))
            .ok_or_else(|| Fit::failed(Rejection::Singular, iterations))?;
        parameters += step; // (10)
        iterations += 1;
        if !parameters.iter().all(|p| p.is_finite()) {
            return Err(Fit::failed(Rejection::Diverged, iterations));
        }
        converged = norm_below_one(model, step);
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
    })
}

fn norm_below_one<M: Model>(_: &M, step: Vector2<f64>) -> bool {
    M::step_norm(step) < 1.0
}

fn residual_rms(model: &impl Model, parameters: Vector2<f64>, arcs: &[Arc]) -> f64 {
    let squares = arcs
        .iter()
        .filter_map(|arc| model.predict(parameters, arc).map(|(h, _)| arc.range - h))
        .map(|residual| residual * residual)
        .sum::<f64>();
    (squares / arcs.len().max(1) as f64).sqrt()
}

#[cfg(test)]
pub(crate) mod testing {
    use crate::event::SonarId;
    use crate::geometry::{Pose2, Vec2};
    use crate::tmam::arc::{Arc, ArcId};

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
