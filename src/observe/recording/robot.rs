//! The robot: where it is, where it looks, where it has been.

use std::f64::consts::TAU;

use rerun::LineStrips2D;

use super::canvas::{Canvas, Moment, Shown, Strip};
use super::entity::{Entity, ui};
use super::plane::PlaneOrigin;
use super::style;
use crate::core::event::Sonar;
use crate::core::geometry::{Pose2, Vec2, unit};
use crate::observe::viewer::Error;

/// Radius of a robot whose sonars all sit in its middle, metres.
const DEFAULT_RADIUS: f64 = 0.15;

/// The robot and its path, a leg per frame: the view shows all legs up to the cursor.
pub struct Robot {
    before: Option<Vec2>,
    // Whether the outline is there.
    shown: bool,
}

impl Robot {
    /// A robot that has not moved yet. Its outline `comes_and_goes` where not every frame is shown.
    pub fn new(comes_and_goes: bool) -> Self {
        Self {
            before: None,
            shown: !comes_and_goes,
        }
    }

    /// The robot at a frame.
    pub fn draw(&mut self, at: Moment, pose: Pose2, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        let (origin, here) = (canvas.origin, pose.position());
        let local = origin.local(here);
        let place = Pose2::new(local.x, local.y, pose.yaw);
        canvas.row(Entity::Robot, at, Shown::Poses(vec![place]))?;
        if !std::mem::replace(&mut self.shown, true) {
            let strokes = outline(&canvas.sonars).into_iter().map(Strip::from);
            let strokes = Shown::Strips(strokes.collect());
            canvas.row(Entity::Outline, at, strokes)?;
        }
        let from = self.before.replace(here).unwrap_or(here);
        let leg = Strip::from(vec![origin.xy(from), origin.xy(here)]);
        canvas.row(Entity::Trajectory, at, Shown::Strips(vec![leg]))
    }

    /// From this frame on the robot is nowhere, until it is drawn again; its path has a gap there.
    pub fn leave(&mut self, at: Moment, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        self.before = None;
        self.shown = false;
        canvas.row(Entity::Outline, at, Shown::Strips(Vec::new()))
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
fn outline(sonars: &[Sonar]) -> Vec<Vec<[f32; 2]>> {
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
    let on_robot = PlaneOrigin::default();
    [circle, arrow]
        .into_iter()
        .chain(ticks)
        .map(|strip| strip.into_iter().map(|p| on_robot.xy(p)).collect())
        .collect()
}

/// How the robot looks; with its outline, unless that comes and goes.
pub fn put_styles(comes_and_goes: bool, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let strips = outline(&canvas.sonars);
    let radii = (0..strips.len()).map(|i| ui(if i < 2 { 2.0 } else { 1.0 }));
    let look = LineStrips2D::update_fields()
        .with_radii(radii)
        .with_colors([style::ROBOT])
        .with_draw_order(10.0);
    // What holds at all times would hide what does not.
    let look = if comes_and_goes {
        look
    } else {
        look.with_strips(strips)
    };
    canvas.put_on(Entity::Outline, &look)?;
    canvas.put_look(Entity::Trajectory)
}
