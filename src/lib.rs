pub mod event;
pub mod geometry;
pub mod truth;
pub mod world;
