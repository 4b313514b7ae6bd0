//! Where a recording has its origin.
//!
//! It holds places as 32-bit floats, seven digits: a millimetre only up to some ten kilometres. Odometry in
//! map coordinates starts farther out, so there the recording counts from where the robot started.

use crate::core::geometry::Vec2;
use crate::core::tmam::arc::Arc;

/// From here on a recording has an origin of its own, metres from the world's.
const FAR: f64 = 1e4;
/// And beyond this there is no place, metres.
const FARTHEST: f64 = 1e12;
/// Widest step along an arc, radians: a chord strays 2 mm from an arc 5 m away.
const ARC_STEP: f64 = 0.06;

/// Where the recording's origin is in the world, metres.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Origin(Vec2);

impl Origin {
    /// For a robot that starts at `start`: the world's own origin if that is near, or else the
    /// start to the metre.
    pub fn of(start: Vec2) -> Self {
        let is_far = start.norm() > FAR && start.amax() < FARTHEST;
        Self(if is_far {
            start.map(libm::rint)
        } else {
            Vec2::zeros()
        })
    }

    /// Where it is in the world, unless it is the world's.
    pub fn shift(self) -> Option<Vec2> {
        (self != Self::default()).then_some(self.0)
    }

    /// A place in the world as seen from here.
    pub fn local(self, place: Vec2) -> Vec2 {
        place - self.0
    }

    /// The same as the viewer stores it.
    pub fn xy(self, place: Vec2) -> [f32; 2] {
        let local = self.local(place);
        [local.x as f32, local.y as f32]
    }

    /// An arc as a strip, right edge to left.
    pub fn sweep(self, arc: &Arc) -> Vec<[f32; 2]> {
        let steps = libm::ceil(arc.beam_width / ARC_STEP).clamp(4.0, 120.0) as u32;
        let right = arc.world_from_sensor.yaw - arc.beam_width / 2.0;
        (0..=steps)
            .map(|i| right + arc.beam_width * f64::from(i) / f64::from(steps))
            .map(|bearing| self.xy(arc.point_at(bearing)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn millimetres_are_drawn_wherever_the_robot_starts() {
        let near = Origin::of(Vec2::new(3.0, -4.0));
        assert_eq!(
            (near.shift(), near.xy(Vec2::new(1.5, 2.0))),
            (None, [1.5, 2.0])
        );
        let start = Vec2::new(691_234.567, 5_334_321.002);
        let far = Origin::of(start);
        assert_eq!(far.shift(), Some(Vec2::new(691_235.0, 5_334_321.0)));
        let [x, y] = far.xy(start + Vec2::new(0.001, 0.0));
        assert!(
            (x - -0.432).abs() < 1e-6 && (y - 0.002).abs() < 1e-6,
            "{x} {y}"
        );
    }

    #[test]
    fn a_start_that_is_no_place_changes_nothing() {
        for x in [f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(Origin::of(Vec2::new(x, 0.0)).shift(), None, "{x}");
        }
    }
}
