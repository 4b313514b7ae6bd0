//! The two rules: what decides a label, how runs go on, and how features are fitted to them.

use super::arc::Arc;
use super::fit::{Fit, FitOptions, fit_in_parts, fit_run};
use super::hypothesis::Gate;
use super::label::{Label, Reason};
use super::report::{ArcReport, Margin};
use super::run::{Run, Runs};
use super::triple::Way;
use super::window::WindowResult;
use crate::core::config::Config;

/// An arc that has no label yet.
#[derive(Debug, Clone)]
pub struct Pending {
    /// What is known of it so far.
    pub report: ArcReport,
    /// The way from the arc before it in its sonar's sequence; `None` where nothing echoed there.
    pub before: Option<Way>,
    /// The arc between its neighbours, where the three make a triple.
    pub triple: Option<[Arc; 3]>,
    /// Whether the entry after it has come.
    pub is_followed: bool,
    /// What its windows came to, once no wider one will be looked at.
    pub window: Option<WindowResult>,
}

/// A label, and what it rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The label.
    pub label: Label,
    /// How far what decides is from another one.
    pub margin: Option<Margin>,
    /// The readings that decided.
    pub readings: Vec<Arc>,
    /// The arc between its neighbours, where the three make a triple.
    pub three: Option<[Arc; 3]>,
}

/// A rule: a policy for each step of the method that the two rules take differently. The paper's rule departs
/// from the paper in none of them; each of the noise-aware rule's can be switched off by itself.
#[derive(Debug, Clone, Copy)]
pub struct Policies {
    labelling: Labelling,
    /// Whether a run may be several features, broken where its parts fit best.
    breaks_runs: bool,
    options: FitOptions,
}

impl Policies {
    /// The rule of a configuration.
    pub fn of(config: &Config, gate: &Gate) -> Self {
        let (departures, bounds) = (config.departures(), &config.opinion);
        Self {
            labelling: if departures.label_by_opinion {
                Labelling::Windows {
                    decisive: bounds.decisive,
                    longest_gap: 2 * bounds.max_half_width,
                }
            } else {
                Labelling::Angles
            },
            breaks_runs: departures.break_runs,
            options: FitOptions {
                converge: departures.converge,
                misfits: departures.reject_misfits.then_some(*gate),
                mirrored: departures.reject_mirrored.then_some(bounds.decisive),
            },
        }
    }

    /// The label of an arc; `None` while what decides is not known yet.
    pub fn label(&self, arc: &Pending) -> Option<Decision> {
        self.labelling.label(arc)
    }

    /// Takes the next labelled arc of a sonar into its open run; returns the run that it closed.
    pub fn run(&self, runs: &mut Runs, arc: &ArcReport, decision: &Decision) -> Option<Run> {
        self.labelling.run(runs, arc, decision)
    }

    /// Fits a feature to a closed run, or one to each of its parts.
    pub fn fit(&self, run: Run) -> Vec<(Run, Fit)> {
        if self.breaks_runs {
            return fit_in_parts(run, &self.options);
        }
        let fit = fit_run(&run, &self.options);
        vec![(run, fit)]
    }
}

/// What decides a label, and so what a run of labels is.
#[derive(Debug, Clone, Copy)]
enum Labelling {
    /// The two angles of the triple. A run has no gaps.
    Angles,
    /// The hypothesis test of the adaptive window. A run goes on over arcs that no window decides.
    Windows {
        /// The lead in chi2 that decides.
        decisive: f64,
        /// So many of them.
        longest_gap: usize,
    },
}

impl Labelling {
    fn label(self, arc: &Pending) -> Option<Decision> {
        if !arc.is_followed {
            return None;
        }
        let triple = arc.report.triple.as_ref();
        match self {
            Self::Angles => Some(Decision {
                label: triple.map_or(arc.report.label, |triple| triple.label),
                margin: triple.map(|triple| Margin::Angle(triple.margin)),
                readings: arc.triple.map(Vec::from).unwrap_or_default(),
                three: arc.triple,
            }),
            Self::Windows { decisive, .. } => {
                let window = arc.window.as_ref()?;
                let undecided = Label::Unidentified(Reason::Ambiguous);
                let by_window = match window.oblique {
                    Some(_) => Label::Unidentified(Reason::Oblique),
                    None => window.test.map_or(undecided, |t| t.label(decisive)),
                };
                Some(Decision {
                    label: triple.map_or(arc.report.label, |_| by_window),
                    margin: (window.margin.filter(|_| triple.is_some())).map(Margin::Chi2),
                    readings: window.readings.clone(),
                    three: arc.triple,
                })
            }
        }
    }

    fn run(self, runs: &mut Runs, arc: &ArcReport, decision: &Decision) -> Option<Run> {
        let id = arc.arc.id;
        match (self, arc.label.kind()) {
            (Self::Angles, Some(kind)) => runs.label(kind, id, &decision.readings),
            (Self::Windows { .. }, Some(kind)) => runs.label_across(kind, id, &decision.readings),
            (Self::Windows { longest_gap, .. }, None) if arc.triple.is_some() => {
                runs.pass(longest_gap)
            }
            (_, None) => runs.close(),
        }
    }
}
