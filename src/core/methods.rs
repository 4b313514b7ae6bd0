//! The ways from frames to a map: TMAM, and the methods that its paper discusses, on the same frames.
//!
//! A rival is a file that implements [`Rival`]: it turns scans into features, each with the readings that
//! it comes from. [`RivalMapper`] makes of that what a replay shows: labels, features, a map.

mod atm;
mod crowley;
mod hough;
mod mapper;
mod rcd;
mod regression;
mod rival;
mod sequences;
mod tbf;
mod triangulation;
mod two_measurement;

pub use mapper::Mapper;

use crate::core::config::{Config, Method};
use crate::core::tmam::Tmam;
use rival::{Rival, RivalMapper};

/// The method that a configuration asks for, before the first frame.
pub fn of(config: &Config) -> Box<dyn Mapper> {
    let rival: Box<dyn Rival> = match config.method {
        Method::Tmam => return Box::new(Tmam::new(config)),
        Method::TwoMeasurement => Box::new(two_measurement::TwoMeasurement::new(config)),
        Method::Tbf => Box::new(tbf::Tbf::new(config)),
        Method::Atm => Box::new(atm::Atm::default()),
        Method::Rcd => Box::new(rcd::Rcd::new(config)),
        Method::Crowley => Box::new(crowley::Crowley::new(config)),
    };
    Box::new(RivalMapper::new(rival, config))
}
