//! Rows of one entity, gathered into chunks.

use std::io::Write;

use rerun::{AsComponents, EntityPath, SerializationResult, SerializedComponentColumn, Timeline};

use super::Error;
use super::encode::{RrdWriter, Store};

/// Rows in a chunk: enough to make the cost of a chunk small, few enough to stay in memory.
const CHUNK_ROWS: usize = 512;
/// Instances in a chunk, for entities whose rows are long.
const CHUNK_INSTANCES: usize = 16_384;

/// When something was: the place of a row on both timelines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// The frame's index.
    pub frame: i64,
    /// The frame's stamp, nanoseconds.
    pub stamp_ns: i64,
}

/// The timelines of a recording.
#[derive(Debug, Clone, Copy)]
pub struct Timelines {
    /// Frames, counted from 0.
    pub frame: Timeline,
    /// The log's own clock.
    pub stamp: Timeline,
}

/// Clocks that started before this are counted from the start of the run, not from 1970.
const FIRST_PLAUSIBLE_STAMP_NS: i64 = 1_000_000_000_000_000_000;

impl Timelines {
    /// The stamps read as dates where they can be dates, else as the time since zero.
    pub fn new(start_ns: i64) -> Self {
        Self {
            frame: Timeline::new_sequence("frame"),
            stamp: if start_ns >= FIRST_PLAUSIBLE_STAMP_NS {
                Timeline::new_timestamp("stamp")
            } else {
                Timeline::new_duration("stamp")
            },
        }
    }

    fn columns(self, moments: &[Moment]) -> Vec<(Timeline, Vec<i64>)> {
        vec![
            (self.frame, moments.iter().map(|m| m.frame).collect()),
            (self.stamp, moments.iter().map(|m| m.stamp_ns).collect()),
        ]
    }
}

/// One element of a row, as the columns of an archetype.
pub trait Instance: Sized {
    /// `instances` of all rows one after another, cut into rows by `lengths`.
    fn columns(
        instances: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>>;
}

/// Rows of one entity that wait to be written together.
pub struct Table<T> {
    entity: EntityPath,
    moments: Vec<Moment>,
    lengths: Vec<usize>,
    instances: Vec<T>,
}

impl<T: Instance> Table<T> {
    /// A table for the entity at `path`.
    pub fn new(path: impl Into<EntityPath>) -> Self {
        Self {
            entity: path.into(),
            moments: Vec::new(),
            lengths: Vec::new(),
            instances: Vec::new(),
        }
    }

    /// Adds a row; moments must not decrease. A full chunk goes to `out`.
    pub fn push<W: Write>(
        &mut self,
        moment: Moment,
        row: impl IntoIterator<Item = T>,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let before = self.instances.len();
        self.instances.extend(row);
        self.moments.push(moment);
        self.lengths.push(self.instances.len() - before);
        if self.moments.len() >= CHUNK_ROWS || self.instances.len() >= CHUNK_INSTANCES {
            self.flush(lines, out)?;
        }
        Ok(())
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        if self.moments.is_empty() {
            return Ok(());
        }
        let moments = std::mem::take(&mut self.moments);
        let lengths = std::mem::take(&mut self.lengths);
        let columns = T::columns(std::mem::take(&mut self.instances), &lengths)?;
        out.chunk(
            Store::Recording,
            &self.entity,
            moments.len(),
            lines.columns(&moments),
            columns,
        )
    }
}

/// Writes something that holds at all times.
pub fn put_static<W: Write>(
    path: impl Into<EntityPath>,
    what: &dyn AsComponents,
    out: &mut RrdWriter<W>,
) -> Result<(), Error> {
    out.chunk(
        Store::Recording,
        &path.into(),
        1,
        Vec::new(),
        unit_columns(what)?,
    )
}

/// An archetype as the columns of a single row.
pub fn unit_columns(
    what: &dyn AsComponents,
) -> SerializationResult<Vec<SerializedComponentColumn>> {
    what.as_serialized_batches()
        .into_iter()
        .map(|batch| {
            let len = batch.array.len();
            batch.partitioned([len])
        })
        .collect()
}
