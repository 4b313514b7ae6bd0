//! `tmam reproduce`: the paper's experiment, made again.

mod counts;
mod experiment;
mod page;
pub mod paper;

pub use experiment::{ReproduceError, Reproduction};
pub use page::{OF_THE_DOCS, page};
