//! The robot: where it is, where it looks, where it has been.

use std::f64::consts::TAU;

use rerun::{LineStrips2D, Points2D};

use super::canvas::{Canvas, Dot, Moment, Shown, Strip};
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
            let names = Shown::Dots(names(&canvas.sonars));
            canvas.row(Entity::SonarNames, at, names)?;
        }
        let from = self.before.replace(here).unwrap_or(here);
        let leg = Strip::from(vec![origin.xy(from), origin.xy(here)]);
        canvas.row(Entity::Trajectory, at, Shown::Strips(vec![leg]))
    }

    /// From this frame on the robot is nowhere, until it is drawn again; its path has a gap there.
    pub fn leave(&mut self, at: Moment, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        self.before = None;
        self.shown = false;
        canvas.row(Entity::Outline, at, Shown::Strips(Vec::new()))?;
        canvas.row(Entity::SonarNames, at, Shown::Dots(Vec::new()))
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

/// The names of the sonars round the robot, in the colours of their echoes; without what all of them begin
/// with.
fn names(sonars: &[Sonar]) -> Vec<Dot> {
    let radius = radius(sonars);
    let names: Vec<&str> = sonars.iter().map(|sonar| sonar.name.as_str()).collect();
    let common = common_start(&names);
    let named = sonars.iter().zip(style::wheel(sonars.len()));
    let named = named.map(|(sonar, color)| {
        let mount = sonar.robot_from_sensor;
        let at = mount.position() + unit(mount.yaw) * (1.4 * radius);
        let name = sonar.name.get(common..).unwrap_or_default().to_owned();
        Dot {
            color: Some(color),
            ..Dot::named(PlaneOrigin::default().xy(at), name)
        }
    });
    named.collect()
}

/// How many bytes all of several names begin with, up to a sign that parts words.
fn common_start(names: &[&str]) -> usize {
    let [first, others @ ..] = names else {
        return 0;
    };
    if others.is_empty() {
        return 0;
    }
    let parts = first.char_indices().filter(|(_, c)| !c.is_alphanumeric());
    let ends = parts.map(|(at, c)| at + c.len_utf8());
    let is_common = |end: &usize| {
        let start = first.get(..*end).unwrap_or_default();
        others.iter().all(|other| other.starts_with(start))
    };
    ends.take_while(is_common).last().unwrap_or(0)
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
    let names = names(&canvas.sonars);
    let dots = Points2D::update_fields();
    let dots = if comes_and_goes {
        dots
    } else {
        dots.with_positions(names.iter().map(|name| name.at))
            .with_colors(names.iter().filter_map(|name| name.color))
            .with_labels(names.iter().map(|name| name.name.as_str()))
    };
    if let Some(look) = Entity::SonarNames.look() {
        canvas.put_on(Entity::SonarNames, &look.of_dots(dots))?;
    }
    canvas.put_look(Entity::Trajectory)
}
