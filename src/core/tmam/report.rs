//! All that is known of one arc.

use std::cmp::Ordering;
use std::sync::Arc as Shared;

use super::arc::Arc;
use super::condition::Condition;
use super::hypothesis::{Gate, HypothesisTest};
use super::label::{Kind, Label, Reason};
use super::oblique::ObliqueWall;
use super::prediction::Prediction;
use super::triple::{Between, TripleTest, Way, conditions};
use crate::core::config::Config;

/// What is known of an arc: its label, and all that was looked at for it.
#[derive(Debug, Clone, PartialEq)]
pub struct ArcReport {
    /// The arc.
    pub arc: Arc,
    /// What it belongs to.
    pub label: Label,
    /// Radians that the angles lack, or have to spare, to the nearest bound that would change the
    /// label; `None` where angles do not decide.
    pub margin: Option<f64>,
    /// How far the chi2 of its readings is from another label; `None` where readings do not decide.
    pub chi2_margin: Option<f64>,
    /// The way from the arc before it in its sonar's sequence; `None` where nothing echoed there.
    pub before: Option<Way>,
    /// The way to the arc after it.
    pub after: Option<Way>,
    /// The bend between the two, radians.
    pub bend: f64,
    /// What the arc and its neighbours say; `None` where they make no triple.
    pub triple: Option<TripleTest>,
    /// What the windows around it support, from the triple to the widest that was looked at. Empty
    /// where it has no neighbour on one side.
    pub windows: Shared<[HypothesisTest]>,
    /// The rough wall that explains its readings at an angle, where no line and no point does.
    pub oblique: Option<ObliqueWall>,
    /// The run that the arc is in, where it has a label; known once that has closed.
    pub run: Option<RunTest>,
    /// Which feature of the final map should have echoed; known at the end of the log.
    pub map: Option<Prediction>,
}

/// What all the readings of a run support.
#[derive(Debug, Clone, PartialEq)]
pub struct RunTest {
    /// The feature that was extracted from it.
    pub extraction: u32,
    /// The test, one for all arcs of the run; `None` by other methods.
    pub test: Option<Shared<HypothesisTest>>,
}

impl ArcReport {
    /// Of an arc after which nothing has echoed yet.
    pub fn new(arc: Arc) -> Self {
        Self {
            arc,
            label: Label::Unidentified(Reason::Missing),
            margin: None,
            chi2_margin: None,
            before: None,
            after: None,
            bend: 0.0,
            triple: None,
            windows: Shared::default(),
            oblique: None,
            run: None,
            map: None,
        }
    }

    /// The widest window that was looked at.
    pub fn window(&self) -> Option<&HypothesisTest> {
        self.windows.last()
    }

    /// The comparisons that make an arc with two neighbours the middle of a triple, in the order in
    /// which they are made; none without two neighbours.
    pub fn conditions(&self, config: &Config) -> Vec<(Between, Condition)> {
        let ways = self.before.as_ref().zip(self.after.as_ref());
        let all = ways.map(|(before, after)| conditions([before, after], self.bend, config));
        let all = all.into_iter().flatten();
        all.map(|(between, condition, _)| (between, condition))
            .collect()
    }

    /// The tests of the readings around it, narrowest first, with the word for whose they are.
    pub fn tests(&self) -> impl Iterator<Item = (&'static str, &HypothesisTest)> {
        let triple = self.triple.as_ref().map(|triple| ("triple", &triple.test));
        let window = self.window().map(|test| ("window", test));
        let run = self
            .run
            .as_ref()
            .and_then(|run| Some(("run", run.test.as_deref()?)));
        [triple, window, run].into_iter().flatten()
    }

    /// Whether the label is contradicted: how a wrong one is found without the truth. The map
    /// decides where it explains the reading; else the readings of the triple, of the window and of
    /// the run do.
    pub fn is_suspect(&self) -> bool {
        match self.kind_by_map() {
            Some(kind) => self.label.kind().is_some_and(|labelled| labelled != kind),
            None => self.tests().any(|(_, test)| test.contradicts(self.label)),
        }
    }

    /// How strongly the label is contradicted: the gate on chi2 with one degree of freedom from
    /// which on it would not be suspect. Infinite where the map says otherwise; zero where there is
    /// no label, or where the map says the same.
    pub fn doubt(&self) -> f64 {
        let Some(labelled) = self.label.kind() else {
            return 0.0;
        };
        match self.kind_by_map() {
            Some(kind) if kind == labelled => return 0.0,
            Some(_) => return f64::INFINITY,
            None => {}
        }
        let doubts = self.tests().map(|(_, test)| {
            let freedom = test.readings.saturating_sub(2);
            Gate::let_through(test.chi2_of(labelled), freedom)
        });
        doubts.fold(0.0, f64::max)
    }

    /// Puts the one that is contradicted more first: what the map contradicts, then what fits its label worst.
    pub fn worse_first(&self, other: &Self) -> Ordering {
        let fit = |report: &Self| {
            let triple = report.triple.as_ref().map(|triple| &triple.test);
            let test = report.window().or(triple)?;
            Some(test.chi2_of(report.label.kind()?))
        };
        let by_doubt = other.doubt().total_cmp(&self.doubt());
        let [one, two] = [self, other].map(|report| fit(report).unwrap_or_default());
        by_doubt.then(two.total_cmp(&one))
    }

    fn kind_by_map(&self) -> Option<Kind> {
        self.map?.support.kind()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_small_for_every_arc_of_a_log_has_one() {
        assert!(size_of::<ArcReport>() <= 400, "{}", size_of::<ArcReport>());
    }
}
