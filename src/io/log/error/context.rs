//! What is said of an error besides itself, and what kind of one it is.

use std::path::Path;

use super::LogError;
use crate::io::log::container::{Loss, OpenError};

impl LogError {
    /// The same, in one line.
    pub(in crate::io::log) fn in_short(&self) -> String {
        match self {
            Self::NoMount(missing) => {
                let name = &missing.sonar;
                let why = &missing.why;
                format!("it has no mounting pose, {why}. Record /tf_static, or give x, y and yaw under [sonar.\"{name}\"]")
            }
            Self::NoBeamWidth { sonar, .. } => format!(
                "it has no beam width, its field_of_view is no angle above 0. Set beam_width under [sonar.\"{sonar}\"]"
            ),
            Self::NoRobotFrame { .. } => {
                "its mount is not in the configuration, and the odometry does not name the frame that it moves. \
                 Set input.robot_frame".to_owned()
            }
            other => other.to_string(),
        }
    }

    /// Whether the log may be well, and only the configuration does not say enough of it.
    pub fn wants_configuration(&self) -> bool {
        match self {
            Self::Io { .. }
            | Self::Empty { .. }
            | Self::NotMcap { .. }
            | Self::NoFile { .. }
            | Self::Unreadable { .. }
            | Self::Damaged { .. } => false,
            // Of a log without channels nothing can be configured.
            Self::NoRanges { found, .. } | Self::NoOdometry { found, .. } => !found.is_empty(),
            Self::Noted { source, .. } => source.wants_configuration(),
            _ => true,
        }
    }

    /// The same, and what else a person should know.
    pub(in crate::io::log) fn noting(self, notes: Vec<String>) -> Self {
        if notes.is_empty() {
            return self;
        }
        Self::Noted {
            source: Box::new(self),
            notes,
        }
    }

    /// What is missing may be what was lost.
    pub(in crate::io::log) fn after(self, losses: &[Loss]) -> Self {
        if losses.is_empty() {
            return self;
        }
        let losses = losses.iter().map(ToString::to_string).collect();
        match self {
            Self::NoRanges { file, found, .. } if found.is_empty() => {
                Self::Unreadable { file, losses }
            }
            error => Self::Damaged {
                source: Box::new(error),
                losses,
            },
        }
    }

    pub(in crate::io::log) fn open(path: &Path, error: OpenError) -> Self {
        let path = path.to_owned();
        match error {
            OpenError::Io(source) => Self::Io { path, source },
            OpenError::Empty => Self::Empty { path },
            OpenError::NotMcap => Self::NotMcap { path },
            OpenError::NoFile => Self::NoFile { path },
        }
    }
}
