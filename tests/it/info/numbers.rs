//! Every number in a finding, held against the same number computed from the messages of the log.

use std::path::Path;

use super::{changed, put, told};
use crate::support::{Bench, Message};

/// Of a `sensor_msgs/Range`, counted from the end of its message.
const MIN_RANGE: usize = 16;
const MAX_RANGE: usize = 12;
const RANGE: usize = 8;
const VARIANCE: usize = 4;

fn is_range(message: &Message) -> bool {
    message.topic.starts_with("/sonar/")
}

fn f32_at(message: &Message, from_end: usize) -> f64 {
    let at = message.data.len() - from_end;
    f64::from(f32::from_le_bytes(
        message.data[at..at + 4].try_into().unwrap(),
    ))
}

fn put_f32(message: &mut Message, from_end: usize, value: f64) {
    let at = message.data.len() - from_end;
    message.data[at..at + 4].copy_from_slice(&(value as f32).to_le_bytes());
}

/// Where the position of a `nav_msgs/Odometry` begins: behind stamp and two names, at a multiple of 8.
fn pose_at(data: &[u8]) -> usize {
    let text = |at: usize| {
        let at = at.next_multiple_of(4);
        at + 4 + u32::from_le_bytes(data[at..at + 4].try_into().unwrap()) as usize
    };
    4 + (text(text(12)) - 4).next_multiple_of(8)
}

/// x, y, z, and the quaternion.
fn pose(message: &Message) -> [f64; 7] {
    let at = pose_at(&message.data);
    std::array::from_fn(|k| {
        let at = at + 8 * k;
        f64::from_le_bytes(message.data[at..at + 8].try_into().unwrap())
    })
}

fn put_pose(message: &mut Message, pose: [f64; 7]) {
    let at = pose_at(&message.data);
    for (k, value) in pose.into_iter().enumerate() {
        message.data[at + 8 * k..at + 8 * k + 8].copy_from_slice(&value.to_le_bytes());
    }
}

fn stamp(message: &Message) -> f64 {
    let part = |at: usize| u32::from_le_bytes(message.data[at..at + 4].try_into().unwrap());
    f64::from(part(4)) + 1e-9 * f64::from(part(8))
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    match values.len() % 2 {
        0 => (values[half - 1] + values[half]) / 2.0,
        _ => values[half],
    }
}

/// The messages of a changed log, and a finding of it.
struct Case {
    ranges: Vec<Message>,
    odometry: Vec<Message>,
    what: String,
    mend: String,
}

fn case(code: &str, change: impl Fn(Message) -> Vec<Message>) -> Case {
    let bench = Bench::new();
    let log = put(
        &bench,
        changed("room_drive.mcap", |message| {
            // Of transforms that move, the odometry says all.
            match message.topic.as_str() {
                "/tf" => Vec::new(),
                _ => change(message),
            }
        }),
    );
    let (info, _) = told(&bench, &log, "");
    let findings = info["findings"].as_array().unwrap();
    let found = findings.iter().find(|finding| finding["code"] == code);
    let found = found.unwrap_or_else(|| panic!("{code}: {:#}", info["findings"]));
    let messages = messages(&log);
    let (ranges, others): (Vec<_>, Vec<_>) = messages.into_iter().partition(is_range);
    Case {
        ranges,
        odometry: others.into_iter().filter(|m| m.topic == "/odom").collect(),
        what: found["what"].as_str().unwrap().to_owned(),
        mend: found["mend"].as_str().unwrap().to_owned(),
    }
}

fn messages(log: &Path) -> Vec<Message> {
    let bytes = std::fs::read(log).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap();
    let of = |message: mcap::Message<'_>| Message {
        topic: message.channel.topic.clone(),
        log_time: message.log_time,
        data: message.data.to_vec(),
        rank: 0,
    };
    messages.map(|message| of(message.unwrap())).collect()
}

impl Case {
    fn says(&self, expected: &str) {
        assert!(self.what.contains(expected), "{expected} in: {}", self.what);
    }

    fn by_sonar(&self) -> Vec<Vec<&Message>> {
        let mut names: Vec<&str> = self.ranges.iter().map(|m| m.topic.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        let of = |name: &&str| self.ranges.iter().filter(|m| m.topic == *name).collect();
        names.iter().map(of).collect()
    }
}

fn of_range(change: impl Fn(&mut Message)) -> impl Fn(Message) -> Vec<Message> {
    move |mut message| {
        if is_range(&message) {
            change(&mut message);
        }
        vec![message]
    }
}

fn of_odometry(change: impl Fn(f64, [f64; 7]) -> [f64; 7]) -> impl Fn(Message) -> Vec<Message> {
    let first = std::cell::Cell::new(None);
    move |mut message| {
        if message.topic == "/odom" {
            let at = stamp(&message);
            let first = first.get().unwrap_or_else(|| {
                first.set(Some(at));
                at
            });
            let changed = change(at - first, pose(&message));
            put_pose(&mut message, changed);
        }
        vec![message]
    }
}

#[test]
fn values_that_stand_for_no_echo() {
    let case = case(
        "stand-in",
        of_range(|message| {
            put_f32(message, MIN_RANGE, 0.0);
            if f32_at(message, RANGE) >= 4.0 {
                put_f32(message, RANGE, 0.0);
            }
        }),
    );
    let sonars = case.by_sonar();
    let zeros = |sonar: &Vec<&Message>| sonar.iter().filter(|m| f32_at(m, RANGE) == 0.0).count();
    let standing: Vec<_> = sonars
        .iter()
        .filter(|sonar| 10 * zeros(sonar) > sonar.len())
        .collect();
    let all: usize = standing.iter().map(|sonar| sonar.len()).sum();
    let zero: usize = standing.iter().map(|sonar| zeros(sonar)).sum();
    case.says(&format!("{} of 16 sonars", standing.len()));
    case.says(&format!(
        "{:.0} % of their echoes lie at 0.000 m",
        100.0 * zero as f64 / all as f64
    ));
}

#[test]
fn one_value_that_stands_for_no_echo_among_the_others() {
    let case = case(
        "stand-in",
        of_range(|message| {
            if f32_at(message, RANGE) >= f32_at(message, MAX_RANGE) {
                put_f32(message, RANGE, 2.55);
            }
        }),
    );
    let value = f64::from(2.55_f32);
    let count = |sonar: &Vec<&Message>| sonar.iter().filter(|m| f32_at(m, RANGE) == value).count();
    let sonars = case.by_sonar();
    let having: Vec<_> = sonars
        .iter()
        .filter(|sonar| 10 * count(sonar) > sonar.len())
        .collect();
    let all: usize = having.iter().map(|sonar| sonar.len()).sum();
    let same: usize = having.iter().map(|sonar| count(sonar)).sum();
    case.says(&format!("{} of 16 sonars", having.len()));
    case.says(&format!(
        "{:.0} % of their echoes lie at 2.550 m to the bit",
        100.0 * same as f64 / all as f64
    ));
    let mend = &case.mend;
    assert!(
        mend.contains("sonars.no_echo = 2.55 (tried: its map explains 100 %"),
        "{mend}"
    );
}

#[test]
fn limits_in_another_unit_than_the_ranges() {
    let case = case(
        "limits",
        of_range(|message| {
            for field in [MAX_RANGE, MIN_RANGE] {
                let metres = f32_at(message, field);
                put_f32(message, field, 100.0 * metres);
            }
        }),
    );
    let ranges = || {
        case.ranges
            .iter()
            .map(|m| f32_at(m, RANGE))
            .filter(|range| range.is_finite())
    };
    let (nearest, farthest) = (
        ranges().fold(f64::INFINITY, f64::min),
        ranges().fold(0.0, f64::max),
    );
    case.says(&format!(
        "ranges from {nearest:.2} to {farthest:.2} m do not lie between"
    ));
    case.says("min_range 20 m and max_range 1000 m");
    assert!(
        case.mend.contains("(tried: its map explains 100 %"),
        "{}",
        case.mend
    );
}

#[test]
fn centimetres_and_variances() {
    let case_of_cm = case(
        "units",
        of_range(|message| {
            for field in [MAX_RANGE, MIN_RANGE, RANGE] {
                let metres = f32_at(message, field);
                put_f32(message, field, 100.0 * metres);
            }
            put_f32(message, VARIANCE, 0.0);
        }),
    );
    let middles = case_of_cm.by_sonar().into_iter().map(|sonar| {
        let echoes = sonar.iter().map(|m| f32_at(m, RANGE));
        middle(echoes.filter(|range| range.is_finite()).collect())
    });
    let nearest = middles
        .filter(|middle| *middle > 50.0)
        .fold(f64::INFINITY, f64::min);
    let max_range = f32_at(&case_of_cm.ranges[0], MAX_RANGE);
    case_of_cm.says(&format!(
        "farther than {nearest:.0} m, and max_range is {max_range} m"
    ));

    let case = case(
        "variance",
        of_range(|message| put_f32(message, VARIANCE, 255.0)),
    );
    case.says("is 255 m^2 in the middle");
}

#[test]
fn odometry_in_centimetres() {
    let case = case(
        "too-fast",
        of_odometry(|_, mut pose| {
            pose[..2].iter_mut().for_each(|part| *part *= 100.0);
            pose
        }),
    );
    let speeds = case.odometry.windows(2).map(|pair| {
        let [a, b] = [pose(&pair[0]), pose(&pair[1])];
        libm::hypot(b[0] - a[0], b[1] - a[1]) / (stamp(&pair[1]) - stamp(&pair[0]))
    });
    let speed = middle(speeds.filter(|speed| *speed > 0.01).collect());
    case.says(&format!("drives {speed:.1} m/s in the middle"));
    assert!(
        case.mend.contains("metres_per_unit = 0.01 (tried"),
        "{}",
        case.mend
    );
}

#[test]
fn a_heading_that_is_set_anew() {
    let case = case(
        "odometry-jump",
        of_odometry(|after, mut pose| {
            if after >= 50.0 {
                let yaw = 2.0 * libm::atan2(pose[5], pose[6]) - 0.5;
                (pose[5], pose[6]) = (libm::sin(yaw / 2.0), libm::cos(yaw / 2.0));
            }
            pose
        }),
    );
    let first = case.ranges.iter().map(stamp).fold(f64::INFINITY, f64::min);
    let before = case.odometry.iter().map(stamp);
    let start = stamp(&case.odometry[0]);
    let last = before.filter(|at| at - start < 50.0).fold(0.0, f64::max);
    case.says(&format!("jumps once, at {:.1} s, by ", last - first));
    case.says(&format!("m and {:.1} deg more", 0.5_f64.to_degrees()));
}

#[test]
fn two_publishers_on_one_topic() {
    let case = case("two-tracks", |message| {
        let mut other = Message {
            data: message.data.clone(),
            topic: message.topic.clone(),
            ..message
        };
        if message.topic != "/odom" {
            return vec![message];
        }
        let mut pose = pose(&other);
        pose[1] += 0.2;
        put_pose(&mut other, pose);
        // 1 ms later, which is less than it drives in.
        let nanoseconds = u32::from_le_bytes(other.data[8..12].try_into().unwrap());
        other.data[8..12].copy_from_slice(&(nanoseconds + 1_000_000).to_le_bytes());
        other.log_time += 1_000_000;
        vec![message, other]
    });
    case.says(&format!("the {} samples on /odom", case.odometry.len()));
    case.says("0.200 m and 0.00 deg apart");
    assert!(
        case.mend.contains("input.odometry_track = 1 (tried"),
        "{}",
        case.mend
    );
}

#[test]
fn clocks_that_are_coarse_or_slow() {
    let whole = case(
        "coarse-stamps",
        of_range(|message| message.data[8..12].fill(0)),
    );
    let late = whole
        .ranges
        .iter()
        .map(|m| m.log_time as f64 * 1e-9 - stamp(m));
    whole.says(&format!(
        "recorded up to {:.2} s later",
        late.fold(0.0, f64::max)
    ));

    let start = std::cell::Cell::new(None);
    let slow = case(
        "clock-rate",
        of_range(|message| {
            let at = message.log_time;
            let first = start.get().unwrap_or_else(|| {
                start.set(Some(at));
                at
            });
            let slow = first + (at - first) * 99 / 100;
            message.data[4..8].copy_from_slice(&((slow / 1_000_000_000) as u32).to_le_bytes());
            message.data[8..12].copy_from_slice(&((slow % 1_000_000_000) as u32).to_le_bytes());
        }),
    );
    let recorded = || slow.ranges.iter().map(|m| m.log_time as f64 * 1e-9);
    let lasted = recorded().fold(0.0, f64::max) - recorded().fold(f64::INFINITY, f64::min);
    slow.says(&format!(
        "in {lasted:.1} s they come {:.2} s",
        lasted / 100.0
    ));
}

#[test]
fn poses_that_are_none() {
    let yaw = |pose: [f64; 7]| 2.0 * libm::atan2(pose[5], pose[6]);
    let heading = case(
        "no-quaternion",
        of_odometry(|_, pose| {
            let [x, y, z, ..] = pose;
            [x, y, z, 0.0, 0.0, yaw(pose), 1.0]
        }),
    );
    let lengths: Vec<f64> = heading
        .odometry
        .iter()
        .map(|m| libm::hypot(pose(m)[5], 1.0))
        .collect();
    let off = lengths
        .iter()
        .filter(|length| (*length - 1.0).abs() > 0.01)
        .count();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    heading.says(&format!("{off} of {} poses have", lengths.len()));
    heading.says(&format!("length is {shortest:.2} to {longest:.2}"));

    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mocap = case(
        "no-floor",
        of_odometry(|_, [x, y, _, _, _, qz, qw]| {
            [x, 0.1, -y, -half * qw, half * qz, half * qz, half * qw]
        }),
    );
    let extent = |part: usize| {
        let parts = || mocap.odometry.iter().map(|m| pose(m)[part]);
        parts().fold(f64::NEG_INFINITY, f64::max) - parts().fold(f64::INFINITY, f64::min)
    };
    let [x, y, z] = [0, 1, 2].map(extent);
    mocap.says(&format!(
        "100 % of them the robot's z axis leans by more than 30 deg (y seems to be up); they extend \
                         {x:.2} m in x, {y:.2} m in y and {z:.2} m in z"
    ));
    assert!(
        mocap.mend.contains("channel.\"/odom\".up = \"y\" (tried"),
        "{}",
        mocap.mend
    );
}

#[test]
fn sonars_that_are_dead() {
    let silent = case(
        "dead-sonar",
        of_range(|message| {
            if message.topic.ends_with("05") {
                put_f32(message, RANGE, f64::INFINITY);
            }
        }),
    );
    silent.says("sonar sonar_05: not a single echo");
    let stuck = case(
        "dead-sonar",
        of_range(|message| {
            if message.topic.ends_with("05") && message.data[9] > 9 {
                put_f32(message, RANGE, 1.25);
            }
        }),
    );
    let of_it: Vec<f64> = stuck.by_sonar()[5]
        .iter()
        .map(|m| f32_at(m, RANGE))
        .collect();
    let echoes = of_it.iter().filter(|range| **range < 10.0).count();
    let same = of_it.iter().filter(|range| **range == 1.25).count();
    let share = 100.0 * same as f64 / echoes as f64;
    stuck.says(&format!("sonar_05: {share:.0} % of its echoes are 1.250 m"));
}
