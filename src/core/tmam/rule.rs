//! The two rules: what decides a label, how runs go on, and how features are fitted to them.

use std::fmt::Debug;

use super::arc::Arc;
use super::fit::{Fit, FitOptions, fit_in_parts, fit_run};
use super::hypothesis::Gate;
use super::label::{Label, Reason};
use super::pending::Pending;
use super::report::ArcReport;
use super::run::{Run, Runs};
use crate::core::config::{self, Config, NoiseAwareOptions};

/// A rule: a policy for each step of the method that the two rules take differently.
pub trait Rule: Debug {
    /// The label of an arc; `None` while what decides is not known yet.
    fn label(&self, arc: &Pending) -> Option<Decision>;

    /// Takes the next labelled arc of a sonar into its open run; returns the run that it closed.
    fn run(&self, runs: &mut Runs, arc: &ArcReport, decision: &Decision) -> Option<Run>;

    /// Fits a feature to a closed run, or one to each of its parts.
    fn fit(&self, run: Run) -> Vec<(Run, Fit)>;
}

/// A label, and what it rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The label.
    pub label: Label,
    /// Radians to the nearest bound that would change it, where angles decide.
    pub margin: Option<f64>,
    /// How far chi2 is from another label, where readings decide.
    pub chi2_margin: Option<f64>,
    /// The readings that decided.
    pub readings: Vec<Arc>,
}

/// The rule of a configuration.
pub fn of(config: &Config, gate: &Gate) -> Box<dyn Rule> {
    match config.rule {
        config::Rule::Paper => Box::new(PaperRule),
        config::Rule::NoiseAware => Box::new(NoiseAwareRule::new(config, gate)),
    }
}

/// The paper's rule: angles decide, equal labels in a row are a run, and a run gives one feature.
#[derive(Debug, Clone, Copy)]
pub struct PaperRule;

impl Rule for PaperRule {
    fn label(&self, arc: &Pending) -> Option<Decision> {
        Labelling::Angles.label(arc)
    }

    fn run(&self, runs: &mut Runs, arc: &ArcReport, decision: &Decision) -> Option<Run> {
        Labelling::Angles.run(runs, arc, decision)
    }

    fn fit(&self, run: Run) -> Vec<(Run, Fit)> {
        Fitting::Whole.fit(run, &FitOptions::default())
    }
}

/// The noise-aware rule: each policy that departs from the paper can be switched off by itself.
#[derive(Debug, Clone, Copy)]
pub struct NoiseAwareRule {
    labelling: Labelling,
    fitting: Fitting,
    options: FitOptions,
}

impl NoiseAwareRule {
    /// Composed as the configuration has it.
    pub fn new(config: &Config, gate: &Gate) -> Self {
        let NoiseAwareOptions {
            label_by_opinion,
            break_runs,
            converge,
            reject_misfits,
            reject_mirrored,
            ..
        } = config.noise_aware;
        let bounds = &config.opinion;
        Self {
            labelling: if label_by_opinion {
                Labelling::Windows {
                    decisive: bounds.decisive,
                    longest_gap: 2 * bounds.max_half_width,
                }
            } else {
                Labelling::Angles
            },
            fitting: if break_runs {
                Fitting::InParts
            } else {
                Fitting::Whole
            },
            options: FitOptions {
                converge,
                misfits: reject_misfits.then_some(*gate),
                mirrored: reject_mirrored.then_some(bounds.decisive),
            },
        }
    }
}

impl Rule for NoiseAwareRule {
    fn label(&self, arc: &Pending) -> Option<Decision> {
        self.labelling.label(arc)
    }

    fn run(&self, runs: &mut Runs, arc: &ArcReport, decision: &Decision) -> Option<Run> {
        self.labelling.run(runs, arc, decision)
    }

    fn fit(&self, run: Run) -> Vec<(Run, Fit)> {
        self.fitting.fit(run, &self.options)
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
                margin: triple.map(|triple| triple.margin),
                chi2_margin: None,
                readings: arc.triple.map(Vec::from).unwrap_or_default(),
            }),
            Self::Windows { decisive, .. } => {
                let window = arc.window.as_ref()?;
                let undecided = Label::Unidentified(Reason::Ambiguous);
                let by_window = match window.oblique {
                    Some(_) => Label::Unidentified(Reason::Oblique),
                    None => window.tests.last().map_or(undecided, |t| t.label(decisive)),
                };
                Some(Decision {
                    label: triple.map_or(arc.report.label, |_| by_window),
                    margin: None,
                    chi2_margin: window.margin.filter(|_| triple.is_some()),
                    readings: window.readings.clone(),
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

/// Whether a run is one feature.
#[derive(Debug, Clone, Copy)]
enum Fitting {
    /// It is.
    Whole,
    /// It may be several, broken where its parts fit best.
    InParts,
}

impl Fitting {
    fn fit(self, run: Run, options: &FitOptions) -> Vec<(Run, Fit)> {
        match self {
            Self::Whole => {
                let fit = fit_run(&run, options);
                vec![(run, fit)]
            }
            Self::InParts => fit_in_parts(run, options),
        }
    }
}
