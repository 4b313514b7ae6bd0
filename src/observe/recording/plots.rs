//! Beside the map: the angles of every triple and the labels that follow from them.

use std::collections::BTreeSet;

use rerun::components::{MarkerShape, Name};
use rerun::{Color, SeriesLines, SeriesPoints, StateConfiguration};

use super::canvas::{Canvas, Moment, Shown};
use super::entity::Entity;
use super::hold::{HeldCell, HeldFrame};
use super::style::{self, LABELS};
use crate::core::event::SonarId;
use crate::core::tmam::triple::TripleTest;
use crate::observe::viewer::Error;

type Pick = fn(&TripleTest) -> f64;

/// Numbers of a triple that are plotted, one dot per sonar and frame.
const PLOTS: [(Entity, Pick); 4] = [
    (Entity::ThetaC, |triple| triple.angles.theta_c),
    (Entity::ThetaI, |triple| triple.angles.theta_i),
    (Entity::Chi2Line, |triple| finite(triple.test.chi2_line)),
    (Entity::Chi2Point, |triple| finite(triple.test.chi2_point)),
];

/// Labels as dots on the lane of their sonar: contact lies above the lane's middle and unidentified
/// below it, so that none hides another where the run is long.
const DOTS: [(Entity, &str, f64, Color); 3] = [
    (Entity::ContactDots, "contact", 0.2, style::CONTACT),
    (
        Entity::IntersectionDots,
        "intersection",
        0.0,
        style::INTERSECTION,
    ),
    (
        Entity::UnidentifiedDots,
        "unidentified",
        -0.2,
        style::UNIDENTIFIED,
    ),
];

/// Plots a decided frame.
pub fn draw(held: &HeldFrame, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let sonars = canvas.sonars.len();
    for (entity, pick) in PLOTS {
        let number = |cell: &HeldCell| Some(pick(cell.report.as_ref()?.triple.as_ref()?));
        canvas.row(entity, held.moment, by_sonar(held, sonars, number))?;
    }
    for cell in &held.cells {
        let label = (cell.report.as_ref()).map(|report| style::name(report.label));
        let label = Shown::Labels(label.into_iter().collect());
        canvas.row(Entity::Labels(cell.sonar), held.moment, label)?;
    }
    for (entity, label, above, _) in DOTS {
        let place = |cell: &HeldCell| {
            let same = (cell.report.as_ref()).is_some_and(|r| r.label.name() == label);
            same.then_some(cell.sonar.index() as f64 + above)
        };
        canvas.row(entity, held.moment, by_sonar(held, sonars, place))?;
    }
    Ok(())
}

/// One number per sonar; NaN, which plots as a gap, where the frame has none of it.
fn by_sonar(held: &HeldFrame, sonars: usize, pick: impl Fn(&HeldCell) -> Option<f64>) -> Shown {
    let mut row = vec![f64::NAN; sonars];
    for cell in &held.cells {
        if let (Some(slot), Some(number)) = (row.get_mut(cell.sonar.index()), pick(cell)) {
            *slot = number;
        }
    }
    Shown::Numbers(row)
}

/// Infinite where the beams have nothing in common: a gap in the plot.
fn finite(chi2: f64) -> f64 {
    if chi2.is_finite() { chi2 } else { f64::NAN }
}

/// The bounds that values are held against.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// On the smaller angle, radians.
    pub gamma: f64,
    /// On the chi2 of a triple.
    pub gate: f64,
}

/// How the plots look.
pub fn put_styles(limits: Limits, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let names: Vec<Name> = canvas
        .sonars
        .iter()
        .map(|s| s.name.as_str().into())
        .collect();
    let sonars = names.len();
    let look = SeriesPoints::update_fields()
        .with_names(names.clone())
        .with_colors(style::wheel(sonars))
        .with_marker_sizes(vec![2.0; sonars]);
    for (entity, _) in PLOTS {
        canvas.put_on(entity, &look)?;
    }
    for (entity, name) in [
        (
            Entity::Gamma,
            format!("gamma {:.1} deg", limits.gamma.to_degrees()),
        ),
        (Entity::Gate, format!("gate {}", limits.gate)),
    ] {
        let look = SeriesLines::update_fields()
            .with_names([name])
            .with_colors([style::BOUND])
            .with_widths([1.5]);
        canvas.put_on(entity, &look)?;
    }
    for (entity, _, _, color) in DOTS {
        let look = SeriesPoints::update_fields()
            .with_names(names.clone())
            .with_colors(vec![color; sonars])
            .with_markers(vec![MarkerShape::Square; sonars])
            .with_marker_sizes(vec![2.5; sonars]);
        canvas.put_on(entity, &look)?;
    }
    Ok(())
}

/// The bounds as lines over the whole run, and how the lanes look: of the sonars that gave something,
/// since the viewer would draw an empty lane for any other.
pub fn put_last(
    seen: &BTreeSet<SonarId>,
    limits: Limits,
    ends: &[Moment],
    canvas: &mut Canvas<'_>,
) -> Result<(), Error> {
    for (entity, bound) in [(Entity::Gamma, limits.gamma), (Entity::Gate, limits.gate)] {
        for end in ends {
            canvas.row(entity, *end, Shown::Numbers(vec![bound]))?;
        }
    }
    canvas.flush()?;
    // Most lanes are grey most of the time: a word there would be noise, a letter is not.
    let look = StateConfiguration::new()
        .with_values(LABELS.map(|look| style::name(look.label)))
        .with_labels(LABELS.map(|look| look.short))
        .with_colors(LABELS.map(|look| look.shade));
    let mut lanes = seen.iter().map(|sonar| Entity::Labels(*sonar));
    lanes.try_for_each(|lane| canvas.put_on(lane, &look))
}
