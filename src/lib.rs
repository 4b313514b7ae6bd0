pub mod config;
pub mod event;
pub mod frames;
pub mod geometry;
pub mod log;
pub mod odometry;
pub mod tmam;
