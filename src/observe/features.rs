//! `features.json`: what was extracted, and the map it made.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Serialize;

use crate::core::config::Config;
use crate::core::event::name_of;
use crate::core::observer::{Setting, Source};
use crate::core::replay::{CauseTold, Outcome};
use crate::core::rounding::{covariance, covariance_of_circle, rounded};
use crate::core::tmam::feature::{Kind, MapFeature, Rejection, Shape};
use crate::core::tmam::step::Extraction;
use crate::core::tool::Tool;

/// The format's name and version.
pub const SCHEMA: &str = "tmam.features/1";

#[derive(Debug, Serialize)]
struct FeaturesDocument<'a> {
    schema: &'static str,
    tool: Tool,
    source: &'a Source,
    config: &'a Config,
    counts: Counts<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    poses: Option<Poses>,
    #[serde(skip_serializing_if = "Option::is_none")]
    causes: Option<&'a [CauseTold]>,
    features: Vec<FeatureRow<'a>>,
    map: MapRows,
}

/// What became of the readings of a replay.
#[derive(Debug, Serialize)]
pub struct Counts<'a> {
    frames: u32,
    readings: u64,
    echoes: u64,
    no_echoes: u64,
    contact: u64,
    intersection: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    circle: Option<u64>,
    unidentified: u64,
    reasons: &'a BTreeMap<&'static str, u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    suspects: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    associated_readings: Option<u64>,
    surplus: u64,
    dropped: &'a BTreeMap<&'static str, u64>,
}

impl<'a> Counts<'a> {
    /// But for those of suspects and associated readings.
    pub fn new(outcome: &'a Outcome) -> Self {
        let tally = &outcome.tally;
        Self {
            frames: outcome.frames,
            readings: tally.readings,
            echoes: tally.echoes,
            no_echoes: tally.no_echoes,
            contact: outcome.labelled("contact"),
            intersection: outcome.labelled("intersection"),
            circle: outcome.labels.get("circle").copied(),
            unidentified: outcome.labelled("unidentified"),
            reasons: &outcome.reasons,
            suspects: None,
            associated_readings: None,
            surplus: tally.surplus,
            dropped: &tally.dropped,
        }
    }
}

/// Where the poses come from: odometry, or odometry and ranges together.
#[derive(Debug, Serialize)]
#[serde(tag = "from", rename_all = "kebab-case")]
enum Poses {
    Odometry {
        reason: String,
    },
    Joint {
        /// Of the path, metres.
        length: f64,
        /// How far the last pose was moved, metres, and its standard deviations over (x, y, yaw).
        end_correction: f64,
        end_sigma: [f64; 3],
        /// By how much odometry is too short, as shares.
        scale_distance: f64,
        scale_rotation: f64,
        odometry_noise: Drift,
        /// Share of the arcs that the map explains.
        explained_before: f64,
        explained: f64,
        closures: Vec<Closure>,
    },
}

/// Standard deviations after a metre, metres and radians, and after turning by a radian.
#[derive(Debug, Serialize)]
struct Drift {
    distance: f64,
    heading: f64,
    turn: f64,
}

/// What was taken for two features until the poses were corrected.
#[derive(Debug, Serialize)]
struct Closure {
    kind: &'static str,
    x: f64,
    y: f64,
    frames: [u32; 2],
}

impl Poses {
    fn of(outcome: &Outcome) -> Option<Self> {
        let joint = match outcome.poses.as_ref()? {
            Ok(joint) => joint,
            Err(kept) => {
                return Some(Self::Odometry {
                    reason: kept.to_string(),
                });
            }
        };
        let end = joint.path.covariances.last().copied().unwrap_or_default();
        let closures = joint.closures.iter().map(|closure| Closure {
            kind: closure.kind.name(),
            x: rounded(closure.place.x),
            y: rounded(closure.place.y),
            frames: closure.frames,
        });
        Some(Self::Joint {
            length: rounded(outcome.distance),
            end_correction: rounded(joint.path.end_correction()),
            end_sigma: [end.m11, end.m22, end.m33]
                .map(|variance| rounded(variance.max(0.0).sqrt())),
            scale_distance: rounded(joint.scales[0]),
            scale_rotation: rounded(joint.scales[1]),
            odometry_noise: Drift {
                distance: rounded(joint.path.drift.distance),
                heading: rounded(joint.path.drift.heading),
                turn: rounded(joint.path.drift.turn),
            },
            explained_before: rounded(joint.explained[0].share),
            explained: rounded(joint.explained[1].share),
            closures: closures.collect(),
        })
    }
}

#[derive(Debug, Serialize)]
struct FeatureRow<'a> {
    id: u32,
    kind: &'static str,
    sensor: &'a str,
    first_frame: u32,
    last_frame: u32,
    readings: Vec<u32>,
    #[serde(flatten)]
    shape: Option<ShapeFields>,
    residual_rms: f64,
    iterations: u32,
    converged: bool,
    outliers: Vec<u32>,
    opinion: Option<&'static str>,
    chi2_line: Option<f64>,
    chi2_point: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    chi2_circle: Option<f64>,
    map_id: Option<u32>,
    action: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
}

#[derive(Debug, Serialize)]
struct MapRows {
    lines: Vec<MapRow>,
    points: Vec<MapRow>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    circles: Vec<MapRow>,
}

#[derive(Debug, Serialize)]
struct MapRow {
    id: u32,
    #[serde(flatten)]
    shape: ShapeFields,
    readings: u32,
    runs: u32,
    status: &'static str,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum ShapeFields {
    Line {
        rho: f64,
        theta: f64,
        /// Null where the method knows none.
        covariance: Option<[[f64; 2]; 2]>,
        mid: [f64; 2],
        half_length: f64,
    },
    Point {
        x: f64,
        y: f64,
        covariance: Option<[[f64; 2]; 2]>,
        rho: f64,
        alpha: f64,
        /// Over (rho, alpha); null where polar coordinates are singular, too.
        polar_covariance: Option<[[f64; 2]; 2]>,
    },
    Circle {
        x: f64,
        y: f64,
        radius: f64,
        /// Over (x, y, radius).
        covariance: [[f64; 3]; 3],
    },
}

impl From<&Shape> for ShapeFields {
    fn from(shape: &Shape) -> Self {
        match shape {
            Shape::Line(line) => Self::Line {
                rho: rounded(line.rho),
                theta: rounded(line.theta),
                covariance: shape.covariance().as_ref().map(covariance),
                mid: [rounded(line.mid.x), rounded(line.mid.y)],
                half_length: rounded(line.half_length),
            },
            Shape::Point(point) => {
                let (rho, alpha) = point.polar();
                Self::Point {
                    x: rounded(point.position.x),
                    y: rounded(point.position.y),
                    covariance: shape.covariance().as_ref().map(covariance),
                    rho: rounded(rho),
                    alpha: rounded(alpha),
                    polar_covariance: point.polar_covariance().as_ref().map(covariance),
                }
            }
            Shape::Circle(circle) => Self::Circle {
                x: rounded(circle.center.x),
                y: rounded(circle.center.y),
                radius: rounded(circle.radius),
                covariance: covariance_of_circle(&circle.covariance),
            },
        }
    }
}

/// Writes the file: pretty, with one newline at its end.
///
/// # Errors
/// When `out` cannot be written.
pub fn write(mut out: impl Write, setting: &Setting<'_>, outcome: &Outcome) -> io::Result<()> {
    let map_of = |kind: Kind| {
        let features = outcome.map.iter();
        let features = features.filter(|feature| feature.shape.kind() == kind);
        features.map(MapRow::from).collect()
    };
    let extractions = outcome.extractions.iter();
    let file = FeaturesDocument {
        schema: SCHEMA,
        tool: Tool::THIS,
        source: setting.source,
        config: setting.config,
        counts: Counts {
            suspects: outcome.suspects,
            associated_readings: Some(outcome.associated_readings),
            ..Counts::new(outcome)
        },
        poses: Poses::of(outcome),
        causes: outcome.causes.as_deref(),
        features: extractions.map(|one| feature(one, setting)).collect(),
        map: MapRows {
            lines: map_of(Kind::Line),
            points: map_of(Kind::Point),
            circles: map_of(Kind::Circle),
        },
    };
    serde_json::to_writer_pretty(&mut out, &file)?;
    out.write_all(b"\n")
}

impl From<&MapFeature> for MapRow {
    fn from(feature: &MapFeature) -> Self {
        Self {
            id: feature.id,
            shape: ShapeFields::from(&feature.shape),
            readings: feature.readings,
            runs: feature.runs,
            status: feature.status.name(),
        }
    }
}

fn feature<'a>(extraction: &Extraction, setting: &Setting<'a>) -> FeatureRow<'a> {
    let frames: Vec<u32> = extraction.associated.iter().map(|arc| arc.frame).collect();
    let (first, action) = (extraction.associated.first(), extraction.action);
    let opinion = extraction.opinion;
    FeatureRow {
        id: extraction.id,
        kind: extraction.kind.name(),
        sensor: first.map_or("", |arc| name_of(setting.sonars, arc.sonar)),
        first_frame: frames.first().copied().unwrap_or_default(),
        last_frame: frames.last().copied().unwrap_or_default(),
        readings: frames,
        shape: extraction.shape.as_ref().map(ShapeFields::from),
        residual_rms: rounded(extraction.residual_rms),
        iterations: extraction.iterations,
        converged: extraction.converged,
        outliers: extraction.outliers.iter().map(|arc| arc.frame).collect(),
        opinion: opinion.map(|test| test.support.name()),
        chi2_line: opinion.map(|test| rounded(test.chi2_line)),
        chi2_point: opinion.map(|test| rounded(test.chi2_point)),
        chi2_circle: opinion.and_then(|test| test.chi2_circle.map(rounded)),
        map_id: action.map_id(),
        action: action.name(),
        reason: action.rejection().map(Rejection::name),
    }
}
