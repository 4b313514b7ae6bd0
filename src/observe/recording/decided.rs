//! The tables that wait for labels, as one.

use std::io::Write;

use super::Error;
use super::arcs::ArcTables;
use super::encode::RrdWriter;
use super::hold::{Held, Ready};
use super::plots::PlotTables;
use super::table::Timelines;
use crate::core::event::Sonar;

/// Everything that a label is needed for.
pub struct DecidedTables {
    arcs: ArcTables,
    plots: PlotTables,
}

impl DecidedTables {
    /// Empty tables for these sonars.
    pub fn new(sonars: &[Sonar]) -> Self {
        Self {
            arcs: ArcTables::new(sonars),
            plots: PlotTables::new(sonars),
        }
    }

    /// Adds a frame whose arcs are decided.
    pub fn write<W: Write>(
        &mut self,
        ready: &Ready,
        sonars: &[Sonar],
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        match ready {
            Ready::InOrder(held) => self.push(held, lines, out),
            // Chunks of its own, so that the rows of the others stay in order.
            Ready::Late(held) => {
                let mut own = Self::new(sonars);
                own.push(held, lines, out)?;
                own.flush(lines, out)
            }
        }
    }

    fn push<W: Write>(
        &mut self,
        held: &Held,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.arcs.push(held, lines, out)?;
        self.plots.push(held, lines, out)
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.arcs.flush(lines, out)?;
        self.plots.flush(lines, out)
    }
}
