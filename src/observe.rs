//! What watches a replay and writes or shows what it sees.

#[cfg(feature = "parquet")]
pub mod arc_table;
#[cfg(not(feature = "parquet"))]
#[path = "observe/without_parquet.rs"]
pub mod arc_table;
pub mod behind;
pub mod causes;
pub mod contradiction;
pub mod drawing;
pub mod features;
pub mod metric_grid;
pub mod path_file;
pub mod progress;
#[cfg(feature = "viewer")]
pub mod recording;
#[cfg(not(feature = "viewer"))]
#[path = "observe/without_viewer.rs"]
pub mod recording;
pub mod report;
pub mod trace;
pub mod viewer;
