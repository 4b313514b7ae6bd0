pub mod event;
pub mod geometry;
