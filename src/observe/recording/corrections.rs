//! What was corrected of the poses: the path of odometry beside the robot's, how far each pose was moved and
//! how sure it is, and the features that pulled the path straight. Nothing where poses are odometry's.

use std::collections::BTreeMap;

use rerun::components::TextLogLevel;
use rerun::{SeriesLines, TextDocument};

use super::canvas::{Canvas, LogLine, Moment, Shown, Strip};
use super::entity::Entity;
use super::map::ellipse;
use super::style;
use crate::core::frames::Frame;
use crate::core::geometry::{Vec2, wrap_angle};
use crate::core::rounding::fixed;
use crate::core::tmam::feature::Point;
use crate::core::tmam::step::Closure;
use crate::observe::viewer::Error;

/// The corrections so far.
#[derive(Default)]
pub struct Corrections {
    // Where odometry had the robot in the frame before, if that is shown.
    before: Option<Vec2>,
    // Where the robot was in the frames that are shown: closures are known at the end only.
    places: BTreeMap<u32, (Moment, Vec2)>,
}

impl Corrections {
    /// Whether any pose was corrected.
    pub fn are_there(&self) -> bool {
        !self.places.is_empty()
    }

    /// What was corrected in a frame.
    pub fn draw(
        &mut self,
        at: Moment,
        frame: &Frame,
        canvas: &mut Canvas<'_>,
    ) -> Result<(), Error> {
        let Some(correction) = &frame.correction else {
            return Ok(());
        };
        if !self.are_there() {
            put_styles(canvas)?;
        }
        let (used, odometry) = (frame.world_from_robot, correction.odom_from_robot);
        let [here, there] = [used, odometry].map(|pose| pose.position());
        self.places.insert(frame.index, (at, here));
        let origin = canvas.origin;
        let from = self.before.replace(there).unwrap_or(there);
        let leg = Strip::from(vec![origin.xy(from), origin.xy(there)]);
        canvas.row(Entity::OdometryPath, at, Shown::Strips(vec![leg]))?;

        let covariance = correction.covariance;
        let place = Point {
            position: here,
            covariance: covariance.fixed_view::<2, 2>(0, 0).into_owned(),
        };
        let outline = ellipse(&place).into_iter().map(|at| origin.xy(at));
        let outline = Strip::from(outline.collect::<Vec<_>>());
        canvas.row(Entity::PoseCovariance, at, Shown::Strips(vec![outline]))?;

        let sigma = (covariance.m11 + covariance.m22).max(0.0).sqrt();
        let moved = Shown::Numbers(vec![(here - there).norm(), sigma]);
        canvas.row(Entity::Moved, at, moved)?;
        let turned = [
            wrap_angle(used.yaw - odometry.yaw),
            covariance.m33.max(0.0).sqrt(),
        ];
        let turned = Shown::Numbers(turned.map(f64::to_degrees).to_vec());
        canvas.row(Entity::Turned, at, turned)
    }

    /// From this frame on the robot is nowhere, until it is drawn again.
    pub fn leave(&mut self, at: Moment, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        match self.before.take() {
            Some(_) => canvas.row(Entity::PoseCovariance, at, Shown::Strips(Vec::new())),
            None => Ok(()),
        }
    }

    /// Links what was seen again to where the robot was, from the frame on in which it saw it again.
    pub fn close_loops(&self, closures: &[Closure], canvas: &mut Canvas<'_>) -> Result<(), Error> {
        let mut by_frame = BTreeMap::<u32, Vec<&Closure>>::new();
        for closure in closures {
            let [a, b] = closure.frames;
            by_frame.entry(a.max(b)).or_default().push(closure);
        }
        for (later, closures) in by_frame {
            let Some((at, here)) = self.places.get(&later) else {
                continue;
            };
            let origin = canvas.origin;
            let links = closures.iter().map(|closure| {
                let [a, b] = closure.frames;
                let before = self.places.get(&a.min(b)).map(|(_, before)| *before);
                let way = before.into_iter().chain([closure.place, *here]);
                Strip::named(way.map(|at| origin.xy(at)).collect(), describe(closure))
            });
            canvas.row(Entity::Closures, *at, Shown::Strips(links.collect()))?;
            let messages = closures.iter().map(|closure| LogLine {
                text: format!("loop closed: {}", describe(closure)),
                level: TextLogLevel::INFO,
                color: style::CLOSURE,
            });
            canvas.row(Entity::ClosureLog, *at, Shown::Messages(messages.collect()))?;
        }
        Ok(())
    }
}

fn describe(closure: &Closure) -> String {
    let [a, b] = closure.frames;
    let [x, y] = [closure.place.x, closure.place.y].map(|place| fixed(place, 3));
    format!(
        "{} at x {x} m, y {y} m, seen from frame {} on, is the one seen from frame {} on",
        closure.kind.name(),
        a.max(b),
        a.min(b)
    )
}

/// How all of it looks, and how to read it.
fn put_styles(canvas: &mut Canvas<'_>) -> Result<(), Error> {
    for entity in [
        Entity::OdometryPath,
        Entity::PoseCovariance,
        Entity::Closures,
    ] {
        canvas.put_look(entity)?;
    }
    for (entity, name) in [(Entity::Moved, "moved"), (Entity::Turned, "turned")] {
        let look = SeriesLines::update_fields()
            .with_names([name, "sigma"])
            .with_colors([style::ROBOT, style::SIGMA])
            .with_widths([1.5, 1.5]);
        canvas.put_on(entity, &look)?;
    }
    let page = TextDocument::from_markdown(include_str!("corrections.md"));
    canvas.put("/about/poses", &page)
}
