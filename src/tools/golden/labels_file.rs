//! Labels in files: a row per sonar in a golden file, and a file of their own that a recording carries.
//!
//! Labels are run-length coded (`12C 3I 40u`, `R` for circles). Stamps are the milliseconds from each arc to the next,
//! exact to the nanosecond, with repeats counted (`560x37 1120 560x3`). Both are kept apart, so that a
//! changed label changes the one text, and a lost reading the other, and arcs are always found again by
//! their stamp.

use std::collections::BTreeMap;
use std::{fmt, io};

use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::collect::labels;
use super::profile::LogInfo;
use super::results::{LabelledArc, Labels, Mark, RangeSigma};
use crate::core::observer::Setting;
use crate::core::replay::Outcome;
use crate::io::schema::in_words;
use crate::observe::features;
use crate::observe::viewer::Carried;
use crate::tools::document::render;

/// The format's name and version.
const SCHEMA: &str = "tmam.labels/1";

/// More arcs than this are refused: a few bytes of text must not fill the memory.
const MOST_ARCS: usize = 5_000_000;

const NS_PER_MS: i64 = 1_000_000;

/// The labels of a golden file: a row per sonar, and counts that must agree with the rows.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelTable {
    contact: u64,
    intersection: u64,
    unidentified: u64,
    /// In files of replays that have any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    circle: Option<u64>,
    #[serde(deserialize_with = "each_once")]
    sonars: BTreeMap<String, SonarRow>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SonarRow {
    /// Earlier files hold a mount and a mean range here; the log's parts have both.
    #[serde(default, rename = "measured", skip_serializing)]
    _measured: IgnoredAny,
    labels: String,
    first_ns: i64,
    steps_ms: String,
}

/// The labels of a replay, as a recording carries them.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelsFile {
    pub log: LogInfo,
    pub noise: RangeSigma,
    pub labels: Labels,
}

#[derive(Serialize, Deserialize)]
struct LabelsDocument {
    schema: String,
    log: LogInfo,
    #[serde(default, skip_serializing_if = "RangeSigma::is_unknown")]
    measured_sigma: RangeSigma,
    /// The stamps of the frames, coded as those of the arcs.
    frames: Option<FrameStamps>,
    labels: LabelTable,
}

#[derive(Serialize, Deserialize)]
struct FrameStamps {
    first_ns: i64,
    steps_ms: String,
}

impl LabelsFile {
    /// The file's text.
    ///
    /// # Errors
    /// When it cannot be JSON.
    pub fn render(&self) -> serde_json::Result<String> {
        let stamps = &self.labels.frame_stamps;
        let text = render(&LabelsDocument {
            schema: SCHEMA.to_owned(),
            log: self.log.clone(),
            measured_sigma: self.noise,
            frames: stamps.first().map(|first_ns| FrameStamps {
                first_ns: *first_ns,
                steps_ms: encode_steps(stamps),
            }),
            labels: LabelTable::from(&self.labels),
        })?;
        Ok(String::from_utf8_lossy(&text).into_owned())
    }

    /// Reads such a text.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn parse(text: &str) -> Result<Self, String> {
        let file: LabelsDocument = serde_json::from_str(text).map_err(|error| in_words(&error))?;
        if file.schema != SCHEMA {
            let found = file.schema;
            return Err(format!(
                "its labels have the schema `{found}`, and `{SCHEMA}` is what can be read"
            ));
        }
        let mut labels = file.labels.open()?;
        if let Some(frames) = file.frames {
            labels.frame_stamps = decode_steps(frames.first_ns, &frames.steps_ms)?;
        }
        Ok(Self {
            log: file.log,
            noise: file.measured_sigma,
            labels,
        })
    }
}

/// What a recording of the replay carries: the features file, to the byte as `--features` writes it,
/// and the label of every arc.
///
/// # Errors
/// When they cannot be formed.
pub fn carried(setting: &Setting<'_>, outcome: &Outcome) -> io::Result<Carried> {
    let mut features = Vec::new();
    features::write(&mut features, setting, outcome)?;
    let labels = LabelsFile {
        log: LogInfo::of(setting),
        noise: RangeSigma::of(outcome.variance_from, setting.config),
        labels: labels(setting.sonars, outcome),
    };
    Ok(Carried {
        features: String::from_utf8(features).map_err(io::Error::other)?,
        labels: Some(labels.render()?),
    })
}

impl From<&Labels> for LabelTable {
    fn from(labels: &Labels) -> Self {
        let [contact, intersection, unidentified, circle] = labels.counts();
        let rows = labels.sonars.iter().filter_map(|(sonar, arcs)| {
            let stamps: Vec<i64> = arcs.iter().map(|arc| arc.stamp_ns).collect();
            let row = SonarRow {
                _measured: IgnoredAny,
                labels: encode_marks(arcs.iter().map(|arc| arc.mark)),
                first_ns: *stamps.first()?,
                steps_ms: encode_steps(&stamps),
            };
            Some((sonar.clone(), row))
        });
        Self {
            contact,
            intersection,
            unidentified,
            circle: (circle > 0).then_some(circle),
            sonars: rows.collect(),
        }
    }
}

impl LabelTable {
    /// The labels behind it.
    ///
    /// # Errors
    /// Where it contradicts itself, in words.
    pub fn open(self) -> Result<Labels, String> {
        let mut labels = Labels::default();
        let mut left = MOST_ARCS;
        for (sonar, row) in self.sonars {
            let arcs = row
                .arcs(left)
                .map_err(|what| format!("labels of sonar `{sonar}`: {what}"))?;
            left -= arcs.len();
            labels.sonars.insert(sonar, arcs);
        }
        let said = [
            self.contact,
            self.intersection,
            self.unidentified,
            self.circle.unwrap_or_default(),
        ];
        for ((mark, said), found) in Mark::ALL.into_iter().zip(said).zip(labels.counts()) {
            if found != said {
                let mark = mark.name();
                return Err(format!(
                    "labels: {said} {mark} are counted, but the sonars have {found}"
                ));
            }
        }
        Ok(labels)
    }
}

impl SonarRow {
    fn arcs(&self, most: usize) -> Result<Vec<LabelledArc>, String> {
        let marks = decode_marks(&self.labels)?;
        if marks.len() > most {
            return Err(format!("with it, there are more than {MOST_ARCS} arcs"));
        }
        let stamps = decode_steps(self.first_ns, &self.steps_ms)?;
        if marks.len() != stamps.len() {
            let (labels, stamps) = (marks.len(), stamps.len());
            return Err(format!("there are {labels} labels and {stamps} stamps"));
        }
        let arc = |(mark, stamp_ns)| LabelledArc {
            stamp_ns,
            mark,
            frame: None,
            margin: None,
            reason: None,
        };
        Ok(marks.into_iter().zip(stamps).map(arc).collect())
    }
}

/// Rows by sonar. A row that is there twice, as after a merge, is refused: the last one would hide the
/// others.
fn each_once<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<BTreeMap<String, SonarRow>, D::Error> {
    struct EachOnce;
    impl<'de> Visitor<'de> for EachOnce {
        type Value = BTreeMap<String, SonarRow>;

        fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
            to.write_str("a row for each sonar")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut rows = BTreeMap::new();
            while let Some((sonar, row)) = map.next_entry::<String, SonarRow>()? {
                if rows.contains_key(&sonar) {
                    let twice = format!("sonar `{sonar}` is there twice");
                    return Err(serde::de::Error::custom(twice));
                }
                rows.insert(sonar, row);
            }
            Ok(rows)
        }
    }
    deserializer.deserialize_map(EachOnce)
}

fn letter(mark: Mark) -> char {
    match mark {
        Mark::Contact => 'C',
        Mark::Intersection => 'I',
        Mark::Unidentified => 'u',
        Mark::Circle => 'R',
    }
}

fn encode_marks(marks: impl IntoIterator<Item = Mark>) -> String {
    let words = runs(marks)
        .into_iter()
        .map(|(mark, count)| format!("{count}{}", letter(mark)));
    words.collect::<Vec<_>>().join(" ")
}

/// The steps between stamps, milliseconds.
fn encode_steps(stamps: &[i64]) -> String {
    let pairs = stamps.iter().zip(stamps.iter().skip(1));
    let steps = runs(pairs.map(|(a, b)| b.saturating_sub(*a)));
    let words = steps.into_iter().map(|(step, count)| match count {
        1 => milliseconds(step),
        _ => format!("{}x{count}", milliseconds(step)),
    });
    words.collect::<Vec<_>>().join(" ")
}

fn runs<T: PartialEq>(items: impl IntoIterator<Item = T>) -> Vec<(T, usize)> {
    let mut runs: Vec<(T, usize)> = Vec::new();
    for item in items {
        match runs.last_mut() {
            Some((last, count)) if *last == item => *count += 1,
            _ => runs.push((item, 1)),
        }
    }
    runs
}

fn milliseconds(ns: i64) -> String {
    let (whole, rest) = (ns / NS_PER_MS, ns % NS_PER_MS);
    if rest == 0 {
        return whole.to_string();
    }
    let digits = format!("{rest:06}");
    format!("{whole}.{}", digits.trim_end_matches('0'))
}

fn decode_marks(text: &str) -> Result<Vec<Mark>, String> {
    let run = |word: &str| {
        let (at, end) = word.char_indices().next_back()?;
        let mark = Mark::ALL.into_iter().find(|mark| letter(*mark) == end)?;
        let count: usize = word.get(..at)?.parse().ok()?;
        (count > 0).then_some((mark, count))
    };
    let mut marks = Vec::new();
    for word in text.split_whitespace() {
        let (mark, count) =
            run(word).ok_or_else(|| format!("`{word}` is no run of labels like 12C, 3I or 40u"))?;
        extend(&mut marks, mark, count)?;
    }
    Ok(marks)
}

/// The stamps behind a text, from the first on.
fn decode_steps(first_ns: i64, text: &str) -> Result<Vec<i64>, String> {
    let mut steps = Vec::new();
    for word in text.split_whitespace() {
        let (step, count) = word.split_once('x').unwrap_or((word, "1"));
        let run = nanoseconds(step).zip(count.parse().ok().filter(|count| *count > 0));
        let (step, count) =
            run.ok_or_else(|| format!("`{word}` is no step in milliseconds like 560 or 560x37"))?;
        extend(&mut steps, step, count)?;
    }
    let mut at = first_ns;
    let mut stamps = vec![first_ns];
    for step in steps {
        at = at
            .checked_add(step)
            .ok_or_else(|| "the steps lead beyond all time".to_owned())?;
        stamps.push(at);
    }
    Ok(stamps)
}

fn nanoseconds(text: &str) -> Option<i64> {
    let (whole, rest) = text.split_once('.').unwrap_or((text, "0"));
    if rest.len() > 6 || !(whole.bytes().chain(rest.bytes())).all(|b| b.is_ascii_digit()) {
        return None;
    }
    let whole: i64 = whole.parse().ok()?;
    let rest: i64 = format!("{rest:0<6}").parse().ok()?;
    whole.checked_mul(NS_PER_MS)?.checked_add(rest)
}

fn extend<T: Clone>(list: &mut Vec<T>, item: T, count: usize) -> Result<(), String> {
    if list.len().saturating_add(count) > MOST_ARCS {
        return Err(format!("more than {MOST_ARCS} arcs"));
    }
    list.extend(std::iter::repeat_n(item, count));
    Ok(())
}

#[cfg(test)]
mod tests;
