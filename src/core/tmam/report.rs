//! All that is known of one arc.

use std::cmp::Ordering;
use std::sync::Arc as Shared;

use super::arc::Arc;
use super::hypothesis::{Gate, HypothesisTest};
use super::label::{Kind, Label, Reason};
use super::oblique::ObliqueWall;
use super::prediction::Prediction;
use super::triple::TripleTest;

/// What is known of an arc: its label, and all that was looked at for it.
#[derive(Debug, Clone, PartialEq)]
pub struct ArcReport {
    /// The arc.
    pub arc: Arc,
    /// What it belongs to.
    pub label: Label,
    /// How far what decides is from another label; `None` where nothing decides.
    pub margin: Option<Margin>,
    /// Whether the entry before it in its sonar's sequence is an echo, too.
    pub follows_echo: bool,
    /// What the arc and its neighbours say; `None` where they make no triple.
    pub triple: Option<TripleTest>,
    /// What the widest window around it that was looked at supports; `None` where it has no neighbour on one side.
    pub window: Option<HypothesisTest>,
    /// The rough wall that explains its readings at an angle, where no line and no point does. Few arcs have one.
    pub oblique: Option<Box<ObliqueWall>>,
    /// The run that the arc is in, where it has a label; known once that has closed.
    pub run: Option<RunTest>,
    /// Which feature of the final map should have echoed; known at the end of the log.
    pub map: Option<Prediction>,
}

/// How far what decides a label is from another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Margin {
    /// Radians that the angles lack, or have to spare, to the nearest bound: under the paper's rule.
    Angle(f64),
    /// Weighted squares of the residuals of the readings: under the noise-aware rule.
    Chi2(f64),
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
            follows_echo: false,
            triple: None,
            window: None,
            oblique: None,
            run: None,
            map: None,
        }
    }

    /// Radians to the nearest bound that would change the label, where angles decide.
    pub fn angle_margin(&self) -> Option<f64> {
        match self.margin? {
            Margin::Angle(radians) => Some(radians),
            Margin::Chi2(_) => None,
        }
    }

    /// How far the chi2 of its readings is from another label, where readings decide.
    pub fn chi2_margin(&self) -> Option<f64> {
        match self.margin? {
            Margin::Chi2(chi2) => Some(chi2),
            Margin::Angle(_) => None,
        }
    }

    /// The tests of the readings around it, narrowest first, with the word for whose they are.
    pub fn tests(&self) -> impl Iterator<Item = (&'static str, &HypothesisTest)> {
        let triple = self.triple.as_ref().map(|triple| ("triple", &triple.test));
        let window = self.window.as_ref().map(|test| ("window", test));
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
            let test = report.window.as_ref().or(triple)?;
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
        assert!(size_of::<ArcReport>() <= 312, "{}", size_of::<ArcReport>());
    }
}
