//! Beside the map: the angles of every triple and the labels that follow from them.

use std::collections::BTreeSet;
use std::io::Write;

use rerun::components::{MarkerShape, Name};
use rerun::external::re_log_types::EntityPathPart;
use rerun::{
    Color, EntityPath, Scalars, SerializationResult, SerializedComponentColumn, SeriesLines,
    SeriesPoints, StateChange, StateConfiguration,
};

use super::Error;
use super::encode::RrdWriter;
use super::hold::Held;
use super::style::{self, LABELS};
use super::table::{Instance, Moment, Table, Timelines, put_static};
use crate::core::event::{Sonar, SonarId};
use crate::core::rounding::rounded;
use crate::core::tmam::triple::TripleTest;

/// An angle in radians, a chi2, or a place on a lane, rounded as in the trace, so that the two can be compared.
struct Value(f64);

impl Instance for Value {
    fn columns(
        values: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(Scalars::update_fields()
            .with_scalars(values.iter().map(|value| rounded(value.0)))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

/// A label, with the reason where there is none. A row without one ends the label before it: a gap in the lane. (A null would say the
/// same, but `rerun rrd verify` takes it for damage.)
struct State(String);

impl Instance for State {
    fn columns(
        states: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(StateChange::update_fields()
            .with_state(states.iter().map(|state| state.0.as_str()))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

/// The angles and labels of every frame.
pub struct PlotTables {
    theta_c: Table<Value>,
    theta_i: Table<Value>,
    chi2_line: Table<Value>,
    chi2_point: Table<Value>,
    labels: Vec<Table<State>>,
    // The same labels as dots: lanes of names melt into grey where a run is long.
    dots: [(&'static str, Table<Value>); 3],
}

impl PlotTables {
    /// Empty tables for these sonars.
    pub fn new(sonars: &[Sonar]) -> Self {
        Self {
            theta_c: Table::new("/angles/theta_c"),
            theta_i: Table::new("/angles/theta_i"),
            chi2_line: Table::new("/chi2/line"),
            chi2_point: Table::new("/chi2/point"),
            labels: sonars.iter().map(|s| Table::new(lane(s))).collect(),
            dots: KINDS.map(|(name, _)| (name, Table::new(dots(name)))),
        }
    }

    /// Adds a decided frame.
    pub fn push<W: Write>(
        &mut self,
        held: &Held,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let sonars = self.labels.len();
        let theta_c = by_sonar(held, sonars, |triple| triple.angles.theta_c);
        let theta_i = by_sonar(held, sonars, |triple| triple.angles.theta_i);
        self.theta_c.push(held.moment, theta_c, lines, out)?;
        self.theta_i.push(held.moment, theta_i, lines, out)?;
        let line = by_sonar(held, sonars, |triple| finite(triple.test.chi2_line));
        let point = by_sonar(held, sonars, |triple| finite(triple.test.chi2_point));
        self.chi2_line.push(held.moment, line, lines, out)?;
        self.chi2_point.push(held.moment, point, lines, out)?;
        for cell in &held.cells {
            if let Some(labels) = self.labels.get_mut(cell.sonar.index()) {
                let state = cell
                    .report
                    .as_ref()
                    .map(|report| State(style::name(report.label)));
                labels.push(held.moment, state, lines, out)?;
            }
        }
        for (name, table) in &mut self.dots {
            let row = dots_of(held, sonars, name);
            table.push(held.moment, row, lines, out)?;
        }
        Ok(())
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.theta_c.flush(lines, out)?;
        self.theta_i.flush(lines, out)?;
        self.chi2_line.flush(lines, out)?;
        self.chi2_point.flush(lines, out)?;
        for labels in &mut self.labels {
            labels.flush(lines, out)?;
        }
        self.dots
            .iter_mut()
            .try_for_each(|(_, table)| table.flush(lines, out))
    }
}

/// One number per sonar; NaN, which plots as a gap, where the frame has no triple of it.
fn by_sonar(held: &Held, sonars: usize, pick: fn(&TripleTest) -> f64) -> Vec<Value> {
    let mut row: Vec<Value> = (0..sonars).map(|_| Value(f64::NAN)).collect();
    for cell in &held.cells {
        let triple = cell.report.as_ref().and_then(|report| report.triple);
        if let (Some(slot), Some(triple)) = (row.get_mut(cell.sonar.index()), triple) {
            *slot = Value(pick(&triple));
        }
    }
    row
}

/// Infinite where the beams have nothing in common: a gap in the plot.
fn finite(chi2: f64) -> f64 {
    if chi2.is_finite() { chi2 } else { f64::NAN }
}

/// A dot on the lane of every sonar whose arc has this label: contact lies above the lane's middle
/// and unidentified below it, so that none hides another where the run is long.
fn dots_of(held: &Held, sonars: usize, label: &str) -> Vec<Value> {
    let above = match label {
        "contact" => 0.2,
        "intersection" => 0.0,
        _ => -0.2,
    };
    let mut row: Vec<Value> = (0..sonars).map(|_| Value(f64::NAN)).collect();
    for cell in &held.cells {
        let at = cell.sonar.index();
        let same = (cell.report.as_ref()).is_some_and(|r| r.label.name() == label);
        if let Some(slot) = row.get_mut(at).filter(|_| same) {
            *slot = Value(at as f64 + above);
        }
    }
    row
}

/// What a label can be, whatever the reason.
const KINDS: [(&str, Color); 3] = [
    ("contact", style::CONTACT),
    ("intersection", style::INTERSECTION),
    ("unidentified", style::UNIDENTIFIED),
];

/// The entity that holds one label's dots.
fn dots(label: &str) -> String {
    format!("/lanes/{label}")
}

/// The entity that holds a sonar's labels: its name is one part, whatever slashes it has.
fn lane(sonar: &Sonar) -> EntityPath {
    EntityPath::new(vec![
        EntityPathPart::new("labels"),
        EntityPathPart::new(sonar.name.as_str()),
    ])
}

/// The bounds that values are held against.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// On the smaller angle, radians.
    pub gamma: f64,
    /// On the chi2 of a triple.
    pub gate: f64,
}

/// How the plots look.
pub fn put_styles<W: Write>(
    sonars: &[Sonar],
    limits: Limits,
    out: &mut RrdWriter<W>,
) -> Result<(), Error> {
    let look = SeriesPoints::update_fields()
        .with_names(sonars.iter().map(|sonar| Name::from(sonar.name.as_str())))
        .with_colors(style::wheel(sonars.len()))
        .with_marker_sizes(vec![2.0; sonars.len()]);
    for path in [
        "/angles/theta_c",
        "/angles/theta_i",
        "/chi2/line",
        "/chi2/point",
    ] {
        put_static(path, &look, out)?;
    }
    for (path, name) in [
        (GAMMA, format!("gamma {:.1} deg", limits.gamma.to_degrees())),
        (GATE, format!("gate {}", limits.gate)),
    ] {
        let look = SeriesLines::update_fields()
            .with_names([name])
            .with_colors([style::BOUND])
            .with_widths([1.5]);
        put_static(path, &look, out)?;
    }
    for (name, color) in KINDS {
        let look = SeriesPoints::update_fields()
            .with_names(sonars.iter().map(|sonar| Name::from(sonar.name.as_str())))
            .with_colors(vec![color; sonars.len()])
            .with_markers(vec![MarkerShape::Square; sonars.len()])
            .with_marker_sizes(vec![2.5; sonars.len()]);
        put_static(dots(name), &look, out)?;
    }
    Ok(())
}

/// The entities that hold the bounds.
pub const GAMMA: &str = "/angles/gamma";
pub const GATE: &str = "/chi2/gate";

/// The bounds as lines over the whole run, and how the lanes look: of the sonars that gave something,
/// since the viewer would draw an empty lane for any other.
pub fn put_last<W: Write>(
    sonars: &[Sonar],
    seen: &BTreeSet<SonarId>,
    limits: Limits,
    ends: &[Moment],
    lines: Timelines,
    out: &mut RrdWriter<W>,
) -> Result<(), Error> {
    for (path, bound) in [(GAMMA, limits.gamma), (GATE, limits.gate)] {
        let mut table = Table::new(path);
        for end in ends {
            table.push(*end, [Value(bound)], lines, out)?;
        }
        table.flush(lines, out)?;
    }
    // Most lanes are grey most of the time: a word there would be noise, a letter is not.
    let look = StateConfiguration::new()
        .with_values(LABELS.map(style::name))
        .with_labels(LABELS.map(style::short))
        .with_colors(LABELS.map(style::shade));
    seen.iter()
        .filter_map(|sonar| sonars.get(sonar.index()))
        .try_for_each(|sonar| put_static(lane(sonar), &look, out))
}
