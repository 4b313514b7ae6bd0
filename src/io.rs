pub mod colour;
pub mod config;
pub mod drives;
#[cfg(all(unix, feature = "terminal"))]
pub mod interruption;
pub mod log;
pub mod output;
pub mod outputs;
pub mod schema;
pub mod text_file;
