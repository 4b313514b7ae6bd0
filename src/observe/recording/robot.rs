//! The robot: where it is, where it looks, where it has been.

use std::f64::consts::TAU;
use std::io::Write;

use rerun::datatypes::Quaternion;
use rerun::{LineStrips2D, SerializationResult, SerializedComponentColumn, Transform3D};

use super::Error;
use super::encode::RrdWriter;
use super::origin::Origin;
use super::style::{self, order, ui};
use super::table::{Instance, Moment, Table, Timelines, put_static};
use crate::core::event::Sonar;
use crate::core::geometry::{Pose2, Vec2, unit};

/// Radius of a robot whose sonars all sit in its middle, metres.
const DEFAULT_RADIUS: f64 = 0.15;

/// The pose in the recording's own frame.
struct Place(Pose2);

impl Instance for Place {
    fn columns(
        places: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        let translations = places.iter().map(|place| {
            let at = place.0.position();
            [at.x as f32, at.y as f32, 0.0]
        });
        let turns = places.iter().map(|place| {
            let half = unit(place.0.yaw / 2.0);
            Quaternion::from_xyzw([0.0, 0.0, half.y as f32, half.x as f32])
        });
        Ok(Transform3D::update_fields()
            .with_many_translation(translations)
            .with_many_quaternion(turns)
            .columns(lengths.iter().copied())?
            .collect())
    }
}

type Strip = Vec<[f32; 2]>;

/// A strip of the outline, in the robot's frame.
struct Stroke(Strip);

impl Instance for Stroke {
    fn columns(
        strokes: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(LineStrips2D::update_fields()
            .with_strips(strokes.into_iter().map(|stroke| stroke.0))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

struct Leg([[f32; 2]; 2]);

impl Instance for Leg {
    fn columns(
        legs: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(LineStrips2D::update_fields()
            .with_strips(legs.iter().map(|leg| leg.0))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

/// The robot's pose and its path, a leg per frame: the view shows all legs up to the cursor.
pub struct RobotTables {
    before: Option<Vec2>,
    // Whether the outline that comes and goes is there.
    shown: bool,
    outline_on_robot: Vec<Strip>,
    outline: Table<Stroke>,
    place: Table<Place>,
    trajectory: Table<Leg>,
}

impl RobotTables {
    /// A robot that has not moved yet. Its outline `comes_and_goes` where not every frame is shown.
    pub fn new(sonars: &[Sonar], comes_and_goes: bool) -> Self {
        Self {
            before: None,
            shown: !comes_and_goes,
            outline_on_robot: outline(sonars),
            outline: Table::new(OUTLINE),
            place: Table::new("/world/robot"),
            trajectory: Table::new("/world/trajectory"),
        }
    }

    /// The robot at a frame.
    pub fn push<W: Write>(
        &mut self,
        at: Moment,
        pose: Pose2,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let origin = out.origin();
        let here = pose.position();
        let local = origin.local(here);
        let place = Place(Pose2::new(local.x, local.y, pose.yaw));
        self.place.push(at, [place], lines, out)?;
        if !std::mem::replace(&mut self.shown, true) {
            let strokes = self.outline_on_robot.iter().cloned().map(Stroke);
            self.outline.push(at, strokes, lines, out)?;
        }
        let from = self.before.replace(here).unwrap_or(here);
        self.trajectory
            .push(at, [Leg([from, here].map(|p| origin.xy(p)))], lines, out)
    }

    /// From this frame on the robot is nowhere, until it is pushed again; its path has a gap there.
    pub fn leave<W: Write>(
        &mut self,
        at: Moment,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.before = None;
        self.shown = false;
        self.outline.push(at, [], lines, out)
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.place.flush(lines, out)?;
        self.outline.flush(lines, out)?;
        self.trajectory.flush(lines, out)
    }
}

/// How far the outermost sonar sits from the robot's middle.
pub fn radius(sonars: &[Sonar]) -> f64 {
    let out = sonars
        .iter()
        .map(|sonar| sonar.robot_from_sensor.position().norm())
        .fold(0.0, f64::max);
    if out > 0.0 { out } else { DEFAULT_RADIUS }
}

const OUTLINE: &str = "/world/robot/outline";

/// The robot's outline: its circle, an arrow ahead, and a tick along every sonar's axis.
fn outline(sonars: &[Sonar]) -> Vec<Strip> {
    const STEPS: u32 = 48;
    let radius = radius(sonars);
    let circle: Vec<Vec2> = (0..=STEPS)
        .map(|i| unit(TAU * f64::from(i % STEPS) / f64::from(STEPS)) * radius)
        .collect();
    let tip = Vec2::new(1.9 * radius, 0.0);
    let arrow = vec![
        Vec2::new(0.0, 0.0),
        tip,
        tip + Vec2::new(-0.5, 0.35) * radius,
        tip,
        tip + Vec2::new(-0.5, -0.35) * radius,
    ];
    let ticks = sonars.iter().map(|sonar| {
        let mount = sonar.robot_from_sensor;
        let from = mount.position();
        vec![from, from + unit(mount.yaw) * (0.35 * radius)]
    });
    let on_robot = Origin::default();
    [circle, arrow]
        .into_iter()
        .chain(ticks)
        .map(|strip| strip.into_iter().map(|p| on_robot.xy(p)).collect())
        .collect()
}

/// How the robot looks; with its outline, unless that comes and goes.
pub fn put_styles<W: Write>(
    sonars: &[Sonar],
    comes_and_goes: bool,
    out: &mut RrdWriter<W>,
) -> Result<(), Error> {
    let strips = outline(sonars);
    let radii = (0..strips.len()).map(|i| ui(if i < 2 { 2.0 } else { 1.0 }));
    let look = LineStrips2D::update_fields()
        .with_radii(radii)
        .with_colors([style::ROBOT])
        .with_draw_order(order::ROBOT);
    // What holds at all times would hide what does not.
    let look = if comes_and_goes {
        look
    } else {
        look.with_strips(strips)
    };
    put_static(OUTLINE, &look, out)?;
    put_static(
        "/world/trajectory",
        &LineStrips2D::update_fields()
            .with_radii([ui(1.0)])
            .with_colors([style::TRAJECTORY])
            .with_draw_order(order::TRAJECTORY),
        out,
    )
}
