pub mod config;
#[cfg(all(unix, feature = "terminal"))]
pub mod interruption;
pub mod log;
pub mod output;
pub mod outputs;
pub mod schema;
pub mod text_file;
