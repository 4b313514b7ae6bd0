//! Which arc is meant.

use crate::core::event::{Sonar, SonarId, name_of};
use crate::core::geometry::{Vec2, direction, unit};
use crate::core::observer::Setting;
use crate::core::pattern::{PatternError, glob_set};
use crate::core::statistics::seconds;
use crate::core::tmam::arc::Arc;

use super::sequences::{Sequences, SonarEntry};

/// What names an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Which {
    /// The arc that the sonar gave this frame.
    Frame(u32),
    /// The sonar's arc nearest to this many seconds after the log's first reading.
    Time(f64),
    /// The arc that passes nearest to a place in the world, metres: what one points at in the map.
    Place(Vec2),
}

/// A question about an arc.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// Globs over the names of the sonars it may be of; empty for all.
    pub sonars: Vec<String>,
    /// Which of their arcs.
    pub which: Which,
}

/// The answer: an arc, and how it was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// The arc.
    pub arc: Arc,
    /// How far it passes from the place that was asked for, metres.
    pub distance: Option<f64>,
    /// How long after the time that was asked for it was measured, seconds.
    pub late: Option<f64>,
}

impl Question {
    /// Finds the arcs that answer it, the best first; never none.
    ///
    /// # Errors
    /// When no arc does.
    pub fn answers(
        &self,
        sequences: &Sequences<'_>,
        setting: &Setting<'_>,
        origin_ns: i64,
    ) -> Result<Vec<Answer>, QuestionError> {
        let sonars = sonars(&self.sonars, sequences, setting)?;
        let names = || sonars.iter().map(|(_, sonar)| sonar.name.clone()).collect();
        let one_sonar = || match sonars.as_slice() {
            [one] => Ok(*one),
            _ => Err(QuestionError::WhichSonar { sonars: names() }),
        };
        let arcs = || {
            let of = |arc: &&Arc| sonars.iter().any(|(id, _)| *id == arc.id.sonar);
            sequences.arcs().filter(of)
        };
        let found = |arc: &Arc, distance, late| Answer {
            arc: *arc,
            distance,
            late,
        };
        let mut answers: Vec<Answer> = match self.which {
            Which::Frame(frame) => {
                let (id, sonar) = one_sonar()?;
                let arc = arcs().find(|arc| arc.id.frame == frame);
                let arc = arc.ok_or_else(|| no_arc(sequences, id, sonar, frame))?;
                vec![found(arc, None, None)]
            }
            Which::Time(asked) => {
                one_sonar()?;
                let from = seconds(origin_ns, setting.source.start_ns);
                let to = seconds(origin_ns, setting.source.end_ns);
                // Times are typed to the millisecond at most.
                if asked < from - 1e-3 || asked > to + 1e-3 {
                    return Err(QuestionError::OutsideTime { asked, from, to });
                }
                let late = |arc: &Arc| seconds(origin_ns, arc.stamp_ns) - asked;
                arcs()
                    .map(|arc| found(arc, None, Some(late(arc))))
                    .collect()
            }
            Which::Place(place) => arcs()
                .map(|arc| found(arc, Some(distance(arc, place)), None))
                .collect(),
        };
        answers.sort_by(|a, b| a.off().total_cmp(&b.off()));
        let best = answers.first();
        let best = *best.ok_or_else(|| QuestionError::NoEcho { sonars: names() })?;
        let reach = arcs().map(|arc| arc.range).fold(0.0, f64::max);
        let Which::Place(place) = self.which else {
            return Ok(answers);
        };
        if best.off() <= reach {
            return Ok(answers);
        }
        let (id, center) = (best.arc.id, best.arc.center());
        let (low, high) = arcs().fold((center, center), |(low, high), arc| {
            (low.inf(&arc.center()), high.sup(&arc.center()))
        });
        let typed = |place: Vec2| format!("{:.2},{:.2}", place.x, place.y);
        Err(QuestionError::FarAway {
            x: place.x,
            y: place.y,
            sonar: name_of(setting.sonars, id.sonar).to_owned(),
            frame: id.frame,
            distance: best.off(),
            reach,
            low: typed(low),
            high: typed(high),
        })
    }
}

impl Answer {
    /// How far it is from what was asked for.
    fn off(&self) -> f64 {
        self.distance.or(self.late).map_or(0.0, f64::abs)
    }
}

/// The flags that name an arc, safe to type.
pub fn command(sensor: &str, frame: u32) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./:".contains(c);
    if !sensor.is_empty() && sensor.chars().all(plain) {
        return format!("--sensor {sensor} --frame {frame}");
    }
    let sensor = sensor.replace('\'', r"'\''");
    format!("--sensor '{sensor}' --frame {frame}")
}

/// The sonars with such names that have entries.
///
/// # Errors
/// When there is none.
pub fn sonars<'a>(
    globs: &[String],
    sequences: &Sequences<'_>,
    setting: &Setting<'a>,
) -> Result<Vec<(SonarId, &'a Sonar)>, QuestionError> {
    let names = glob_set(globs)?;
    let seen = || {
        let ids = sequences.sonars();
        ids.filter_map(|id| Some((id, setting.sonars.get(id.index())?)))
    };
    let matching: Vec<_> = seen()
        .filter(|(_, sonar)| {
            globs.is_empty() || names.is_match(&sonar.name) || globs.contains(&sonar.name)
        })
        .collect();
    if matching.is_empty() {
        return Err(QuestionError::NoSuchSonar {
            asked: globs.to_vec(),
            sonars: seen().map(|(_, sonar)| sonar.name.clone()).collect(),
        });
    }
    Ok(matching)
}

/// How far a place lies from the nearest point of an arc, metres.
fn distance(arc: &Arc, place: Vec2) -> f64 {
    let away = place - arc.center();
    if arc.beam_holds(direction(away)) {
        return (away.norm() - arc.range).abs();
    }
    let yaw = arc.world_from_sensor.yaw;
    let ends = [yaw - arc.beam_width / 2.0, yaw + arc.beam_width / 2.0];
    let ends = ends.map(|bearing| (away - unit(bearing) * arc.range).norm());
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

fn no_arc(sequences: &Sequences<'_>, id: SonarId, sonar: &Sonar, frame: u32) -> QuestionError {
    let [first, last] = sequences.frames;
    if !(first..=last).contains(&frame) {
        return QuestionError::NoSuchFrame { frame, first, last };
    }
    let sequence = sequences.of(id);
    let fired = sequence.iter().any(|given| given.frame == frame);
    let arcs = || sequence.iter().filter(|given| given.report.is_some());
    let before = arcs().rfind(|given| given.frame < frame);
    let after = arcs().find(|given| given.frame > frame);
    let near = match (before, after) {
        (None, None) => "; it gave no echo in the whole replay".to_owned(),
        (Some(SonarEntry { frame, .. }), None) | (None, Some(SonarEntry { frame, .. })) => {
            format!("; its nearest arc is in frame {frame}")
        }
        (Some(before), Some(after)) => {
            let (before, after) = (before.frame, after.frame);
            format!("; its nearest arcs are in frames {before} and {after}")
        }
    };
    QuestionError::NoArc {
        sonar: sonar.name.clone(),
        frame,
        why: if fired {
            "nothing echoed"
        } else {
            "it did not fire, or its reading could not be used"
        },
        near,
    }
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum QuestionError {
    /// No sonar has such a name.
    #[error("no sonar matches {}; the log has {}", asked.join(", "), sonars.join(", "))]
    NoSuchSonar {
        /// What was asked for.
        asked: Vec<String>,
        /// The log's sonars that have entries.
        sonars: Vec<String>,
    },
    /// A frame or a time alone does not name an arc.
    #[error(
        "--frame and --time name an arc of one sonar: give it with --sensor NAME. Of those asked for, \
         the log has {}", sonars.join(", ")
    )]
    WhichSonar {
        /// Those that match.
        sonars: Vec<String>,
    },
    /// There is no such frame.
    #[error("there is no frame {frame}: the replay has frames {first} to {last}")]
    NoSuchFrame {
        /// Asked for.
        frame: u32,
        /// The first one.
        first: u32,
        /// The last one.
        last: u32,
    },
    /// The frame holds no echo of the sonar.
    #[error("{sonar} has no arc in frame {frame}: {why}{near}")]
    NoArc {
        /// The sonar.
        sonar: String,
        /// The frame.
        frame: u32,
        /// Nothing came back, or it did not fire.
        why: &'static str,
        /// The arcs around it.
        near: String,
    },
    /// The log does not last that long.
    #[error(
        "--time {asked} s is outside the replay, which lasts from {from:.3} s to {to:.3} s after the \
         log's first reading"
    )]
    OutsideTime {
        /// Asked for, seconds.
        asked: f64,
        /// The replay's first reading.
        from: f64,
        /// Its last one.
        to: f64,
    },
    /// Nothing was measured there.
    #[error(
        "no arc passes near {x},{y}: the nearest, of {sonar} in frame {frame}, passes {distance:.2} m from \
         it, and the longest echo is {reach:.2} m. The sonars were between {low} and {high}, metres in \
         the odometry frame"
    )]
    FarAway {
        /// Asked for, metres.
        x: f64,
        /// Asked for, metres.
        y: f64,
        /// Whose arc is nearest.
        sonar: String,
        /// Its frame.
        frame: u32,
        /// How far it passes, metres.
        distance: f64,
        /// Of the sonars asked for, metres.
        reach: f64,
        /// Where the sonars were, as one types it.
        low: String,
        /// See `low`.
        high: String,
    },
    /// Not one echo.
    #[error("{} gave no echo in the whole replay, so there is no arc to explain", sonars.join(", "))]
    NoEcho {
        /// The sonars.
        sonars: Vec<String>,
    },
    /// A glob.
    #[error(transparent)]
    Glob(#[from] PatternError),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Pose2;
    use crate::core::tmam::arc::ArcId;

    #[test]
    fn an_arc_ends_where_its_beam_does() {
        let arc = Arc {
            id: ArcId {
                frame: 0,
                sonar: SonarId(0),
            },
            stamp_ns: 0,
            world_from_sensor: Pose2::new(1.0, 0.0, 0.0),
            range: 2.0,
            beam_width: 0.4,
            variance: 1e-4,
        };
        let on_axis = distance(&arc, Vec2::new(3.25, 0.0));
        assert!((on_axis - 0.25).abs() < 1e-12, "{on_axis}");
        // Behind the sensor, on the circle but not on the arc.
        let behind = distance(&arc, Vec2::new(-1.0, 0.0));
        assert!(behind > 3.9, "{behind}");
    }
}
