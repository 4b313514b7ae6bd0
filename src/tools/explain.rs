//! Why one arc was labelled so, what would have changed that, and whether it was right.
//!
//! A replay says in the [`ArcReport`](crate::core::tmam::report::ArcReport) of an arc what decided; the tests of the
//! windows before the last are those of the same readings again. A [`Question`] names one, and an [`Explanation`] tells it with what stands around it. None of it
//! reads or writes files.

pub mod changes;
pub mod history;
pub mod pose;
pub mod question;
pub mod readings;
pub mod sequences;
pub mod suspects;
pub mod triple;
pub mod windows;

use std::fmt::Write as _;
use std::io;

use serde::Serialize;

use self::changes::{LabelChange, Windows, by_angles, by_neighbours};
use self::history::{Doubt, RunStory, TruthStory};
use self::pose::PoseStory;
use self::question::{Answer, command};
pub use self::question::{Question, QuestionError, Which};
use self::readings::{Reading, Situation};
use self::sequences::Sequences;
use self::triple::{AnglesStory, Pair};
use self::windows::Window;
use crate::core::config::Config;
use crate::core::event::name_of;
use crate::core::observer::{Observer, Setting, Source};
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::core::rounding::{number, optional};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::MapFeature;
use crate::core::tmam::hypothesis::Gate;
use crate::core::tmam::label::{Label, Reason};
use crate::core::tmam::prediction::Prediction;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::TripleTest;
use crate::tools::document;
use crate::tools::evaluate::Truth;
use crate::tools::tables::section;

/// How many other arcs that pass near a place are named.
const NEAR: usize = 5;

/// An arc that passes farther from a place than this is hardly the one that was meant, metres.
const FAR: f64 = 0.3;

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
    /// How its pose was corrected, where poses were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<PoseStory>,
    /// How far it passes from the place that was asked for.
    #[serde(serialize_with = "optional")]
    pub distance: Option<f64>,
    /// How long after the time that was asked for it was measured, seconds.
    #[serde(serialize_with = "optional")]
    pub late: Option<f64>,
    /// Other arcs that pass about as near, nearest first.
    pub also_near: Vec<Near>,
    pub label: Label,
    pub reason: Option<Reason>,
    /// The rough wall that it came from, for the reason `oblique`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub oblique: Option<ObliqueStory>,
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
    pub changes: Vec<LabelChange>,
    /// The windows that were looked at.
    pub windows: Vec<Window>,
    /// The lead in chi2 that decides.
    #[serde(serialize_with = "number")]
    pub decisive: f64,
    /// Why no wider window was looked at.
    pub windows_end: Option<&'static str>,
    /// Runs that the arc stands behind, and what became of them.
    pub runs: Vec<RunStory>,
    pub map: Option<Prediction>,
    /// Whether the map has the feature that it names from crossings of several sonars' arcs, and from no run.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub crossings: bool,
    /// What echoed, where that is known.
    pub truth: Option<TruthStory>,
}

/// A rough wall that explains readings at an angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ObliqueStory {
    /// How many readings, the one after the arc and those before that.
    pub readings: usize,
    /// Squares that remain of the wall through the near edge of the beams.
    #[serde(serialize_with = "number")]
    pub chi2: f64,
    /// Between that edge and the wall's normal.
    #[serde(serialize_with = "number")]
    pub incidence: f64,
}

/// Another arc that passes near a place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Near {
    pub sensor: String,
    pub frame: u32,
    #[serde(serialize_with = "number")]
    pub distance: f64,
}

/// Replays a log and explains one of its arcs.
///
/// # Errors
/// When there is nothing to replay, or no arc that answers the question.
pub fn explain(
    replay: &Replay<'_>,
    question: &Question,
    truth: Option<&Truth>,
    watch: &mut dyn Observer,
) -> Result<(Outcome, Explanation), ExplainError> {
    let outcome = replay.run(&mut [watch])?;
    let sequences = Sequences::new(replay, &outcome);
    let found = question.answers(&sequences, &replay.setting(), replay.origin_ns())?;
    let told = Explanation::new(&found, replay, &outcome, &sequences, truth);
    let explanation = told.ok_or_else(|| QuestionError::NoEcho {
        sonars: question.sonars.clone(),
    })?;
    Ok((outcome, explanation))
}

impl Explanation {
    fn new(
        found: &[Answer],
        replay: &Replay<'_>,
        outcome: &Outcome,
        sequences: &Sequences<'_>,
        truth: Option<&Truth>,
    ) -> Option<Self> {
        let (best, others) = found.split_first()?;
        let (arc, config) = (best.arc, replay.config());
        let sonars = replay.setting().sonars;
        let name = |arc: &Arc| name_of(sonars, arc.id.sonar).to_owned();
        let near = |found: &Answer| {
            Some(Near {
                sensor: name(&found.arc),
                frame: found.arc.id.frame,
                distance: found.distance?,
            })
        };
        let (sequence, place) = sequences.around(arc.id)?;
        let report = sequence.get(place)?.report?;
        let label = report.label;
        let situation = Situation::new(sequence, place, config, replay.origin_ns());
        let three = situation.three.as_ref();
        let gate = || Gate::new(config.opinion.gate);
        let would_be = |three| TripleTest::of(three, &config.triple, &gate());
        let triple = report.triple.or_else(|| three.map(would_be));
        let by_opinion = config.departures().label_by_opinion;
        let windows = Windows::new(sequence, place, config);
        let changes = match (&triple, report.triple.is_some()) {
            (_, true) if by_opinion => windows.changes(),
            (Some(triple), true) => {
                let beams = replay.readings().map(|reading| reading.beam_width);
                let narrowest = beams.fold(f64::INFINITY, f64::min);
                by_angles(label, &triple.angles, &config.triple, narrowest)
            }
            // Without the bounds that it breaks it would be the middle of a triple.
            (would_be, _) => {
                let then = would_be.filter(|_| !by_opinion).map(|triple| triple.label);
                let then = then.filter(|label| label.kind().is_some()).map(Label::name);
                by_neighbours(&situation.obstacles, then)
            }
        };
        let decisive = config.opinion.decisive;
        // Angles decide by the triple, readings by the widest window.
        let half_width = report.window.map_or(0, |last| last.half_width());
        let wide = if by_opinion { half_width } else { 1 };
        let decided = sequence.get(place.saturating_sub(wide)..=place + wide);
        let decided: Vec<Arc> = (decided.into_iter().flatten())
            .filter_map(|given| Some(given.report?.arc))
            .collect();
        let circles = config.departures().circles;
        Some(Self {
            sensor: name(&arc),
            arc: Reading::new(&arc, replay.origin_ns()),
            pose: PoseStory::new(&arc, outcome),
            distance: best.distance,
            late: best.late,
            also_near: others.iter().take(NEAR).filter_map(near).collect(),
            label,
            reason: label.reason(),
            oblique: report.oblique.as_ref().map(|wall| ObliqueStory {
                readings: wall.readings,
                chi2: wall.chi2,
                incidence: wall.incidence,
            }),
            decided_by: if by_opinion { "opinion" } else { "angles" },
            suspect: report.is_suspect(),
            doubts: Doubt::all(report),
            pairs: three.map_or_else(Vec::new, Pair::both),
            angles: triple.map(|triple| AnglesStory::new(&triple, &config.triple)),
            changes,
            windows: Window::all(windows.looked_at(report), sequence, place, decisive),
            windows_end: windows::end(report, &config.opinion),
            decisive,
            runs: RunStory::all(arc.id, outcome),
            map: report.map,
            crossings: {
                let id = report.map.and_then(|map| map.feature);
                let of_no_run = |known: &MapFeature| Some(known.id) == id && known.runs == 0;
                outcome.map.iter().any(of_no_run)
            },
            truth: truth
                .map(|truth| TruthStory::new(&arc, label, (three, &decided), circles, truth)),
            situation,
        })
    }

    /// The story for a person: degrees, millimetres and metres, within 100 columns. `log` is how the
    /// log was named on the command line; what did not decide is told where it is `verbose`.
    pub fn text(&self, setting: &Setting<'_>, log: &str, verbose: bool) -> String {
        let mut text = self.head(setting.source);
        let is_triple = self.is_triple();
        let by_angles = self.decided_by == "angles";
        let (angles, windows) = (self.told_angles(), self.told_windows());
        let decided = if by_angles { &angles } else { &windows };
        if let Some((title, told)) = decided.as_ref().filter(|_| is_triple) {
            section(&mut text, title, told);
        }
        let mut readings = self.situation.text(&self.arc);
        readings.extend(self.pose.map(|pose| pose.text()));
        section(&mut text, "READINGS", &readings);
        if !self.changes.is_empty() {
            // Windows may change their mind more than once; the rule's bounds and the sequence's do not.
            let monotone = by_angles || !is_triple;
            let changes = self.changes.iter().map(|change| change.text(monotone));
            section(
                &mut text,
                "WHAT WOULD CHANGE IT",
                &changes.collect::<String>(),
            );
        }
        let runs = history::text(&self.runs, self.map, self.crossings);
        section(&mut text, "RUN AND FEATURE", &runs);
        if let Some(truth) = &self.truth {
            section(&mut text, "TRUTH", &truth.text());
        }
        if verbose && !self.pairs.is_empty() {
            let title = "PAIRS (bearings off the beam's axis, left is positive)";
            let pairs = Pair::text(&self.pairs, self.arc.beam_width);
            section(&mut text, title, &pairs);
        }
        let other = if is_triple == by_angles {
            windows
        } else {
            angles
        };
        if let Some((title, told)) = other.filter(|_| verbose) {
            section(&mut text, title, &told);
        }
        if !self.also_near.is_empty() {
            section(&mut text, "OTHER ARCS THAT PASS NEAR", "");
        }
        for near in &self.also_near {
            let (millimetres, flags) = (near.distance * 1e3, command(&near.sensor, near.frame));
            let _ = writeln!(text, "  {millimetres:8.1} mm  tmam explain {log} {flags}");
        }
        text
    }

    fn is_triple(&self) -> bool {
        !matches!(
            self.reason,
            Some(Reason::Missing | Reason::Gap | Reason::Turning)
        )
    }

    /// The angles under a title.
    fn told_angles(&self) -> Option<(&'static str, String)> {
        let title = match (self.is_triple(), self.decided_by) {
            (false, _) => "ANGLES THAT IT WOULD HAVE AS THE MIDDLE OF A TRIPLE",
            (true, "angles") => "WHAT DECIDED: THE ANGLES",
            (true, _) => "WHAT THE PAPER'S RULE WOULD SAY",
        };
        let angles = self.angles.as_ref()?;
        Some((title, angles.text(self.arc.beam_width)))
    }

    /// The windows under a title.
    fn told_windows(&self) -> Option<(&'static str, String)> {
        let title = match self.decided_by {
            "angles" => "WHAT THE NOISE-AWARE RULE WOULD SAY (chi2 of the best line and point)",
            _ => "WHAT DECIDED: THE WINDOWS (chi2 of the best line and of the best point)",
        };
        (!self.windows.is_empty()).then(|| (title, Window::text(&self.windows)))
    }

    /// The sentence that says what decided.
    fn decision(&self) -> Option<String> {
        if !self.is_triple() {
            return self.situation.obstacle();
        }
        match (self.decided_by, &self.angles) {
            ("angles", Some(angles)) => Some(angles.decision()),
            _ => Window::decision(&self.windows, self.windows_end, self.decisive),
        }
    }

    fn head(&self, source: &Source) -> String {
        let what = match self.label {
            Label::Contact => "CONTACT: taken for part of a wall",
            Label::Intersection => "INTERSECTION: taken for a point",
            Label::Circle => "CIRCLE: taken for part of a pillar",
            Label::Unidentified(reason) => match reason {
                Reason::Missing => "UNIDENTIFIED: no echo before or after it, so no triple",
                Reason::Gap => {
                    "UNIDENTIFIED: a neighbour is too far in time or distance, so no triple"
                }
                Reason::Turning => {
                    "UNIDENTIFIED: the sensor turned, or its path bent, so no triple"
                }
                Reason::NoPoints => {
                    "UNIDENTIFIED: neither contact nor intersection points on a common side"
                }
                Reason::Wide => "UNIDENTIFIED: the smaller angle is not below gamma",
                Reason::Ambiguous => "UNIDENTIFIED: line and point cannot be told apart",
                Reason::Neither => {
                    "UNIDENTIFIED: its readings come from neither one line nor one point"
                }
                Reason::Oblique => {
                    "UNIDENTIFIED: its readings come from a rough wall that is seen at an angle"
                }
                Reason::ArcFeature => {
                    "UNIDENTIFIED: two readings do not tell the radius of what they come from"
                }
                Reason::Unused => "UNIDENTIFIED: no feature came of it",
            },
        };
        let mut text = format!(
            "{}, frame {}, {:.3} s after the first reading of {}{}\n{what}\n",
            self.sensor,
            self.arc.frame,
            self.arc.seconds,
            source.file,
            if source.complete { "" } else { " (INCOMPLETE)" },
        );
        if let Some(decision) = self.decision() {
            let _ = writeln!(text, "{decision}.");
        }
        if let Some(distance) = self.distance {
            let away = format!("{:.1} mm", distance * 1e3);
            text.push_str(&if distance > FAR {
                format!("No arc passes near the place asked for: this one, the nearest, passes {away} from it.\n")
            } else {
                format!("It passes {away} from the place asked for.\n")
            });
        }
        if let Some(wall) = self.oblique {
            let _ = writeln!(
                text,
                "A rough wall seen at {:.0} deg explains it: {} readings through the near edge of the beam, chi2 \
                 {:.2}.",
                wall.incidence.to_degrees(),
                wall.readings,
                wall.chi2
            );
        }
        // What one types has three decimals at most.
        if let Some(late) = self.late.filter(|late| late.abs() > 1e-3) {
            let when = if late > 0.0 { "after" } else { "before" };
            let _ = writeln!(
                text,
                "It was measured {:.3} s {when} the time asked for: none of this sonar is nearer.",
                late.abs()
            );
        }
        for doubt in &self.doubts {
            let _ = writeln!(text, "SUSPECT: {}", doubt.text());
        }
        if self.label.kind().is_some() && !self.suspect {
            text.push_str("Not suspect: neither its readings nor the map contradict the label.\n");
        }
        text.push_str(match self.truth.as_ref().and_then(|truth| truth.right) {
            Some(true) => "In truth the label is right.\n",
            Some(false) => "In truth the label is WRONG.\n",
            None => "",
        });
        text
    }
}

/// The sentence that says what decided on an arc that is the middle of a triple.
pub fn decision(report: &ArcReport, config: &Config) -> Option<String> {
    match config.departures().label_by_opinion {
        true => Window::decision_of(report, &config.opinion),
        false => Some(AnglesStory::new(report.triple.as_ref()?, &config.triple).decision()),
    }
}

/// Writes an explanation (`tmam.explanation/1`) or a list of suspects (`tmam.suspects/1`) in JSON,
/// pretty, with one newline at its end.
///
/// # Errors
/// When `out` cannot be written.
pub fn write_json(
    out: &mut dyn io::Write,
    schema: &'static str,
    setting: &Setting<'_>,
    told: &impl Serialize,
) -> io::Result<()> {
    #[derive(Serialize)]
    struct Content<'a, T> {
        source: &'a Source,
        config: &'a Config,
        #[serde(flatten)]
        told: &'a T,
    }
    let content = Content {
        source: setting.source,
        config: setting.config,
        told,
    };
    document::write(out, schema, &content)
}
