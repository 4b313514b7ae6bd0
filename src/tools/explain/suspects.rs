//! The arcs of a replay whose labels are contradicted most.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use comfy_table::CellAlignment;
use serde::Serialize;

use super::ExplainError;
use super::history::Doubt;
use super::question::{command, sonars};
use super::sequences::Sequences;
use crate::core::config::Rule;
use crate::core::observer::{Observer, Setting};
use crate::core::replay::{Outcome, Replay};
use crate::core::rounding::{number, rounded};
use crate::core::statistics::seconds;
use crate::core::tmam::hypothesis::Support;
use crate::core::tmam::label::{Kind, Label};
use crate::core::tmam::report::ArcReport;
use crate::core::wording::counted;
use crate::tools::tables::{TableColumn, optional, render, table};

/// A suspect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suspect {
    pub sensor: String,
    pub frame: u32,
    pub stamp_ns: i64,
    /// After the log's first reading.
    #[serde(serialize_with = "number")]
    pub seconds: f64,
    pub label: Label,
    /// The gate on chi2 with one degree of freedom from which on it would not be suspect; `None`
    /// where none would do, because the map says otherwise.
    pub doubt: Option<f64>,
    /// What contradicts it.
    pub doubts: Vec<Doubt>,
    /// What the map says.
    pub map: Option<Support>,
    /// The flags that name it, as one types them after `tmam explain LOG`.
    pub explain: String,
}

impl Suspect {
    /// The feature of the map that contradicts it.
    fn feature(&self) -> Option<u32> {
        self.doubts.iter().find_map(|doubt| doubt.feature)
    }
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
    watch: &mut dyn Observer,
) -> Result<(Outcome, Suspects), ExplainError> {
    let outcome = replay.run(&mut [watch])?;
    let sonars = sonars(globs, &Sequences::new(replay, &outcome), &replay.setting())?;
    let name = |report: &ArcReport| {
        let mut of = sonars.iter().filter(|(id, _)| *id == report.arc.id.sonar);
        Some(of.next()?.1.name.clone())
    };
    let labelled = (outcome.reports.iter())
        .filter(|report| report.label.kind().is_some() && name(report).is_some());
    let mut suspects: Vec<_> = labelled
        .clone()
        .filter(|report| report.is_suspect())
        .collect();
    suspects.sort_by(|a, b| a.worse_first(b));
    let row = |report: &ArcReport| {
        let (sensor, arc, doubt) = (name(report)?, &report.arc, report.doubt());
        Some(Suspect {
            explain: command(&sensor, arc.id.frame),
            sensor,
            frame: arc.id.frame,
            stamp_ns: arc.stamp_ns,
            seconds: seconds(replay.origin_ns(), arc.stamp_ns),
            label: report.label,
            doubt: doubt.is_finite().then(|| rounded(doubt)),
            doubts: Doubt::all(report),
            map: report.map.map(|map| map.support),
        })
    };
    let list = Suspects {
        suspects: suspects.len() as u64,
        labels: labelled.count() as u64,
        worst: suspects.into_iter().take(most).filter_map(row).collect(),
    };
    Ok((outcome, list))
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
    let columns: [TableColumn<'_, Suspect>; 7] = [
        ("sensor", &|suspect| suspect.sensor.clone()),
        ("frame", &|suspect| suspect.frame.to_string()),
        ("time s", &|suspect| format!("{:.3}", suspect.seconds)),
        ("label", &|suspect| suspect.label.name().to_owned()),
        ("contradicted by", &by),
        ("doubt", &|suspect| optional(suspect.doubt, 1)),
        ("the map says", &map),
    ];
    let mut rows = table(&columns.each_ref().map(|(head, _)| *head), 1);
    for column in [3, 4, 6] {
        if let Some(column) = rows.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Left);
        }
    }
    for suspect in &list.worst {
        rows.add_row(columns.each_ref().map(|(_, cell)| cell(suspect)));
    }
    let _ = write!(
        text,
        "\n{}\ndoubt: the opinion.gate from which on the label would not be suspect; - where no gate would\n\
         do, since the map says otherwise.{}\nThe whole story of one:\n  tmam explain {log} --sensor SONAR \
         --frame FRAME\n",
        render(&rows),
        match setting.config.rule {
            Rule::Paper => " The map is the noise-aware rule's, with its ids.",
            Rule::NoiseAware => "",
        }
    );
    text.push_str(&shared(list));
    text
}

/// What the suspects that are listed share, where several share one cause.
fn shared(list: &Suspects) -> String {
    let mut causes = BTreeMap::<(&str, Option<&str>), Vec<&Suspect>>::new();
    for suspect in &list.worst {
        let kind = suspect.map.and_then(Support::kind).map(Kind::name);
        let cause = (suspect.label.name(), kind);
        causes.entry(cause).or_default().push(suspect);
    }
    let mut causes: Vec<_> = causes.into_iter().filter(|(_, of)| of.len() > 1).collect();
    causes.sort_by_key(|(_, of)| std::cmp::Reverse(of.len()));
    if causes.is_empty() {
        return String::new();
    }
    let mut text = match (list.worst.len() as u64) < list.suspects {
        true => "\nby cause, of those above:\n".to_owned(),
        false => "\nby cause:\n".to_owned(),
    };
    for ((label, kind), of) in causes {
        let mut sonars = BTreeMap::<&str, u64>::new();
        for suspect in &of {
            *sonars.entry(&suspect.sensor).or_default() += 1;
        }
        let sonars = sonars
            .iter()
            .map(|(sonar, count)| format!("{sonar} {count}"));
        let sonars = sonars.collect::<Vec<_>>().join(", ");
        let ids: BTreeSet<u32> = of.iter().filter_map(|suspect| suspect.feature()).collect();
        let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
        let why = match (kind, ids.as_slice()) {
            (Some(kind), [id]) => format!("where the map has {kind} {id}"),
            (Some(kind), ids) => format!("where the map has {kind}s {}", ids.join(", ")),
            (None, _) => "that its readings do not fit".to_owned(),
        };
        let _ = writeln!(text, "  {:>4}  {label} {why}: {sonars}", of.len());
    }
    text
}

fn by(suspect: &Suspect) -> String {
    let said = suspect.doubts.iter().map(|doubt| {
        let says = doubt.says.name();
        match doubt.readings {
            Some(readings) if doubt.by != "triple" => format!("{} of {readings}: {says}", doubt.by),
            _ => format!("{}: {says}", doubt.by),
        }
    });
    said.collect::<Vec<_>>().join(", ")
}

fn map(suspect: &Suspect) -> String {
    let says = match suspect.map {
        Some(Support::Neither) => "unknown",
        Some(Support::Ambiguous) => "wall or its end",
        Some(Support::Line) => "line",
        Some(Support::Point) => "point",
        Some(Support::Circle) => "circle",
        None => "-",
    };
    match suspect.feature() {
        Some(id) => format!("{says} {id}"),
        None => says.to_owned(),
    }
}
