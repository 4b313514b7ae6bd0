//! Why one arc was labelled so, what would have changed that, and whether it was right.
//!
//! A replay says all that it tested of an arc in its [`ArcReport`]; a [`Question`] names one, and an
//! [`Explanation`] tells it with what stands around it. None of it reads or writes files.

pub mod changes;
pub mod history;
pub mod pairs;
pub mod question;
pub mod sequences;
pub mod situation;
pub mod suspects;
pub mod text;

use std::io::{self, Write};

use serde::Serialize;

use self::changes::{Change, Windows, by_angles, by_neighbours};
use self::history::{Doubt, MapStory, RunStory, TruthStory, doubts, runs};
use self::pairs::Pair;
use self::question::Found;
pub use self::question::{Question, QuestionError, Which};
use self::sequences::Sequences;
use self::situation::{AnglesStory, Reading, Situation, Window};
use crate::core::config::Config;
use crate::core::observer::{Setting, Source};
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::core::rounding::{number, optional};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::hypothesis::Gate;
use crate::core::tmam::label::{Label, Reason};
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::TripleTest;
use crate::core::tool::Tool;
use crate::tools::evaluate::Truth;

/// How many other arcs that pass near a place are named.
const NEAR: usize = 5;

/// Why there is nothing to explain.
#[derive(Debug, thiserror::Error)]
pub enum ExplainError {
    #[error(transparent)]
    Replay(#[from] ReplayError),
    #[error(transparent)]
    Question(#[from] QuestionError),
}

/// The whole story of an arc. SI units and radians.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    pub sensor: String,
    pub arc: Reading,
    /// How far it passes from the place that was asked for.
    #[serde(serialize_with = "optional")]
    pub distance: Option<f64>,
    /// How long after the time that was asked for it was measured, seconds.
    #[serde(serialize_with = "optional")]
    pub late: Option<f64>,
    /// Other arcs that pass about as near, nearest first.
    pub also_near: Vec<Near>,
    pub label: &'static str,
    pub reason: Option<&'static str>,
    /// `angles` or `opinion`.
    pub decided_by: &'static str,
    pub suspect: bool,
    pub doubts: Vec<Doubt>,
    pub situation: Situation,
    /// The two pairs, where the arc has an echo on either side.
    pub pairs: Vec<Pair>,
    /// The angles, where it is the middle of a triple; those it would have, where only a bound keeps
    /// it from that.
    pub angles: Option<AnglesStory>,
    pub changes: Vec<Change>,
    /// The windows that were looked at.
    pub windows: Vec<Window>,
    /// The lead in chi2 that decides.
    #[serde(serialize_with = "number")]
    pub decisive: f64,
    /// Why no wider window was looked at: `decided`, `neither`, `max-half-width` or `no-more-readings`.
    pub windows_end: Option<&'static str>,
    /// Runs that the arc stands behind, and what became of them.
    pub runs: Vec<RunStory>,
    pub map: Option<MapStory>,
    /// What echoed, where that is known.
    pub truth: Option<TruthStory>,
}

/// Another arc that passes near a place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Near {
    pub sensor: String,
    pub frame: u32,
    #[serde(serialize_with = "optional")]
    pub distance: Option<f64>,
}

/// Replays a log and explains one of its arcs.
///
/// # Errors
/// When there is nothing to replay, or no arc that answers the question.
pub fn explain(
    replay: &Replay<'_>,
    question: &Question,
    truth: Option<&Truth>,
) -> Result<(Outcome, Explanation), ExplainError> {
    let outcome = replay.run(&mut [])?;
    let sequences = Sequences::new(replay, &outcome);
    let found = question.answers(&sequences, &replay.setting(), replay.origin_ns())?;
    let told = tell(&found, replay, &outcome, &sequences, truth);
    let explanation = told.ok_or_else(|| QuestionError::NoEcho {
        sonars: question.sonars.clone(),
    })?;
    Ok((outcome, explanation))
}

fn tell(
    found: &[Found],
    replay: &Replay<'_>,
    outcome: &Outcome,
    sequences: &Sequences<'_>,
    truth: Option<&Truth>,
) -> Option<Explanation> {
    let best = found.first()?;
    let (arc, config) = (best.arc, replay.config());
    let setting = replay.setting();
    let name = |arc: &Arc| {
        let sonar = setting.sonars.get(arc.id.sonar.index());
        sonar.map_or_else(String::new, |sonar| sonar.name.clone())
    };
    let (sequence, place) = sequences.around(arc.id)?;
    let report = sequence.get(place)?.report?;
    let situation = Situation::new(sequence, place, config, replay.origin_ns());
    let triple = situation.three.as_ref().map(|three| {
        let gate = || Gate::new(config.opinion.gate);
        let own = report.triple;
        own.unwrap_or_else(|| TripleTest::of(three, &config.triple, &gate()))
    });
    let windows = Windows::new(sequence, place, config);
    let by_opinion = config.departures().label_by_opinion;
    let changes = match (&triple, report.triple.is_some()) {
        (_, true) if by_opinion => windows.changes(),
        (Some(triple), true) => {
            let beams = replay.readings().map(|reading| reading.beam_width);
            let narrowest = beams.fold(f64::INFINITY, f64::min);
            by_angles(report.label, &triple.angles, &config.triple, narrowest)
        }
        // Without the bounds that it breaks it would be the middle of a triple.
        (would_be, _) => {
            let then = would_be.filter(|_| !by_opinion).map(|triple| triple.label);
            let then = then.filter(|label| label.kind().is_some()).map(Label::name);
            by_neighbours(&situation, then)
        }
    };
    let near = |found: &Found| Near {
        sensor: name(&found.arc),
        frame: found.arc.id.frame,
        distance: found.distance,
    };
    Some(Explanation {
        sensor: name(&arc),
        arc: Reading::new(&arc, replay.origin_ns()),
        distance: best.distance,
        late: best.late,
        also_near: (found.iter().skip(1).take(NEAR))
            .filter(|found| found.distance.is_some())
            .map(near)
            .collect(),
        label: report.label.name(),
        reason: report.label.reason().map(Reason::name),
        decided_by: if by_opinion { "opinion" } else { "angles" },
        suspect: report.is_suspect(),
        doubts: doubts(report),
        pairs: situation.three.as_ref().map_or_else(Vec::new, Pair::both),
        angles: triple.map(|triple| AnglesStory::new(&triple, &config.triple)),
        changes,
        windows: Window::looked_at(sequence, place, config),
        windows_end: windows_end(report, config),
        decisive: config.opinion.decisive,
        runs: runs(arc.id, outcome),
        map: report.map.map(|map| MapStory {
            says: map.support.name(),
            feature: map.feature,
        }),
        truth: truth.map(|truth| TruthStory::new(&arc, report.label, &situation, truth)),
        situation,
    })
}

/// Why no wider window was looked at.
fn windows_end(report: &ArcReport, config: &Config) -> Option<&'static str> {
    let last = report.window()?;
    let bounds = &config.opinion;
    Some(match last.label(bounds.decisive) {
        Label::Contact | Label::Intersection => "decided",
        Label::Unidentified(Reason::Neither) => "neither",
        Label::Unidentified(_) if report.windows.len() == bounds.max_half_width => "max-half-width",
        Label::Unidentified(_) => "no-more-readings",
    })
}

/// Writes an explanation (`tmam.explanation/1`) or a list of suspects (`tmam.suspects/1`) in JSON,
/// pretty, with one newline at its end.
///
/// # Errors
/// When `out` cannot be written.
pub fn write_json(
    mut out: impl Write,
    schema: &'static str,
    setting: &Setting<'_>,
    told: &impl Serialize,
) -> io::Result<()> {
    #[derive(Serialize)]
    struct File<'a, T> {
        schema: &'static str,
        tool: Tool,
        source: &'a Source,
        config: &'a Config,
        #[serde(flatten)]
        told: &'a T,
    }
    let file = File {
        schema,
        tool: Tool::THIS,
        source: setting.source,
        config: setting.config,
        told,
    };
    serde_json::to_writer_pretty(&mut out, &file)?;
    out.write_all(b"\n")
}
