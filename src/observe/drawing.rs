//! What tools hand over to be drawn in a recording, as plain data.

use std::collections::BTreeMap;

use nalgebra::Matrix3;

use crate::core::geometry::Vec2;
use crate::core::tmam::feature::Circle;

/// What is drawn over a run, and how much of the run is shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overlay {
    /// Features as they were: pale.
    pub golden: Vec<Sketched>,
    /// Of those, the ones that moved or are missing: bright.
    pub before: Vec<Sketched>,
    /// Features that moved or are new, as they are now: bright, in another colour.
    pub now: Vec<Sketched>,
    /// What became of the label of an arc, by frame and sonar.
    pub labels: BTreeMap<(u32, String), String>,
    /// What the event log says, at a frame and its stamp.
    pub notes: Vec<(u32, i64, String)>,
    /// The frame at which the viewer opens.
    pub first_frame: Option<u32>,
    /// First and last of the frames to show; `None`: all of them. The map is complete in any case.
    pub only: Option<Vec<[u32; 2]>>,
    /// The page that says what the recording is gets this, too (Markdown).
    pub about: String,
    /// The truth, and what is wrong.
    pub truth: Option<DrawnTruth>,
}

/// The truth about a run, and what is wrong with the run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DrawnTruth {
    /// The scores (Markdown).
    pub page: String,
    /// What the run was held against, in JSON: against another world it is another recording.
    pub world: String,
    /// The walls and points that are really there.
    pub real: Vec<Sketched>,
    /// Of those, the ones that the final map misses.
    pub missed: Vec<Sketched>,
    /// What is wrong with the label of an arc, by frame and sonar.
    pub wrong: BTreeMap<(u32, String), String>,
    /// From where a feature of the final map is to where it should be.
    pub errors: Vec<Sketched>,
    /// Features of the final map that are too many.
    pub spurious: Vec<Sketched>,
}

/// The maps A and B of two results, to be drawn over each other.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnPair {
    /// What stands above them.
    pub title: String,
    /// The two sides, and what differs (Markdown).
    pub page: String,
    /// Map B, whole.
    pub b: Vec<Sketched>,
    /// Map A, and what differs.
    pub over: Overlay,
}

/// A line, a point or a circle as it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Sketched {
    /// Both ends of a line; twice the place of a point, or of the centre of a circle.
    pub ends: [Vec2; 2],
    pub is_point: bool,
    /// Of a circle, metres; 0 of all else.
    pub radius: f64,
    /// What to call it.
    pub name: String,
}

impl Sketched {
    /// The line along which it is drawn, where it is no point.
    pub fn places(&self) -> Vec<Vec2> {
        if self.radius == 0.0 {
            return self.ends.to_vec();
        }
        let circle = Circle {
            center: self.ends[0],
            radius: self.radius,
            covariance: Matrix3::zeros(),
        };
        circle.outline().collect()
    }
}

impl Overlay {
    /// Whether a frame is shown.
    pub fn shows(&self, frame: u32) -> bool {
        let within = |[first, last]: &[u32; 2]| (*first..=*last).contains(&frame);
        let only = self.only.as_ref();
        only.is_none_or(|only| only.iter().any(within))
    }
}

/// A sweep, of which a heat map is drawn for every pair of keys, or curves over a single one.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnGrid {
    /// The log.
    pub file: String,
    /// Everything in it as text: another text is another recording.
    pub content: Vec<u8>,
    /// What follows from it: the lines above the table (Markdown).
    pub conclusion: String,
    /// What the cells are ranked by, in words.
    pub ranked_by: &'static str,
    /// The keys with several values.
    pub axes: Vec<DrawnAxis>,
    /// The numbers that are drawn.
    pub columns: Vec<DrawnColumn>,
    /// The best first, those that could not be replayed last.
    pub cells: Vec<DrawnCell>,
    /// How many of the first cells are the best ones; 0 where all are alike.
    pub best: usize,
}

/// A key that is swept.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnAxis {
    /// The last part of the key, which stands on tabs.
    pub short: String,
    /// The key with its unit, which stands along pictures.
    pub name: String,
    /// The key with its unit in little room, which stands above tables.
    pub heading: String,
    pub values: Vec<f64>,
    /// What is configured without the sweep.
    pub configured: Option<f64>,
}

/// A number that is drawn of every cell.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnColumn {
    pub heading: String,
    pub low_is_better: bool,
    /// Decimals that are written.
    pub decimals: usize,
    /// What it is multiplied with before: 100 for shares, 1000 for millimetres.
    pub scale: f64,
}

/// One configuration of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnCell {
    /// The place of its value on every axis.
    pub places: Vec<usize>,
    /// By column; `None` where it could not be replayed.
    pub numbers: Option<Vec<Option<f64>>>,
}

impl DrawnColumn {
    /// A number as it is written.
    pub fn text(&self, number: Option<f64>) -> String {
        let (decimals, scale) = (self.decimals, self.scale);
        number.map_or_else(
            || "-".to_owned(),
            |number| format!("{:.decimals$}", number * scale),
        )
    }
}
