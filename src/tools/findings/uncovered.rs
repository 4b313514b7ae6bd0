//! Readings that no odometry covers.

use super::facts::Facts;
use super::finding::{Finding, Weight, percent};
use super::odometry::OdometryFacts;
use super::trial::wider_gap;
use crate::core::statistics::fraction;
use crate::core::wording::{counted, seconds_between};
use Weight::{Notable, Serious};

/// From this share of readings without a pose on, a part of the map is missing.
const MANY_WITHOUT_POSE: f64 = 0.2;

pub fn check(_: &Facts, odometry: &OdometryFacts) -> Option<Finding> {
    let bound = odometry.gap_bound;
    let lost = odometry.readings - odometry.readings_with_pose;
    let share = fraction(lost, odometry.readings);
    let outside = odometry.readings_before + odometry.readings_after;
    (lost > 0).then(|| {
        Finding::new(
            if share > MANY_WITHOUT_POSE {
                Serious
            } else {
                Notable
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
            if wider_gap(odometry, bound).is_some() {
                "the odometry is slow: raise frames.max_odometry_gap (skeleton below), and know that \
                 poses between samples are straight lines"
            } else if outside * 2 > lost {
                "record odometry for as long as the sonars; check that their clocks agree"
            } else {
                "look at what interrupts the odometry"
            },
        )
    })
}

pub fn gaps(facts: &Facts, odometry: &OdometryFacts) -> Option<Finding> {
    let gap = odometry.longest_gap.filter(|_| odometry.gaps > 0)?;
    Some(Finding::new(
        Notable,
        "odometry-gaps",
        format!(
            "the odometry has {} wider than {} s; the longest is {:.1} s, at {} s",
            counted(odometry.gaps, "gap"),
            odometry.gap_bound,
            gap.seconds,
            seconds_between(facts.source.start_ns, gap.stamp_ns, 1)
        ),
        if odometry.readings_with_pose == odometry.readings {
            "none: no reading falls into them"
        } else {
            "readings in them have no pose"
        },
        "",
    ))
}
