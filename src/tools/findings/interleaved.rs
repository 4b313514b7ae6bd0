//! Two tracks on one odometry topic: two publishers, whose poses alternate.

use super::examined::Examined;
use super::finding::{Finding, Weight};
use crate::core::wording::counted;
use crate::io::log::tracks::two_tracks;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let samples = &of.survey.log.events.odometry;
    let [way, turn] = two_tracks(samples)?.apart;
    let topic = of.survey.odometry_topic.as_deref().unwrap_or_default();
    let keys = [1, 2].map(|track| format!("input.odometry_track = {track}"));
    let tried = of.best(&keys);
    let advice = match &tried {
        Some(tried) => format!("for this log {}{tried}", tried.keys),
        None => {
            "have one of them publish to a topic of its own and choose with --odom-topic".to_owned()
        }
    };
    Some(Finding::new(
        Weight::Serious,
        "two-tracks",
        format!(
            "the {} on {topic} are of two tracks that alternate, {way:.3} m and {:.2} deg apart in the middle: two \
             nodes publish it",
            counted(samples.len() as u64, "sample"),
            turn.to_degrees()
        ),
        "readings are placed by one and then by the other, and walls are drawn twice",
        format!("stop one of the two publishers (ros2 topic info -v names them); {advice}"),
    )
    .with(tried))
}
