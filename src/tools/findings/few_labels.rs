//! Why most arcs have no label.

use super::examined::Examined;
use super::finding::{Finding, Weight, percent};
use super::trial::Replayable;
use crate::core::config::Method;
use crate::core::statistics::fraction;
use Weight::{Notable, Serious};

/// What the finding is called.
pub const CODE: &str = "few-labels";
/// From so many arcs on, shares mean something.
const ENOUGH_ARCS: u64 = 20;

/// With fewer labelled arcs than this there is hardly a map.
const FEW: f64 = 0.05;

/// A reason that holds for more arcs than this is worth a word.
const MOST: f64 = 0.5;

/// Why most arcs have no label, and what helps, by the reason.
const REASONS: [(&str, &str, &str); 5] = [
    (
        "missing",
        "no echo came before or after",
        "look at max_range: sonars that look into the open rarely echo three times in a row",
    ),
    (
        "gap",
        "the readings before or after are too far away",
        "drive slower, or raise sequence.max_gap or sequence.max_baseline",
    ),
    (
        "turning",
        "the robot turned",
        "drive straight for longer, or raise triple.turn_tolerance or triple.bend_tolerance",
    ),
    (
        "wide",
        "neither angle is below gamma",
        "noise does that, and wrong mounts or poses; triple.gamma is the gate",
    ),
    (
        "ambiguous",
        "wall and corner fit alike",
        "the steps are short for the ranges: try a wider frames.step",
    ),
];

/// What is said of every other reason.
const NEITHER_FITS: (&str, &str) = (
    "no wall or corner fits the ranges inside the beam",
    "noise and targets that change do that, a beam width that is too small, and wrong mounts, \
     clocks or poses: look at the recording",
);

pub fn check(of: &Examined<'_>) -> Option<Finding> {
    let facts = of.facts;
    // What placeholders give says nothing of the log.
    let outcome = facts.replay.outcome.as_ref();
    let outcome = outcome.filter(|_| facts.replay.possible == Replayable::Yes)?;
    // Other methods label what they use, which may be little.
    if of.survey.config.method != Method::Tmam {
        return None;
    }
    let labelled = outcome.labelled("contact") + outcome.labelled("intersection");
    let arcs = labelled + outcome.labelled("unidentified");
    // The commonest; of equally common ones the first by name.
    let by_name = outcome.reasons.iter().rev();
    let (reason, count) = by_name.max_by_key(|(_, count)| **count)?;
    let few = fraction(labelled, arcs) < FEW;
    if arcs < ENOUGH_ARCS || !(few || fraction(*count, arcs) > MOST) {
        return None;
    }
    let known = REASONS.iter().find(|(name, ..)| name == reason);
    let (what, mend) = known.map_or(NEITHER_FITS, |(_, what, mend)| (what, mend));
    // That wall and corner fit alike is no fault: a sonar alone rarely decides.
    let is_fault = few && *reason != "ambiguous";
    Some(Finding::new(
        if is_fault { Serious } else { Notable },
        CODE,
        format!(
            "{} of {arcs} arcs are labelled; {} are not because {what} ({reason})",
            percent(fraction(labelled, arcs)),
            percent(fraction(*count, arcs)),
        ),
        "walls and corners in which they belong are missing from the map",
        mend,
    ))
}
