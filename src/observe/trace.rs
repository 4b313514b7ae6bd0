//! `trace.jsonl`: a line per arc, in (frame, sensor) order, that says why it was labelled so.

use std::io::Write;

use serde::Serialize;

use crate::core::event::Sonar;
use crate::core::replay::Outcome;
use crate::core::rounding::{number, optional};
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::{Angles, OnMiddle};

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

/// Writes a line per arc.
///
/// # Errors
/// When `out` cannot be written.
pub fn write(
    mut out: impl Write,
    sonars: &[Sonar],
    outcome: &Outcome,
) -> Result<(), std::io::Error> {
    for report in &outcome.reports {
        serde_json::to_writer(&mut out, &row(report, sonars))?;
        out.write_all(b"\n")?;
    }
    Ok(())
}

fn row<'a>(report: &ArcReport, sonars: &'a [Sonar]) -> Row<'a> {
    let arc = &report.arc;
    let (triple, window) = (report.triple.as_ref(), report.window());
    let points = |of: fn(&Angles) -> &OnMiddle| {
        triple.map(|triple| of(&triple.angles).map(|pair| pair.iter().flatten().count()))
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
        label: report.label.name(),
        reason: report.label.reason().map(|reason| reason.name()),
        theta_c: triple.map(|t| t.angles.theta_c),
        theta_i: triple.map(|t| t.angles.theta_i),
        theta_c_sigma: triple.and_then(|t| t.spread.theta_c),
        theta_i_sigma: triple.and_then(|t| t.spread.theta_i),
        contact_points: points(|angles| &angles.contact_points),
        intersection_points: points(|angles| &angles.intersection_points),
        margin: report.margin,
        opinion: triple.map(|t| t.test.support.name()),
        chi2_line: triple.map(|t| t.test.chi2_line),
        chi2_point: triple.map(|t| t.test.chi2_point),
        readings: window.map(|w| w.readings),
        wide_opinion: window.map(|w| w.support.name()),
        wide_chi2_line: window.map(|w| w.chi2_line),
        wide_chi2_point: window.map(|w| w.chi2_point),
        map_opinion: report.map.map(|m| m.support.name()),
        suspect: report.is_suspect(),
        feature: report.run.map(|run| run.extraction),
    }
}
