//! Sensors that measure with light among the sonars (DLu/navigation_layers#3, ros/common_msgs#73).

use super::examined::{Examined, in_words};
use super::finding::{Finding, Weight, which_sonars};

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    let sonars = &of.facts.sonars;
    let infrared: Vec<&str> = of
        .sonars()
        .filter(|(_, traits)| traits.infrared)
        .map(|(sonar, _)| sonar.name.as_str())
        .collect();
    if infrared.is_empty() {
        return Vec::new();
    }
    let all = infrared.len() == sonars.len();
    let sound = of.sonars().filter(|(_, traits)| !traits.infrared);
    let sound: Vec<String> = sound
        .map(|(sonar, _)| toml::Value::from(sonar.name.as_str()).to_string())
        .collect();
    let key = format!("input.sonars = [{}]", sound.join(", "));
    let tried = if all { None } else { of.tried(&key) };
    let found = Finding::new(
        if all {
            Weight::Notable
        } else {
            Weight::Serious
        },
        "infrared",
        format!(
            "{} {} with light by the messages (radiation_type = 1), not with sound",
            which_sonars(&infrared, sonars.len()),
            if infrared.len() == 1 {
                "measures"
            } else {
                "measure"
            }
        ),
        "a narrow beam of light sees one point, and where it looks past an edge a sonar does not",
        if all {
            "if they are sonars, mend radiation_type in the driver (0 is ultrasound)".to_owned()
        } else {
            format!(
                "leave them out: {key}{}, or --sensor",
                in_words(tried.as_ref())
            )
        },
    );
    vec![found.with(tried)]
}
