//! The second opinion window by window, as the noise-aware rule widens it, and what would have
//! changed its label.

use serde::Serialize;

use super::need::{Need, Relation};
use super::rule::Change;
use super::watch::Given;
use crate::core::config::Config;
use crate::core::geometry::angle_between;
use crate::core::rounding::number;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::Kind;
use crate::core::tmam::hypothesis::{Gate, HypothesisTest, Support};
use crate::core::tmam::sequence::gap;
use crate::core::tmam::label::{Label, Reason};

/// The readings `k-m ..= k+m` around an arc, and what they support.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Window {
    /// Readings to either side: m.
    pub half_width: usize,
    /// Frame of the first reading.
    pub first_frame: u32,
    /// Frame of the last reading.
    pub last_frame: u32,
    /// Squares that remain of the best line.
    #[serde(serialize_with = "number")]
    pub chi2_line: f64,
    /// Squares that remain of the best point.
    #[serde(serialize_with = "number")]
    pub chi2_point: f64,
    /// A model explains the readings when its chi2 is below this.
    #[serde(serialize_with = "number")]
    pub gate: f64,
    /// What the readings support: `line`, `point`, `ambiguous` or `neither`.
    pub support: &'static str,
    /// What they decide, if they do: `line` or `point`.
    pub decides: Option<&'static str>,
}

/// Every window that could be looked at around an arc, from the triple on.
#[derive(Debug, Clone, PartialEq)]
pub struct Windows {
    opinions: Vec<(HypothesisTest, u32, u32)>,
    gate: f64,
    decisive: f64,
    /// Readings to either side that the sequence has.
    pub room: usize,
    /// At most this many are looked at.
    pub max_half_width: usize,
}

impl Windows {
    /// The windows around the arc at `place` of a sequence.
    pub fn new(sequence: &[Given], place: usize, config: &Config) -> Self {
        let arc = |at: usize| sequence.get(at).and_then(|given| given.arc);
        let max_half_width = config.opinion.max_half_width;
        let joined = |a: Option<Arc>, b: Option<Arc>| match (a, b) {
            (Some(a), Some(b)) => {
                let turn = angle_between(a.world_from_sensor.yaw, b.world_from_sensor.yaw);
                !gap(&a, &b, &config.sequence) && turn <= config.triple.turn_tolerance
            }
            _ => false,
        };
        let room = (1..=place.min(max_half_width))
            .take_while(|m| {
                let (low, high) = (place - m, place + m);
                joined(arc(low), arc(low + 1)) && joined(arc(high - 1), arc(high))
            })
            .count();
        let gate = Gate::new(config.opinion.gate);
        let opinions = (1..=room).map(|m| {
            let arcs: Vec<Arc> = (place - m..=place + m).filter_map(arc).collect();
            let frame = |arc: Option<&Arc>| arc.map_or(0, |arc| arc.id.frame);
            let ends = (frame(arcs.first()), frame(arcs.last()));
            (HypothesisTest::of(&arcs, &gate), ends.0, ends.1)
        });
        Self {
            opinions: opinions.collect(),
            gate: config.opinion.gate,
            decisive: config.opinion.decisive,
            room,
            max_half_width,
        }
    }

    /// The windows that were looked at: up to the one that ended it.
    pub fn looked_at(&self) -> Vec<Window> {
        let gate = Gate::new(self.gate);
        let windows = (1..)
            .zip(&self.opinions)
            .take(self.last(self.gate, self.decisive));
        windows
            .map(|(half_width, (opinion, first_frame, last_frame))| Window {
                half_width,
                first_frame: *first_frame,
                last_frame: *last_frame,
                chi2_line: opinion.chi2_line,
                chi2_point: opinion.chi2_point,
                gate: gate.at(opinion.readings.saturating_sub(2)),
                support: opinion.support.name(),
                decides: opinion.decided(self.decisive).map(Kind::name),
            })
            .collect()
    }

    /// Why no wider window was looked at than the `last` one: `decided`, `neither`, `max-half-width`
    /// or `no-more-readings`.
    pub fn end(&self, last: &Window) -> &'static str {
        match (last.decides, last.support) {
            (Some(_), _) => "decided",
            (None, "neither") => "neither",
            _ if self.room == self.max_half_width => "max-half-width",
            _ => "no-more-readings",
        }
    }

    /// The label that the windows give; `None` without any.
    pub fn label(&self) -> Option<Label> {
        self.label_with(self.gate, self.decisive)
    }

    /// What `opinion.gate` and `opinion.decisive` would have to be for another label: tried on
    /// either side of every value at which a window changes its mind, nearest first.
    pub fn changes(&self) -> Vec<Change> {
        let Some(now) = self.label() else {
            return Vec::new();
        };
        let finite = |(opinion, _, _): &(HypothesisTest, u32, u32)| {
            let lead = (opinion.chi2_line - opinion.chi2_point).abs();
            let freedom = opinion.readings.saturating_sub(2);
            let gates = [opinion.chi2_line, opinion.chi2_point];
            (lead, gates.map(|chi2| Gate::let_through(chi2, freedom)))
        };
        let bounds: Vec<_> = self.opinions.iter().map(finite).collect();
        let leads = bounds.iter().map(|(lead, _)| *lead);
        let gates = bounds.iter().flat_map(|(_, gates)| *gates);
        let decisive = self.tried("opinion.decisive", self.decisive, leads, |decisive| {
            self.label_with(self.gate, decisive)
        });
        let gate = self.tried("opinion.gate", self.gate, gates, |gate| {
            self.label_with(gate, self.decisive)
        });
        let why = if self.room == self.max_half_width {
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
                Some(Change {
                    label: name,
                    needs: vec![*need],
                    impossible: None,
                })
            });
            let before = changes.len();
            changes.extend(found);
            if changes.len() == before {
                changes.push(Change {
                    label: name,
                    needs: Vec::new(),
                    impossible: Some(why),
                });
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
        let needs = bounds.into_iter().map(|bound| Need {
            key,
            relation: if bound >= now {
                Relation::Above
            } else {
                Relation::Below
            },
            bound,
        });
        needs
            .filter_map(|need| Some((label(need.value()?)?.name(), need)))
            .collect()
    }

    /// How many windows are looked at.
    fn last(&self, gate: f64, decisive: f64) -> usize {
        let gate = Gate::new(gate);
        let ends = |opinion: &HypothesisTest| {
            let opinion = under(opinion, &gate);
            opinion.decided(decisive).is_some() || opinion.support == Support::Neither
        };
        let place = self
            .opinions
            .iter()
            .position(|(opinion, _, _)| ends(opinion));
        place.map_or(self.opinions.len(), |place| place + 1)
    }

    fn label_with(&self, gate: f64, decisive: f64) -> Option<Label> {
        let last = self.last(gate, decisive).checked_sub(1)?;
        let (opinion, _, _) = self.opinions.get(last)?;
        let opinion = under(opinion, &Gate::new(gate));
        Some(match (opinion.decided(decisive), opinion.support) {
            (Some(Kind::Line), _) => Label::Contact,
            (Some(Kind::Point), _) => Label::Intersection,
            (None, Support::Neither) => Label::Unidentified(Reason::Neither),
            (None, _) => Label::Unidentified(Reason::Ambiguous),
        })
    }
}

/// The same readings under another gate.
fn under(opinion: &HypothesisTest, gate: &Gate) -> HypothesisTest {
    let gate = gate.at(opinion.readings.saturating_sub(2));
    HypothesisTest {
        support: match (opinion.chi2_line < gate, opinion.chi2_point < gate) {
            (true, false) => Support::Line,
            (false, true) => Support::Point,
            (true, true) => Support::Ambiguous,
            (false, false) => Support::Neither,
        },
        ..*opinion
    }
}

#[cfg(test)]
mod tests;
