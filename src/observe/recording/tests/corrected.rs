use nalgebra::Matrix3;
use rerun::StoreKind;

use super::run::{chunks, drive, record, record_closing, ring};
use crate::core::frames::{Correction, Frame};
use crate::core::geometry::{Pose2, Vec2};
use crate::core::tmam::label::Kind;
use crate::core::tmam::step::Closure;

const OF_CORRECTIONS: [&str; 7] = [
    "/about/poses",
    "/correction/moved",
    "/correction/turned",
    "/log/closures",
    "/world/closures",
    "/world/odometry",
    "/world/pose_covariance",
];

/// A drive whose odometry lies ever farther to the left.
fn corrected() -> Vec<Frame> {
    let mut frames = drive(&ring(4), 50, None);
    for frame in &mut frames {
        let off = 0.01 * f64::from(frame.index);
        let pose = frame.world_from_robot;
        frame.correction = Some(Box::new(Correction {
            odom_from_robot: Pose2::new(pose.x, pose.y + off, pose.yaw - 0.1),
            covariance: Matrix3::identity() * 1e-4,
        }));
    }
    frames
}

#[test]
fn corrections_are_drawn_at_their_frames_and_closures_at_the_later_one() {
    let closure = |frames| Closure {
        kind: Kind::Line,
        place: Vec2::new(3.0, 5.0),
        frames,
    };
    let closures = [closure([40, 10]), closure([2, 30])];
    let (bytes, _) = record_closing(&closures, &ring(4), &corrected());
    let chunks = chunks(&bytes, StoreKind::Recording);
    let frames = |path: &str| -> Vec<i64> {
        let rows = chunks[path].iter().filter(|chunk| !chunk.is_static());
        let indices = rows.flat_map(|chunk| {
            let indices = chunk.iter_indices(&"frame".into());
            indices.map(|(frame, _)| frame.as_i64()).collect::<Vec<_>>()
        });
        indices.collect()
    };
    for path in ["/world/odometry", "/correction/moved", "/correction/turned"] {
        assert_eq!(frames(path), (0..50).collect::<Vec<_>>(), "{path}");
    }
    assert_eq!(frames("/world/closures"), [30, 40]);
    assert_eq!(frames("/log/closures"), [30, 40]);
    let component = rerun::Scalars::descriptor_scalars().component;
    let of = |path: &str| -> Vec<[f64; 2]> {
        let rows = chunks[path].iter().filter(|chunk| !chunk.is_static());
        let values = rows.flat_map(|chunk| {
            let rows = chunk.iter_slices::<f64>(component);
            rows.map(|row| [row[0], row[1]]).collect::<Vec<_>>()
        });
        values.collect()
    };
    let (moved, turned) = (of("/correction/moved")[20], of("/correction/turned")[20]);
    assert!((moved[0] - 0.2).abs() < 1e-9, "{moved:?}");
    assert!((moved[1] - 2e-4_f64.sqrt()).abs() < 1e-9, "{moved:?}");
    assert!(
        (turned[0] - 0.1_f64.to_degrees()).abs() < 1e-9,
        "{turned:?}"
    );
    assert!(
        (turned[1] - 0.01_f64.to_degrees()).abs() < 1e-9,
        "{turned:?}"
    );
}

#[test]
fn there_is_nothing_of_it_where_poses_are_those_of_odometry() {
    let (bytes, _) = record(&ring(4), &drive(&ring(4), 50, None));
    let chunks = chunks(&bytes, StoreKind::Recording);
    for path in OF_CORRECTIONS {
        assert!(!chunks.contains_key(path), "{path}");
    }
}
