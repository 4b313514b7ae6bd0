//! Iterated least squares, (10) to (12): the one loop of every fit.

use nalgebra::{Matrix2, RowVector2, Vector2};

use super::arc::Arc;
use super::feature::Rejection;

/// A determinant below this fraction of the squared trace leaves a direction undetermined.
const SINGULAR: f64 = 1e-12;

/// An observation model `r = h(P) + w` with two parameters.
pub trait Observation {
    /// Predicted range of one arc and its derivative by the parameters; `None` where the model has
    /// no derivative.
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)>;
}

/// Where an iteration goes from its parameters.
pub enum Advance {
    /// To these, and on.
    To(Vector2<f64>),
    /// To these, which are the end.
    Last(Vector2<f64>),
    /// Nowhere: there is nothing better.
    Stay,
}

/// Where an iteration ended.
#[derive(Debug, Clone, Copy)]
pub struct Minimum {
    pub parameters: Vector2<f64>,
    /// Steps that were made.
    pub iterations: u32,
    /// Whether it came to its end before it ran out of steps.
    pub converged: bool,
}

/// Why an iteration led nowhere, and after how many steps.
pub type Failure = (Rejection, u32);

/// Iterates (10) from `start`: `advance` gets the parameters and the full step from them.
///
/// # Errors
/// When the readings do not determine both parameters, or the iteration runs away.
pub fn iterate(
    model: &impl Observation,
    arcs: &[Arc],
    start: Vector2<f64>,
    longest: u32,
    mut advance: impl FnMut(Vector2<f64>, Vector2<f64>) -> Advance,
) -> Result<Minimum, Failure> {
    let (mut parameters, mut iterations, mut converged) = (start, 0, false);
    while !converged && iterations < longest {
        let step = normal_equations(model, parameters, arcs)
            .and_then(|(information, gradient)| Some(invert(information)? * gradient))
            .ok_or((Rejection::Singular, iterations))?;
        match advance(parameters, step) {
            Advance::To(next) => parameters = next,
            Advance::Last(next) => (parameters, converged) = (next, true),
            Advance::Stay => break,
        }
        iterations += 1;
        if !parameters.iter().all(|p| p.is_finite()) {
            return Err((Rejection::Diverged, iterations));
        }
    }
    Ok(Minimum {
        parameters,
        iterations,
        converged,
    })
}

/// The mean square error (12) of an estimate; `None` where the readings do not determine it.
pub fn covariance(
    model: &impl Observation,
    parameters: Vector2<f64>,
    arcs: &[Arc],
) -> Option<Matrix2<f64>> {
    let (information, _) = normal_equations(model, parameters, arcs)?;
    invert(information) // (12)
}

/// Sum over the arcs of squared residuals, each divided by its variance; infinite where the model
/// cannot predict.
pub fn chi2(model: &impl Observation, parameters: Vector2<f64>, arcs: &[Arc]) -> f64 {
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
