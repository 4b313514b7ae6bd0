//! The results in a `features.json`.

use serde::Deserialize;

use super::collect::sigma_of_circle;
use super::collect::spans;
use super::results::{Feature, Geometry, Results, sigma_of};
use crate::core::tmam::label::Kind;

/// What of `features.json` is compared; the rest is passed over.
#[derive(Deserialize)]
pub struct FeaturesFile {
    features: Vec<FileRow>,
    map: MapLists,
    /// The configuration that it came from, as it is written there.
    pub config: Option<serde_json::Value>,
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
    lines: Vec<FileRow>,
    points: Vec<FileRow>,
    #[serde(default)]
    circles: Vec<FileRow>,
}

#[derive(Deserialize)]
struct FileRow {
    id: u32,
    sensor: Option<String>,
    first_frame: Option<u32>,
    last_frame: Option<u32>,
    readings: Readings,
    #[serde(flatten)]
    geometry: Geometry,
    covariance: Option<Covariance>,
    map_id: Option<u32>,
    action: Option<String>,
    reason: Option<String>,
    status: Option<String>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
enum Covariance {
    Two([[f64; 2]; 2]),
    Circle([[f64; 3]; 3]),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Readings {
    Frames(Vec<u32>),
    Count(u32),
}

impl FeaturesFile {
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
        let runs = self.features.iter();
        let spans = spans(runs.filter_map(|row| Some((row.map_id?, row.frames()?))));
        let rows = (self.map.lines.into_iter())
            .chain(self.map.points)
            .chain(self.map.circles);
        let mut map = rows
            .map(FileRow::into_feature)
            .collect::<Result<Vec<Feature>, String>>()?;
        for feature in &mut map {
            feature.frames = spans.get(&feature.id).copied();
        }
        map.sort_by_key(|feature| feature.id);
        let extracted = self.features.into_iter().map(FileRow::into_feature);
        Ok(Results {
            map,
            extracted: extracted.collect::<Result<_, String>>()?,
            ..Results::default()
        })
    }
}

impl FileRow {
    fn frames(&self) -> Option<[u32; 2]> {
        Some([self.first_frame?, self.last_frame?])
    }

    fn into_feature(self) -> Result<Feature, String> {
        let feature = Feature::new(self.geometry);
        // A run that no feature could be fitted to has no numbers at all.
        if feature.is_unfitted() && self.covariance.is_some() {
            let numbers = match feature.kind() {
                Kind::Line => "`rho`, `theta`, `mid` and `half_length`",
                Kind::Point => "`x` and `y`",
                Kind::Circle => "`x`, `y` and `radius`",
            };
            let (kind, id) = (feature.kind().name(), self.id);
            return Err(format!("{kind} {id} lacks one of {numbers}"));
        }
        Ok(Feature {
            id: self.id,
            sigma: self.covariance.and_then(|covariance| match covariance {
                Covariance::Two([[a, _], [_, d]]) => sigma_of([a, d]),
                Covariance::Circle(rows) => sigma_of_circle(rows),
            }),
            frames: self.frames(),
            readings: match self.readings {
                Readings::Frames(frames) => u32::try_from(frames.len()).unwrap_or(u32::MAX),
                Readings::Count(count) => count,
            },
            sensor: self.sensor,
            fate: self.reason.or(self.action).or(self.status),
            ..feature
        })
    }
}
