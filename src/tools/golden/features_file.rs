//! The results in a `features.json`.

use serde::Deserialize;

use super::range_noise::RangeNoise;
use super::results::{Feature, Results, micro};
use super::rows::KindName;
use crate::core::tmam::feature::Kind;

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
    ///
    /// # Errors
    /// A feature without its numbers.
    pub fn into_results(self) -> Result<Results, String> {
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
        let lines = file.map.lines.into_iter().map(|row| row.placed(Kind::Line));
        let points = file
            .map
            .points
            .into_iter()
            .map(|row| row.placed(Kind::Point));
        let mut map: Vec<Feature> = lines
            .chain(points)
            .map(|feature| {
                let feature = feature?;
                Ok(Feature {
                    frames: spans.get(&feature.id).copied(),
                    ..feature
                })
            })
            .collect::<Result<_, String>>()?;
        map.sort_by_key(|feature| feature.id);
        let extracted = file
            .features
            .into_iter()
            .map(|row| {
                let kind = row.kind.map_or(Kind::Line, Kind::from);
                // Of a run that no feature could be fitted to there are no numbers at all.
                if row.has_numbers() {
                    row.placed(kind)
                } else {
                    Ok(row.feature(kind))
                }
            })
            .collect::<Result<_, String>>()?;
        Ok(Results {
            map,
            extracted,
            labels: None,
            noise: RangeNoise::Unknown,
        })
    }
}

impl Extracted {
    fn has_numbers(&self) -> bool {
        let numbers = [self.rho, self.theta, self.half_length, self.x, self.y];
        self.mid.is_some() || numbers.iter().any(Option::is_some)
    }

    /// A feature that is somewhere.
    fn placed(self, kind: Kind) -> Result<Feature, String> {
        let feature = self.feature(kind);
        if feature.geometry.is_some() {
            return Ok(feature);
        }
        let numbers = match kind {
            Kind::Line => "`rho`, `theta`, `mid` and `half_length`",
            Kind::Point => "`x` and `y`",
        };
        let (name, id) = (kind.name(), feature.id);
        Err(format!("{name} {id} lacks one of {numbers}"))
    }

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
