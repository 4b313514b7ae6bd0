//! A list of suspects, for a person.

use std::fmt::Write as _;

use crate::core::observer::Setting;
use crate::core::wording::counted;
use crate::tools::explain::doubts::Doubt;
use crate::tools::explain::suspects::{Suspect, Suspects};
use crate::tools::tables::{render, table};

/// The worst suspects of a replay. `log` is how the log was named on the command line.
pub fn suspects(setting: &Setting<'_>, log: &str, list: &Suspects) -> String {
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
            column.set_cell_alignment(comfy_table::CellAlignment::Left);
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
