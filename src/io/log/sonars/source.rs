//! A sonar of which only the messages are known.

use nalgebra::Isometry3;

use crate::io::log::stamps::Clock;

/// What tells one sonar from another.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct SourceKey {
    /// The topic its readings come on.
    pub topic: String,
    /// Its frame.
    pub frame: String,
    /// Its place in a message that holds several.
    pub element: Option<usize>,
}

/// A sonar of which only the messages are known.
#[derive(Debug, Clone)]
pub struct Source {
    /// What tells it from the others.
    pub key: SourceKey,
    /// The beam in its first message: its axis is x.
    pub frame_from_beam: Isometry3<f64>,
    /// Whether a later message has the beam elsewhere.
    pub turned: bool,
    /// Beam width in its first message that has one, radians.
    pub(super) beam_width: Option<f64>,
    /// What that is where neither messages nor configuration say it, radians.
    pub(super) likely_beam_width: Option<f64>,
    /// When its messages were stamped and recorded.
    pub clock: Clock,
}

impl Source {
    /// A sonar before its first reading.
    pub fn new(key: &SourceKey, frame_from_beam: Isometry3<f64>) -> Self {
        Self {
            key: key.clone(),
            frame_from_beam,
            turned: false,
            beam_width: None,
            likely_beam_width: None,
            clock: Clock::default(),
        }
    }

    /// Takes what a message says of the beam's width, radians; 0 or NaN for nothing.
    pub fn learn(&mut self, beam_width: f64, likely_beam_width: f64) {
        self.beam_width = self.beam_width.or(usable(beam_width));
        self.likely_beam_width = self.likely_beam_width.or(usable(likely_beam_width));
    }
}

/// A sonar's beam is narrower than this, radians.
pub const WIDEST_BEAM: f64 = std::f64::consts::FRAC_PI_2;

/// Whether a beam is wider than any sonar's, as one that a driver gives in degrees.
pub(super) fn is_senseless(width: f64) -> bool {
    width >= WIDEST_BEAM
}

/// A beam width that is one, radians.
pub(super) fn usable(width: f64) -> Option<f64> {
    (width > 0.0 && width.is_finite()).then_some(width)
}
