//! Sonars against sonars: are they where they were, and do they measure what they did?

use super::compare::{angle, length};
use super::difference::SonarDifference;
use super::results::{Labels, Measured};
use super::tolerance::Tolerance;

/// The sonars that are mounted or measure otherwise. One that is not there on both sides is left to
/// the labels, which are gone or new.
pub fn compare_sonars(
    golden: &Labels,
    actual: &Labels,
    tolerance: &Tolerance,
) -> Vec<SonarDifference> {
    let pairs = golden
        .measured
        .iter()
        .filter_map(|(sensor, then)| Some((sensor, then, actual.measured.get(sensor)?)));
    pairs
        .map(|(sensor, then, now)| SonarDifference {
            sensor: sensor.clone(),
            changes: changes(then, now, tolerance),
        })
        .filter(|difference| !difference.changes.is_empty())
        .collect()
}

fn changes(then: &Measured, now: &Measured, tolerance: &Tolerance) -> Vec<super::Change> {
    let ([x, y, yaw], [u, v, turned]) = (then.mount, now.mount);
    [
        length("mount x", x, u, tolerance.position),
        length("mount y", y, v, tolerance.position),
        angle("mount yaw", yaw, turned, tolerance.theta),
        length("mean range", then.mean_range, now.mean_range, tolerance.rho),
    ]
    .into_iter()
    .flatten()
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sonar_that_turned_or_measures_otherwise_is_named_with_what_changed() {
        let with = |mount: [f64; 3], mean_range: f64| {
            let measured = Measured { mount, mean_range };
            Labels {
                measured: [("left".to_owned(), measured)].into(),
                ..Labels::default()
            }
        };
        let golden = with([0.1, 0.2, 3.138], 2.0);
        let what = |actual: &Labels| -> Vec<&str> {
            let found = compare_sonars(&golden, actual, &Tolerance::default());
            found
                .iter()
                .flat_map(|one| one.changes.iter().map(|change| change.what))
                .collect()
        };
        assert_eq!(what(&with([0.105, 0.2, -3.138], 2.005)), Vec::<&str>::new());
        assert_eq!(what(&with([0.1, 0.2, 3.10], 2.0)), ["mount yaw"]);
        assert_eq!(
            what(&with([0.1, 0.25, 3.138], 2.02)),
            ["mount y", "mean range"]
        );
        assert_eq!(what(&Labels::default()), Vec::<&str>::new());
    }
}
