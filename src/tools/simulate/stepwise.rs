//! Stop and go, as in the paper's experiment.

use crate::io::log::writer::Twist;

use super::motion::{Action, ROUNDING, Tick, limit, nanoseconds};
use super::{Path, SimulateError, positive, require};

/// Stop and go: all sonars fire at each stop, which has one stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepwise {
    /// Between stops along the path, metres.
    pub step: f64,
    /// How many stops; none for as many as the path has, a closed one once round.
    pub steps: Option<usize>,
    /// Between stops, seconds.
    pub interval: f64,
}

/// Twelve centimetres, which takes the paper's room in its 150 steps.
impl Default for Stepwise {
    fn default() -> Self {
        Self {
            step: 0.12,
            steps: None,
            interval: 0.4,
        }
    }
}

impl Stepwise {
    /// See [`Motion::schedule`](super::Motion::schedule).
    pub(super) fn schedule(&self, path: &Path, sonars: usize) -> Result<Vec<Tick>, SimulateError> {
        positive("the step in metres", self.step)?;
        positive("the time between steps in seconds", self.interval)?;
        let length = path.length();
        let fitting = length / self.step + ROUNDING;
        limit(self.steps.map_or(fitting, |steps| steps as f64) * sonars as f64)?;
        // A closed path ends on its first place, which then is not visited twice.
        let most = libm::floor(fitting) as usize + usize::from(!path.is_closed());
        let steps = match self.steps {
            None => most.max(1),
            Some(steps) if steps > most && !path.is_closed() => {
                return Err(SimulateError::PathTooShort {
                    steps,
                    step: self.step,
                    length,
                    most,
                });
            }
            Some(steps) => steps,
        };
        require(steps > 0, "the number of steps", 0.0, "1 or more")?;

        let ticks = (0..steps).flat_map(|step| {
            let tick = Tick {
                after_ns: nanoseconds(step as f64 * self.interval),
                world_from_robot: path.at(step as f64 * self.step),
                action: Action::Odometry(Twist::default()),
            };
            let shots = (0..sonars).map(move |sonar| Tick {
                action: Action::Fire(sonar),
                ..tick
            });
            std::iter::once(tick).chain(shots)
        });
        Ok(ticks.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::simulate::Motion;
    use crate::tools::simulate::motion::tests::{line, shots};

    #[test]
    fn the_room_takes_150_steps_of_16_shots() {
        let ticks = Motion::Stepwise(Stepwise::default())
            .schedule(&Path::room(), 16)
            .unwrap();
        assert_eq!(ticks.len(), 150 * 17);
        assert_eq!(ticks.last().unwrap().after_ns, 59_600_000_000);
        assert!(ticks.is_sorted_by_key(|tick| tick.after_ns));
    }

    #[test]
    fn steps_end_with_an_open_path_and_go_round_a_closed_one() {
        let stepwise = |steps| Stepwise {
            step: 0.5,
            steps,
            ..Stepwise::default()
        };
        let count = |path: &Path, steps| {
            let ticks = stepwise(steps).schedule(path, 1)?;
            Ok::<_, SimulateError>(shots(&ticks).len())
        };
        assert_eq!(count(&line(1.0), None).unwrap(), 3);
        assert_eq!(count(&line(1.0), Some(2)).unwrap(), 2);
        assert_eq!(count(&line(0.1), None).unwrap(), 1);
        assert!(matches!(
            count(&line(1.0), Some(4)),
            Err(SimulateError::PathTooShort { most: 3, .. })
        ));
        assert_eq!(count(&Path::room(), None).unwrap(), 36);
        assert_eq!(count(&Path::room(), Some(100)).unwrap(), 100);
        assert!(count(&Path::room(), Some(0)).is_err());
        assert!(count(&Path::room(), Some(usize::MAX)).is_err());
    }

    #[test]
    fn what_cannot_be_walked_is_refused() {
        for step in [0.0, -1.0, f64::NAN, 1e-300, f64::INFINITY] {
            let stepwise = Stepwise {
                step,
                ..Stepwise::default()
            };
            assert!(stepwise.schedule(&line(1.0), 16).is_err(), "{step}");
        }
    }
}
