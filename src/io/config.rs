//! `tmam.toml`: the configuration as a file.

pub mod file;
pub mod keys;
pub mod render;
