//! Point clouds: where the beams of a sonar ring ended.

use nalgebra::Point3;

use super::{Content, HitsMessage, frame};
use crate::io::log::value::{FieldError, Value, missing};

/// `sensor_msgs/PointCloud`.
pub fn point_cloud(message: &Value) -> Result<Content, FieldError> {
    let point = |point: &Value| {
        Ok(Point3::new(
            point.number("x")?,
            point.number("y")?,
            point.number("z")?,
        ))
    };
    let points = message.list("points")?.iter().map(point);
    hits(message, points.collect::<Result<_, _>>()?)
}

/// `sensor_msgs/PointCloud2` with coordinates of 32 or 64 bits.
pub fn point_cloud_2(message: &Value) -> Result<Content, FieldError> {
    let big_endian = message.number("is_bigendian")? != 0.0;
    let bytes: Vec<u8> = match message.get("data") {
        Some(Value::Numbers(bytes)) => bytes.iter().map(|b| *b as u8).collect(),
        _ => return Err(missing("data", "bytes")),
    };
    let fields = message.list("fields")?;
    let layout = ["x", "y", "z"].map(|name| {
        let field = fields.iter().find(|f| f.text("name") == Ok(name))?;
        let offset = usize::try_from(field.get("offset")?.as_integer()?).ok()?;
        let length = match field.get("datatype")?.as_integer()? {
            7 => 4,
            8 => 8,
            _ => return None,
        };
        Some(offset..offset.checked_add(length)?)
    });
    let [Some(x), Some(y), Some(z)] = layout else {
        return Err(missing("fields", "x, y and z as floating-point numbers"));
    };
    let step = message.number("point_step")? as usize;
    if step == 0 {
        return Err(missing("point_step", "a length above 0"));
    }
    let points = bytes.chunks_exact(step).map(|point| {
        let coordinate = |place: &std::ops::Range<usize>| {
            let bytes = point.get(place.clone())?;
            number(bytes, big_endian)
        };
        Some(Point3::new(
            coordinate(&x)?,
            coordinate(&y)?,
            coordinate(&z)?,
        ))
    });
    let points: Option<Vec<_>> = points.collect();
    hits(
        message,
        points.ok_or_else(|| missing("data", "points as its fields say"))?,
    )
}

fn number(bytes: &[u8], big_endian: bool) -> Option<f64> {
    let ordered = || -> Vec<u8> {
        if big_endian {
            bytes.iter().rev().copied().collect()
        } else {
            bytes.to_vec()
        }
    };
    if bytes.len() == 4 {
        Some(f32::from_le_bytes(ordered().try_into().ok()?).into())
    } else {
        Some(f64::from_le_bytes(ordered().try_into().ok()?))
    }
}

fn hits(message: &Value, points: Vec<Point3<f64>>) -> Result<Content, FieldError> {
    Ok(Content::Hits(HitsMessage {
        stamp_ns: message.time("header.stamp")?,
        frame_id: frame(message, "header.frame_id")?,
        points,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::json;

    fn points(read: super::super::Read, text: &str) -> Vec<Point3<f64>> {
        match read(&json::decode(text.as_bytes()).unwrap()).unwrap() {
            Content::Hits(hits) => hits.points,
            other => panic!("{other:?}"),
        }
    }

    const HEADER: &str = r#""header":{"stamp":{"sec":1,"nanosec":0},"frame_id":"base"}"#;

    #[test]
    fn both_kinds_of_cloud_hold_points() {
        let one = format!(r#"{{{HEADER},"points":[{{"x":1,"y":2,"z":0}}],"channels":[]}}"#);
        assert_eq!(points(point_cloud, &one), [Point3::new(1.0, 2.0, 0.0)]);

        let data: Vec<u8> = [1.5_f32, 2.0, 0.0, 9.0].map(f32::to_be_bytes).concat();
        let two = format!(
            r#"{{{HEADER},"height":1,"width":1,"is_bigendian":true,"point_step":16,"row_step":16,
            "fields":[{{"name":"x","offset":0,"datatype":7,"count":1}},
            {{"name":"y","offset":4,"datatype":7,"count":1}},
            {{"name":"z","offset":8,"datatype":7,"count":1}}],"data":{data:?}}}"#
        );
        assert_eq!(points(point_cloud_2, &two), [Point3::new(1.5, 2.0, 0.0)]);
        for (from, to) in [
            ("\"point_step\":16", "\"point_step\":0"),
            ("\"point_step\":16", "\"point_step\":8"),
            ("\"offset\":8", "\"offset\":-1"),
            ("\"datatype\":7", "\"datatype\":2"),
        ] {
            let odd = json::decode(two.replace(from, to).as_bytes()).unwrap();
            assert!(point_cloud_2(&odd).is_err(), "{to}");
        }
    }
}
