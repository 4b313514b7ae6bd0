pub mod config;
pub mod log;
pub mod output;
pub mod outputs;
pub mod schema;
