//! A single sonar in the form of a scan: the same range in each ray of its beam, and nothing in all others
//! (ros-navigation/navigation2#5718).

use nalgebra::Isometry3;

use super::message::{Content, RangeMessage};

/// So many rays of one length side by side, and none beside them, are no scan of a room.
const RAYS: usize = 3;

/// The beam of a topic's only sonar, as far as its scans show one.
#[derive(Debug, Clone, Default)]
pub enum Cone {
    /// Nothing echoed yet.
    #[default]
    Unknown,
    /// Axis in the frame of the scan, and full angle, radians.
    One(Box<Isometry3<f64>>, f64),
    /// They are scans of many directions.
    None,
}

impl Cone {
    /// A scan as the one reading that it is, where it is one. Before the first echo of such a sonar shows its
    /// beam, its scans are nothing.
    pub fn narrowed<'m>(&mut self, content: Content<'m>) -> Content<'m> {
        let Content::Ranges(rays) = content else {
            return content;
        };
        let is_scan = rays.len() > RAYS && rays.iter().all(|ray| ray.element.is_some());
        if !is_scan {
            return Content::Ranges(rays);
        }
        if matches!(self, Self::Unknown) {
            *self = Self::of(&rays);
        }
        let found = rays
            .iter()
            .find(|ray| ray.range.is_finite())
            .or(rays.first());
        match (&self, found) {
            (Self::One(axis, width), Some(ray)) => Content::Ranges(vec![RangeMessage {
                element: None,
                frame_from_beam: **axis,
                beam_width: *width,
                delay_ns: 0,
                ..ray.clone()
            }]),
            _ => Content::Ranges(rays),
        }
    }

    fn of(rays: &[RangeMessage<'_>]) -> Self {
        let is_echo = |ray: &RangeMessage<'_>| ray.range.is_finite();
        let (Some(first), Some(last)) = (
            rays.iter().position(is_echo),
            rays.iter().rposition(is_echo),
        ) else {
            return Self::Unknown;
        };
        let inside = rays.get(first..=last).unwrap_or_default();
        let same =
            |ray: &RangeMessage<'_>| inside.first().is_some_and(|one| one.range == ray.range);
        let (Some(left), Some(right)) = (inside.first(), inside.last()) else {
            return Self::None;
        };
        if inside.len() < RAYS || inside.len() == rays.len() || !inside.iter().all(same) {
            return Self::None;
        }
        let [left, right] = [left, right].map(|ray| ray.frame_from_beam);
        let axis = left.lerp_slerp(&right, 0.5);
        let step = inside.first().map_or(0.0, |ray| ray.likely_beam_width);
        Self::One(Box::new(axis), step * inside.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::types::read_json;

    fn scan(ranges: &str) -> Content<'static> {
        let text = format!(
            r#"{{"header":{{"stamp":{{"sec":1,"nanosec":0}},"frame_id":"f"}},"angle_min":-1,"angle_max":1,
            "angle_increment":0.25,"time_increment":0,"range_min":0.1,"range_max":4,"ranges":{ranges}}}"#
        );
        read_json("sensor_msgs/LaserScan", &text).unwrap()
    }

    fn beams(cone: &mut Cone, ranges: &str) -> Vec<RangeMessage<'static>> {
        match cone.narrowed(scan(ranges)) {
            Content::Ranges(beams) => beams,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn one_sonar_spread_over_a_scan_is_one_sonar() {
        let mut cone = Cone::default();
        let first = beams(&mut cone, "[null,null,null,null,2,2,2,null,null]");
        let later = beams(&mut cone, "[null,null,null,null,null,null,null,null,null]");
        for (beams, range) in [(first, 2.0), (later, f64::INFINITY)] {
            let [one] = beams.as_slice() else {
                panic!("{beams:?}")
            };
            assert_eq!((one.range, one.element), (range, None));
            assert!((one.beam_width - 0.75).abs() < 1e-12);
            let bearing = one.frame_from_beam.rotation.euler_angles().2;
            assert!((bearing - 0.25).abs() < 1e-12, "{bearing}");
        }
    }

    #[test]
    fn a_ring_that_looks_at_many_things_stays_a_ring() {
        for ranges in [
            "[null,1,2,3,4,5,6,null,null]",
            "[2,2,2,2,2,2,2,2,2]",
            "[null,2,2,null]",
        ] {
            let mut cone = Cone::default();
            assert!(beams(&mut cone, ranges).len() > 1, "{ranges}");
            assert!(
                beams(&mut cone, "[null,null,2,2,2,null,null,null]").len() > 1,
                "{ranges}"
            );
        }
    }
}
