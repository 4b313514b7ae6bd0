//! `trace.jsonl`: a line per arc, in (frame, sensor) order, that says why it was labelled so.

use std::io::{self, Write};

use serde::Serialize;

use crate::core::event::{Sonar, name_of};
use crate::core::geometry::Pose2;
use crate::core::replay::Outcome;
use crate::core::rounding::rounded;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::{Angles, Sides};

/// One line. SI units and radians; `null` where the arc is not the middle of a triple.
#[derive(Debug, Serialize)]
pub(super) struct TraceRow<'a> {
    pub frame: u32,
    pub sensor: &'a str,
    pub stamp_ns: i64,
    pub x: f64,
    pub y: f64,
    pub yaw: f64,
    /// The sensor as odometry has it, where poses were corrected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry: Option<[f64; 3]>,
    pub range: f64,
    pub label: &'static str,
    pub reason: Option<&'static str>,
    pub theta_c: Option<f64>,
    pub theta_i: Option<f64>,
    pub theta_c_sigma: Option<f64>,
    pub theta_i_sigma: Option<f64>,
    pub contact_points: Option<[usize; 2]>,
    pub intersection_points: Option<[usize; 2]>,
    pub margin: Option<f64>,
    pub opinion: Option<&'static str>,
    pub chi2_line: Option<f64>,
    pub chi2_point: Option<f64>,
    pub readings: Option<usize>,
    pub wide_opinion: Option<&'static str>,
    pub wide_chi2_line: Option<f64>,
    pub wide_chi2_point: Option<f64>,
    /// Where circles are asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wide_chi2_circle: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub incidence: Option<f64>,
    pub map_opinion: Option<&'static str>,
    pub suspect: bool,
    pub feature: Option<u32>,
}

/// Writes a line per arc.
///
/// # Errors
/// When `out` cannot be written.
pub fn write(mut out: impl Write, sonars: &[Sonar], outcome: &Outcome) -> io::Result<()> {
    let joint = outcome.joint();
    for report in outcome.reports.iter() {
        let odometry = joint.and_then(|joint| joint.odom_from_sensor.get(&report.arc.id));
        serde_json::to_writer(&mut out, &row(report, sonars, odometry))?;
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// What is told of an arc; `odometry` is the sensor as odometry has it, where poses were corrected.
pub(super) fn row<'a>(
    report: &ArcReport,
    sonars: &'a [Sonar],
    odometry: Option<&Pose2>,
) -> TraceRow<'a> {
    let arc = &report.arc;
    let (triple, window) = (report.triple.as_ref(), report.window.as_ref());
    let points = |of: fn(&Angles) -> Sides| {
        triple.map(|triple| of(&triple.angles).map(|pair| pair.into_iter().map(usize::from).sum()))
    };
    TraceRow {
        frame: arc.id.frame,
        sensor: name_of(sonars, arc.id.sonar),
        stamp_ns: arc.stamp_ns,
        x: rounded(arc.world_from_sensor.x),
        y: rounded(arc.world_from_sensor.y),
        yaw: rounded(arc.world_from_sensor.yaw),
        odometry: odometry.map(|pose| [pose.x, pose.y, pose.yaw].map(rounded)),
        range: rounded(arc.range),
        label: report.label.name(),
        reason: report.label.reason().map(|reason| reason.name()),
        theta_c: triple.map(|t| rounded(t.angles.theta_c)),
        theta_i: triple.map(|t| rounded(t.angles.theta_i)),
        theta_c_sigma: triple.and_then(|t| t.spread.theta_c().map(rounded)),
        theta_i_sigma: triple.and_then(|t| t.spread.theta_i().map(rounded)),
        contact_points: points(|angles| angles.contact),
        intersection_points: points(|angles| angles.intersection),
        margin: report.angle_margin().map(rounded),
        opinion: triple.map(|t| t.test.support.name()),
        chi2_line: triple.map(|t| rounded(t.test.chi2_line)),
        chi2_point: triple.map(|t| rounded(t.test.chi2_point)),
        readings: window.map(|w| w.readings),
        wide_opinion: window.map(|w| w.support.name()),
        wide_chi2_line: window.map(|w| rounded(w.chi2_line)),
        wide_chi2_point: window.map(|w| rounded(w.chi2_point)),
        wide_chi2_circle: window.and_then(|w| w.chi2_circle.map(rounded)),
        incidence: (report.oblique.as_ref()).map(|wall| rounded(wall.incidence)),
        map_opinion: report.map.map(|m| m.support.name()),
        suspect: report.is_suspect(),
        feature: report.run.as_ref().map(|run| run.extraction),
    }
}
