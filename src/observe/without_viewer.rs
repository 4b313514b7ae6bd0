//! In place of the recording where the feature `viewer` is off: whoever asks for one is told how to
//! get it.

use std::convert::Infallible;
use std::io::Write;
use std::path::Path;

use super::drawing::{DrawnGrid, DrawnPair, Overlay};
use super::viewer::{Carried, CarriedError, Error};
use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError, Setting};
use crate::core::replay::Outcome;
use crate::core::tmam::step::Step;

/// There is none.
pub struct Live(Infallible);

/// There is none.
pub struct Recording(Infallible);

impl Live {
    pub fn connect(_url: &str, _spawn: bool) -> Result<Self, Error> {
        Err(Error::NotBuiltIn)
    }
}

impl Recording {
    pub fn new(
        _out: Option<&mut (dyn Write + Send)>,
        _viewer: Option<Live>,
        _setting: Setting<'_>,
        _overlay: Overlay,
    ) -> Result<Self, Error> {
        Err(Error::NotBuiltIn)
    }

    pub fn tell(&mut self, _outcome: &Outcome) -> Result<(), Error> {
        match self.0 {}
    }

    pub fn close(self, _carried: Option<&Carried>) -> Result<Option<Error>, Error> {
        match self.0 {}
    }
}

impl Observer for Recording {
    fn frame(&mut self, _: &Frame, _: &Step) -> Result<(), ObserverError> {
        match self.0 {}
    }

    fn finish(&mut self, _: &Step) -> Result<(), ObserverError> {
        match self.0 {}
    }
}

pub fn write_grid(_out: impl Write, _grid: &DrawnGrid) -> Result<(), Error> {
    Err(Error::NotBuiltIn)
}

pub fn write_pairs(_out: impl Write, _pairs: &[DrawnPair]) -> Result<(), Error> {
    Err(Error::NotBuiltIn)
}

pub fn read_carried(_path: &Path) -> Result<Carried, CarriedError> {
    Err(CarriedError::NotBuiltIn)
}
