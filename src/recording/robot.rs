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
use crate::event::Sonar;
use crate::geometry::{Pose2, Vec2, unit};

/// Radius of a robot whose sonars all sit in its middle, metres.
const DEFAULT_RADIUS: f64 = 0.15;

/// The pose in the recording's own frame; `None` where the robot is not shown.
struct Place(Option<Pose2>);

impl Instance for Place {
    fn columns(
        places: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        let translations = places.iter().map(|place| {
            let at = place.0.map_or_else(Vec2::zeros, |pose| pose.position());
            [at.x as f32, at.y as f32, 0.0]
        });
        // A quaternion that is no rotation is how a thing is said to be nowhere.
        let turns = places.iter().map(|place| {
            let half = place
                .0
                .map_or_else(Vec2::zeros, |pose| unit(pose.yaw / 2.0));
            Quaternion::from_xyzw([0.0, 0.0, half.y as f32, half.x as f32])
        });
        Ok(Transform3D::update_fields()
            .with_many_translation(translations)
            .with_many_quaternion(turns)
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
    place: Table<Place>,
    trajectory: Table<Leg>,
}

impl RobotTables {
    /// A robot that has not moved yet.
    pub fn new() -> Self {
        Self {
            before: None,
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
        let place = Pose2::new(local.x, local.y, pose.yaw);
        self.place.push(at, [Place(Some(place))], lines, out)?;
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
        self.place.push(at, [Place(None)], lines, out)
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.place.flush(lines, out)?;
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

/// The robot's outline: its circle, an arrow ahead, and a tick along every sonar's axis.
pub fn put_styles<W: Write>(sonars: &[Sonar], out: &mut RrdWriter<W>) -> Result<(), Error> {
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
    let strips: Vec<Vec<[f32; 2]>> = [circle, arrow]
        .into_iter()
        .chain(ticks)
        .map(|strip| strip.into_iter().map(|p| on_robot.xy(p)).collect())
        .collect();
    let radii = (0..strips.len()).map(|i| ui(if i < 2 { 2.0 } else { 1.0 }));
    put_static(
        "/world/robot/outline",
        &LineStrips2D::new(strips)
            .with_radii(radii)
            .with_colors([style::ROBOT])
            .with_draw_order(order::ROBOT),
        out,
    )?;
    put_static(
        "/world/trajectory",
        &LineStrips2D::update_fields()
            .with_radii([ui(1.0)])
            .with_colors([style::TRAJECTORY])
            .with_draw_order(order::TRAJECTORY),
        out,
    )
}
