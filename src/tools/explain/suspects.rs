//! The arcs of a replay whose labels are contradicted most.

use std::fmt::Write as _;

use comfy_table::CellAlignment;
use serde::Serialize;

use super::ExplainError;
use super::history::{Doubt, chi2_of_label, doubts};
use super::question::{since, sonars};
use super::sequences::Sequences;
use crate::core::observer::Setting;
use crate::core::replay::{Outcome, Replay};
use crate::core::rounding::{number, rounded};
use crate::core::tmam::report::ArcReport;
use crate::core::wording::counted;
use crate::tools::tables::{render, table};

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
    let outcome = replay.run(&mut [])?;
    let setting = replay.setting();
    let sonars = sonars(globs, &Sequences::new(replay, &outcome), &setting)?;
    let of_sonars = outcome.reports.iter();
    let labelled: Vec<&ArcReport> = of_sonars
        .filter(|report| sonars.iter().any(|(id, _)| *id == report.arc.id.sonar))
        .filter(|report| report.label.kind().is_some())
        .collect();
    let mut suspects: Vec<&ArcReport> = labelled
        .iter()
        .copied()
        .filter(|report| report.is_suspect())
        .collect();
    // Those that the map contradicts come first, and among them those that fit their label worst.
    let key = |j: &ArcReport| (j.doubt(), chi2_of_label(j).unwrap_or_default());
    suspects.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    let row = |report: &ArcReport| {
        let id = report.arc.id;
        let (_, sonar) = sonars.iter().find(|(sonar, _)| *sonar == id.sonar)?;
        let doubt = report.doubt();
        Some(Suspect {
            sensor: sonar.name.clone(),
            frame: id.frame,
            stamp_ns: report.arc.stamp_ns,
            seconds: since(report.arc.stamp_ns, replay.origin_ns()),
            label: report.label.name(),
            doubt: doubt.is_finite().then(|| rounded(doubt)),
            doubts: doubts(report),
            map: report.map.map(|map| map.support.name()),
            explain: command(&sonar.name, id.frame),
        })
    };
    let list = Suspects {
        suspects: suspects.len() as u64,
        labels: labelled.len() as u64,
        worst: suspects.into_iter().take(most).filter_map(row).collect(),
    };
    drop(labelled);
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

/// The worst suspects of a replay. `log` is how the log was named on the command line.
pub fn text(setting: &Setting<'_>, log: &str, list: &Suspects) -> String {
    let shown = list.worst.len();
    let mut text = format!(
        "{}: {} of {} are suspect{}\n",
        setting.source.file,
        list.suspects,
        counted(list.labels, "label"),
        if (shown as u64) < list.suspects {
            format!("; the worst {shown}")
        } else {
            String::new()
        }
    );
    if shown == 0 {
        return text;
    }
    let mut rows = table(
        &[
            "sensor",
            "frame",
            "time s",
            "label",
            "contradicted by",
            "doubt",
            "the map says",
        ],
        1,
    );
    for column in [3, 4, 6] {
        if let Some(column) = rows.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Left);
        }
    }
    for suspect in &list.worst {
        rows.add_row([
            suspect.sensor.clone(),
            suspect.frame.to_string(),
            format!("{:.3}", suspect.seconds),
            suspect.label.to_owned(),
            by(suspect),
            suspect
                .doubt
                .map_or_else(|| "-".to_owned(), |doubt| format!("{doubt:.1}")),
            map(suspect),
        ]);
    }
    let _ = write!(text, "\n{}", render(&rows));
    text.push_str(
        "\ndoubt: the opinion.gate from which on the label would not be suspect; - where no gate would\n\
         do, since the map says otherwise. The whole story of each:\n",
    );
    for suspect in &list.worst {
        let _ = writeln!(text, "  tmam explain {log} {}", suspect.explain);
    }
    text
}

fn by(suspect: &Suspect) -> String {
    let said = |doubt: &Doubt| match doubt.readings {
        Some(readings) if doubt.by != "triple" => {
            format!("{} of {readings}: {}", doubt.by, doubt.says)
        }
        _ => format!("{}: {}", doubt.by, doubt.says),
    };
    let said: Vec<String> = suspect.doubts.iter().map(said).collect();
    said.join(", ")
}

fn map(suspect: &Suspect) -> String {
    match suspect.map {
        Some("neither") => "unknown",
        Some("ambiguous") => "wall or its end",
        Some(kind) => kind,
        None => "-",
    }
    .to_owned()
}
