//! `trace.jsonl`: a line per arc, in (frame, sensor) order, that says why it was labelled so.

use std::collections::{BTreeMap, VecDeque};
use std::io::Write;
use std::path::PathBuf;

use serde::Serialize;

use crate::core::event::Sonar;
use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError, Setting};
use crate::core::rounding::{number, optional};
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::pair::{PairPoint, Points};
use crate::core::tmam::step::Step;
use crate::core::tmam::report::ArcReport;
use crate::io::output::OutputError;

/// One line. SI units and radians; `null` where the arc is not the middle of a triple.
#[derive(Debug, Serialize)]
struct Row<'a> {
    frame: u32,
    sensor: &'a str,
    stamp_ns: i64,
    #[serde(serialize_with = "number")]
    x: f64,
    #[serde(serialize_with = "number")]
    y: f64,
    #[serde(serialize_with = "number")]
    yaw: f64,
    #[serde(serialize_with = "number")]
    range: f64,
    label: &'static str,
    reason: Option<&'static str>,
    #[serde(serialize_with = "optional")]
    theta_c: Option<f64>,
    #[serde(serialize_with = "optional")]
    theta_i: Option<f64>,
    #[serde(serialize_with = "optional")]
    theta_c_sigma: Option<f64>,
    #[serde(serialize_with = "optional")]
    theta_i_sigma: Option<f64>,
    contact_points: Option<[usize; 2]>,
    intersection_points: Option<[usize; 2]>,
    #[serde(serialize_with = "optional")]
    margin: Option<f64>,
    opinion: Option<&'static str>,
    #[serde(serialize_with = "optional")]
    chi2_line: Option<f64>,
    #[serde(serialize_with = "optional")]
    chi2_point: Option<f64>,
    readings: Option<usize>,
    wide_opinion: Option<&'static str>,
    #[serde(serialize_with = "optional")]
    wide_chi2_line: Option<f64>,
    #[serde(serialize_with = "optional")]
    wide_chi2_point: Option<f64>,
    map_opinion: Option<&'static str>,
    suspect: bool,
    feature: Option<u32>,
}

/// Writes the trace while the replay goes on.
///
/// An arc is written once all is known of it; arcs after it wait, so that the lines stay in order.
#[derive(Debug)]
pub struct Trace<'a, W> {
    out: W,
    path: PathBuf,
    sonars: &'a [Sonar],
    waiting: VecDeque<ArcId>,
    judged: BTreeMap<ArcId, ArcReport>,
}

impl<'a, W: Write> Trace<'a, W> {
    /// A trace into `out`; `path` is what errors call it.
    pub fn new(out: W, path: PathBuf, setting: Setting<'a>) -> Self {
        Self {
            out,
            path,
            sonars: setting.sonars,
            waiting: VecDeque::new(),
            judged: BTreeMap::new(),
        }
    }

    fn failed(&self, source: std::io::Error) -> OutputError {
        OutputError {
            path: self.path.clone(),
            source,
        }
    }

    fn take(&mut self, step: &Step) {
        self.waiting.extend(step.arcs.iter().map(|arc| arc.id));
        let judgements = step.judgements.iter();
        self.judged.extend(judgements.map(|j| (j.arc.id, *j)));
    }

    fn write_settled(&mut self) -> Result<(), OutputError> {
        while let Some(id) = self.waiting.front()
            && let Some(judgement) = self.judged.remove(id)
        {
            let row = row(&judgement, self.sonars);
            serde_json::to_writer(&mut self.out, &row)
                .map_err(std::io::Error::from)
                .and_then(|()| self.out.write_all(b"\n"))
                .map_err(|source| self.failed(source))?;
            self.waiting.pop_front();
        }
        Ok(())
    }
}

impl<W: Write> Observer for Trace<'_, W> {
    fn frame(&mut self, _: &Frame, step: &Step) -> Result<(), ObserverError> {
        self.take(step);
        self.write_settled().map_err(ObserverError::new)
    }

    fn finish(&mut self, step: &Step) -> Result<(), ObserverError> {
        self.take(step);
        self.write_settled()
            .and_then(|()| self.out.flush().map_err(|source| self.failed(source)))
            .map_err(ObserverError::new)
    }
}

fn row<'a>(judgement: &ArcReport, sonars: &'a [Sonar]) -> Row<'a> {
    let (arc, verdict) = (&judgement.arc, &judgement.verdict);
    let wide = judgement.wide.as_ref();
    let evidence = verdict.evidence.as_ref();
    let points = |of: fn(&Points) -> &[Option<PairPoint>; 2]| {
        let count = |points: &Points| of(points).iter().flatten().count();
        evidence.map(|e| [count(&e.angles.before), count(&e.angles.after)])
    };
    Row {
        frame: arc.id.frame,
        sensor: sonars
            .get(arc.id.sonar.index())
            .map_or("", |sonar| sonar.name.as_str()),
        stamp_ns: arc.stamp_ns,
        x: arc.world_from_sensor.x,
        y: arc.world_from_sensor.y,
        yaw: arc.world_from_sensor.yaw,
        range: arc.range,
        label: verdict.label.name(),
        reason: verdict.label.reason().map(|reason| reason.name()),
        theta_c: evidence.map(|e| e.angles.theta_c),
        theta_i: evidence.map(|e| e.angles.theta_i),
        theta_c_sigma: evidence.and_then(|e| e.spread.theta_c),
        theta_i_sigma: evidence.and_then(|e| e.spread.theta_i),
        contact_points: points(|p| &p.contact),
        intersection_points: points(|p| &p.intersection),
        margin: verdict.margin,
        opinion: evidence.map(|e| e.opinion.support.name()),
        chi2_line: evidence.map(|e| e.opinion.chi2_line),
        chi2_point: evidence.map(|e| e.opinion.chi2_point),
        readings: wide.map(|w| w.readings),
        wide_opinion: wide.map(|w| w.support.name()),
        wide_chi2_line: wide.map(|w| w.chi2_line),
        wide_chi2_point: wide.map(|w| w.chi2_point),
        map_opinion: judgement.map.map(|m| m.support.name()),
        suspect: judgement.is_suspect(),
        feature: judgement.run.map(|run| run.extraction),
    }
}
