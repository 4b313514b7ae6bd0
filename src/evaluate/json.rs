//! An evaluation for machines: `tmam.evaluation/1`, described in `docs/formats.md`.

use std::io::{self, Write};

use serde::Serialize;

use super::Evaluation;
use super::errors::Errors;
use super::extracted::ExtractedScore;
use super::labels::{ByTarget, Class, Judged, LabelScore, Wrong};
use super::map::{KindScore, MapScore, Match};
use super::matching::{self, LINE_ANGLE, LINE_OFFSET, POINT_DISTANCE};
use super::suspects::SuspectScore;
use super::truth::{AGREEING_SIGMAS, Origin, Target, Truth, VISIBLE};
use crate::config::Config;
use crate::event::Sonar;
use crate::observer::{Setting, Source};
use crate::rounding::{optional, rounded};
use crate::tool::Tool;
use crate::world::Reflector;

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
struct Map<'a> {
    exact: bool,
    lines: Features<'a>,
    points: Features<'a>,
}

#[derive(Serialize)]
struct Features<'a> {
    features: u64,
    visible: u64,
    matched: u64,
    unasked: u64,
    missed: Vec<Missed>,
    spurious: &'a [u32],
    duplicates: Vec<Named>,
    shared: Vec<Named>,
    parts: &'a [u32],
    errors: &'a Errors,
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional")]
    covered: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional")]
    overrun: Option<f64>,
    matches: Vec<Pair>,
}

#[derive(Serialize)]
struct Missed {
    index: usize,
    echoes: u64,
}

/// A feature and the wall or point that it shows.
#[derive(Serialize)]
struct Named {
    id: u32,
    index: usize,
}

#[derive(Serialize)]
struct Pair {
    id: u32,
    index: usize,
    #[serde(flatten)]
    error: ErrorFields,
    #[serde(serialize_with = "optional")]
    nees: Option<f64>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum ErrorFields {
    Line { rho: f64, theta: f64 },
    Point { distance: f64 },
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

fn map<'a>(score: &'a MapScore, truth: &Truth) -> Map<'a> {
    Map {
        exact: score.is_exact(),
        lines: features(&score.lines, truth),
        points: features(&score.points, truth),
    }
}

fn features<'a>(score: &'a KindScore, truth: &Truth) -> Features<'a> {
    Features {
        features: score.features,
        visible: score.visible,
        matched: score.matched(),
        unasked: score.unasked,
        missed: score
            .missed
            .iter()
            .map(|reflector| Missed {
                index: index(*reflector),
                echoes: truth.echoes(*reflector),
            })
            .collect(),
        spurious: &score.spurious,
        duplicates: named(&score.duplicates),
        shared: named(&score.shared),
        parts: &score.parts,
        errors: &score.errors,
        covered: score.covered,
        overrun: score.overrun,
        matches: score.matches.iter().map(pair).collect(),
    }
}

fn named(pairs: &[(u32, Reflector)]) -> Vec<Named> {
    let pairs = pairs.iter();
    pairs
        .map(|(id, reflector)| Named {
            id: *id,
            index: index(*reflector),
        })
        .collect()
}

fn pair(found: &Match) -> Pair {
    Pair {
        id: found.feature,
        index: index(found.reflector),
        error: match found.comparison.error {
            matching::Error::Line { rho, theta, .. } => ErrorFields::Line {
                rho: rounded(rho),
                theta: rounded(theta),
            },
            matching::Error::Point { distance } => ErrorFields::Point {
                distance: rounded(distance),
            },
        },
        nees: found.comparison.nees,
    }
}

fn index(reflector: Reflector) -> usize {
    match reflector {
        Reflector::Line(index) | Reflector::Point(index) => index,
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
