//! What became of the arcs.

use super::{Finding, Info, Weight, percent};
use crate::tools::info::Verdict;
use crate::tools::info::statistics::fraction;

/// From so many arcs on, shares mean something.
const ENOUGH: u64 = 20;
/// With fewer labelled arcs than this there is hardly a map.
const FEW: f64 = 0.05;
/// A reason that holds for more arcs than this is worth a word.
const MOST: f64 = 0.5;

/// Whether too few arcs are labelled, and why.
pub fn findings(info: &Info, findings: &mut Vec<Finding>) {
    // What placeholders give says nothing of the log.
    let Some(outcome) = info
        .trial
        .outcome
        .as_ref()
        .filter(|_| info.verdict == Verdict::Yes)
    else {
        return;
    };
    let labelled = outcome.labelled("contact") + outcome.labelled("intersection");
    let arcs = labelled + outcome.labelled("unidentified");
    // The commonest; of equally common ones the first by name.
    let Some((reason, count)) = outcome
        .reasons
        .iter()
        .rev()
        .max_by_key(|(_, count)| **count)
    else {
        return;
    };
    let few = fraction(labelled, arcs) < FEW;
    if arcs < ENOUGH || !(few || fraction(*count, arcs) > MOST) {
        return;
    }
    let (what, mend) = explain(reason);
    findings.push(Finding::new(
        if few {
            Weight::Serious
        } else {
            Weight::Notable
        },
        "few-labels",
        format!(
            "{} of {arcs} arcs are labelled; {} are not because {what} ({reason})",
            percent(fraction(labelled, arcs)),
            percent(fraction(*count, arcs)),
        ),
        "walls and corners in which they belong are missing from the map",
        mend,
    ));
}

fn explain(reason: &str) -> (&'static str, &'static str) {
    match reason {
        "missing" => (
            "no echo came before or after",
            "look at max_range: sonars that look into the open rarely echo three times in a row",
        ),
        "gap" => (
            "the readings before or after are too far away",
            "drive slower, or raise sequence.max_gap or sequence.max_baseline",
        ),
        "turning" => (
            "the robot turned",
            "drive straight for longer, or raise triple.turn_tolerance or triple.bend_tolerance",
        ),
        "wide" => (
            "neither angle is below gamma",
            "noise does that, and wrong mounts or poses; triple.gamma is the gate",
        ),
        "ambiguous" => (
            "wall and corner fit alike",
            "the steps are short for the ranges: try a wider frames.step",
        ),
        _ => (
            "no wall or corner fits the ranges inside the beam",
            "noise and targets that change do that, a beam width that is too small, and wrong mounts, \
             clocks or poses: look at the recording",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_has_its_own_words() {
        let reasons = [
            "missing",
            "gap",
            "turning",
            "no-points",
            "wide",
            "ambiguous",
        ];
        let mut words: Vec<_> = reasons.iter().map(|reason| explain(reason)).collect();
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), reasons.len());
    }
}
