//! Point clouds: where the beams of a sonar ring ended.

use std::ops::Range;

use nalgebra::Point3;

use super::message::{Content, HitsMessage, MOST_SONARS};
use super::value::{Field, FieldError, Fields, Value};

/// `sensor_msgs/PointCloud`.
pub fn point_cloud(fields: &Fields<'_>) -> Result<Content, FieldError> {
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
pub fn point_cloud_2(fields: &Fields<'_>) -> Result<Content, FieldError> {
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
fn hits(
    stamp: &Field<'_>,
    frame: &Field<'_>,
    count: usize,
    points: impl FnOnce() -> Result<Vec<Point3<f64>>, FieldError>,
) -> Result<Content, FieldError> {
    if count > MOST_SONARS {
        return Ok(Content::Crowd(count));
    }
    Ok(Content::Hits(HitsMessage {
        stamp_ns: stamp.time()?,
        frame_id: frame.frame()?,
        points: points()?,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::types::read_json;

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
