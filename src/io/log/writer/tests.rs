use std::f64::consts::FRAC_PI_2;
use std::io::Cursor;

use re_cdr::{CdrReader, LittleEndian};

use super::*;

const STAMP_NS: i64 = 1_500_000_000_250_000_000;

fn log(write: impl FnOnce(&mut LogWriter<Cursor<Vec<u8>>>)) -> Vec<mcap::Message<'static>> {
    let mut log = LogWriter::new(Cursor::new(Vec::new())).unwrap();
    write(&mut log);
    let bytes = log.finish().unwrap().into_inner();
    let messages = mcap::MessageStream::new(&bytes).unwrap();
    messages.map(Result::unwrap).collect()
}

/// A reader behind the encapsulation header, having checked the `std_msgs/Header`.
fn body<'a>(data: &'a [u8], frame: &str) -> CdrReader<'a, LittleEndian> {
    let (encapsulation, body) = data.split_at(4);
    assert_eq!(encapsulation, [0, 1, 0, 0]);
    let mut reader = CdrReader::new(body);
    assert_eq!(reader.read_i32().unwrap(), 1_500_000_000);
    assert_eq!(reader.read_u32().unwrap(), 250_000_000);
    assert_eq!(reader.read_str().unwrap(), frame);
    reader
}

fn floats<const N: usize>(reader: &mut CdrReader<LittleEndian>) -> [f64; N] {
    std::array::from_fn(|_| reader.read_f64().unwrap())
}

#[test]
fn a_range_is_laid_out_as_its_schema_says() {
    let messages = log(|log| {
        log.range(&RangeMessage {
            stamp_ns: STAMP_NS,
            sonar: "left",
            field_of_view: 0.4,
            min_range: 0.2,
            max_range: 5.0,
            range: f32::INFINITY,
            variance: 1e-6,
        })
        .unwrap();
    });
    let [message] = messages.as_slice() else {
        panic!("one message expected")
    };
    assert_eq!(message.channel.topic, "/sonar/left");
    assert_eq!(message.channel.message_encoding, "cdr");
    let schema = message.channel.schema.as_ref().unwrap();
    assert_eq!(schema.name, "sensor_msgs/msg/Range");
    assert_eq!(schema.encoding, "ros2msg");
    assert_eq!(message.log_time, STAMP_NS as u64);

    let mut reader = body(&message.data, "left");
    assert_eq!(reader.read_u8().unwrap(), ULTRASOUND);
    let values: [f32; 5] = std::array::from_fn(|_| reader.read_f32().unwrap());
    assert_eq!(values, [0.4, 0.2, 5.0, f32::INFINITY, 1e-6]);
    assert_eq!(reader.remaining(), 0);
}

#[test]
fn odometry_comes_with_its_transform() {
    let twist = Twist {
        linear: 0.5,
        angular: -0.25,
    };
    let pose = Pose2::new(1.0, 2.0, FRAC_PI_2);
    let messages = log(|log| log.odometry(STAMP_NS, pose, twist).unwrap());
    let [odometry, transform] = messages.as_slice() else {
        panic!("two messages expected")
    };
    let half = std::f64::consts::FRAC_1_SQRT_2;

    assert_eq!(odometry.channel.topic, "/odom");
    let mut reader = body(&odometry.data, "odom");
    assert_eq!(reader.read_str().unwrap(), "base_link");
    let [x, y, z, qx, qy, qz, qw] = floats(&mut reader);
    assert_eq!([x, y, z, qx, qy], [1.0, 2.0, 0.0, 0.0, 0.0]);
    assert!((qz - half).abs() < 1e-15 && (qw - half).abs() < 1e-15);
    assert_eq!(floats(&mut reader), [0.0; 36]);
    assert_eq!(floats(&mut reader), [0.5, 0.0, 0.0, 0.0, 0.0, -0.25]);
    assert_eq!(floats(&mut reader), [0.0; 36]);
    assert_eq!(reader.remaining(), 0);

    assert_eq!(transform.channel.topic, "/tf");
    let (_, sequence) = transform.data.split_at(4);
    assert_eq!(
        CdrReader::<LittleEndian>::new(sequence).read_u32().unwrap(),
        1
    );
}

#[test]
fn a_stamp_that_ros_cannot_hold_is_refused() {
    let mut log = LogWriter::new(Cursor::new(Vec::new())).unwrap();
    for stamp_ns in [-1, i64::MIN, i64::MAX] {
        let refused = log.odometry(stamp_ns, Pose2::IDENTITY, Twist::default());
        assert!(
            matches!(refused, Err(WriteError::Stamp { .. })),
            "{stamp_ns}"
        );
    }
}

#[test]
fn the_covariance_of_a_path_stands_in_its_rows_and_columns() {
    let covariance = Matrix3::new(1.0, 2.0, 3.0, 2.0, 4.0, 5.0, 3.0, 5.0, 6.0);
    let pose = Pose2::new(1.0, 2.0, 0.0);
    let messages = log(|log| log.path_pose(STAMP_NS, pose, &covariance).unwrap());
    let [message] = messages.as_slice() else {
        panic!("one message expected")
    };
    assert_eq!(message.channel.topic, PATH_TOPIC);
    let mut reader = body(&message.data, "odom");
    assert_eq!(reader.read_str().unwrap(), "base_link");
    assert_eq!(
        floats::<7>(&mut reader),
        [1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    );
    let mut expected = [[0.0; 6]; 6];
    expected[0] = [1.0, 2.0, 0.0, 0.0, 0.0, 3.0];
    expected[1] = [2.0, 4.0, 0.0, 0.0, 0.0, 5.0];
    expected[5] = [3.0, 5.0, 0.0, 0.0, 0.0, 6.0];
    assert_eq!(floats::<36>(&mut reader), *expected.as_flattened());
    assert_eq!(floats::<42>(&mut reader), [0.0; 42]);
    assert_eq!(reader.remaining(), 0);
}
