//! The circle that explains readings best.

use crate::core::tmam::arc::Arc;
use crate::core::tmam::circle::{CircleFit, FEWEST, is_held};

/// The least chi2 of a cylinder whose centre lies in all beams; infinite where there is none, and 0 of so few
/// readings that a circle always fits them.
pub fn least_chi2(arcs: &[Arc]) -> f64 {
    if arcs.len() < FEWEST {
        return 0.0;
    }
    let fit = CircleFit::best(arcs);
    let fit = fit.filter(|fit| fit.is_cylinder() && is_held(&fit.parameters, arcs, 0.0));
    fit.map_or(f64::INFINITY, |fit| fit.chi2)
}
