//! Arcs in the map: of the current frame, coloured by label, with the points they were judged by.

use std::io::Write;

use rerun::{LineStrips2D, Points2D, SerializationResult, SerializedComponentColumn};

use super::Error;
use super::encode::RrdWriter;
use super::hold::Held;
use super::style::{self, order, ui};
use super::table::{Instance, Table, Timelines, put_static};
use crate::core::event::Sonar;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::{OnMiddle, TripleTest};

/// The entity of the arcs.
pub const ARCS: &str = "/world/arcs";

struct ArcStrip {
    points: Vec<[f32; 2]>,
    class: u16,
    /// What the viewer shows when the arc is pointed at or selected.
    story: String,
}

impl Instance for ArcStrip {
    fn columns(
        arcs: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        let classes: Vec<u16> = arcs.iter().map(|arc| arc.class).collect();
        let (strips, stories): (Vec<_>, Vec<_>) =
            arcs.into_iter().map(|arc| (arc.points, arc.story)).unzip();
        Ok(LineStrips2D::update_fields()
            .with_strips(strips)
            .with_class_ids(classes)
            .with_labels(stories)
            .columns(lengths.iter().copied())?
            .collect())
    }
}

struct Beam([[f32; 2]; 2]);

impl Instance for Beam {
    fn columns(
        beams: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(LineStrips2D::update_fields()
            .with_strips(beams.iter().map(|beam| beam.0))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

struct Touch([f32; 2]);

impl Instance for Touch {
    fn columns(
        points: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(Points2D::update_fields()
            .with_positions(points.iter().map(|point| point.0))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

/// The arcs of every frame and their points.
pub struct ArcTables {
    sonars: Vec<String>,
    arcs: Table<ArcStrip>,
    beams: Table<Beam>,
    contact_points: Table<Touch>,
    intersection_points: Table<Touch>,
}

impl ArcTables {
    /// Empty tables for these sonars.
    pub fn new(sonars: &[Sonar]) -> Self {
        Self {
            sonars: sonars.iter().map(|sonar| sonar.name.clone()).collect(),
            arcs: Table::new(ARCS),
            beams: Table::new("/world/beams"),
            contact_points: Table::new("/world/contact_points"),
            intersection_points: Table::new("/world/intersection_points"),
        }
    }

    /// Adds a decided frame.
    pub fn push<W: Write>(
        &mut self,
        held: &Held,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let origin = out.origin();
        let decided = || held.cells.iter().filter_map(|cell| cell.report.as_ref());
        let strips = decided().map(|report| {
            let sonar = self.sonars.get(report.arc.id.sonar.index());
            ArcStrip {
                points: origin.sweep(&report.arc),
                class: style::class(report.label),
                story: story(sonar.map_or("?", String::as_str), report),
            }
        });
        self.arcs.push(held.moment, strips, lines, out)?;
        let beams = decided().map(|ArcReport { arc, .. }| {
            let ahead = arc.point_at(arc.world_from_sensor.yaw);
            Beam([arc.center(), ahead].map(|place| origin.xy(place)))
        });
        self.beams.push(held.moment, beams, lines, out)?;
        let touches = |pick: fn(&TripleTest) -> OnMiddle| {
            decided()
                .filter_map(|report| report.triple.as_ref())
                .flat_map(move |triple| pick(triple).into_iter().flatten().flatten())
                .map(move |point| Touch(origin.xy(point)))
        };
        self.contact_points.push(
            held.moment,
            touches(|triple| triple.angles.contact_points),
            lines,
            out,
        )?;
        self.intersection_points.push(
            held.moment,
            touches(|triple| triple.angles.intersection_points),
            lines,
            out,
        )
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.arcs.flush(lines, out)?;
        self.beams.flush(lines, out)?;
        self.contact_points.flush(lines, out)?;
        self.intersection_points.flush(lines, out)
    }
}

/// The sonar, the label and the evidence for it, in a line.
pub fn story(sonar: &str, report: &ArcReport) -> String {
    let label = style::name(report.label);
    let Some(triple) = &report.triple else {
        return format!("{sonar}, {label}");
    };
    let angle = |theta: f64, sigma: Option<f64>| match sigma {
        Some(sigma) => format!("{:.1} +- {:.1} deg", theta.to_degrees(), sigma.to_degrees()),
        None => format!("{:.1} deg", theta.to_degrees()),
    };
    let test = &triple.test;
    format!(
        "{sonar}, {label}; theta_c {}, theta_i {}; chi2 line {}, point {}: {}",
        angle(triple.angles.theta_c, triple.spread.theta_c),
        angle(triple.angles.theta_i, triple.spread.theta_i),
        chi2(test.chi2_line),
        chi2(test.chi2_point),
        test.support.name()
    )
}

/// A chi2; infinite where the beams have no place for such a feature.
pub fn chi2(x: f64) -> String {
    if x.is_finite() {
        format!("{x:.1}")
    } else {
        "none in the beam".to_owned()
    }
}

/// How arcs look.
pub fn put_styles<W: Write>(out: &mut RrdWriter<W>) -> Result<(), Error> {
    let strips = LineStrips2D::update_fields;
    put_static(
        ARCS,
        &strips()
            .with_radii([ui(2.0)])
            .with_show_labels(false)
            .with_draw_order(order::ARC),
        out,
    )?;
    put_static(
        "/world/beams",
        &strips()
            .with_radii([ui(0.5)])
            .with_colors([style::BEAM])
            .with_draw_order(order::BEAM),
        out,
    )?;
    for (path, color) in [
        ("/world/contact_points", style::CONTACT),
        ("/world/intersection_points", style::INTERSECTION),
    ] {
        let look = Points2D::update_fields()
            .with_radii([ui(3.0)])
            .with_colors([color])
            .with_draw_order(order::TOUCH);
        put_static(path, &look, out)?;
    }
    Ok(())
}
