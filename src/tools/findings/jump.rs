//! Odometry that jumps: farther, or farther round, than a robot gets from one sample to the next by its speed
//! before and behind (aliasrobotics/RVD#595, introlab/rtabmap_ros#551, SteveMacenski/slam_toolbox#112).

use super::examined::Examined;
use super::finding::{Finding, Weight};
use super::laid::from_speeds;
use super::poses;
use crate::core::rounding::fixed;
use crate::core::statistics::seconds;
use crate::core::wording::times;
use crate::io::log::leaps::{jumps, window};

/// So many jumps are corrections that come again and again.
const SEVERAL: usize = 3;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    if poses::are_none(&of.survey.traits.poses) {
        return None; // headings turn over where the robot's axes do
    }
    let twice = of
        .survey
        .clock_set
        .as_ref()
        .map_or(&[][..], |set| &set.twice);
    let (events, input) = (&of.survey.log.events, &of.survey.config.input);
    let samples = window(&events.odometry, &events.readings, input.start, input.end);
    let jumps = jumps(samples, twice);
    let (first, last) = (jumps.first()?, jumps.last()?);
    let at = |stamp_ns: i64| seconds(of.facts.source.start_ns, stamp_ns).max(0.0);
    let largest = |i: usize| {
        let all = jumps.iter().filter_map(|jump| jump.excess.get(i));
        all.copied().fold(0.0, f64::max)
    };
    let again = jumps.len() >= SEVERAL;
    let when = if again {
        let apart = seconds(first.from.stamp_ns, last.from.stamp_ns) / (jumps.len() - 1) as f64;
        format!(
            "the first at {} s, then every {apart:.1} s on average",
            fixed(at(first.from.stamp_ns), 1)
        )
    } else {
        let all = jumps.iter().map(|jump| fixed(at(jump.from.stamp_ns), 1));
        format!("at {} s", all.collect::<Vec<_>>().join(" s and "))
    };
    let advice = if again {
        "replay the odometry that a localisation corrects so (--odom-topic, or input.world_frame = \"odom\"), which \
         drifts and does not jump"
            .to_owned()
    } else {
        format!(
            "replay the parts by themselves: --end {:.1}, then --start {:.1}",
            at(first.from.stamp_ns),
            at(first.to.stamp_ns)
        )
    };
    let by = if jumps.len() == 1 { "by" } else { "by up to" };
    let ways = ["take-out", "spread"].map(|how| format!("input.odometry_jumps = \"{how}\""));
    let keys = [ways.as_slice(), &[from_speeds()]].concat();
    let tried = of.best(&keys);
    // A robot that turned or drove between two samples, by what it heard behind.
    if tried.is_none() && of.worsens(&ways[0]) {
        return None;
    }
    Some(Finding::new(
        Weight::Serious,
        "odometry-jump",
        format!(
            "the odometry jumps {}, {when}, {by} {:.2} m and {:.1} deg more than the robot drives and turns",
            times(jumps.len() as u64),
            largest(0),
            largest(1).to_degrees()
        ),
        "the map before and after it does not fit together, and walls are drawn twice",
        match &tried {
            Some(tried) => format!("set {}{tried}; or {advice}", tried.keys),
            None => advice,
        },
    )
    .with(tried))
}
