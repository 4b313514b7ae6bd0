//! Beside the map: what decided every label, a dot per sonar and frame in the colour of the label, against the
//! bounds that it was held to.

use rerun::SeriesLines;

use super::canvas::{Canvas, Moment, Shown};
use super::entity::Entity;
use super::reports::{Reports, dot_color};
use super::style;
use crate::core::config::Config;
use crate::core::event::SonarId;
use crate::core::rounding::fixed;
use crate::core::tmam::label::Label;
use crate::core::tmam::report::ArcReport;
use crate::observe::viewer::Error;

/// A number of every arc, plotted against its bounds.
pub struct Plot {
    /// What it shows and how that reads.
    pub title: &'static str,
    /// The values that there is room for: dots of what lies beyond are at the edge.
    pub range: [f64; 2],
    pub bounds: Vec<Bound>,
    pub dots: fn(SonarId) -> Entity,
    of: fn(&ArcReport) -> Option<f64>,
}

impl Plot {
    /// What is drawn of an arc.
    pub fn value(&self, report: &ArcReport) -> Option<f64> {
        let [low, high] = self.range;
        // Of two infinite ones there is no difference.
        let value = (self.of)(report).filter(|value| !value.is_nan())?;
        Some(value.clamp(low, high))
    }
}

/// Lines that values are held against.
pub struct Bound {
    pub entity: Entity,
    name: String,
    at: Vec<f64>,
}

impl Bound {
    fn new(entity: Entity, name: String, at: &[f64]) -> Self {
        let at = at.to_vec();
        Self { entity, name, at }
    }
}

/// What decides under the rule of a configuration, where beams are this wide at most.
pub fn deciding(config: &Config, beam_width: f64) -> [Plot; 2] {
    if config.departures().label_by_opinion {
        let decisive = config.opinion.decisive;
        let beyond = 4.0 * decisive.max(config.opinion.gate);
        return [
            Plot {
                title: "lead in chi2: up = wall",
                range: [-beyond, beyond],
                bounds: vec![Bound::new(
                    Entity::Decisive,
                    format!("decisive {decisive}"),
                    &[decisive, -decisive],
                )],
                dots: Entity::Lead,
                of: lead,
            },
            Plot {
                title: "best chi2/gate: low = fits",
                range: [0.0, 4.0],
                bounds: vec![Bound::new(Entity::Gate, "gate".to_owned(), &[1.0])],
                dots: Entity::Fit,
                of: fit,
            },
        ];
    }
    let bounds = &config.triple;
    let gamma = bounds.gamma.to_degrees();
    [
        Plot {
            title: "theta_c/theta_i: low = wall",
            range: [0.0, 2.0 * bounds.beta],
            bounds: vec![
                Bound::new(
                    Entity::Alpha,
                    format!("alpha {}", bounds.alpha),
                    &[bounds.alpha],
                ),
                Bound::new(
                    Entity::Beta,
                    format!("beta {}", bounds.beta),
                    &[bounds.beta],
                ),
            ],
            dots: Entity::Ratio,
            of: ratio,
        },
        Plot {
            title: "smaller angle [deg]",
            range: [0.0, beam_width.to_degrees()],
            bounds: vec![Bound::new(
                Entity::Gamma,
                format!("gamma {} deg", fixed(gamma, 1)),
                &[gamma],
            )],
            dots: Entity::Angle,
            of: smaller_angle,
        },
    ]
}

/// By how much the chi2 of a line is ahead of that of a point in the widest window.
fn lead(report: &ArcReport) -> Option<f64> {
    report.triple.as_ref()?;
    let window = report.window?;
    Some(window.chi2_point - window.chi2_line)
}

/// chi2 of the better of line and point in the widest window, by its gate; of a circle, where it is one.
fn fit(report: &ArcReport) -> Option<f64> {
    report.triple.as_ref()?;
    let window = report.window?;
    Some(match window.chi2_circle {
        Some(circle) if report.label == Label::Circle => circle / window.gate_circle,
        _ => window.chi2_line.min(window.chi2_point) / window.gate,
    })
}

fn ratio(report: &ArcReport) -> Option<f64> {
    let angles = &report.triple.as_ref()?.angles;
    Some(angles.theta_c / angles.theta_i)
}

/// In degrees.
fn smaller_angle(report: &ArcReport) -> Option<f64> {
    let angles = &report.triple.as_ref()?.angles;
    Some(angles.theta_c.min(angles.theta_i).to_degrees())
}

/// Draws the dots and the bounds, over the whole run from its first moment to its last.
pub fn draw(
    plots: &[Plot; 2],
    reports: &Reports,
    all: &[ArcReport],
    ends: &[Moment],
    canvas: &mut Canvas<'_>,
) -> Result<(), Error> {
    for plot in plots {
        for (at, reports) in reports.with(all) {
            for report in reports {
                let Some(value) = plot.value(report) else {
                    continue;
                };
                let dot = (value, dot_color(report));
                let entity = (plot.dots)(report.arc.id.sonar);
                canvas.row(entity, at, Shown::Dotted(vec![dot]))?;
            }
        }
        for bound in &plot.bounds {
            let look = SeriesLines::update_fields()
                .with_names(vec![bound.name.as_str(); bound.at.len()])
                .with_colors(vec![style::BOUND; bound.at.len()])
                .with_widths(vec![1.5; bound.at.len()]);
            canvas.put_on(bound.entity, &look)?;
            for end in ends {
                canvas.row(bound.entity, *end, Shown::Numbers(bound.at.clone()))?;
            }
        }
    }
    canvas.flush()
}
