//! Features as rows of a golden file.

use serde::{Deserialize, Serialize};

use super::results::{Feature, Geometry};
use crate::core::tmam::feature::Kind;

/// The features of a golden file, by kind.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rows {
    lines: Vec<LineRow>,
    points: Vec<PointRow>,
    /// Runs that no feature could be fitted to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    unfitted: Vec<UnfittedRow>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LineRow {
    id: u32,
    rho: f64,
    theta: f64,
    mid: [f64; 2],
    half_length: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sigma: Option<[f64; 2]>,
    readings: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    frames: Option<[u32; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensor: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fate: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PointRow {
    id: u32,
    x: f64,
    y: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sigma: Option<[f64; 2]>,
    readings: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    frames: Option<[u32; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensor: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fate: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UnfittedRow {
    id: u32,
    kind: KindName,
    readings: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    frames: Option<[u32; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensor: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fate: Option<String>,
}

/// The kind of a feature, in files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum KindName {
    /// A line.
    Line,
    /// A point.
    Point,
}

impl From<KindName> for Kind {
    fn from(name: KindName) -> Self {
        match name {
            KindName::Line => Self::Line,
            KindName::Point => Self::Point,
        }
    }
}

impl From<Kind> for KindName {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Line => Self::Line,
            Kind::Point => Self::Point,
        }
    }
}

impl From<&[Feature]> for Rows {
    fn from(features: &[Feature]) -> Self {
        let mut rows = Self::default();
        for feature in features {
            let Feature {
                id,
                sigma,
                readings,
                frames,
                ..
            } = *feature;
            let (sensor, fate) = (feature.sensor.clone(), feature.fate.clone());
            match feature.geometry {
                Some(Geometry::Line {
                    rho,
                    theta,
                    mid,
                    half_length,
                }) => rows.lines.push(LineRow {
                    id,
                    rho,
                    theta,
                    mid,
                    half_length,
                    sigma,
                    readings,
                    frames,
                    sensor,
                    fate,
                }),
                Some(Geometry::Point { x, y }) => rows.points.push(PointRow {
                    id,
                    x,
                    y,
                    sigma,
                    readings,
                    frames,
                    sensor,
                    fate,
                }),
                None => rows.unfitted.push(UnfittedRow {
                    id,
                    kind: feature.kind.into(),
                    readings,
                    frames,
                    sensor,
                    fate,
                }),
            }
        }
        rows.lines.sort_by_key(|row| row.id);
        rows.points.sort_by_key(|row| row.id);
        rows.unfitted.sort_by_key(|row| row.id);
        rows
    }
}

impl From<Rows> for Vec<Feature> {
    fn from(rows: Rows) -> Self {
        let lines = rows.lines.into_iter().map(|row| Feature {
            id: row.id,
            sigma: row.sigma,
            readings: row.readings,
            frames: row.frames,
            sensor: row.sensor,
            fate: row.fate,
            ..Feature::line(row.rho, row.theta, row.mid, row.half_length)
        });
        let points = rows.points.into_iter().map(|row| Feature {
            id: row.id,
            sigma: row.sigma,
            readings: row.readings,
            frames: row.frames,
            sensor: row.sensor,
            fate: row.fate,
            ..Feature::point(row.x, row.y)
        });
        let unfitted = rows.unfitted.into_iter().map(|row| Feature {
            id: row.id,
            readings: row.readings,
            frames: row.frames,
            sensor: row.sensor,
            fate: row.fate,
            ..Feature::new(row.kind.into(), None)
        });
        let mut features: Vec<Feature> = lines.chain(points).chain(unfitted).collect();
        features.sort_by_key(|feature| feature.id);
        features
    }
}
