//! Sonars against sonars: are they where they were, and do they measure what they did?

use super::compare::{angle, length};
use std::collections::BTreeSet;

use super::difference::{Change, SonarDifference, Value};
use super::results::{Labels, Measured};
use super::tolerance::Tolerance;

/// The sonars that are gone, new, mounted otherwise or measure otherwise.
pub fn compare_sonars(
    golden: &Labels,
    actual: &Labels,
    tolerance: &Tolerance,
) -> Vec<SonarDifference> {
    let sensors: BTreeSet<&String> = [golden, actual]
        .into_iter()
        .flat_map(|labels| labels.sonars.keys().chain(labels.measured.keys()))
        .collect();
    let of = |sensor: &String| {
        let [then, now] = [golden, actual].map(|labels| labels.sonars.get(sensor).map(Vec::len));
        match (then, now) {
            (Some(arcs), None) => vec![count(
                arcs.to_string(),
                "none, the sonar is gone".to_owned(),
            )],
            (None, Some(arcs)) => vec![count(
                "none".to_owned(),
                format!("{arcs}, the sonar is new"),
            )],
            _ => golden
                .measured
                .get(sensor)
                .zip(actual.measured.get(sensor))
                .map_or_else(Vec::new, |(then, now)| changes(then, now, tolerance)),
        }
    };
    sensors
        .into_iter()
        .map(|sensor| SonarDifference {
            sensor: sensor.clone(),
            changes: of(sensor),
        })
        .filter(|difference| !difference.changes.is_empty())
        .collect()
}

fn count(golden: String, actual: String) -> Change {
    Change {
        what: "arcs",
        value: Value::Word { golden, actual },
    }
}

fn changes(then: &Measured, now: &Measured, tolerance: &Tolerance) -> Vec<Change> {
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
    use super::super::difference::Difference;
    use super::super::results::{LabelledArc, Mark};
    use super::super::text::describe;
    use super::*;

    #[test]
    fn a_sonar_that_is_gone_or_new_is_named_in_a_line() {
        let arc = LabelledArc {
            stamp_ns: 0,
            mark: Mark::Contact,
            frame: None,
            margin: None,
            reason: None,
        };
        let with = |name: &str| Labels {
            sonars: [
                ("left".to_owned(), vec![arc]),
                (name.to_owned(), vec![arc; 3]),
            ]
            .into(),
            ..Labels::default()
        };
        let found = compare_sonars(&with("front"), &with("rear"), &Tolerance::default());
        let text = |at: usize| describe(&Difference::Sonar(found[at].clone()), None);
        assert_eq!(found.len(), 2);
        assert_eq!(text(0), "front: arcs 3 -> none, the sonar is gone");
        assert_eq!(text(1), "rear: arcs none -> 3, the sonar is new");
    }

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
