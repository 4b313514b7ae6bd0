//! A log's facts and findings for a person: metres, seconds and degrees, within 100 columns.

use std::fmt::Write as _;

use comfy_table::{ColumnConstraint, Width};

use super::findings::{Finding, Weight};
use super::statistics::seconds;
use super::tables::{LONGEST_NAME, channels, clocks, echoes, motion, render, sonars, table};
use super::{Info, Verdict};
use crate::core::legible::{legible, one_line, shortened};
use crate::core::wording::counted;

/// Longest part of a finding, characters.
const LONGEST_PART: usize = 2000;

/// Everything, as text.
pub fn text(info: &Info) -> String {
    let mut text = head(info);
    if !info.channels.is_empty() {
        section(&mut text, "CHANNELS", &channels(info));
    }
    if !info.sonars.is_empty() {
        section(&mut text, "SONARS", &sonars(&info.sonars));
        section(&mut text, "ECHOES", &echoes(&info.sonars));
    }
    if let Some(odometry) = &info.odometry {
        section(&mut text, "ODOMETRY", &motion(info, odometry));
    }
    if info
        .channels
        .iter()
        .any(|c| c.used && c.stamped + c.unstamped > 0)
    {
        section(&mut text, "CLOCKS", &clocks(info));
    }
    section(&mut text, "FINDINGS", &findings(&info.findings));
    if let Some(skeleton) = &info.skeleton {
        section(
            &mut text,
            "TMAM.TOML (print only this: --skeleton)",
            skeleton,
        );
    }
    legible(&text).into_owned()
}

/// Writing into a string cannot fail.
fn section(text: &mut String, title: &str, body: &str) {
    let _ = write!(text, "\n{title}\n{body}");
}

fn head(info: &Info) -> String {
    let mut text = format!(
        "{}: {:.1} s, {} used, {}{}\n",
        info.file,
        seconds(info.start_ns, info.end_ns),
        counted(info.messages, "message"),
        counted(info.sonars.len() as u64, "sonar"),
        if info.is_complete() {
            ""
        } else {
            ", INCOMPLETE"
        },
    );
    let verdict = match info.verdict {
        Verdict::Yes => "can be replayed",
        Verdict::InPart => {
            "can be replayed in part, without the sonars that findings name; with the configuration at the end whole"
        }
        Verdict::WithSkeleton => {
            "cannot be replayed as it is; with the configuration at the end it can"
        }
        Verdict::No => "cannot be replayed",
    };
    text.push_str(verdict);
    if let Some(outcome) = &info.trial.outcome {
        let [contact, intersection, unidentified] =
            ["contact", "intersection", "unidentified"].map(|label| outcome.labelled(label));
        let arcs = contact + intersection + unidentified;
        let frames = counted(outcome.frames.into(), "frame");
        let _ = write!(text, ": {frames}, {}", counted(arcs, "arc"));
        // Labels made with placeholders mean nothing.
        if info.verdict == Verdict::Yes {
            let _ = write!(text, ", {contact} contact, {intersection} intersection");
        }
    }
    text.push('\n');
    text
}

fn findings(findings: &[Finding]) -> String {
    if findings.is_empty() {
        return "  nothing to worry about\n".to_owned();
    }
    let mut table = table(&["", ""], 2);
    if let Some(column) = table.column_mut(0) {
        column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(11)));
    }
    for finding in findings {
        let weight = match finding.weight {
            Weight::Blocking => "BLOCKING",
            Weight::Serious => "serious",
            Weight::Notable => "notable",
        };
        let parts = [
            (finding.what.as_str(), ""),
            (finding.effect.as_str(), "effect: "),
            (finding.mend.as_str(), "to do: "),
        ];
        let lines: Vec<String> = parts
            .into_iter()
            .filter(|(part, _)| !part.is_empty())
            .map(|(part, name)| {
                let part = shortened(&one_line(part), LONGEST_NAME, LONGEST_PART);
                format!("{name}{part}")
            })
            .collect();
        table.add_row([weight.to_owned(), lines.join("\n")]);
    }
    render(&table).trim_start_matches('\n').to_owned()
}
