//! What waits for verdicts: arcs and their points in the map, angles and labels beside it.

use std::io::Write;

use rerun::components::Name;
use rerun::external::re_log_types::EntityPathPart;
use rerun::{
    EntityPath, LineStrips2D, Points2D, Scalars, SerializationResult, SerializedComponentColumn,
    SeriesLines, SeriesPoints, StateChange, StateConfiguration,
};

use super::Error;
use super::encode::RrdWriter;
use super::hold::Held;
use super::style::{self, order, ui};
use super::table::{Instance, Moment, Table, Timelines, put_static};
use crate::event::Sonar;
use crate::geometry::Vec2;
use crate::tmam::arc::Arc;
use crate::tmam::pair::PairPoint;
use crate::tmam::triple::Evidence;

/// Widest step along an arc, radians: a chord strays 2 mm from an arc 5 m away.
const ARC_STEP: f64 = 0.06;

/// A position as the viewer stores it.
pub fn xy(point: Vec2) -> [f32; 2] {
    [point.x as f32, point.y as f32]
}

/// The same number as the trace writes it.
fn rounded(angle: f64) -> f64 {
    libm::round(angle * 1e9) / 1e9
}

struct ArcStrip {
    points: Vec<[f32; 2]>,
    class: u16,
    sonar: String,
}

impl Instance for ArcStrip {
    fn columns(
        arcs: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        let classes: Vec<u16> = arcs.iter().map(|arc| arc.class).collect();
        let (strips, names): (Vec<_>, Vec<_>) =
            arcs.into_iter().map(|arc| (arc.points, arc.sonar)).unzip();
        Ok(LineStrips2D::update_fields()
            .with_strips(strips)
            .with_class_ids(classes)
            .with_labels(names)
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

struct Angle(f64);

impl Instance for Angle {
    fn columns(
        angles: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(Scalars::update_fields()
            .with_scalars(angles.iter().map(|angle| angle.0))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

/// A row without one ends the state before it: a gap in the lane. (A null would say the same,
/// but `rerun rrd verify` takes it for damage.)
struct State(&'static str);

impl Instance for State {
    fn columns(
        states: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(StateChange::update_fields()
            .with_state(states.iter().map(|state| state.0))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

/// The entity that holds a sonar's labels: its name is one part, whatever slashes it has.
pub fn label_entity(sonar: &Sonar) -> EntityPath {
    EntityPath::new(vec![
        EntityPathPart::new("labels"),
        EntityPathPart::new(sonar.name.as_str()),
    ])
}

/// The tables of everything that a verdict is needed for.
pub struct ArcTables {
    names: Vec<String>,
    arcs: Table<ArcStrip>,
    beams: Table<Beam>,
    contact_points: Table<Touch>,
    intersection_points: Table<Touch>,
    theta_c: Table<Angle>,
    theta_i: Table<Angle>,
    labels: Vec<Table<State>>,
}

impl ArcTables {
    /// Empty tables for these sonars.
    pub fn new(sonars: &[Sonar]) -> Self {
        Self {
            names: sonars.iter().map(|sonar| sonar.name.clone()).collect(),
            arcs: Table::new("/world/arcs"),
            beams: Table::new("/world/beams"),
            contact_points: Table::new("/world/contact_points"),
            intersection_points: Table::new("/world/intersection_points"),
            theta_c: Table::new("/angles/theta_c"),
            theta_i: Table::new("/angles/theta_i"),
            labels: sonars
                .iter()
                .map(|sonar| Table::new(label_entity(sonar)))
                .collect(),
        }
    }

    /// Adds a decided frame.
    pub fn push<W: Write>(
        &mut self,
        held: &Held,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let at = held.moment;
        let decided = || {
            held.cells
                .iter()
                .filter_map(|cell| Some((cell.arc?, cell.verdict?)))
        };
        self.arcs.push(
            at,
            decided().map(|(arc, verdict)| ArcStrip {
                points: sweep(&arc),
                class: style::class(verdict.label),
                sonar: self
                    .names
                    .get(arc.id.sonar.index())
                    .cloned()
                    .unwrap_or_default(),
            }),
            lines,
            out,
        )?;
        self.beams.push(
            at,
            decided().map(|(arc, _)| {
                Beam([
                    xy(arc.center()),
                    xy(arc.point_at(arc.world_from_sensor.yaw)),
                ])
            }),
            lines,
            out,
        )?;
        let touches = |pick: fn(&Evidence) -> Vec<Vec2>| {
            decided()
                .filter_map(|(_, verdict)| verdict.evidence)
                .flat_map(move |evidence| pick(&evidence))
                .map(|point| Touch(xy(point)))
        };
        self.contact_points
            .push(at, touches(contact_points), lines, out)?;
        self.intersection_points
            .push(at, touches(intersection_points), lines, out)?;
        let angles = |pick: fn(&Evidence) -> f64| self.by_sonar(held, pick);
        let (theta_c, theta_i) = (angles(|e| e.theta_c), angles(|e| e.theta_i));
        self.theta_c.push(at, theta_c, lines, out)?;
        self.theta_i.push(at, theta_i, lines, out)?;
        for cell in &held.cells {
            if let Some(table) = self.labels.get_mut(cell.sonar.index()) {
                let state = cell
                    .verdict
                    .map(|verdict| State(style::name(verdict.label)));
                table.push(at, state, lines, out)?;
            }
        }
        Ok(())
    }

    /// One number per sonar; NaN, which plots as a gap, where the frame has no triple of it.
    fn by_sonar(&self, held: &Held, pick: fn(&Evidence) -> f64) -> Vec<Angle> {
        let mut row: Vec<Angle> = self.names.iter().map(|_| Angle(f64::NAN)).collect();
        for cell in &held.cells {
            let evidence = cell.verdict.and_then(|verdict| verdict.evidence);
            if let (Some(slot), Some(evidence)) = (row.get_mut(cell.sonar.index()), evidence) {
                *slot = Angle(rounded(pick(&evidence)));
            }
        }
        row
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
        self.intersection_points.flush(lines, out)?;
        self.theta_c.flush(lines, out)?;
        self.theta_i.flush(lines, out)?;
        for table in &mut self.labels {
            table.flush(lines, out)?;
        }
        Ok(())
    }
}

/// The arc as a strip, right edge to left.
pub fn sweep(arc: &Arc) -> Vec<[f32; 2]> {
    let steps = libm::ceil(arc.beam_width / ARC_STEP).clamp(4.0, 120.0) as u32;
    let right = arc.world_from_sensor.yaw - arc.beam_width / 2.0;
    (0..=steps)
        .map(|i| right + arc.beam_width * f64::from(i) / f64::from(steps))
        .map(|bearing| xy(arc.point_at(bearing)))
        .collect()
}

/// Where the common tangents with its neighbours touch the middle arc.
fn contact_points(evidence: &Evidence) -> Vec<Vec2> {
    on_middle(&evidence.before.contact, &evidence.after.contact)
}

/// Where its neighbours cross the middle arc.
fn intersection_points(evidence: &Evidence) -> Vec<Vec2> {
    on_middle(&evidence.before.intersection, &evidence.after.intersection)
}

fn on_middle(before: &[Option<PairPoint>], after: &[Option<PairPoint>]) -> Vec<Vec2> {
    let before = before.iter().flatten().map(|pair| pair.on_b);
    let after = after.iter().flatten().map(|pair| pair.on_a);
    before.chain(after).collect()
}

/// How the entities of [`ArcTables`] look.
pub fn put_styles<W: Write>(
    sonars: &[Sonar],
    gamma: f64,
    out: &mut RrdWriter<W>,
) -> Result<(), Error> {
    let strips = LineStrips2D::update_fields;
    put_static(
        "/world/arcs",
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

    let look = SeriesPoints::update_fields()
        .with_names(sonars.iter().map(|sonar| Name::from(sonar.name.as_str())))
        .with_colors(style::wheel(sonars.len()))
        .with_marker_sizes(vec![2.0; sonars.len()]);
    put_static("/angles/theta_c", &look, out)?;
    put_static("/angles/theta_i", &look, out)?;
    let look = SeriesLines::update_fields()
        .with_names([format!("gamma {:.1} deg", gamma.to_degrees())])
        .with_colors([style::BOUND])
        .with_widths([1.5]);
    put_static("/angles/gamma", &look, out)?;

    // Most lanes are grey most of the time: a word there would be noise.
    let look = StateConfiguration::new()
        .with_values(["contact", "intersection", "unidentified"])
        .with_labels(["contact", "intersection", "?"])
        .with_colors([style::CONTACT, style::INTERSECTION, style::UNIDENTIFIED]);
    for sonar in sonars {
        put_static(label_entity(sonar), &look, out)?;
    }
    Ok(())
}

/// gamma as a line over the whole run.
pub fn put_gamma<W: Write>(
    gamma: f64,
    ends: &[Moment],
    lines: Timelines,
    out: &mut RrdWriter<W>,
) -> Result<(), Error> {
    let mut table = Table::new("/angles/gamma");
    for end in ends {
        table.push(*end, [Angle(rounded(gamma))], lines, out)?;
    }
    table.flush(lines, out)
}
