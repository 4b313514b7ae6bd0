//! Poses that are not of a robot on a floor, and orientations that are none.

use super::examined::Examined;
use super::finding::{Finding, Weight, percent};
use super::laid::{best_axes, from_speeds};
use crate::core::statistics::fraction;
use crate::core::wording::counted;
use crate::io::log::traits::PoseTraits;

/// From this share of the poses on, it is the log and not a message.
const MANY: f64 = 0.1;
/// A floor is flatter, metres.
const FLAT: f64 = 1.0;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    let poses = &of.survey.traits.poses;
    [quaternions(of, poses), leaning(of, poses), flying(poses)]
        .into_iter()
        .flatten()
        .collect()
}

/// Whether many poses are not of a robot on a floor, or have no orientation.
pub fn are_none(poses: &PoseTraits) -> bool {
    let share = |count| fraction(count, poses.poses);
    share(poses.off_unit) >= MANY || share(poses.leaning) >= MANY
}

/// Quaternions of another length than 1, as drivers write that put the heading into one of its parts.
fn quaternions(of: &Examined<'_>, poses: &PoseTraits) -> Option<Finding> {
    if fraction(poses.off_unit, poses.poses) < MANY {
        return None;
    }
    let [shortest, longest] = poses.lengths;
    let mut what = format!(
        "{} of {} have an orientation that is no unit quaternion: {}",
        poses.off_unit,
        counted(poses.poses, "pose"),
        match longest > 0.0 {
            true => format!("its length is {shortest:.2} to {longest:.2}"),
            false => "it was never set, and is zero".to_owned(),
        }
    );
    let mut mend =
        "mend the driver: a heading is x = 0, y = 0, z = sin(yaw/2), w = cos(yaw/2)".to_owned();
    let mut keys = vec![from_speeds()];
    if fraction(poses.heading_for_quaternion, poses.off_unit) > 0.5 {
        what.push_str("; z seems to be the heading itself");
        keys.extend(of_heading(of));
    }
    let tried = of.best(&keys);
    if let Some(tried) = &tried {
        mend.push_str(&format!("; until then: {}{tried}", tried.named()));
    }
    Some(
        Finding::new(
            Weight::Serious,
            "no-quaternion",
            what,
            "headings are not what the driver meant, and walls bend",
            mend,
        )
        .with(tried),
    )
}

/// The keys that read z as the heading, in radians and in degrees.
fn of_heading(of: &Examined<'_>) -> Vec<String> {
    let topic = of.survey.odometry_topic.as_deref().unwrap_or_default();
    let mut channels = of.facts.channels.iter();
    let channel = channels.find(|channel| channel.topic == topic);
    let pose = match channel.and_then(|channel| channel.type_name.rsplit('/').next()) {
        Some("Odometry" | "PoseWithCovarianceStamped") => "pose.pose",
        Some("PoseStamped") => "pose",
        _ => return Vec::new(),
    };
    let robot_frame = toml::Value::from(of.survey.traits.robot_frame.as_str());
    let section = format!("channel.{}", toml::Value::from(topic));
    let in_unit = |unit: &str| {
        let keys = [
            format!("x = \"{pose}.position.x\""),
            format!("y = \"{pose}.position.y\""),
            format!("yaw = \"{pose}.orientation.z\""),
            format!("angle_unit = \"{unit}\""),
            "stamp = \"header.stamp\"".to_owned(),
            "frame = \"header.frame_id\"".to_owned(),
        ];
        let mut keys = keys.map(|key| format!("{section}.{key}")).to_vec();
        keys.push(format!("input.robot_frame = {robot_frame}"));
        keys.join("\n")
    };
    ["rad", "deg"].map(in_unit).to_vec()
}

/// Poses with another axis up (mocap) or with z down (NED).
fn leaning(of: &Examined<'_>, poses: &PoseTraits) -> Option<Finding> {
    let share = fraction(poses.leaning, poses.poses);
    if share < MANY {
        return None;
    }
    let [x, y, z] = poses.extent.map(|[low, high]| high - low);
    let why = if 2 * poses.upside_down > poses.leaning {
        "it points down, as in NED frames"
    } else if z > y {
        "y seems to be up"
    } else {
        "the robot lies, another axis is up, or the parts of the quaternion stand in another order"
    };
    let tried = best_axes(of);
    Some(Finding::new(
        Weight::Serious,
        "no-floor",
        format!(
            "the poses are not of a robot on a floor: in {} of them the robot's z axis leans by more than 30 deg \
             ({why}); they extend {x:.2} m in x, {y:.2} m in y and {z:.2} m in z",
            percent(share)
        ),
        "the map is laid through x and y of these poses, and is not the floor's",
        match &tried {
            Some(tried) => format!(
                "set {}{tried}; better, turn the poses before they are recorded (REP 103)",
                tried.named()
            ),
            None => "turn the poses so that z is up before they are recorded (REP 103)".to_owned(),
        },
    )
    .with(tried))
}

/// Poses that rise and fall.
fn flying(poses: &PoseTraits) -> Option<Finding> {
    let [.., [low, high]] = poses.extent;
    (high - low > FLAT && fraction(poses.leaning, poses.poses) < MANY).then(|| {
        Finding::new(
            Weight::Serious,
            "no-floor",
            format!(
                "the robot rises and falls by {:.2} m: the poses are not of a robot on a floor",
                high - low
            ),
            "readings from several heights fall into one plane",
            "replay the part on one floor with --start and --end",
        )
    })
}
