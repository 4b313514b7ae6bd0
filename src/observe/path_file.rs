//! The path that a replay used, a pose per odometry sample, in files that other tools read.
//!
//! TUM (`timestamp tx ty tz qx qy qz qw`, a line per pose) is what evo takes; an MCAP log of
//! `nav_msgs/Odometry` is what Foxglove shows, with covariances.

use std::io::{self, Cursor, Write};
use std::path::Path;

use nalgebra::Matrix3;

use crate::core::geometry::{Pose2, unit};
use crate::core::replay::{Outcome, Replay};
use crate::core::rounding::fixed;
use crate::io::log::writer::{LogWriter, WriteError};
use crate::io::output::{Output, is_stdout};

/// How a path is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathFormat {
    /// Text.
    Tum,
    /// An MCAP log.
    Mcap,
}

impl PathFormat {
    /// What the name of a file asks for; standard output takes text.
    pub fn of(file: &Path) -> Option<Self> {
        let extension = file.extension().and_then(|extension| extension.to_str());
        match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("tum" | "txt") => Some(Self::Tum),
            Some("mcap") => Some(Self::Mcap),
            _ => is_stdout(file).then_some(Self::Tum),
        }
    }
}

/// Writes the path.
///
/// # Errors
/// When `out` cannot be written, or a stamp is none that ROS has.
pub fn write(out: &mut Output, replay: &Replay<'_>, outcome: &Outcome) -> io::Result<()> {
    let path = replay.path(outcome);
    match PathFormat::of(out.path()) {
        Some(PathFormat::Mcap) => {
            let log = odometry(&path, outcome).map_err(io::Error::other)?;
            out.write_all(&log)
        }
        _ => tum(out, &path),
    }
}

fn tum(mut out: impl Write, path: &[(i64, Pose2)]) -> io::Result<()> {
    const SECOND: u64 = 1_000_000_000;
    for (stamp_ns, pose) in path {
        let sign = if *stamp_ns < 0 { "-" } else { "" };
        let since = stamp_ns.unsigned_abs();
        let half = unit(pose.yaw / 2.0);
        let [x, y, qz, qw] = [pose.x, pose.y, half.y, half.x].map(|value| fixed(value, 9));
        writeln!(
            out,
            "{sign}{}.{:09} {x} {y} 0 0 0 {qz} {qw}",
            since / SECOND,
            since % SECOND
        )?;
    }
    Ok(())
}

fn odometry(path: &[(i64, Pose2)], outcome: &Outcome) -> Result<Vec<u8>, WriteError> {
    let mut log = LogWriter::new(Cursor::new(Vec::new()))?;
    for (stamp_ns, pose) in path {
        let covariance = outcome
            .joint()
            .map(|joint| joint.path.covariance(*stamp_ns));
        let covariance = covariance.unwrap_or_else(Matrix3::zeros);
        log.path_pose(*stamp_ns, *pose, &covariance)?;
    }
    Ok(log.finish()?.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_says_the_format() {
        let of = |name: &str| PathFormat::of(Path::new(name));
        assert_eq!(of("a.tum"), Some(PathFormat::Tum));
        assert_eq!(of("dir.mcap/a.txt"), Some(PathFormat::Tum));
        assert_eq!(of("-"), Some(PathFormat::Tum));
        assert_eq!(of("a.b.mcap"), Some(PathFormat::Mcap));
        assert_eq!(of("a"), None);
        assert_eq!(of("a.csv"), None);
    }

    #[test]
    fn stamps_keep_their_nanoseconds_on_either_side_of_zero() {
        let mut text = Vec::new();
        let turned = Pose2::new(1.5, -1e-12, std::f64::consts::PI);
        let path = [(1_700_000_000_000_000_007, turned), (-500_000_000, turned)];
        tum(&mut text, &path).unwrap();
        assert_eq!(
            String::from_utf8(text).unwrap(),
            "1700000000.000000007 1.500000000 0.000000000 0 0 0 1.000000000 0.000000000\n\
             -0.500000000 1.500000000 0.000000000 0 0 0 1.000000000 0.000000000\n"
        );
    }
}
