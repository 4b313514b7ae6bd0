//! The paper's rule line by line, and what would have changed its label.

use serde::Serialize;

use super::need::{Need, Relation};
use crate::core::config::Triple;
use crate::core::rounding::{number, optional};
use crate::core::tmam::label::Label;

/// One comparison of the rule.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Condition {
    /// The label that needs it.
    pub label: &'static str,
    /// `theta_c` or `theta_i`.
    pub angle: &'static str,
    /// Its value, radians.
    #[serde(serialize_with = "number")]
    pub value: f64,
    /// `<` or `>`.
    pub relation: &'static str,
    /// The parameter: `alpha`, `beta` or `gamma`.
    pub parameter: &'static str,
    /// What it is multiplied with: the value of `theta_i`, radians; `None` for gamma.
    #[serde(serialize_with = "optional")]
    pub times: Option<f64>,
    /// The bound, radians.
    #[serde(serialize_with = "number")]
    pub bound: f64,
    /// Whether it holds.
    pub holds: bool,
}

/// The four comparisons of the rule: two for each label.
pub fn conditions(theta_c: f64, theta_i: f64, bounds: &Triple) -> [Condition; 4] {
    let condition = |label, angle, value, relation: Relation, parameter, times, bound| Condition {
        label,
        angle,
        value,
        relation: relation.sign(),
        parameter,
        times,
        bound,
        holds: relation.holds(value, bound),
    };
    let gate = |label, angle, value| {
        condition(
            label,
            angle,
            value,
            Relation::Below,
            "gamma",
            None,
            bounds.gamma,
        )
    };
    let ratio = |label, relation, parameter, factor: f64| {
        let bound = factor * theta_i;
        condition(
            label,
            "theta_c",
            theta_c,
            relation,
            parameter,
            Some(theta_i),
            bound,
        )
    };
    [
        ratio("contact", Relation::Below, "alpha", bounds.alpha),
        gate("contact", "theta_c", theta_c),
        ratio("intersection", Relation::Above, "beta", bounds.beta),
        gate("intersection", "theta_i", theta_i),
    ]
}

/// What would give another label.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// The label.
    pub label: &'static str,
    /// Parameters that would all have to change. Empty where none can do it.
    pub needs: Vec<Need>,
    /// Why none can.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impossible: Option<&'static str>,
}

impl Change {
    fn by(label: &'static str, needs: Vec<Need>) -> Self {
        Self {
            label,
            needs,
            impossible: None,
        }
    }

    fn impossible(label: &'static str, why: &'static str) -> Self {
        Self {
            label,
            needs: Vec::new(),
            impossible: Some(why),
        }
    }
}

/// What alpha, beta and gamma would have to be for another label: the conditions of
/// [`judge`](crate::core::tmam::triple::judge), solved for the parameters. `narrowest` is the narrowest
/// beam of the replay, radians, which gamma must stay below.
pub fn changes(
    label: Label,
    theta_c: f64,
    theta_i: f64,
    bounds: &Triple,
    narrowest: f64,
) -> Vec<Change> {
    let ratio = theta_c / theta_i;
    let alpha = |relation| need("triple.alpha", relation, ratio);
    let beta = |relation| need("triple.beta", relation, ratio);
    let gamma = |relation, bound| need("triple.gamma", relation, bound);
    let mut changes = Vec::new();
    let fulfil = |name, smaller: f64, ratio_holds: bool, ratio_need: Need, gate_holds: bool| {
        let mut needs = Vec::new();
        if !ratio_holds {
            needs.push(ratio_need);
        }
        if !gate_holds {
            needs.push(gamma(Relation::Above, smaller));
        }
        let gamma_fits = |need: &Need| {
            need.key != "triple.gamma" || need.value().is_some_and(|v| v.to_radians() < narrowest)
        };
        if needs.iter().all(|n| n.value().is_some() && gamma_fits(n)) {
            Change::by(name, needs)
        } else {
            Change::impossible(name, "gamma cannot be as wide as the beam")
        }
    };
    if label != Label::Contact {
        changes.push(if theta_c < theta_i {
            let holds = theta_c < bounds.alpha * theta_i;
            let gate = theta_c < bounds.gamma;
            fulfil("contact", theta_c, holds, alpha(Relation::Above), gate)
        } else {
            Change::impossible(
                "contact",
                "theta_c is not below theta_i, and alpha is below 1",
            )
        });
    }
    if label != Label::Intersection {
        changes.push(if theta_c > theta_i {
            let holds = theta_c > bounds.beta * theta_i;
            let gate = theta_i < bounds.gamma;
            fulfil("intersection", theta_i, holds, beta(Relation::Below), gate)
        } else {
            Change::impossible(
                "intersection",
                "theta_c is not above theta_i, and beta is above 1",
            )
        });
    }
    let losing = match label {
        Label::Contact => vec![alpha(Relation::AtMost), gamma(Relation::AtMost, theta_c)],
        Label::Intersection => vec![beta(Relation::AtLeast), gamma(Relation::AtMost, theta_i)],
        Label::Unidentified(_) => return changes,
    };
    let losing = losing.into_iter().filter(|need| need.value().is_some());
    let losing: Vec<Change> = losing
        .map(|n| Change::by("unidentified", vec![n]))
        .collect();
    if losing.is_empty() {
        let why = "the smaller angle is 0, which passes every bound";
        changes.push(Change::impossible("unidentified", why));
    }
    changes.extend(losing);
    changes
}

fn need(key: &'static str, relation: Relation, bound: f64) -> Need {
    Need {
        key,
        relation,
        bound,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::tmam::pair::{PairPoint, Points};
    use crate::core::tmam::triple::judge;
    use proptest::prelude::*;

    const BEAM: f64 = 0.4;

    /// Judges two angles as the machine does, by points that lie so far apart.
    fn label(theta_c: f64, theta_i: f64, bounds: &Triple) -> Label {
        let at = |bearing: f64| {
            let point = PairPoint {
                bearing_a: bearing,
                bearing_b: bearing,
                on_a: nalgebra::Vector2::zeros(),
                on_b: nalgebra::Vector2::zeros(),
            };
            [Some(point), None]
        };
        let points = |contact, intersection| Points {
            contact: at(contact),
            intersection: at(intersection),
        };
        judge(points(0.0, 0.0), points(theta_c, theta_i), BEAM, bounds).0
    }

    /// The parameters with every need of a change passed, or missed, by a hair.
    fn moved(change: &Change, bounds: &Triple, passed: bool) -> Triple {
        let mut moved = bounds.clone();
        for need in &change.needs {
            let hair = if passed == need.relation.is_upward() {
                1e-9
            } else {
                -1e-9
            };
            let value = need.bound * (1.0 + hair);
            *match need.key {
                "triple.alpha" => &mut moved.alpha,
                "triple.beta" => &mut moved.beta,
                _ => &mut moved.gamma,
            } = value;
        }
        moved
    }

    /// The parameters as a person would type them.
    fn typed(change: &Change, bounds: &Triple) -> Triple {
        let mut typed = bounds.clone();
        for need in &change.needs {
            let value = need.value().unwrap();
            match need.key {
                "triple.alpha" => typed.alpha = value,
                "triple.beta" => typed.beta = value,
                _ => typed.gamma = value.to_radians(),
            }
        }
        typed
    }

    proptest! {
        #[test]
        fn judged_again_with_the_changed_parameter_the_label_is_the_other_one(
            theta_c in 1e-4..0.39_f64, theta_i in 1e-4..0.39_f64,
            alpha in 0.05..0.95_f64, beta in 1.05..6.0_f64, gamma in 0.01..0.38_f64,
        ) {
            let bounds = Triple { alpha, beta, gamma, ..Triple::default() };
            let now = label(theta_c, theta_i, &bounds);
            let changes = changes(now, theta_c, theta_i, &bounds, BEAM);
            prop_assert!(changes.iter().all(|change| change.label != now.name()));
            for change in &changes {
                if change.impossible.is_some() {
                    continue;
                }
                prop_assert!(!change.needs.is_empty());
                let after = label(theta_c, theta_i, &typed(change, &bounds));
                prop_assert_eq!(after.name(), change.label, "{:?}", change);
                let after = label(theta_c, theta_i, &moved(change, &bounds, true));
                prop_assert_eq!(after.name(), change.label, "{:?}", change);
                let short = label(theta_c, theta_i, &moved(change, &bounds, false));
                prop_assert_ne!(short.name(), change.label, "{:?}", change);
            }
        }

        #[test]
        fn what_is_called_impossible_is_so_for_every_parameter(
            theta_c in 1e-4..0.4_f64, theta_i in 1e-4..0.4_f64,
            alpha in 0.01..0.99_f64, beta in 1.01..50.0_f64, gamma in 0.001..0.399_f64,
        ) {
            let bounds = Triple::default();
            let now = label(theta_c, theta_i, &bounds);
            let any = Triple { alpha, beta, gamma, ..Triple::default() };
            let then = label(theta_c, theta_i, &any);
            for change in changes(now, theta_c, theta_i, &bounds, BEAM) {
                if change.impossible.is_some() {
                    prop_assert_ne!(then.name(), change.label, "{:?}", change);
                }
            }
        }
    }

    #[test]
    fn the_comparisons_are_those_of_the_rule() {
        let bounds = Triple::default();
        let held = |theta_c, theta_i| conditions(theta_c, theta_i, &bounds).map(|c| c.holds);
        assert_eq!(held(0.01, 0.1), [true, true, false, true]);
        assert_eq!(held(0.1, 0.01), [false, true, true, true]);
        assert_eq!(held(0.39, 0.39), [false, false, false, false]);
    }
}
