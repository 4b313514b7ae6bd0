pub mod event;
pub mod geometry;
pub mod log;
pub mod simulate;
pub mod truth;
pub mod world;
