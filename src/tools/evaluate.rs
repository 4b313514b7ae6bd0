//! How well a replay did, where the truth is known.
//!
//! [`Truth`] says what echoed at each arc and which walls and points could be seen at all; an
//! [`Evaluation`] holds what a replay came to against it.

pub mod drawing;
pub mod extracted;
pub mod labels;
pub mod map;
pub mod matching;
pub mod path;
pub mod scorer;
pub mod suspects;
pub mod text;
pub mod truth;

use std::io::{self, Write};

use serde::Serialize;

use crate::core::config::Config;
use crate::core::event::Sonar;
use crate::core::observer::{Setting, Source};
use crate::core::rounding::{number, optional};
use crate::tools::document;
use labels::ScoredArc;
use matching::{LINE_ANGLE, LINE_OFFSET, POINT_DISTANCE};
pub use scorer::Evaluation;
use truth::{AGREEING_SIGMAS, Origin, Target, VISIBLE};
pub use truth::{Truth, TruthError};

#[derive(Serialize)]
struct Content<'a> {
    source: &'a Source,
    config: &'a Config,
    truth: TruthFields,
    #[serde(flatten)]
    evaluation: &'a Evaluation,
    wrong_labels: Vec<WrongLabel<'a>>,
}

/// What was held true, and the gates of the matching.
#[derive(Serialize)]
struct TruthFields {
    origin: Origin,
    walls: usize,
    points: usize,
    visible_from: u64,
    agreeing_sigmas: f64,
    #[serde(serialize_with = "number")]
    agreeing_range: f64,
    #[serde(serialize_with = "number")]
    line_offset: f64,
    #[serde(serialize_with = "number")]
    line_angle: f64,
    #[serde(serialize_with = "number")]
    point_distance: f64,
}

#[derive(Serialize)]
struct WrongLabel<'a> {
    frame: u32,
    sensor: &'a str,
    label: &'static str,
    truth: &'static str,
    index: Option<usize>,
    one_target: bool,
    suspect: bool,
    #[serde(serialize_with = "optional")]
    doubt: Option<f64>,
}

/// Writes an evaluation in JSON: `tmam.evaluation/1`, described in `docs/formats.md`.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write(
    out: &mut dyn Write,
    setting: &Setting<'_>,
    truth: &Truth,
    evaluation: &Evaluation,
) -> io::Result<()> {
    let wrong = evaluation.arcs.iter();
    let mut wrong: Vec<&ScoredArc> = wrong.filter(|a| a.is_right() == Some(false)).collect();
    wrong.sort_by_key(|arc| arc.arc);
    let content = Content {
        source: setting.source,
        config: setting.config,
        truth: TruthFields {
            origin: truth.origin(),
            walls: truth.world().walls().len(),
            points: truth.world().points().len(),
            visible_from: VISIBLE,
            agreeing_sigmas: AGREEING_SIGMAS,
            agreeing_range: truth.agreeing_range(),
            line_offset: LINE_OFFSET,
            line_angle: LINE_ANGLE,
            point_distance: POINT_DISTANCE,
        },
        evaluation,
        wrong_labels: wrong
            .into_iter()
            .map(|arc| wrong_label(arc, setting.sonars))
            .collect(),
    };
    document::write(out, "tmam.evaluation/1", &content)
}

fn wrong_label<'a>(arc: &ScoredArc, sonars: &'a [Sonar]) -> WrongLabel<'a> {
    let sonar = sonars.get(arc.arc.sonar.index());
    WrongLabel {
        frame: arc.arc.frame,
        sensor: sonar.map_or("", |sonar| sonar.name.as_str()),
        label: arc.label.name(),
        truth: arc.target.name(),
        index: match arc.target {
            Target::Reflector(reflector) => Some(reflector.index()),
            Target::Other(_) => None,
        },
        one_target: arc.one_target,
        suspect: arc.suspect,
        doubt: arc.doubt.is_finite().then_some(arc.doubt),
    }
}
