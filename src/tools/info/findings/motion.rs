//! What is wrong with the odometry.

use super::{Finding, Info, Weight, percent};
use crate::core::rounding::fixed;
use crate::core::wording::{counted, counted_with, seconds_between};
use crate::io::log::leaps::is_leap;
use crate::tools::info::motion::{Leap, OdometryFacts};
use crate::tools::info::statistics::{fraction, seconds};
use crate::tools::info::trial::wider_gap;

/// From this share of readings without a pose on, a part of the map is missing.
const MANY: f64 = 0.2;

/// Whatever is wrong with how the robot moved.
pub fn findings(info: &Info, findings: &mut Vec<Finding>) {
    let Some(odometry) = &info.odometry else {
        return;
    };
    still(info, odometry, findings);
    jumps(info, odometry, findings);
    without_pose(info, odometry, findings);
    let repeated: u64 = info
        .channels
        .iter()
        .filter(|c| c.used && c.topic == odometry.topic)
        .map(|c| c.repeated_stamps)
        .sum();
    if repeated > 0 {
        findings.push(Finding::new(
            Weight::Notable,
            "repeated-odometry",
            format!(
                "{} the stamp of the one before",
                counted_with(repeated, "odometry sample", "carries", "carry")
            ),
            "the first of them is taken for a reading at that instant",
            "look whether two nodes publish the odometry",
        ));
    }
}

fn still(info: &Info, odometry: &OdometryFacts, findings: &mut Vec<Finding>) {
    let frames = &info.trial.config.frames;
    if odometry.distance < frames.step && odometry.turning < frames.step_angle {
        findings.push(Finding::new(
            Weight::Serious,
            "still",
            format!(
                "the robot does not move: {:.2} m and {:.1} deg in all",
                odometry.distance,
                odometry.turning.to_degrees()
            ),
            "arcs from one place tell nothing of walls and corners: they all fall into one frame",
            "look whether the odometry is the right one; lower frames.step for a crawling robot",
        ));
    }
}

fn jumps(info: &Info, odometry: &OdometryFacts, findings: &mut Vec<Finding>) {
    let too_far = |leap: &&Leap| is_leap(leap.distance, leap.seconds);
    if let Some(jump) = odometry.largest_jump.as_ref().filter(too_far) {
        let at = seconds(info.start_ns, jump.stamp_ns);
        let told = fixed(at, 1);
        findings.push(Finding::new(
            Weight::Serious,
            "odometry-jump",
            format!(
                "the odometry jumps by {:.2} m in {:.3} s, at {told} s",
                jump.distance, jump.seconds
            ),
            "the map before and after it does not fit together",
            format!(
                "replay the parts by themselves: --end {:.1}, then --start {:.1}",
                at.max(0.0),
                (at + jump.seconds).max(0.0)
            ),
        ));
    }
}

fn without_pose(info: &Info, odometry: &OdometryFacts, findings: &mut Vec<Finding>) {
    let bound = info.trial.config.frames.max_odometry_gap;
    let lost = odometry.readings - odometry.readings_with_pose;
    let share = fraction(lost, odometry.readings);
    if lost > 0 {
        let outside = odometry.readings_before + odometry.readings_after;
        let slow = wider_gap(odometry, bound).is_some();
        findings.push(Finding::new(
            if share > MANY {
                Weight::Serious
            } else {
                Weight::Notable
            },
            "no-pose",
            format!(
                "{lost} of {} ({}) {} no pose: {} before the first odometry sample, {} \
                 after the last, {} in gaps wider than {bound} s",
                counted(odometry.readings, "reading"),
                percent(share),
                if lost == 1 { "has" } else { "have" },
                odometry.readings_before,
                odometry.readings_after,
                lost.saturating_sub(outside),
            ),
            "they are dropped",
            if slow {
                "the odometry is slow: raise frames.max_odometry_gap (skeleton below), and know that \
                 poses between samples are straight lines"
            } else if outside * 2 > lost {
                "record odometry for as long as the sonars; check that their clocks agree"
            } else {
                "look at what interrupts the odometry"
            },
        ));
    }
    if let Some(gap) = odometry.longest_gap.filter(|_| odometry.gaps > 0) {
        findings.push(Finding::new(
            Weight::Notable,
            "odometry-gaps",
            format!(
                "the odometry has {} wider than {bound} s; the longest is {:.1} s, at {} s",
                counted(odometry.gaps, "gap"),
                gap.seconds,
                seconds_between(info.start_ns, gap.stamp_ns, 1)
            ),
            if odometry.readings_with_pose == odometry.readings {
                "none: no reading falls into them"
            } else {
                "readings in them have no pose"
            },
            "",
        ));
    }
}
