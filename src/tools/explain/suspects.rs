//! The arcs of a replay whose labels are contradicted most.

use serde::Serialize;

use super::ExplainError;
use super::doubts::{Doubt, chi2_of_label, doubts};
use super::question::{since, sonars};
use super::watch::Watch;
use crate::core::replay::{Outcome, Replay};
use crate::core::rounding::{number, rounded};
use crate::core::tmam::report::ArcReport;

/// A suspect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suspect {
    /// The sonar's name.
    pub sensor: String,
    /// The frame.
    pub frame: u32,
    /// The stamp.
    pub stamp_ns: i64,
    /// Seconds after the log's first reading.
    #[serde(serialize_with = "number")]
    pub seconds: f64,
    /// `contact` or `intersection`.
    pub label: &'static str,
    /// The gate on chi2 with one degree of freedom from which on it would not be suspect; `None`
    /// where none would do, because the map says otherwise.
    pub doubt: Option<f64>,
    /// What contradicts it.
    pub doubts: Vec<Doubt>,
    /// What the map says: `line`, `point`, `ambiguous` or `neither`.
    pub map: Option<&'static str>,
    /// The command that explains it, as one types it after `tmam explain LOG`.
    pub explain: String,
}

/// The suspects of a replay, worst first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suspects {
    /// How many there are.
    pub suspects: u64,
    /// Labels that were given.
    pub labels: u64,
    /// The worst of them.
    pub worst: Vec<Suspect>,
}

/// Replays a log and lists the worst `most` suspects of the sonars with such names.
///
/// # Errors
/// When there is nothing to replay, or no such sonar.
pub fn list(
    replay: &Replay<'_>,
    globs: &[String],
    most: usize,
) -> Result<(Outcome, Suspects), ExplainError> {
    let mut watch = Watch::default();
    let outcome = replay.run(&mut [&mut watch])?;
    let setting = replay.setting();
    let sonars = sonars(globs, &watch, &setting)?;
    let of_sonars = watch.judgements.values();
    let labelled: Vec<&ArcReport> = of_sonars
        .filter(|judgement| sonars.iter().any(|(id, _)| *id == judgement.arc.id.sonar))
        .filter(|judgement| judgement.verdict.label.kind().is_some())
        .collect();
    let mut suspects: Vec<&ArcReport> = labelled
        .iter()
        .copied()
        .filter(|judgement| judgement.is_suspect())
        .collect();
    // Those that the map contradicts come first, and among them those that fit their label worst.
    let key = |j: &ArcReport| (j.doubt(), chi2_of_label(j).unwrap_or_default());
    suspects.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    let row = |judgement: &ArcReport| {
        let id = judgement.arc.id;
        let (_, sonar) = sonars.iter().find(|(sonar, _)| *sonar == id.sonar)?;
        let doubt = judgement.doubt();
        Some(Suspect {
            sensor: sonar.name.clone(),
            frame: id.frame,
            stamp_ns: judgement.arc.stamp_ns,
            seconds: since(judgement.arc.stamp_ns, replay.origin_ns()),
            label: judgement.verdict.label.name(),
            doubt: doubt.is_finite().then(|| rounded(doubt)),
            doubts: doubts(judgement),
            map: judgement.map.map(|map| map.support.name()),
            explain: command(&sonar.name, id.frame),
        })
    };
    let list = Suspects {
        suspects: suspects.len() as u64,
        labels: labelled.len() as u64,
        worst: suspects.into_iter().take(most).filter_map(row).collect(),
    };
    Ok((outcome, list))
}

/// The flags that name an arc, safe to type.
pub fn command(sensor: &str, frame: u32) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./:".contains(c);
    if !sensor.is_empty() && sensor.chars().all(plain) {
        format!("--sensor {sensor} --frame {frame}")
    } else {
        format!(
            "--sensor '{}' --frame {frame}",
            sensor.replace('\'', r"'\''")
        )
    }
}
