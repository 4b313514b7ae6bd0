pub mod cli;
pub mod event;
pub mod geometry;
pub mod log;
pub mod output;
pub mod simulate;
pub mod truth;
pub mod world;
