//! Sonars whose frames are a camera's: z forward, x to the right, y down (PX4/PX4-SITL_gazebo-classic#361).

use super::examined::{Examined, in_words};
use super::finding::{Finding, Weight, which_sonars};

const KEY: &str = "sonars.beam_axis = \"z\"";

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let optical: Vec<_> = of.sonars().filter(|(_, mount)| mount.is_optical).collect();
    let names: Vec<&str> = optical
        .iter()
        .map(|(sonar, _)| sonar.name.as_str())
        .collect();
    if 2 * names.len() <= of.facts.sonars.len() {
        return None;
    }
    let is_called_so = optical
        .iter()
        .all(|(_, mount)| mount.frame.contains("optical"));
    let tried = of.tried(KEY);
    (is_called_so || tried.is_some()).then(|| {
        Finding::new(
            Weight::Serious,
            "optical",
            format!(
                "the frames of {} have y pointing down, as those of cameras: z is forward in these (REP 103), and \
                 beams are taken to look along x",
                which_sonars(&names, of.facts.sonars.len())
            ),
            "every beam is taken to look 90 deg to the right of where it does",
            format!("set {KEY}{}", in_words(tried.as_ref())),
        )
        .with(tried)
    })
}
