//! Messages of unknown types, read by the field paths that the configuration gives.

use std::borrow::Cow;

use nalgebra::{UnitQuaternion, Vector3};

use super::message::{Content, MOST_SONARS, RangeMessage, Role, TransformMessage};
use super::poses::{as_written, placed, rotation};
use super::value::{Field, FieldError, Fields};
use crate::core::config::channel::{AngleUnit, ChannelFields, Given, TimeUnit};

/// What the messages of a described channel are good for.
pub fn role(described: &ChannelFields) -> Role {
    if described.is_odometry() {
        Role::Odometry
    } else {
        Role::Range
    }
}

/// The paths of the wanted fields, in the order in which [`read`] takes them; empty for those that are not
/// described.
pub fn paths(described: &ChannelFields) -> Vec<String> {
    let path = |path: &Option<String>| path.clone().unwrap_or_default();
    let given = |given: &Option<Given>| match given {
        Some(Given::Path(path)) => path.clone(),
        _ => String::new(),
    };
    let inside = |message: &Option<String>, name: &str| {
        let path = message.as_ref().map(|message| format!("{message}.{name}"));
        path.unwrap_or_default()
    };
    let mut paths = vec![path(&described.stamp), path(&described.frame)];
    if described.is_odometry() {
        let position = &described.position;
        let or = |path: &Option<String>, name| match path {
            Some(path) if position.is_none() => path.clone(),
            _ => inside(position, name),
        };
        paths.extend([or(&described.x, "x"), or(&described.y, "y")]);
        paths.push(path(&described.yaw));
        paths.extend(["x", "y", "z", "w"].map(|name| inside(&described.orientation, name)));
        let element = |array: &Option<String>, place: usize| {
            let path = array.as_ref().map(|array| format!("{array}[{place}]"));
            path.unwrap_or_default()
        };
        paths.extend([1, 2, 3, 0].map(|place| element(&described.orientation, place)));
        paths.push(inside(position, "z"));
        paths.extend([0, 1, 2].map(|place| element(position, place)));
    } else {
        paths.push(path(&described.range));
        let limits = [
            &described.min_range,
            &described.max_range,
            &described.beam_width,
            &described.variance,
        ];
        paths.extend(limits.map(given));
    }
    paths
}

/// Reads a message by a description.
///
/// # Errors
/// A field that is not there.
pub fn read<'m>(
    described: &ChannelFields,
    fields: &Fields<'_, 'm>,
) -> Result<Content<'m>, FieldError> {
    if described.is_odometry() {
        return odometry(described, fields).map(Content::Odometry);
    }
    let [_, _, range, ..] = fields.all::<7>();
    Ok(match range.count() {
        Some(count) if count > MOST_SONARS => Content::Crowd(count),
        Some(count) => {
            let readings = (0..count).map(|element| reading(described, fields, Some(element)));
            Content::Ranges(readings.collect::<Result<_, _>>()?)
        }
        None => Content::Ranges(vec![reading(described, fields, None)?]),
    })
}

/// A message's only reading, or that of an element of its arrays.
fn reading<'m>(
    described: &ChannelFields,
    fields: &Fields<'_, 'm>,
    element: Option<usize>,
) -> Result<RangeMessage<'m>, FieldError> {
    let all = fields.all::<7>();
    let [stamp, frame, range, min_range, max_range, width, variance] =
        all.each_ref().map(|field| match element {
            Some(element) => field.at(element),
            None => field.clone(),
        });
    let metres = described.metres_per_unit.unwrap_or(1.0);
    let angle = described.angle_unit.unwrap_or(AngleUnit::Rad);
    let given =
        |given: &Option<Given>, field: &Field<'_, '_>, none: f64, unit: &dyn Fn(f64) -> f64| {
            match given {
                None => Ok(none),
                Some(Given::Constant(value)) => Ok(*value),
                Some(Given::Path(_)) => field.distance().map(unit),
            }
        };
    let length = |x: f64| x * metres;
    let (stamp_ns, frame_id) = (stamp_of(described, &stamp)?, frame_of(described, &frame)?);
    let infinite = f64::INFINITY;
    Ok(RangeMessage {
        element,
        min_range: given(&described.min_range, &min_range, 0.0, &length)?,
        max_range: given(&described.max_range, &max_range, infinite, &length)?,
        beam_width: given(&described.beam_width, &width, 0.0, &|x| angle.radians(x))?,
        variance: given(&described.variance, &variance, 0.0, &|x| {
            x * metres * metres
        })?,
        ..RangeMessage::plain(stamp_ns, frame_id, length(range.distance()?))
    })
}

fn odometry<'m>(
    described: &ChannelFields,
    fields: &Fields<'_, 'm>,
) -> Result<TransformMessage<'m>, FieldError> {
    let all = fields.all::<17>();
    let [
        stamp,
        frame,
        x,
        y,
        yaw,
        qx,
        qy,
        qz,
        qw,
        ex,
        ey,
        ez,
        ew,
        z,
        place @ ..,
    ] = &all;
    let turn = match ew.is_there() {
        true => [ex, ey, ez, ew],
        false => [qx, qy, qz, qw],
    };
    let turn = turn.map(Clone::clone);
    let [px, py, pz] = place;
    let [x, y, z] = match px.is_there() {
        true => [px, py, pz],
        false => [x, y, z],
    };
    let height = z.number().unwrap_or_default();
    let metres = described.metres_per_unit.unwrap_or(1.0);
    let position = Vector3::new(x.number()?, y.number()?, height) * metres;
    let quaternion = described.orientation.is_some().then(|| as_written(&turn));
    let turn = if described.orientation.is_some() {
        rotation(&turn)?
    } else {
        let angle = described.angle_unit.unwrap_or(AngleUnit::Rad);
        let yaw = angle.radians(yaw.number()?);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
        yaw.is_finite().then_some(turn)
    };
    Ok(TransformMessage {
        stamp_ns: stamp_of(described, stamp)?,
        parent: frame_of(described, frame)?,
        child: Cow::Borrowed(""),
        parent_from_child: turn.and_then(|turn| placed(position, turn)),
        quaternion: quaternion.flatten(),
        twist: None,
    })
}

/// Nanoseconds; 0 where the description has no stamp.
fn stamp_of(described: &ChannelFields, stamp: &Field<'_, '_>) -> Result<i64, FieldError> {
    if described.stamp.is_none() {
        return Ok(0);
    }
    let unit = described.stamp_unit.unwrap_or(TimeUnit::S).nanoseconds();
    let whole = || stamp.value.as_integer().map(|n| n.saturating_mul(unit));
    let part = || {
        let number = stamp.value.as_number().filter(|x| x.is_finite())?;
        Some(libm::round(number * unit as f64) as i64)
    };
    let time = stamp.value.as_time().or_else(whole).or_else(part);
    time.ok_or_else(|| stamp.missing("a time or a number"))
}

/// Without a leading slash; empty where the description has none.
fn frame_of<'m>(
    described: &ChannelFields,
    frame: &Field<'_, 'm>,
) -> Result<Cow<'m, str>, FieldError> {
    match (&described.frame, &described.frame_name) {
        (Some(_), _) => frame.frame(),
        (None, Some(name)) => Ok(name.trim_start_matches('/').to_owned().into()),
        (None, None) => Ok(Cow::Borrowed("")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::config::file;
    use crate::io::log::json;
    use crate::io::log::value::Path;

    fn content(description: &str, text: &str) -> Result<Content<'static>, FieldError> {
        let config = file::parse(&format!("[channel.'/t']\n{description}")).unwrap();
        file::check(&config).unwrap();
        let described = &config.channel["/t"];
        let paths: Vec<Path> = paths(described).into_iter().map(Path::from).collect();
        let values = json::decode(text.as_bytes(), &paths).unwrap();
        let paths = &paths;
        read(described, &Fields { paths, values })
    }

    fn beams(description: &str, text: &str) -> Vec<RangeMessage<'static>> {
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
                let pose = odometry.parent_from_child.unwrap();
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
    fn arrays_of_a_position_and_of_a_quaternion_that_begins_with_w() {
        let text = r#"{"position":[3,4,-1],"q":[0,0,0,1]}"#;
        let Content::Odometry(odometry) =
            content("position='position'\norientation='q'", text).unwrap()
        else {
            panic!()
        };
        let pose = odometry.parent_from_child.unwrap();
        assert_eq!(pose.translation.vector, Vector3::new(3.0, 4.0, -1.0));
        assert!((pose.rotation.euler_angles().2.abs() - std::f64::consts::PI).abs() < 1e-12);
        assert_eq!(odometry.quaternion, Some([0.0, 0.0, 1.0, 0.0]));
    }

    #[test]
    fn a_path_that_leads_nowhere_is_named() {
        let error = content("range='echo.m'", r#"{"echo":{"cm":150}}"#).unwrap_err();
        assert!(error.to_string().contains("`echo.m`"), "{error}");
        assert!(content("range='r'\nstamp='t'", r#"{"r":1}"#).is_err());
        assert!(content("range='r'\nframe='r'", r#"{"r":1}"#).is_err());
    }
}
