//! The three measurements association model as a pure state machine: frames in, decisions out.
//!
//! No input or output, no clock, no threads. Equation numbers are those of Wang et al., "Sonar
//! Feature Map Building for a Mobile Robot"; `docs/algorithm.md` reads code and paper side by side.

pub mod arc;
pub mod feature;
pub mod fit;
pub mod map;
pub mod pair;
pub mod run;
pub mod step;
pub mod triple;
