pub mod features;
pub mod progress;
pub mod recording;
pub mod report;
pub mod trace;
