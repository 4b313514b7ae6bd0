//! Features as rows of a file: of a golden file, and of `features.json`.

use serde::{Deserialize, Serialize};

use super::results::{Feature, Geometry, Results, micro};
use crate::tmam::feature::Kind;

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

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindName {
    Line,
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

/// What of `features.json` is compared; the rest is passed over.
#[derive(Deserialize)]
pub struct FeaturesFile {
    features: Vec<Extracted>,
    map: MapLists,
    config: Option<serde_json::Value>,
    source: Option<SourceRow>,
}

#[derive(Deserialize)]
struct SourceRow {
    complete: bool,
    #[serde(default)]
    lost: Vec<String>,
}

#[derive(Deserialize)]
struct MapLists {
    lines: Vec<Extracted>,
    points: Vec<Extracted>,
}

#[derive(Deserialize)]
struct Extracted {
    id: u32,
    kind: Option<KindName>,
    sensor: Option<String>,
    first_frame: Option<u32>,
    last_frame: Option<u32>,
    readings: Readings,
    rho: Option<f64>,
    theta: Option<f64>,
    mid: Option<[f64; 2]>,
    half_length: Option<f64>,
    x: Option<f64>,
    y: Option<f64>,
    covariance: Option<[[f64; 2]; 2]>,
    map_id: Option<u32>,
    action: Option<String>,
    reason: Option<String>,
    status: Option<String>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Readings {
    Frames(Vec<u32>),
    Count(u32),
}

impl FeaturesFile {
    /// The configuration that it came from, as it is written there.
    pub fn config(&self) -> Option<serde_json::Value> {
        self.config.clone()
    }

    /// What could not be read of its log; empty for a whole one.
    pub fn losses(&self) -> Vec<String> {
        match &self.source {
            Some(source) if !source.complete && source.lost.is_empty() => {
                vec!["part of the log".to_owned()]
            }
            Some(source) => source.lost.clone(),
            None => Vec::new(),
        }
    }

    /// The results in it: no labels.
    pub fn into_results(self) -> Results {
        let file = self;
        let mut spans = std::collections::BTreeMap::<u32, [u32; 2]>::new();
        for row in &file.features {
            if let (Some(id), Some(first), Some(last)) =
                (row.map_id, row.first_frame, row.last_frame)
            {
                let span = spans.entry(id).or_insert([first, last]);
                *span = [span[0].min(first), span[1].max(last)];
            }
        }
        let lines = file
            .map
            .lines
            .into_iter()
            .map(|row| row.feature(Kind::Line));
        let points = file
            .map
            .points
            .into_iter()
            .map(|row| row.feature(Kind::Point));
        let mut map: Vec<Feature> = lines
            .chain(points)
            .map(|feature| Feature {
                frames: spans.get(&feature.id).copied(),
                ..feature
            })
            .collect();
        map.sort_by_key(|feature| feature.id);
        let extracted = file
            .features
            .into_iter()
            .map(|row| {
                let kind = row.kind.map_or(Kind::Line, Kind::from);
                row.feature(kind)
            })
            .collect();
        Results {
            map,
            extracted,
            labels: None,
        }
    }
}

impl Extracted {
    fn feature(self, kind: Kind) -> Feature {
        let line = (self.rho, self.theta, self.mid, self.half_length);
        let shaped = match (kind, line, self.x, self.y) {
            (Kind::Line, (Some(rho), Some(theta), Some(mid), Some(half_length)), ..) => {
                Feature::line(rho, theta, mid, half_length)
            }
            (Kind::Point, _, Some(x), Some(y)) => Feature::point(x, y),
            _ => Feature::new(kind, None),
        };
        let sigma = self.covariance.filter(|_| shaped.geometry.is_some());
        Feature {
            id: self.id,
            sigma: sigma.map(|[[a, _], [_, d]]| [a, d].map(|v| micro(v.max(0.0).sqrt()))),
            readings: match self.readings {
                Readings::Frames(frames) => u32::try_from(frames.len()).unwrap_or(u32::MAX),
                Readings::Count(count) => count,
            },
            frames: self.first_frame.zip(self.last_frame).map(|(a, b)| [a, b]),
            sensor: self.sensor,
            fate: self.reason.or(self.action).or(self.status),
            ..shaped
        }
    }
}
