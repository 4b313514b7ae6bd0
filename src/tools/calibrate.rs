//! What of a log's configuration is off: [`search`] tries what [`crate::core::calibrate`] finds likely.

pub mod search;
