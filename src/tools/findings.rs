//! What a person should know of a log, what it does to the map and what to do about it: the log held against
//! physics, and what stands in the way of a replay. A check a file; `info` tells all of it, `replay` what is
//! serious.

mod arrangement;
mod axes;
mod clocks;
mod coarse_ranges;
mod contradicted;
mod dead;
mod degrees;
mod distances;
pub mod examined;
pub mod facts;
mod few_labels;
pub mod finding;
mod heading;
mod infrared;
mod interleaved;
mod jump;
mod laid;
mod limits;
mod losses;
mod mounts;
mod noise;
mod obstacles;
pub mod odometry;
mod one_mount;
mod pillars;
mod poses;
mod repeats;
mod robot_frame;
mod sonar;
pub mod sonars;
mod speed;
mod stamps;
mod stand_in;
mod still;
pub mod trial;
mod uncovered;
mod units;
mod unread;
mod unsaid;
mod variances;

use examined::Examined;
use facts::Facts;
use finding::{Finding, Weight};
use trial::Explained;

use crate::core::legible::one_line;
use crate::core::replay::CauseTold;
use crate::core::rounding::fixed;

/// A check.
type Check = fn(&Examined<'_>) -> Vec<Finding>;

/// In the order in which findings of one weight are told.
const CHECKS: [Check; 32] = [
    |of| unread::check(of.facts),
    |of| obstacles::findings(of.facts, &of.survey.obstacles),
    |of| losses::check(of.facts).into_iter().collect(),
    poses::check,
    speed::check,
    mounts::check,
    contradicted::check,
    robot_frame::check,
    axes::check,
    arrangement::check,
    interleaved::check,
    jump::check,
    heading::check,
    variances::check,
    distances::check,
    stand_in::check,
    infrared::check,
    degrees::check,
    |of| of_odometry(of, still::check),
    |of| of_odometry(of, uncovered::check),
    |of| of_odometry(of, uncovered::gaps),
    |of| of_odometry(of, stamps::repeated_odometry),
    |of| stamps::clock_set(of.facts).into_iter().collect(),
    |of| stamps::check(of.facts),
    clocks::check,
    limits::check,
    repeats::check,
    sonar::check,
    one_mount::check,
    dead::check,
    pillars::check,
    last,
];

fn last(of: &Examined<'_>) -> Vec<Finding> {
    let checks = [coarse_ranges::check, noise::check, few_labels::check];
    checks.iter().filter_map(|check| check(of)).collect()
}

fn of_odometry(
    of: &Examined<'_>,
    check: fn(&Facts, &odometry::OdometryFacts) -> Option<Finding>,
) -> Vec<Finding> {
    let odometry = of.facts.odometry.as_ref();
    let found = odometry.and_then(|odometry| check(of.facts, odometry));
    found.into_iter().collect()
}

/// Everything found, the weightiest first.
pub fn findings(of: &Examined<'_>) -> Vec<Finding> {
    let mut found: Vec<Finding> = CHECKS.iter().flat_map(|check| check(of)).collect();
    let unsaid = unsaid::check(of.facts, &of.survey.log.notes, &found);
    found.extend(unsaid);
    found.sort_by_key(|finding| finding.weight);
    found
}

/// Causes that are told, at most.
const CAUSES: usize = 3;

/// What is wrong by physics and was tried and mends most of it: causes, the one that explains most first. What else
/// is off is not seen before that is mended.
pub fn causes(found: &[Finding]) -> Vec<CauseTold> {
    let tried = found
        .iter()
        .filter(|finding| finding.weight < Weight::Notable);
    let tried = tried.filter_map(|finding| Some((finding, finding.tried.as_ref()?)));
    let mut causes: Vec<_> = tried
        .filter_map(|(finding, tried)| {
            Some((finding, tried, tried.without.filter(|_| tried.is_most())?))
        })
        .collect();
    causes.sort_by(|(_, a, _), (_, b, _)| a.with.bits.total_cmp(&b.with.bits));
    causes.truncate(CAUSES);
    let told = causes.into_iter().map(|(finding, tried, without)| {
        let settings: Vec<String> = tried
            .keys
            .lines()
            .map(|key| key.replacen(" = ", "=", 1))
            .collect();
        let share = |of: Explained| fixed(100.0 * of.share, 1);
        // Without an arc there are none.
        let bits = |from: Explained, to: Explained| match from.bits.is_finite() {
            true => format!(
                ", bits from {} to {}",
                fixed(from.bits, 2),
                fixed(to.bits, 2)
            ),
            false => String::new(),
        };
        CauseTold {
            text: format!(
                "{}: with {} explained goes from {} to {} %{}",
                one_line(&finding.what),
                settings.join(", "),
                share(without),
                share(tried.with),
                bits(without, tried.with)
            ),
            settings,
            sonar: None,
        }
    });
    told.collect()
}

/// How many serious findings a replay tells of.
const TOLD: usize = 4;

/// What a replay tells: what is serious and not noted, the weightiest first.
pub fn to_warn_of(found: &[Finding]) -> Vec<&Finding> {
    let is_serious = |finding: &&Finding| finding.weight < Weight::Notable;
    let serious = || found.iter().filter(is_serious);
    // Few labels follow from what else is wrong.
    let is_cause = |finding: &&Finding| finding.code != few_labels::CODE;
    let has_cause = serious().any(|finding| is_cause(&finding));
    let told = serious().filter(|finding| !finding.is_noted() && (is_cause(finding) || !has_cause));
    told.collect()
}

/// The first few of them, a line each.
pub fn warnings(serious: &[&Finding], named: &str) -> String {
    let told = serious.iter().take(TOLD);
    let mut text: String = told
        .map(|finding| format!("warning: {}\n", finding.line()))
        .collect();
    if let more @ 1.. = serious.len().saturating_sub(TOLD) {
        text.push_str(&format!(
            "warning: and {more} more: tmam info {named} tells them\n"
        ));
    }
    text
}
