//! Sonars on one mount.

use super::facts::Facts;
use super::finding::{Finding, Weight};

pub fn check(facts: &Facts) -> Option<Finding> {
    let mounts: Vec<_> = facts.sonars.iter().filter_map(|s| s.mount).collect();
    let same = mounts.array_windows().all(|[a, b]| a == b);
    (mounts.len() > 1 && same).then(|| {
        Finding::new(
            Weight::Serious,
            "one-mount",
            format!(
                "all {} sonars sit at the same place and look the same way",
                mounts.len()
            ),
            "a map from wrong mounts is wrong everywhere",
            "give the true mounts under [sonar.\"NAME\"], or mend the robot's transforms",
        )
    })
}
