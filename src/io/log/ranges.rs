//! Messages that hold ranges: one sonar's, or those of a ring; and point clouds, where the beams of a ring ended.

use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::Range;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::message::{Content, HitsMessage, MOST_SONARS, NO_TURN, RangeMessage, norm};
use super::poses::{as_written, foxglove_isometry, turn_of};
use super::value::{Field, FieldError, Fields, Value};

/// `sensor_msgs/Range` in both its forms: Humble's has no `variance`.
pub fn range<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    const INFRARED: f64 = 1.0;
    let [
        stamp,
        frame,
        range,
        min_range,
        max_range,
        width,
        variance,
        radiation,
    ] = fields.all();
    Ok(Content::Ranges(vec![RangeMessage {
        infrared: radiation.value.as_number() == Some(INFRARED),
        min_range: min_range.number()?,
        max_range: max_range.distance()?,
        beam_width: width.number()?,
        // Humble's has none.
        variance: variance.value.as_number().unwrap_or(0.0),
        ..RangeMessage::plain(stamp.time()?, frame.frame()?, range.distance()?)
    }]))
}

/// `sensor_msgs/LaserScan` as a ring of sonars.
pub fn laser_scan<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let [
        stamp,
        frame,
        ranges,
        start,
        end,
        step,
        delay,
        min_range,
        max_range,
    ] = fields.all();
    let scan = Scan {
        stamp_ns: stamp.time()?,
        frame_id: frame.frame()?,
        frame_from_scan: Isometry3::identity(),
        start: start.finite()?,
        end: end.finite()?,
        increment: step.finite()?,
        time_increment: delay.number()?,
        min_range: min_range.number()?,
        max_range: max_range.distance()?,
        ranges: ranges.distances()?,
    };
    Ok(scan.content())
}

/// `foxglove.LaserScan` as a ring of sonars; it knows no limits of range.
pub fn foxglove_scan<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let [stamp, frame, ranges, start, end, is_there, pose @ ..] = fields.all::<13>();
    let frame_from_scan = if is_there.is_there() {
        let is_turn = as_written(turn_of(&pose)).is_none_or(|turn| norm(turn) > NO_TURN);
        let pose = foxglove_isometry(&pose)?.filter(|_| is_turn);
        let expected = "a finite pose with a quaternion that is not zero";
        pose.ok_or_else(|| is_there.missing(expected))?
    } else {
        Isometry3::identity()
    };
    let scan = Scan {
        stamp_ns: stamp.time_or_zero()?,
        frame_id: frame.frame()?,
        frame_from_scan,
        start: start.finite()?,
        end: end.finite()?,
        increment: 0.0,
        time_increment: 0.0,
        min_range: 0.0,
        max_range: f64::INFINITY,
        ranges: ranges.distances()?,
    };
    Ok(scan.content())
}

/// Ranges at bearings that are evenly apart. Radians, metres, seconds.
struct Scan<'m> {
    stamp_ns: i64,
    frame_id: Cow<'m, str>,
    /// Bearings count from its x axis, about its z axis.
    frame_from_scan: Isometry3<f64>,
    start: f64,
    end: f64,
    /// 0 where only the ends are known.
    increment: f64,
    time_increment: f64,
    min_range: f64,
    max_range: f64,
    ranges: Vec<f64>,
}

/// A scan of more than a turn, radians, is one in degrees.
const MORE_THAN_A_TURN: f64 = 1.1 * TAU;

impl<'m> Scan<'m> {
    fn content(mut self) -> Content<'m> {
        if self.ranges.len() > MOST_SONARS {
            return Content::Crowd(self.ranges.len());
        }
        let in_degrees = (self.end - self.start).abs() > MORE_THAN_A_TURN;
        if in_degrees {
            let angles = [&mut self.start, &mut self.end, &mut self.increment];
            angles
                .into_iter()
                .for_each(|angle| *angle = angle.to_radians());
        }
        let mut beams = self.beams();
        beams
            .iter_mut()
            .for_each(|beam| beam.in_degrees = in_degrees);
        Content::Ranges(beams)
    }

    fn beams(&self) -> Vec<RangeMessage<'m>> {
        if let [range] = self.ranges.as_slice() {
            // One sonar, as wide as the scan.
            let middle = (self.start + self.end) / 2.0;
            return vec![RangeMessage {
                beam_width: (self.end - self.start).abs(),
                ..self.beam(middle, *range)
            }];
        }
        let steps = self.ranges.len().saturating_sub(1) as f64;
        let increment = match self.increment {
            0.0 => (self.end - self.start) / steps,
            increment => increment,
        };
        let ranges = self.ranges.iter().enumerate();
        ranges
            .map(|(i, range)| RangeMessage {
                delay_ns: delay_ns(self.time_increment * i as f64),
                element: Some(i),
                likely_beam_width: increment.abs(),
                ..self.beam(self.start + i as f64 * increment, *range)
            })
            .collect()
    }

    fn beam(&self, bearing: f64, range: f64) -> RangeMessage<'m> {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), bearing);
        RangeMessage {
            frame_from_beam: self.frame_from_scan
                * Isometry3::from_parts(Translation3::identity(), turn),
            min_range: self.min_range,
            max_range: self.max_range,
            likely_beam_width: self.increment.abs(),
            ..RangeMessage::plain(self.stamp_ns, self.frame_id.clone(), range)
        }
    }
}

/// Nanoseconds of a delay in seconds; none where it is negative or no number.
fn delay_ns(seconds: f64) -> i64 {
    if seconds > 0.0 {
        libm::round(seconds * 1e9) as i64
    } else {
        0
    }
}

/// `sensor_msgs/PointCloud`.
pub fn point_cloud<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let [stamp, frame, x, y, z] = fields.all();
    let count = x.count().ok_or_else(|| x.missing("a list"))?;
    let point = |i| {
        Ok(Point3::new(
            x.at(i).number()?,
            y.at(i).number()?,
            z.at(i).number()?,
        ))
    };
    hits(&stamp, &frame, count, || (0..count).map(point).collect())
}

/// `sensor_msgs/PointCloud2` with coordinates of 32 or 64 bits.
pub fn point_cloud_2<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let [stamp, frame, names, offsets, kinds, big_endian, step, data] = fields.all();
    let big_endian = big_endian.number()? != 0.0;
    let layout = ["x", "y", "z"].map(|name| {
        let field = (0..names.count()?).find(|i| names.at(*i).text() == Ok(name))?;
        let offset = usize::try_from(offsets.at(field).value.as_integer()?).ok()?;
        let length = match kinds.at(field).value.as_integer()? {
            7 => 4,
            8 => 8,
            _ => return None,
        };
        Some(offset..offset.checked_add(length)?)
    });
    let [Some(x), Some(y), Some(z)] = layout else {
        return Err(names.missing("x, y and z as floating-point numbers"));
    };
    let length = step.number()? as usize;
    if length == 0 {
        return Err(step.missing("a length above 0"));
    }
    let bytes = match &*data.value {
        Value::Bytes(bytes) => bytes.to_vec(),
        Value::Numbers(bytes) => bytes.iter().map(|byte| *byte as u8).collect(),
        _ => return Err(data.missing("bytes")),
    };
    hits(&stamp, &frame, bytes.len() / length, || {
        let points = bytes.chunks_exact(length).map(|point| {
            let at = |place: &Range<usize>| number(point.get(place.clone())?, big_endian);
            Some(Point3::new(at(&x)?, at(&y)?, at(&z)?))
        });
        let points: Option<Vec<_>> = points.collect();
        points.ok_or_else(|| data.missing("points as its fields say"))
    })
}

fn number(bytes: &[u8], big_endian: bool) -> Option<f64> {
    let mut bytes = bytes.to_vec();
    if big_endian {
        bytes.reverse();
    }
    match bytes.len() {
        4 => Some(f32::from_le_bytes(bytes.try_into().ok()?).into()),
        _ => Some(f64::from_le_bytes(bytes.try_into().ok()?)),
    }
}

/// A cloud, whose points are only read where there are no more of them than sonars can be told apart.
fn hits<'m>(
    stamp: &Field<'_, 'm>,
    frame: &Field<'_, 'm>,
    count: usize,
    points: impl FnOnce() -> Result<Vec<Point3<f64>>, FieldError>,
) -> Result<Content<'m>, FieldError> {
    if count > MOST_SONARS {
        return Ok(Content::Crowd(count));
    }
    Ok(Content::Hits(HitsMessage {
        stamp_ns: stamp.time()?,
        frame_id: frame.frame()?.into_owned(),
        points: points()?,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::types::read_json;

    const ROS: &str = "sensor_msgs/LaserScan";
    const FOXGLOVE: &str = "foxglove.LaserScan";

    fn beams(name: &str, text: &str) -> Vec<RangeMessage<'static>> {
        match read_json(name, text).unwrap() {
            Content::Ranges(beams) => beams,
            other => panic!("{other:?}"),
        }
    }

    fn bearing(beam: &RangeMessage<'_>) -> f64 {
        beam.frame_from_beam.rotation.euler_angles().2
    }

    const SCAN: &str = r#"{"header":{"stamp":{"sec":1,"nanosec":0},"frame_id":"/ring"},
        "angle_min":-1,"angle_max":1,"angle_increment":0.5,"time_increment":0.01,"scan_time":0,
        "range_min":0.1,"range_max":4,"ranges":[1,2,null,4,5],"intensities":[]}"#;

    #[test]
    fn a_scan_is_a_ring_of_sonars() {
        let beams = beams(ROS, SCAN);
        assert_eq!(beams.len(), 5);
        assert_eq!(beams[3].element, Some(3));
        assert!((bearing(&beams[3]) - 0.5).abs() < 1e-12);
        assert_eq!(beams[3].delay_ns, 30_000_000);
        assert_eq!((beams[3].min_range, beams[3].max_range), (0.1, 4.0));
        assert_eq!(
            (beams[3].beam_width, beams[3].likely_beam_width),
            (0.0, 0.5)
        );
        assert_eq!(beams[2].range, f64::INFINITY);
        assert_eq!(beams[0].frame_id, "ring");
    }

    #[test]
    fn a_scan_with_one_range_is_one_sonar_in_the_middle() {
        let one = SCAN.replace("[1,2,null,4,5]", "[2]").replace("-1", "0.4");
        let beams = beams(ROS, &one);
        assert_eq!(beams.len(), 1);
        assert_eq!(beams[0].element, None);
        assert!((bearing(&beams[0]) - 0.7).abs() < 1e-12);
        assert!((beams[0].beam_width - 0.6).abs() < 1e-12);
    }

    #[test]
    fn a_scan_of_many_turns_is_one_in_degrees() {
        let degrees = SCAN
            .replace(
                "\"angle_min\":-1,\"angle_max\":1",
                "\"angle_min\":-60,\"angle_max\":60",
            )
            .replace("\"angle_increment\":0.5", "\"angle_increment\":30");
        let of_degrees = beams(ROS, &degrees);
        assert!(of_degrees.iter().all(|beam| beam.in_degrees));
        assert!((bearing(&of_degrees[3]) - 30.0_f64.to_radians()).abs() < 1e-12);
        assert!((of_degrees[0].likely_beam_width - 30.0_f64.to_radians()).abs() < 1e-12);
        let whole_turn = SCAN.replace(
            "\"angle_min\":-1,\"angle_max\":1",
            "\"angle_min\":0,\"angle_max\":6.29",
        );
        assert!(beams(ROS, &whole_turn).iter().all(|beam| !beam.in_degrees));
    }

    #[test]
    fn a_crowd_of_ranges_is_only_counted() {
        let many = SCAN.replace(
            "[1,2,null,4,5]",
            &format!("[0{}]", ",1".repeat(MOST_SONARS)),
        );
        let content = read_json(ROS, &many).unwrap();
        assert_eq!(content, Content::Crowd(MOST_SONARS + 1));
        assert_eq!(content.sonars(), MOST_SONARS + 1);
    }

    #[test]
    fn foxgloves_scan_has_a_pose_and_ends() {
        let text = r#"{"timestamp":{"sec":1,"nsec":5},"frame_id":"base_link",
            "pose":{"position":{"x":0.5,"y":0,"z":0},"orientation":{"x":0,"y":0,"z":1,"w":0}},
            "start_angle":0,"end_angle":1,"ranges":[1,2,3],"intensities":[]}"#;
        let found = beams(FOXGLOVE, text);
        assert_eq!(found[1].stamp_ns, 1_000_000_005);
        assert!((bearing(&found[1]) - (0.5 - std::f64::consts::PI)).abs() < 1e-12);
        assert_eq!(found[1].frame_from_beam.translation.x, 0.5);
        assert_eq!(
            (found[1].likely_beam_width, found[1].max_range),
            (0.5, f64::INFINITY)
        );
        let without_pose = text.replace("\"pose\"", "\"other\"");
        assert!((bearing(&beams(FOXGLOVE, &without_pose)[1]) - 0.5).abs() < 1e-12);
        let zero = text.replace("\"z\":1,\"w\":0", "\"z\":0,\"w\":0");
        assert!(read_json(FOXGLOVE, &zero).is_err());
    }

    const ONE: &str = "sensor_msgs/PointCloud";
    const TWO: &str = "sensor_msgs/PointCloud2";

    fn points(name: &str, text: &str) -> Vec<Point3<f64>> {
        match read_json(name, text).unwrap() {
            Content::Hits(hits) => hits.points,
            other => panic!("{other:?}"),
        }
    }

    const HEADER: &str = r#""header":{"stamp":{"sec":1,"nanosec":0},"frame_id":"base"}"#;

    #[test]
    fn both_kinds_of_cloud_hold_points() {
        let one = format!(r#"{{{HEADER},"points":[{{"x":1,"y":2,"z":0}}],"channels":[]}}"#);
        assert_eq!(points(ONE, &one), [Point3::new(1.0, 2.0, 0.0)]);

        let data: Vec<u8> = [1.5_f32, 2.0, 0.0, 9.0].map(f32::to_be_bytes).concat();
        let two = format!(
            r#"{{{HEADER},"height":1,"width":1,"is_bigendian":true,"point_step":16,"row_step":16,
            "fields":[{{"name":"x","offset":0,"datatype":7,"count":1}},
            {{"name":"y","offset":4,"datatype":7,"count":1}},
            {{"name":"z","offset":8,"datatype":7,"count":1}}],"data":{data:?}}}"#
        );
        assert_eq!(points(TWO, &two), [Point3::new(1.5, 2.0, 0.0)]);
        for (from, to) in [
            ("\"point_step\":16", "\"point_step\":0"),
            ("\"point_step\":16", "\"point_step\":8"),
            ("\"offset\":8", "\"offset\":-1"),
            ("\"datatype\":7", "\"datatype\":2"),
        ] {
            assert!(read_json(TWO, &two.replace(from, to)).is_err(), "{to}");
        }
    }
}
