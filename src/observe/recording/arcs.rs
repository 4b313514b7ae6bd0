//! Arcs in the map: of the current frame, coloured by label, with the points they were judged by; and once
//! all is known the evidence beside each arc, and the suspects, whose label is contradicted: bright in the
//! map of their frame, and a warning in the log.
//!
//! All is known of an arc only at the end of the log, after it was drawn. So evidence has rows of its own,
//! at the entity and the moment of the arcs, an instance for each arc in their order.

use rerun::components::TextLogLevel;

use super::canvas::{Canvas, Dot, LogLine, Moment, Shown, Strip};
use super::entity::Entity;
use super::evidence::Known;
use super::hold::HeldFrame;
use super::style;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::hypothesis::HypothesisTest;
use crate::core::tmam::pair::{PairPoint, Points};
use crate::core::tmam::report::ArcReport;
use crate::observe::viewer::Error;

/// Draws the arcs of a decided frame.
pub fn draw(held: &HeldFrame, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let (origin, at) = (canvas.origin, held.moment);
    let cells = held.cells.iter();
    let decided = || cells.clone().filter_map(|cell| cell.report.as_ref());
    let arcs = decided().map(|report| Strip {
        class: style::class(report.label),
        ..Strip::named(
            origin.sweep(&report.arc),
            story(canvas.sonar(report.arc.id.sonar), report),
        )
    });
    let arcs = Shown::Strips(arcs.collect());
    canvas.row(Entity::Arcs, at, arcs)?;
    let beams = decided().map(|ArcReport { arc, .. }| {
        let ahead = arc.point_at(arc.world_from_sensor.yaw);
        Strip::from(vec![origin.xy(arc.center()), origin.xy(ahead)])
    });
    canvas.row(Entity::Beams, at, Shown::Strips(beams.collect()))?;
    // Where the pairs of a triple meet its middle arc.
    let touches = |of: fn(Points) -> [Option<PairPoint>; 2]| {
        let triples = cells.clone().filter_map(|cell| cell.triple.as_ref());
        let points = triples.flat_map(|[before, middle, after]| {
            let first = of(Points::of(before, middle)).into_iter().flatten();
            let second = of(Points::of(middle, after)).into_iter().flatten();
            (first.map(|point| point.on_b)).chain(second.map(|point| point.on_a))
        });
        Shown::Dots(points.map(|point| Dot::from(origin.xy(point))).collect())
    };
    let contact = touches(|points| points.contact);
    canvas.row(Entity::ContactPoints, at, contact)?;
    let intersection = touches(|points| points.intersection);
    canvas.row(Entity::IntersectionPoints, at, intersection)
}

/// The sonar, the label and the evidence for it, in a line.
fn story(sonar: &str, report: &ArcReport) -> String {
    let label = style::name(report.label);
    let Some(triple) = &report.triple else {
        return format!("{sonar}, {label}");
    };
    let angle = |theta: f64, sigma: Option<f64>| match sigma {
        Some(sigma) => format!("{:.1} +- {:.1} deg", theta.to_degrees(), sigma.to_degrees()),
        None => format!("{:.1} deg", theta.to_degrees()),
    };
    let test = &triple.test;
    format!(
        "{sonar}, {label}; theta_c {}, theta_i {}; chi2 line {}, point {}: {}",
        angle(triple.angles.theta_c, triple.spread.theta_c),
        angle(triple.angles.theta_i, triple.spread.theta_i),
        chi2(test.chi2_line),
        chi2(test.chi2_point),
        test.support.name()
    )
}

/// A chi2; infinite where the beams have no place for such a feature.
fn chi2(x: f64) -> String {
    if x.is_finite() {
        format!("{x:.1}")
    } else {
        "none in the beam".to_owned()
    }
}

/// The frames whose arcs are reported on at the end.
#[derive(Default)]
pub struct Reports {
    // Each with whether its arcs are drawn.
    frames: Vec<(Moment, bool)>,
}

impl Reports {
    /// Adds a frame that is drawn.
    pub fn frame(&mut self, at: Moment) {
        self.frames.push((at, true));
    }

    /// Notes that from here on nothing is drawn.
    pub fn leave(&mut self, at: Moment) {
        self.frames.push((at, false));
    }

    /// Writes the evidence of all arcs, by frame and sonar.
    pub fn draw(&self, all: &[ArcReport], canvas: &mut Canvas<'_>) -> Result<(), Error> {
        for (at, is_drawn) in &self.frames {
            let known = of_frame(all, *at, *is_drawn).iter().map(|report| Known {
                sensor: canvas.sonar(report.arc.id.sonar).to_owned(),
                report: report.clone(),
            });
            let row = Shown::Evidence(known.collect());
            canvas.row(Entity::Evidence, *at, row)?;
        }
        Ok(())
    }

    /// Writes the suspects among them.
    pub fn draw_suspects(&self, all: &[ArcReport], canvas: &mut Canvas<'_>) -> Result<(), Error> {
        let mut shown = false;
        for (at, is_drawn) in &self.frames {
            let reports = of_frame(all, *at, *is_drawn).iter();
            let suspects: Vec<&ArcReport> = reports.filter(|r| r.is_suspect()).collect();
            if !suspects.is_empty() || shown {
                let strips = suspects.iter().map(|report| {
                    let story = story(canvas.sonar(report.arc.id.sonar), report);
                    let name = format!("{story}; suspect: {}", why(report));
                    Strip::named(canvas.origin.sweep(&report.arc), name)
                });
                let strips = Shown::Strips(strips.collect());
                canvas.row(Entity::Suspects, *at, strips)?;
            }
            shown = !suspects.is_empty();
            for report in &suspects {
                let ArcId { frame, sonar } = report.arc.id;
                let (sonar, label) = (canvas.sonar(sonar), report.label.name());
                let why = why(report);
                let message = LogLine {
                    text: format!("suspect: {sonar}, frame {frame}: {label}, but {why}"),
                    level: TextLogLevel::WARN,
                    color: style::SUSPECT,
                };
                canvas.row(Entity::SuspectLog, *at, Shown::Messages(vec![message]))?;
            }
        }
        canvas.flush()
    }
}

/// The reports on the arcs of a frame; none where it is not drawn.
fn of_frame(all: &[ArcReport], at: Moment, is_drawn: bool) -> &[ArcReport] {
    let before = |last: i64| all.partition_point(|report| i64::from(report.arc.id.frame) < last);
    let of_frame = all.get(before(at.frame)..before(at.frame + 1));
    of_frame.filter(|_| is_drawn).unwrap_or_default()
}

/// What contradicts the label.
fn why(report: &ArcReport) -> String {
    if let Some(map) = report.map.filter(|map| map.support.kind().is_some()) {
        return format!("the map of all readings has a {} there", map.support.name());
    }
    let mut tests = report.tests().map(|(_, test)| test);
    let against = tests.find(|test| test.contradicts(report.label));
    against.map_or_else(String::new, says)
}

fn says(test: &HypothesisTest) -> String {
    format!(
        "{} readings say {} (chi2 line {}, point {})",
        test.readings,
        test.support.name(),
        chi2(test.chi2_line),
        chi2(test.chi2_point)
    )
}
