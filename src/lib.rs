pub mod config;
pub mod event;
pub mod frames;
pub mod geometry;
pub mod odometry;
pub mod tmam;
