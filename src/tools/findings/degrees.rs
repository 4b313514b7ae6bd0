//! Scans whose angles are in degrees (PilzDE/psen_scan_v2#180).

use super::examined::Examined;
use super::finding::{Finding, Weight, which_sonars};

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    let scans = of.sonars().filter(|(_, traits)| traits.in_degrees);
    let scans: Vec<&str> = scans.map(|(sonar, _)| sonar.name.as_str()).collect();
    if scans.is_empty() {
        return Vec::new();
    }
    let sonars = of.facts.sonars.len();
    vec![Finding::new(
        Weight::Notable,
        "scan-in-degrees",
        format!(
            "scans span more than a turn in radians ({}): their angles are taken for degrees",
            which_sonars(&scans, sonars)
        ),
        "other programs take the angles for radians and put these beams anywhere",
        "mend the driver: angle_min, angle_max and angle_increment are in radians".to_owned(),
    )]
}
