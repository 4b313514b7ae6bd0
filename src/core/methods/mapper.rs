//! What every method is to a replay.

use crate::core::frames::Frame;
use crate::core::tmam::Tmam;
use crate::core::tmam::feature::MapFeature;
use crate::core::tmam::step::Step;

/// From frames to a map: a pure state machine.
pub trait Mapper {
    /// Takes the next frame.
    fn step(&mut self, frame: &Frame) -> Step;

    /// The log has ended: what still waits is decided.
    fn finish(&mut self) -> Step;

    /// The map so far, by id.
    fn features(&self) -> &[MapFeature];

    /// What the log lacks for the method; `None` where it lacks nothing. Known at the end.
    fn lacking(&self) -> Option<String>;
}

impl Mapper for Tmam {
    fn step(&mut self, frame: &Frame) -> Step {
        self.step(frame)
    }

    fn finish(&mut self) -> Step {
        self.finish()
    }

    fn features(&self) -> &[MapFeature] {
        self.map().features()
    }

    fn lacking(&self) -> Option<String> {
        None
    }
}
