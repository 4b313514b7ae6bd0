//! Messages of unknown types, read by the field paths that the configuration gives.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::messages::{Content, MOST_SONARS, OdometryMessage, RangeMessage, Role, rotation};
use super::value::{FieldError, Value, missing};
use crate::core::config::channel::{AngleUnit, ChannelFields, Given, TimeUnit};

/// What the messages of a described channel are good for.
pub fn role(fields: &ChannelFields) -> Role {
    if fields.is_odometry() {
        Role::Odometry
    } else {
        Role::Range
    }
}

/// Reads a message by a description.
///
/// # Errors
/// A field that is not there.
pub fn read(fields: &ChannelFields, message: &Value) -> Result<Content, FieldError> {
    match &fields.range {
        Some(range) => ranges(fields, range, message),
        None => odometry(fields, message).map(Content::Odometry),
    }
}

fn ranges(fields: &ChannelFields, range: &str, message: &Value) -> Result<Content, FieldError> {
    let array = range.split_once("[]").map_or(range, |(array, _)| array);
    let count = match message.get(array) {
        Some(Value::Numbers(numbers)) => Some(numbers.len()),
        Some(Value::List(items)) => Some(items.len()),
        _ => None,
    };
    let reading = |element: Option<usize>| reading(fields, range, &Place { message, element });
    Ok(match count {
        Some(count) if count > MOST_SONARS => Content::Crowd(count),
        Some(count) => Content::Ranges(
            (0..count)
                .map(|i| reading(Some(i)))
                .collect::<Result<_, _>>()?,
        ),
        None => Content::Ranges(vec![reading(None)?]),
    })
}

fn reading(
    fields: &ChannelFields,
    range: &str,
    place: &Place<'_>,
) -> Result<RangeMessage, FieldError> {
    let metres = fields.metres_per_unit.unwrap_or(1.0);
    let angle = fields.angle_unit.unwrap_or(AngleUnit::Rad);
    let given = |given: &Option<Given>, none: f64, unit: &dyn Fn(f64) -> f64| match given {
        None => Ok(none),
        Some(Given::Constant(value)) => Ok(*value),
        Some(Given::Path(path)) => place.distance(path).map(unit),
    };
    Ok(RangeMessage {
        stamp_ns: place.stamp(fields)?,
        delay_ns: 0,
        frame_id: place.frame(fields)?,
        element: place.element,
        frame_from_beam: Isometry3::identity(),
        range: place.distance(range)? * metres,
        min_range: given(&fields.min_range, 0.0, &|x| x * metres)?,
        max_range: given(&fields.max_range, f64::INFINITY, &|x| x * metres)?,
        beam_width: given(&fields.beam_width, 0.0, &|x| angle.radians(x))?,
        likely_beam_width: 0.0,
        variance: given(&fields.variance, 0.0, &|x| x * metres * metres)?,
    })
}

fn odometry(fields: &ChannelFields, message: &Value) -> Result<OdometryMessage, FieldError> {
    let place = Place {
        message,
        element: None,
    };
    let metres = fields.metres_per_unit.unwrap_or(1.0);
    let angle = fields.angle_unit.unwrap_or(AngleUnit::Rad);
    let number = |path: &Option<String>, name: &'static str| match path {
        Some(path) => message.number(path),
        None => Err(missing(name, "a path in the configuration")),
    };
    let position = match &fields.position {
        Some(position) => Vector3::new(
            message.number(&format!("{position}.x"))?,
            message.number(&format!("{position}.y"))?,
            0.0,
        ),
        None => Vector3::new(number(&fields.x, "x")?, number(&fields.y, "y")?, 0.0),
    } * metres;
    let turn = match &fields.orientation {
        Some(orientation) => rotation(message, orientation)?,
        None => {
            let yaw = angle.radians(number(&fields.yaw, "yaw")?);
            yaw.is_finite()
                .then(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw))
        }
    };
    let is_finite = position.iter().all(|x| x.is_finite());
    Ok(OdometryMessage {
        stamp_ns: place.stamp(fields)?,
        world_frame: place.frame(fields)?,
        robot_frame: String::new(),
        world_from_robot: turn
            .filter(|_| is_finite)
            .map(|turn| Isometry3::from_parts(position.into(), turn)),
    })
}

/// A message, or an element of the arrays in it.
struct Place<'a> {
    message: &'a Value,
    element: Option<usize>,
}

impl Place<'_> {
    /// The value at a path: behind `[]`, and in arrays, the element's.
    fn find(&self, path: &str) -> Option<Value> {
        let (array, rest) = match path.split_once("[]") {
            Some((array, rest)) => (array, rest.trim_start_matches('.')),
            None => (path, ""),
        };
        let value = self.message.get(array)?;
        match (value, self.element) {
            (Value::Numbers(numbers), Some(element)) => {
                numbers.get(element).copied().map(Value::Float)
            }
            (Value::List(items), Some(element)) => {
                let item = items.get(element)?;
                let found = if rest.is_empty() {
                    Some(item)
                } else {
                    item.get(rest)
                };
                found.cloned()
            }
            (value, _) => Some(value.clone()),
        }
    }

    fn distance(&self, path: &str) -> Result<f64, FieldError> {
        self.find(path)
            .and_then(|value| value.as_distance())
            .ok_or_else(|| missing(path, "a number"))
    }

    /// Nanoseconds; 0 where the description has no stamp.
    fn stamp(&self, fields: &ChannelFields) -> Result<i64, FieldError> {
        let Some(path) = &fields.stamp else {
            return Ok(0);
        };
        let value = self.find(path).unwrap_or(Value::Null);
        let unit = fields.stamp_unit.unwrap_or(TimeUnit::S).nanoseconds();
        let whole = value.as_integer().map(|n| n.saturating_mul(unit));
        value
            .as_time()
            .or(whole)
            .or_else(|| {
                let seconds = value.as_number().filter(|x| x.is_finite())?;
                Some(libm::round(seconds * unit as f64) as i64)
            })
            .ok_or_else(|| missing(path, "a time or a number"))
    }

    /// Without a leading slash; empty where the description has none.
    fn frame(&self, fields: &ChannelFields) -> Result<String, FieldError> {
        let name = match (&fields.frame, &fields.frame_name) {
            (Some(path), _) => match self.find(path) {
                Some(Value::Text(text)) => text,
                _ => return Err(missing(path, "text")),
            },
            (None, Some(name)) => name.clone(),
            (None, None) => String::new(),
        };
        Ok(name.trim_start_matches('/').to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::config::file;
    use crate::io::log::json;

    fn content(description: &str, text: &str) -> Result<Content, FieldError> {
        let config = file::parse(&format!("[channel.'/t']\n{description}")).unwrap();
        file::check(&config).unwrap();
        read(
            &config.channel["/t"],
            &json::decode(text.as_bytes()).unwrap(),
        )
    }

    fn beams(description: &str, text: &str) -> Vec<RangeMessage> {
        match content(description, text).unwrap() {
            Content::Ranges(beams) => beams,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn one_range_with_its_unit() {
        let found = beams(
            "range='echo.cm'\nmetres_per_unit=0.01\nstamp='t'\nstamp_unit='ms'\nframe='id'\n\
             beam_width=30\nmin_range=0.02\nmax_range='far'",
            r#"{"echo":{"cm":150},"t":1500,"id":"/left","far":400}"#,
        );
        let [one] = found.as_slice() else { panic!() };
        assert_eq!((one.range, one.min_range, one.max_range), (1.5, 0.02, 4.0));
        assert_eq!((one.stamp_ns, &*one.frame_id), (1_500_000_000, "left"));
        assert!((one.beam_width - 30_f64.to_radians()).abs() < 1e-15);
        assert_eq!(one.element, None);
    }

    #[test]
    fn arrays_of_numbers_and_of_messages() {
        let numbers = beams(
            "range='d'\nvariance='v'\nframe_name='ring'",
            r#"{"d":[1,null,3],"v":[0.1,0.2,0.3]}"#,
        );
        assert_eq!(numbers[1].range, f64::INFINITY);
        assert_eq!((numbers[2].variance, numbers[2].element), (0.3, Some(2)));
        assert_eq!((numbers[2].stamp_ns, &*numbers[2].frame_id), (0, "ring"));

        let messages = beams(
            "range='e[].r'\nframe='e[].id'\nstamp='stamp'",
            r#"{"e":[{"r":1,"id":"a"},{"r":2,"id":"b"}],"stamp":{"sec":1,"nsec":2}}"#,
        );
        assert_eq!((messages[1].range, &*messages[1].frame_id), (2.0, "b"));
        assert_eq!(messages[1].stamp_ns, 1_000_000_002);
    }

    #[test]
    fn odometry_in_degrees_or_with_a_quaternion() {
        let text = r#"{"p":{"x":1,"y":2,"z":9},"q":{"x":0,"y":0,"z":1,"w":0},"a":90,"bad":null}"#;
        let yaw = |description: &str| match content(description, text).unwrap() {
            Content::Odometry(odometry) => {
                let pose = odometry.world_from_robot.unwrap();
                assert_eq!((pose.translation.x, pose.translation.y), (1.0, 2.0));
                pose.rotation.euler_angles().2
            }
            other => panic!("{other:?}"),
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        assert!((yaw("x='p.x'\ny='p.y'\nyaw='a'\nangle_unit='deg'") - quarter).abs() < 1e-12);
        assert!((yaw("position='p'\norientation='q'").abs() - 2.0 * quarter).abs() < 1e-12);
    }

    #[test]
    fn a_path_that_leads_nowhere_is_named() {
        let error = content("range='echo.m'", r#"{"echo":{"cm":150}}"#).unwrap_err();
        assert!(error.to_string().contains("`echo.m`"), "{error}");
        assert!(content("range='r'\nstamp='t'", r#"{"r":1}"#).is_err());
        assert!(content("range='r'\nframe='r'", r#"{"r":1}"#).is_err());
    }
}
