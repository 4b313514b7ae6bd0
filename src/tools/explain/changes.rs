//! What would have given another label: the parameters that would have to change, and values that a
//! person can type.

use serde::{Serialize, Serializer, ser::SerializeStruct as _};

use super::sequences::Given;
use super::situation::Situation;
use crate::core::config::{Config, Triple};
use crate::core::rounding::rounded;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::condition::Relation;
use crate::core::tmam::hypothesis::{Gate, HypothesisTest};
use crate::core::tmam::label::Label;
use crate::core::tmam::triple::Angles;
use crate::io::config::keys::{Bounds, KEYS, Unit};

/// A parameter and the bound that it would have to pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Need {
    /// The key of the configuration.
    pub key: &'static str,
    /// On which side of the bound.
    pub relation: Relation,
    /// The bound, SI units or radians.
    pub bound: f64,
}

impl Need {
    /// A value with few digits on the right side of the bound, as it is written in the
    /// configuration; `None` where the key does not take any.
    pub fn value(&self) -> Option<f64> {
        let key = KEYS.iter().find(|key| key.path == self.key)?;
        let inside = |value: f64| match key.unit {
            Unit::Degrees => value.to_radians(),
            Unit::Plain => value,
        };
        let bound = match key.unit {
            Unit::Degrees => self.bound.to_degrees(),
            Unit::Plain => self.bound,
        };
        let allowed = |value: f64| match key.bounds {
            Bounds::Any => true,
            Bounds::Between(low, high) => value > low && value < high,
            Bounds::Above(low) => value > low,
            Bounds::AtLeast(low) => value >= low,
        };
        (2..=12).find_map(|decimals: u32| {
            let scale = 10_u64.pow(decimals) as f64;
            let value = if self.relation.is_upward() {
                (bound * scale).ceil() / scale
            } else {
                (bound * scale).floor() / scale
            };
            let right = self.relation.holds(inside(value), self.bound);
            // The next number of this many digits, where the bound itself is one of them.
            let next = if self.relation.is_upward() {
                value + 1.0 / scale
            } else {
                value - 1.0 / scale
            };
            let next = (next * scale).round() / scale;
            let value = if right { value } else { next };
            (value.is_finite() && allowed(value) && self.relation.holds(inside(value), self.bound))
                .then_some(value)
        })
    }

    /// The flag that sets such a value, as one types it.
    pub fn flag(&self) -> Option<String> {
        let value = self.value()?;
        Some(match self.key {
            "triple.alpha" => format!("--alpha {value}"),
            "triple.beta" => format!("--beta {value}"),
            "triple.gamma" => format!("--gamma {value}"),
            key => format!("--set {key}={value}"),
        })
    }
}

impl Serialize for Need {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut need = serializer.serialize_struct("Need", 4)?;
        need.serialize_field("key", self.key)?;
        need.serialize_field("relation", self.relation.sign())?;
        need.serialize_field("bound", &rounded(self.bound))?;
        need.serialize_field("flag", &self.flag())?;
        need.end()
    }
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
/// [`Angles::label`], solved for the parameters. `narrowest` is the narrowest
/// beam of the replay, radians, which gamma must stay below.
pub fn by_angles(label: Label, angles: &Angles, bounds: &Triple, narrowest: f64) -> Vec<Change> {
    let (theta_c, theta_i) = (angles.theta_c, angles.theta_i);
    let [alpha_holds, contact_gate, beta_holds, intersection_gate] =
        angles.conditions(bounds).map(|condition| condition.holds());
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
            let need = alpha(Relation::Above);
            fulfil("contact", theta_c, alpha_holds, need, contact_gate)
        } else {
            Change::impossible(
                "contact",
                "theta_c is not below theta_i, and alpha is below 1",
            )
        });
    }
    if label != Label::Intersection {
        changes.push(if theta_c > theta_i {
            let need = beta(Relation::Below);
            fulfil("intersection", theta_i, beta_holds, need, intersection_gate)
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

/// What would make the arc the middle of a triple, and the label that it would have `then`, if any.
pub fn by_neighbours(situation: &Situation, then: Option<&'static str>) -> Vec<Change> {
    let mut needs: Vec<Need> = Vec::new();
    for obstacle in &situation.obstacles {
        match needs.iter_mut().find(|known| known.key == obstacle.key) {
            Some(known) => known.bound = known.bound.max(obstacle.found),
            None => needs.push(need(obstacle.key, Relation::AtLeast, obstacle.found)),
        }
    }
    let change = Change::by(then.unwrap_or("a triple"), needs);
    (!change.needs.is_empty())
        .then_some(change)
        .into_iter()
        .collect()
}

/// Every window that could be looked at around an arc, from the triple on: those that the rule looked
/// at, and wider ones to which other parameters would lead.
#[derive(Debug, Clone, PartialEq)]
pub struct Windows {
    tests: Vec<HypothesisTest>,
    gate: f64,
    decisive: f64,
    max_half_width: usize,
}

impl Windows {
    /// The windows around the arc at `place` of a sequence.
    pub fn new(sequence: &[Given<'_>], place: usize, config: &Config) -> Self {
        let report = |at: usize| sequence.get(at).and_then(|given| given.report);
        let bounds = &config.opinion;
        let continues = |to: usize| {
            let way = report(to).and_then(|report| report.before);
            way.is_some_and(|way| way.continues(config))
        };
        let room = (1..=place.min(bounds.max_half_width))
            .take_while(|m| continues(place - m + 1) && continues(place + m))
            .count();
        let gate = Gate::new(bounds.gate);
        let mut tests = report(place).map_or_else(Vec::new, |report| report.windows.clone());
        for m in tests.len() + 1..=room {
            let arcs = (place - m..=place + m).filter_map(|at| Some(report(at)?.arc));
            tests.push(HypothesisTest::of(&arcs.collect::<Vec<Arc>>(), &gate));
        }
        Self {
            tests,
            gate: bounds.gate,
            decisive: bounds.decisive,
            max_half_width: bounds.max_half_width,
        }
    }

    /// What `opinion.gate` and `opinion.decisive` would have to be for another label: tried on
    /// either side of every value at which a window changes its mind, nearest first.
    pub fn changes(&self) -> Vec<Change> {
        let Some(now) = self.label_with(self.gate, self.decisive) else {
            return Vec::new();
        };
        let finite = |opinion: &HypothesisTest| {
            let lead = (opinion.chi2_line - opinion.chi2_point).abs();
            let freedom = opinion.readings.saturating_sub(2);
            let gates = [opinion.chi2_line, opinion.chi2_point];
            (lead, gates.map(|chi2| Gate::let_through(chi2, freedom)))
        };
        let bounds: Vec<_> = self.tests.iter().map(finite).collect();
        let leads = bounds.iter().map(|(lead, _)| *lead);
        let gates = bounds.iter().flat_map(|(_, gates)| *gates);
        let decisive = self.tried("opinion.decisive", self.decisive, leads, |decisive| {
            self.label_with(self.gate, decisive)
        });
        let gate = self.tried("opinion.gate", self.gate, gates, |gate| {
            self.label_with(gate, self.decisive)
        });
        let why = if self.tests.len() == self.max_half_width {
            "neither opinion.decisive nor opinion.gate alone can do it; a larger opinion.max_half_width might"
        } else {
            "neither opinion.decisive nor opinion.gate alone can do it"
        };
        let mut changes = Vec::new();
        for name in ["contact", "intersection", "unidentified"] {
            if name == now.name() {
                continue;
            }
            let found = [&decisive, &gate].into_iter().filter_map(|tried| {
                let (_, need) = tried.iter().find(|(label, _)| *label == name)?;
                Some(Change::by(name, vec![*need]))
            });
            let before = changes.len();
            changes.extend(found);
            if changes.len() == before {
                changes.push(Change::impossible(name, why));
            }
        }
        changes
    }

    /// Labels by the value of one parameter, from the nearest value outwards.
    fn tried(
        &self,
        key: &'static str,
        now: f64,
        bounds: impl Iterator<Item = f64>,
        label: impl Fn(f64) -> Option<Label>,
    ) -> Vec<(&'static str, Need)> {
        let mut bounds: Vec<f64> = bounds.filter(|bound| bound.is_finite()).collect();
        bounds.sort_by(|a, b| (a - now).abs().total_cmp(&(b - now).abs()));
        let needs = bounds.into_iter().map(|bound| {
            let upward = bound >= now;
            let relation = if upward {
                Relation::Above
            } else {
                Relation::Below
            };
            need(key, relation, bound)
        });
        needs
            .filter_map(|need| Some((label(need.value()?)?.name(), need)))
            .collect()
    }

    /// The label under another gate and lead.
    fn label_with(&self, gate: f64, decisive: f64) -> Option<Label> {
        let gate = Gate::new(gate);
        let mut tests = self.tests.iter().map(|test| test.under(&gate));
        let last = tests.clone().next_back()?;
        let test = tests.find(|test| test.is_final(decisive)).unwrap_or(last);
        Some(test.label(decisive))
    }
}

#[cfg(test)]
mod tests;
