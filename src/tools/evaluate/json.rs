//! An evaluation for machines: `tmam.evaluation/1`, described in `docs/formats.md`.

mod map;

use std::io::{self, Write};

use serde::Serialize;

use self::map::{Map, index, map};
use super::Evaluation;
use super::extracted::ExtractedScore;
use super::labels::{ByTarget, Class, Judged, LabelScore, Wrong};
use super::matching::{LINE_ANGLE, LINE_OFFSET, POINT_DISTANCE};
use super::suspects::SuspectScore;
use super::truth::{AGREEING_SIGMAS, Origin, Target, Truth, VISIBLE};
use crate::core::config::Config;
use crate::core::event::Sonar;
use crate::core::observer::{Setting, Source};
use crate::core::rounding::{optional, rounded};
use crate::core::tool::Tool;

/// The format's name and version.
pub const SCHEMA: &str = "tmam.evaluation/1";

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    tool: Tool,
    source: &'a Source,
    config: &'a Config,
    truth: TruthFields,
    labels: Labels<'a>,
    suspects: &'a SuspectScore,
    extracted: Extracted<'a>,
    map: Map<'a>,
    confirmed: Map<'a>,
    wrong_labels: Vec<WrongLabel<'a>>,
}

/// What was held true, and the gates of the matching.
#[derive(Serialize)]
struct TruthFields {
    origin: &'static str,
    walls: usize,
    points: usize,
    visible_from: u64,
    agreeing_sigmas: f64,
    agreeing_range: f64,
    line_offset: f64,
    line_angle: f64,
    point_distance: f64,
}

#[derive(Serialize)]
struct Labels<'a> {
    arcs: u64,
    #[serde(serialize_with = "optional")]
    coverage: Option<f64>,
    #[serde(serialize_with = "optional")]
    wrong_share: Option<f64>,
    #[serde(serialize_with = "optional")]
    wrong_share_known: Option<f64>,
    wrong: Wrong,
    contact: WithScore,
    intersection: WithScore,
    unidentified: ByTarget,
    reasons: &'a std::collections::BTreeMap<&'static str, ByTarget>,
    other: &'a std::collections::BTreeMap<&'static str, u64>,
}

#[derive(Serialize)]
struct WithScore {
    #[serde(flatten)]
    arcs: ByTarget,
    #[serde(flatten)]
    score: Class,
}

#[derive(Serialize)]
struct Extracted<'a> {
    lines: &'a ExtractedScore,
    points: &'a ExtractedScore,
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

/// Writes the document, pretty and with a newline at its end.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write(
    out: &mut dyn Write,
    setting: &Setting<'_>,
    truth: &Truth,
    evaluation: &Evaluation,
) -> io::Result<()> {
    let world = truth.world();
    let document = Document {
        schema: SCHEMA,
        tool: Tool::THIS,
        source: setting.source,
        config: setting.config,
        truth: TruthFields {
            origin: match truth.origin() {
                Origin::Log => "log",
                Origin::EchoModel => "echo-model",
            },
            walls: world.walls().len(),
            points: world.points().len(),
            visible_from: VISIBLE,
            agreeing_sigmas: AGREEING_SIGMAS,
            agreeing_range: rounded(truth.agreeing_range()),
            line_offset: rounded(LINE_OFFSET),
            line_angle: rounded(LINE_ANGLE),
            point_distance: rounded(POINT_DISTANCE),
        },
        labels: labels(&evaluation.labels),
        suspects: &evaluation.suspects,
        extracted: Extracted {
            lines: &evaluation.extracted_lines,
            points: &evaluation.extracted_points,
        },
        map: map(&evaluation.map, truth),
        confirmed: map(&evaluation.confirmed, truth),
        wrong_labels: wrong_labels(&evaluation.arcs, setting.sonars),
    };
    serde_json::to_writer_pretty(&mut *out, &document)?;
    out.write_all(b"\n")
}

fn labels(score: &LabelScore) -> Labels<'_> {
    Labels {
        arcs: score.arcs,
        coverage: score.coverage,
        wrong_share: score.wrong_share,
        wrong_share_known: score.wrong_share_known,
        wrong: score.wrong,
        contact: WithScore {
            arcs: score.contact,
            score: score.contact_score,
        },
        intersection: WithScore {
            arcs: score.intersection,
            score: score.intersection_score,
        },
        unidentified: score.unidentified,
        reasons: &score.reasons,
        other: &score.other,
    }
}

fn wrong_labels<'a>(arcs: &[Judged], sonars: &'a [Sonar]) -> Vec<WrongLabel<'a>> {
    let mut wrong: Vec<&Judged> = arcs
        .iter()
        .filter(|arc| arc.is_right() == Some(false))
        .collect();
    wrong.sort_by_key(|arc| arc.arc);
    wrong
        .into_iter()
        .map(|arc| WrongLabel {
            frame: arc.arc.frame,
            sensor: sonars
                .get(arc.arc.sonar.index())
                .map_or("", |sonar| sonar.name.as_str()),
            label: arc.label.name(),
            truth: arc.target.name(),
            index: match arc.target {
                Target::Reflector(reflector) => Some(index(reflector)),
                Target::Other(_) => None,
            },
            one_target: arc.one_target,
            suspect: arc.suspect,
            doubt: arc.doubt.is_finite().then_some(arc.doubt),
        })
        .collect()
}
