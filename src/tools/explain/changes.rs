//! What would have given another label: the parameters that would have to change, and values that a
//! person can type.

use serde::{Serialize, Serializer, ser::SerializeStruct as _};

use super::readings::Obstacle;
use super::sequences::{SonarEntry, way_to};
use crate::core::config::{Config, TestBounds, Triple};
use crate::core::rounding::rounded;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::condition::Relation;
use crate::core::tmam::hypothesis::{Gate, HypothesisTest};
use crate::core::tmam::label::Label;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::Angles;
use crate::io::config::keys::{KEYS, Unit};

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
        let bound = match key.unit {
            Unit::Degrees => self.bound.to_degrees(),
            Unit::Plain => self.bound,
        };
        let holds = |value: f64| match key.unit {
            Unit::Degrees => self.relation.holds(value.to_radians(), self.bound),
            Unit::Plain => self.relation.holds(value, self.bound),
        };
        (2..=12).find_map(|decimals: u32| {
            let scale = 10_u64.pow(decimals) as f64;
            let (near, step) = if self.relation.is_upward() {
                ((bound * scale).ceil(), 1.0)
            } else {
                ((bound * scale).floor(), -1.0)
            };
            // The next number of this many digits, where the bound itself is one of them.
            let near_holds = holds(near / scale);
            let value = if near_holds { near } else { near + step } / scale;
            (value.is_finite() && key.bounds.hold(value) && holds(value)).then_some(value)
        })
    }

    /// The flag that sets such a value, as one types it.
    pub fn flag(&self) -> Option<String> {
        let value = self.value()?;
        Some(match self.key.strip_prefix("triple.") {
            Some(flag @ ("alpha" | "beta" | "gamma")) => format!("--{flag} {value}"),
            _ => format!("--set {}={value}", self.key),
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
pub struct LabelChange {
    /// The label.
    pub label: &'static str,
    /// Parameters that would all have to change. Empty where none can do it.
    pub needs: Vec<Need>,
    /// Why none can.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impossible: Option<&'static str>,
}

impl LabelChange {
    /// As one says it; `monotone` where every value beyond that of a need does it too.
    pub fn text(&self, monotone: bool) -> String {
        if let Some(why) = self.impossible {
            return format!("  {:<13} not here: {why}\n", self.label);
        }
        let needs = self.needs.iter().filter_map(|need| {
            let flag = need.flag()?;
            Some(match (monotone, need.relation.is_upward()) {
                (false, _) => flag,
                (true, true) => format!("{flag} or more"),
                (true, false) => format!("{flag} or less"),
            })
        });
        let needs = needs.collect::<Vec<_>>().join(" and ");
        format!("  {:<13} with {needs}\n", self.label)
    }

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
pub fn by_angles(
    label: Label,
    angles: &Angles,
    bounds: &Triple,
    narrowest: f64,
) -> Vec<LabelChange> {
    let (theta_c, theta_i) = (angles.theta_c, angles.theta_i);
    let fits = |need: &Need| match (need.value(), need.key) {
        (Some(degrees), "triple.gamma") => degrees.to_radians() < narrowest,
        (value, _) => value.is_some(),
    };
    // Of each condition whether it holds, and what would make it hold and what break it.
    let [alpha, contact_gate, beta, intersection_gate] = angles.conditions(bounds).map(|c| {
        let (hold, fail) = if c.relation.is_upward() {
            (Relation::Below, Relation::AtLeast)
        } else {
            (Relation::Above, Relation::AtMost)
        };
        let bound = match c.key {
            "triple.gamma" => c.found,
            _ => theta_c / theta_i,
        };
        (
            c.holds(),
            need(c.key, hold, bound),
            need(c.key, fail, bound),
        )
    });
    let (mut gained, mut lost) = (Vec::new(), Vec::new());
    for (of, conditions, in_order, out_of_order) in [
        (
            Label::Contact,
            [alpha, contact_gate],
            theta_c < theta_i,
            "theta_c is not below theta_i, and alpha is below 1",
        ),
        (
            Label::Intersection,
            [beta, intersection_gate],
            theta_c > theta_i,
            "theta_c is not above theta_i, and beta is above 1",
        ),
    ] {
        if of == label {
            let needs = conditions.into_iter().map(|(_, _, fails)| fails);
            let needs = needs.filter(|need| need.value().is_some());
            lost.extend(needs.map(|need| LabelChange::by("unidentified", vec![need])));
            if lost.is_empty() {
                let why = "the smaller angle is 0, which passes every bound";
                lost.push(LabelChange::impossible("unidentified", why));
            }
            continue;
        }
        let broken = conditions.into_iter().filter(|(holds, ..)| !holds);
        let needs: Vec<Need> = broken.map(|(_, hold, _)| hold).collect();
        gained.push(if !in_order {
            LabelChange::impossible(of.name(), out_of_order)
        } else if needs.iter().all(fits) {
            LabelChange::by(of.name(), needs)
        } else {
            LabelChange::impossible(of.name(), "gamma cannot be as wide as the beam")
        });
    }
    gained.extend(lost);
    gained
}

fn need(key: &'static str, relation: Relation, bound: f64) -> Need {
    Need {
        key,
        relation,
        bound,
    }
}

/// What would make the arc the middle of a triple, and the label that it would have `then`, if any.
pub fn by_neighbours(obstacles: &[Obstacle], then: Option<&'static str>) -> Vec<LabelChange> {
    let mut needs: Vec<Need> = Vec::new();
    for obstacle in obstacles {
        match needs.iter_mut().find(|known| known.key == obstacle.key) {
            Some(known) => known.bound = known.bound.max(obstacle.found),
            None => needs.push(need(obstacle.key, Relation::AtLeast, obstacle.found)),
        }
    }
    match needs.is_empty() {
        true => Vec::new(),
        false => vec![LabelChange::by(then.unwrap_or("a triple"), needs)],
    }
}

/// Every window that could be looked at around an arc, from the triple on: those that the rule looked
/// at, of which the report holds the last, and wider ones to which other parameters would lead.
#[derive(Debug)]
pub struct Windows<'a> {
    tests: Vec<HypothesisTest>,
    bounds: &'a TestBounds,
}

impl<'a> Windows<'a> {
    /// The windows around the arc at `place` of a sequence.
    pub fn new(sequence: &[SonarEntry<'_>], place: usize, config: &'a Config) -> Self {
        let report = |at: usize| sequence.get(at).and_then(|given| given.report);
        let bounds = &config.opinion;
        let continues = |to: usize| way_to(sequence, to).is_some_and(|way| way.continues(config));
        let room = (1..=place.min(bounds.max_half_width))
            .take_while(|m| continues(place - m + 1) && continues(place + m))
            .count();
        let (gate, circles) = (Gate::new(bounds.gate), config.departures().circles);
        let test = |m: usize| {
            let arcs = (place - m..=place + m).filter_map(|at| Some(report(at)?.arc));
            HypothesisTest::with_circles(circles, &arcs.collect::<Vec<Arc>>(), &gate)
        };
        Self {
            tests: (1..=room).map(test).collect(),
            bounds,
        }
    }

    /// Those that the rule looked at, narrowest first.
    pub fn looked_at(&self, report: &ArcReport) -> &[HypothesisTest] {
        let count = report.window.map_or(0, |last| last.half_width());
        self.tests.get(..count).unwrap_or(&self.tests)
    }

    /// What `opinion.gate` and `opinion.decisive` would have to be for another label: tried on
    /// either side of every value at which a window changes its mind, nearest first.
    pub fn changes(&self) -> Vec<LabelChange> {
        let (gate, decisive) = (self.bounds.gate, self.bounds.decisive);
        let Some(now) = self.label_with(gate, decisive) else {
            return Vec::new();
        };
        let lead = |test: &HypothesisTest| (test.chi2_line - test.chi2_point).abs();
        let gates = |test: &HypothesisTest| {
            let freedom = test.readings.saturating_sub(2);
            [test.chi2_line, test.chi2_point].map(|chi2| Gate::let_through(chi2, freedom))
        };
        let decisive_tried = tried(
            "opinion.decisive",
            decisive,
            self.tests.iter().map(lead),
            |decisive| self.label_with(gate, decisive),
        );
        let gate_tried = tried(
            "opinion.gate",
            gate,
            self.tests.iter().flat_map(gates),
            |gate| self.label_with(gate, decisive),
        );
        let why = if self.tests.len() == self.bounds.max_half_width {
            "neither opinion.decisive nor opinion.gate alone can do it; a larger opinion.max_half_width might"
        } else {
            "neither opinion.decisive nor opinion.gate alone can do it"
        };
        let mut changes = Vec::new();
        let circles = self.tests.iter().any(|test| test.chi2_circle.is_some());
        let names = ["contact", "intersection", "unidentified"];
        for name in names.into_iter().chain(circles.then_some("circle")) {
            let wanted = |(label, _): &&(Label, Need)| label.name() == name;
            let found = [&decisive_tried, &gate_tried].map(|tried| tried.iter().find(wanted));
            let needs = found.iter().flatten().map(|(_, need)| *need);
            if name == now.name() {
                continue;
            } else if found == [None, None] {
                changes.push(LabelChange::impossible(name, why));
            }
            changes.extend(needs.map(|need| LabelChange::by(name, vec![need])));
        }
        changes
    }

    /// The label under another gate and lead.
    fn label_with(&self, gate: f64, decisive: f64) -> Option<Label> {
        let gate = Gate::new(gate);
        let mut tests: Vec<HypothesisTest> = Vec::new();
        for test in self.tests.iter().map(|test| test.under(&gate)) {
            tests.push(test);
            if test.is_final(decisive) {
                break;
            }
        }
        let last = tests.len().checked_sub(1)?;
        let at = HypothesisTest::deciding(&tests, decisive).unwrap_or(last);
        Some(tests.get(at)?.label(decisive))
    }
}

/// Labels by the value of one parameter, from the nearest value outwards.
fn tried(
    key: &'static str,
    now: f64,
    bounds: impl Iterator<Item = f64>,
    label: impl Fn(f64) -> Option<Label>,
) -> Vec<(Label, Need)> {
    let mut bounds: Vec<f64> = bounds.filter(|bound| bound.is_finite()).collect();
    bounds.sort_by(|a, b| (a - now).abs().total_cmp(&(b - now).abs()));
    let needs = bounds.into_iter().map(|bound| match bound >= now {
        true => need(key, Relation::Above, bound),
        false => need(key, Relation::Below, bound),
    });
    needs
        .filter_map(|need| Some((label(need.value()?)?, need)))
        .collect()
}

#[cfg(test)]
mod tests;
