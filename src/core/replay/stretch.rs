//! A stretch of a log that its own map explains less than the rest.

use crate::core::rounding::fixed;

/// The stretch that is explained least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// From when to when, seconds after the log's first reading.
    pub seconds: [f64; 2],
    /// Its first frame and its last one.
    pub frames: [u32; 2],
    /// Its arcs.
    pub arcs: u64,
    /// The share of them that the map explains.
    pub explained: f64,
    /// The share of all others.
    pub elsewhere: f64,
    /// Whether that is so at the poses of odometry, and not at those that were estimated.
    pub by_odometry: bool,
    /// By how many seconds its ranges are stamped late (early below zero), and the share that the map explains
    /// then; `None` where no delay makes it as good as the rest.
    pub delay: Option<(f64, f64)>,
}

impl Stretch {
    /// In words, after the number of its arcs.
    pub fn in_words(&self) -> String {
        let [from, to] = self.seconds.map(|seconds| fixed(seconds, 1));
        let [first, last] = self.frames;
        let percent = |share: f64| fixed(100.0 * share, 0);
        let poses = if self.by_odometry {
            "at the poses of odometry "
        } else {
            ""
        };
        let text = format!(
            "arcs from {from} to {to} s, frames {first} to {last}: {poses}{} % are explained, elsewhere {} %",
            percent(self.explained),
            percent(self.elsewhere)
        );
        let Some((delay, share)) = self.delay else {
            return text + "; something was off then";
        };
        let (to, came) = if delay > 0.0 {
            ("earlier", "late")
        } else {
            ("later", "early")
        };
        let (delay, share) = (fixed(delay.abs(), 2), percent(share));
        format!("{text}; with stamps {delay} s {to} {share} % are: they came {came}")
    }
}
