//! One sonar's stream: from its entries to triples, windows, labels and runs.

use std::collections::VecDeque;
use std::sync::Arc as Shared;

use super::arc::{Arc, ArcId};
use super::hypothesis::Gate;
use super::label::Label;
use super::report::{ArcReport, RunTest};
use super::rule::{Decision, Pending, Policies};
use super::run::{Run, Runs};
use super::step::Extraction;
use super::triple::{TripleTest, Way, bend, obstacle};
use super::window::{AdaptiveWindow, WindowResult};
use crate::core::config::Config;

/// One sonar's stream of entries.
#[derive(Debug, Clone, Default)]
pub struct Stream {
    /// The last two entries; `None` where nothing echoed.
    last_two: [Option<Arc>; 2],
    window: AdaptiveWindow,
    runs: Runs,
    pending: VecDeque<Pending>,
    /// Where the reports on its labelled arcs are among those of all sonars, in order.
    labelled: Vec<usize>,
}

impl Stream {
    /// Takes the sonar's next entry, `None` for no echo: it completes the triple of the arc before
    /// it.
    pub fn triple(&mut self, next: Option<Arc>, config: &Config, gate: &Gate) {
        let [before, middle] = std::mem::take(&mut self.last_two);
        let way = middle.zip(next).map(|(a, b)| Way::between(&a, &b));
        if let (Some(middle), Some(newest)) = (middle, self.pending.back_mut()) {
            newest.is_followed = true;
            if let (Some(before), Some(after)) = (before, next)
                && let (Some(way_before), Some(way_after)) = (newest.before, way)
            {
                let three = [before, middle, after];
                let report = &mut newest.report;
                match obstacle([&way_before, &way_after], bend(&three), config) {
                    Some(reason) => report.label = Label::Unidentified(reason),
                    None => {
                        let mut triple = TripleTest::of(&three, &config.triple, gate);
                        // Three readings fix its three unknowns.
                        triple.test.chi2_circle = config.departures().circles.then_some(0.0);
                        report.triple = Some(triple);
                        newest.triple = Some(three);
                    }
                }
            }
        }
        self.last_two = [middle, next];
        if let Some(arc) = next {
            let mut report = ArcReport::new(arc);
            report.follows_echo = way.is_some();
            self.pending.push_back(Pending {
                report,
                before: way,
                triple: None,
                is_followed: false,
                window: None,
            });
        }
    }

    /// Widens the windows that the newest entry completes. Arcs that are labelled already have theirs in `reports`.
    pub fn window(
        &mut self,
        next: Option<Arc>,
        config: &Config,
        gate: &Gate,
        reports: &mut [ArcReport],
    ) {
        let newest = self.pending.back().filter(|_| next.is_some());
        let way = newest.and_then(|newest| newest.before);
        if !way.is_some_and(|way| way.continues(config)) {
            let ended = self.window.end();
            self.settle(ended, reports);
        }
        if let Some(arc) = next {
            let before = self.pending.iter().rev().nth(1);
            let triple = before.and_then(|before| Some(before.report.triple?.test));
            let settled = {
                let circles = config.departures().circles;
                (self.window).push(arc, triple, &config.opinion, circles, gate)
            };
            self.settle(settled, reports);
        }
    }

    /// Labels the next arc in order, if what decides is known; its report is added to those of all sonars.
    pub fn label(
        &mut self,
        rule: &Policies,
        reports: &mut Vec<ArcReport>,
    ) -> Option<(ArcReport, Decision)> {
        let decision = rule.label(self.pending.front()?)?;
        let Pending {
            mut report, window, ..
        } = self.pending.pop_front()?;
        report.label = decision.label;
        report.margin = decision.margin;
        let oblique = window.as_ref().and_then(|window| window.oblique);
        report.oblique = oblique.map(Box::new);
        report.window = window.and_then(|window| window.test);
        self.labelled.push(reports.len());
        reports.push(report.clone());
        Some((report, decision))
    }

    /// Takes a labelled arc into the open run; returns the run that it closed.
    pub fn run(&mut self, rule: &Policies, report: &ArcReport, decision: &Decision) -> Option<Run> {
        rule.run(&mut self.runs, report, decision)
    }

    /// Notes in the reports of a closed run which feature it gave.
    pub fn note(&self, extraction: &Extraction, reports: &mut [ArcReport]) {
        let test = extraction.opinion.map(Shared::new);
        for arc in &extraction.labelled {
            if let Some(report) = self.labelled(*arc, reports) {
                report.run = Some(RunTest {
                    extraction: extraction.id,
                    test: test.clone(),
                });
            }
        }
    }

    fn labelled<'r>(&self, arc: ArcId, reports: &'r mut [ArcReport]) -> Option<&'r mut ArcReport> {
        let is_before = |place: &usize| reports.get(*place).is_some_and(|it| it.arc.id < arc);
        let at = self.labelled.partition_point(is_before);
        let report = reports.get_mut(*self.labelled.get(at)?);
        report.filter(|report| report.arc.id == arc)
    }

    fn settle(&mut self, results: Vec<WindowResult>, reports: &mut [ArcReport]) {
        for result in results {
            let at = (self.pending).partition_point(|pending| pending.report.arc.id < result.arc);
            let pending = self.pending.get_mut(at);
            match pending.filter(|pending| pending.report.arc.id == result.arc) {
                Some(pending) => pending.window = Some(result),
                None => {
                    if let Some(report) = self.labelled(result.arc, reports) {
                        report.window = result.test;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
