//! `tmam.toml`: the configuration as a file.

pub mod changed;
pub mod file;
pub mod idle;
pub mod keys;
pub mod render;
