//! A log's facts and findings for machines: `tmam.info/1`, described in `docs/formats.md`.

use crate::core::tool::Tool;
use std::io::{self, Write};

use serde::Serialize;

use super::channels::ChannelFacts;
use super::findings::Finding;
use super::motion::OdometryFacts;
use super::sonars::SonarFacts;
use super::{Info, Verdict};

/// The format's name and version.
pub const SCHEMA: &str = "tmam.info/1";

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    tool: Tool,
    source: Source<'a>,
    replay: Replay<'a>,
    channels: &'a [ChannelFacts],
    sonars: &'a [SonarFacts],
    odometry: Option<&'a OdometryFacts>,
    findings: &'a [Finding],
    skeleton: Option<&'a str>,
}

#[derive(Serialize)]
struct Source<'a> {
    file: &'a str,
    messages: u64,
    start_ns: i64,
    end_ns: i64,
    complete: bool,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    lost: &'a [String],
}

#[derive(Serialize)]
struct Replay<'a> {
    possible: &'static str,
    counts: Option<Counts<'a>>,
}

#[derive(Serialize)]
struct Counts<'a> {
    frames: u32,
    readings: u64,
    echoes: u64,
    no_echoes: u64,
    contact: u64,
    intersection: u64,
    unidentified: u64,
    reasons: &'a std::collections::BTreeMap<&'static str, u64>,
    surplus: u64,
    dropped: &'a std::collections::BTreeMap<&'static str, u64>,
}

/// Writes the document, pretty and with a newline at its end.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write(out: &mut dyn Write, info: &Info) -> io::Result<()> {
    let counts = info.trial.outcome.as_ref().map(|outcome| Counts {
        frames: outcome.frames,
        readings: outcome.tally.readings,
        echoes: outcome.tally.echoes,
        no_echoes: outcome.tally.no_echoes,
        contact: outcome.labelled("contact"),
        intersection: outcome.labelled("intersection"),
        unidentified: outcome.labelled("unidentified"),
        reasons: &outcome.reasons,
        surplus: outcome.tally.surplus,
        dropped: &outcome.tally.dropped,
    });
    let document = Document {
        schema: SCHEMA,
        tool: Tool::THIS,
        source: Source {
            file: &info.file,
            messages: info.messages,
            start_ns: info.start_ns,
            end_ns: info.end_ns,
            complete: info.is_complete(),
            lost: &info.losses,
        },
        replay: Replay {
            possible: match info.verdict {
                Verdict::Yes => "yes",
                Verdict::InPart => "in-part",
                Verdict::WithSkeleton => "with-skeleton",
                Verdict::No => "no",
            },
            counts,
        },
        channels: &info.channels,
        sonars: &info.sonars,
        odometry: info.odometry.as_ref(),
        findings: &info.findings,
        skeleton: info.skeleton.as_deref(),
    };
    serde_json::to_writer_pretty(&mut *out, &document)?;
    out.write_all(b"\n")
}
