//! The labels of a replay as a file of their own, which a recording carries.

use serde::{Deserialize, Serialize};

use super::coding::{decode_steps, encode_steps};
use super::file::LogInfo;
use super::label_table::LabelTable;
use super::layout::render;
use super::range_noise::RangeNoise;
use super::results::Labels;
use crate::io::schema::in_words;

/// The format's name and version.
const SCHEMA: &str = "tmam.labels/1";

/// What such a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelsFile {
    /// The log that the labels are of.
    pub log: LogInfo,
    /// The noise of its ranges.
    pub noise: RangeNoise,
    /// The label of every arc.
    pub labels: Labels,
}

#[derive(Serialize, Deserialize)]
struct File {
    schema: String,
    log: LogInfo,
    #[serde(default, skip_serializing_if = "RangeNoise::is_unknown")]
    measured_sigma: RangeNoise,
    /// The stamps of the frames, coded as those of the arcs.
    frames: Option<Frames>,
    labels: LabelTable,
}

#[derive(Serialize, Deserialize)]
struct Frames {
    first_ns: i64,
    steps_ms: String,
}

/// The labels as text, with the log that they are of and the noise of its ranges.
///
/// # Errors
/// When they cannot be JSON.
pub fn write_labels(
    log: &LogInfo,
    noise: RangeNoise,
    labels: &Labels,
) -> Result<String, serde_json::Error> {
    let first = labels.frame_stamps.first();
    let text = render(&File {
        schema: SCHEMA.to_owned(),
        log: log.clone(),
        measured_sigma: noise,
        frames: first.map(|first_ns| Frames {
            first_ns: *first_ns,
            steps_ms: encode_steps(&labels.frame_stamps),
        }),
        labels: labels.into(),
    })?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

/// What is behind such a text.
///
/// # Errors
/// What is wrong with it.
pub fn read_labels(text: &str) -> Result<LabelsFile, String> {
    let file: File = serde_json::from_str(text).map_err(|error| in_words(&error))?;
    if file.schema != SCHEMA {
        return Err(format!(
            "its labels have the schema `{}`, and `{SCHEMA}` is what can be read",
            file.schema
        ));
    }
    let mut labels = file.labels.open().map_err(|wrong| wrong.0)?;
    if let Some(frames) = file.frames {
        labels.frame_stamps = decode_steps(frames.first_ns, &frames.steps_ms)?;
    }
    Ok(LabelsFile {
        log: file.log,
        noise: file.measured_sigma,
        labels,
    })
}

#[cfg(test)]
mod tests {
    use super::super::results::{LabelledArc, Mark};
    use super::*;

    #[test]
    fn labels_come_back_with_the_frames_that_they_are_in() {
        let arc = |stamp_ns| LabelledArc {
            stamp_ns,
            mark: Mark::Contact,
            frame: None,
            margin: None,
            reason: None,
        };
        let labels = Labels {
            sonars: [("left".to_owned(), vec![arc(5), arc(25)])].into(),
            frame_stamps: vec![5, 20, 40],
            ..Labels::default()
        };
        let log = LogInfo {
            file: "a.mcap".to_owned(),
            events_sha256: "0".to_owned(),
        };
        for noise in [
            RangeNoise::Unknown,
            RangeNoise::Given,
            RangeNoise::Measured(0.0035),
        ] {
            let text = write_labels(&log, noise, &labels).unwrap();
            let expected = LabelsFile {
                log: log.clone(),
                noise,
                labels: labels.clone(),
            };
            assert_eq!(read_labels(&text).unwrap(), expected);
        }
        let text = write_labels(&log, RangeNoise::Given, &labels).unwrap();
        assert_eq!(labels.frame_at(25), Some(1));
        let newer = text.replace("tmam.labels/1", "tmam.labels/2");
        assert!(read_labels(&newer).unwrap_err().contains("tmam.labels/2"));
        assert!(
            read_labels(&text[..text.len() / 2])
                .unwrap_err()
                .contains("cut off")
        );
    }
}
