//! What is known at the end of the log only, written back to the frames: the evidence beside each arc, the
//! label lanes, and what decided.
//!
//! Evidence has rows of its own, at the entity and the moment of the arcs, an instance for each arc in their
//! order.

use rerun::StateConfiguration;

use super::canvas::{Canvas, Moment, Shown};
use super::entity::Entity;
use super::evidence::Known;
use super::style;
use crate::core::event::SonarId;
use crate::core::tmam::label::{Kind, Label};
use crate::core::tmam::report::ArcReport;
use crate::observe::viewer::Error;

/// A frame that is reported on at the end.
pub struct ReportedFrame {
    pub at: Moment,
    is_drawn: bool,
    /// The sonars that gave something, or nothing echoed.
    sonars: Vec<SonarId>,
}

/// The frames that are reported on at the end.
#[derive(Default)]
pub struct Reports {
    frames: Vec<ReportedFrame>,
}

/// How a lane shows a label that is suspect: what it is called there, and its word.
const SUSPECTS: [(Kind, &str, &str); 3] = [
    (Kind::Line, "contact, suspect", "SUSPECT wall"),
    (Kind::Point, "intersection, suspect", "SUSPECT corner"),
    (Kind::Circle, "circle, suspect", "SUSPECT pillar"),
];

impl Reports {
    /// Adds a frame that is drawn.
    pub fn frame(&mut self, at: Moment, sonars: impl Iterator<Item = SonarId>) {
        self.push(at, true, sonars);
    }

    /// Notes that from here on nothing is drawn of these sonars.
    pub fn leave(&mut self, at: Moment, sonars: impl Iterator<Item = SonarId>) {
        self.push(at, false, sonars);
    }

    fn push(&mut self, at: Moment, is_drawn: bool, sonars: impl Iterator<Item = SonarId>) {
        self.frames.push(ReportedFrame {
            at,
            is_drawn,
            sonars: sonars.collect(),
        });
    }

    /// Every frame with the reports on its arcs, by sonar; with none where it is not drawn.
    pub fn with<'a>(
        &'a self,
        all: &'a [ArcReport],
    ) -> impl Iterator<Item = (Moment, &'a [ArcReport])> {
        self.frames.iter().map(|frame| (frame.at, frame.of(all)))
    }

    /// Writes the evidence of all arcs, by frame and sonar.
    pub fn draw_evidence(&self, all: &[ArcReport], canvas: &mut Canvas<'_>) -> Result<(), Error> {
        for (at, reports) in self.with(all) {
            let known = reports.iter().map(|report| Known {
                sensor: canvas.sonar(report.arc.id.sonar).to_owned(),
                report: report.clone(),
            });
            let row = Shown::Evidence(known.collect());
            canvas.row(Entity::Evidence, at, row)?;
        }
        Ok(())
    }

    /// Writes the labels, as words and as dots on the lane of their sonar: contact lies above the lane's
    /// middle and unidentified below it, so that none hides another where the run is long.
    pub fn draw_labels(&self, all: &[ArcReport], canvas: &mut Canvas<'_>) -> Result<(), Error> {
        for frame in &self.frames {
            let reports = frame.of(all);
            for sonar in &frame.sonars {
                let report = reports.iter().find(|report| report.arc.id.sonar == *sonar);
                let label = Shown::Labels(report.map(on_lane).into_iter().collect());
                canvas.row(Entity::Labels(*sonar), frame.at, label)?;
            }
            for report in reports {
                let sonar = report.arc.id.sonar;
                let above = match report.label {
                    Label::Contact => 0.2,
                    Label::Intersection => 0.0,
                    Label::Circle => 0.1,
                    Label::Unidentified(_) => -0.2,
                };
                let dot = (f64::from(sonar.0) + above, dot_color(report));
                let dot = Shown::Dotted(vec![dot]);
                canvas.row(Entity::LabelDots(sonar), frame.at, dot)?;
            }
        }
        Ok(())
    }
}

impl ReportedFrame {
    fn of<'a>(&self, all: &'a [ArcReport]) -> &'a [ArcReport] {
        let before =
            |last: i64| all.partition_point(|report| i64::from(report.arc.id.frame) < last);
        let of_frame = all.get(before(self.at.frame)..before(self.at.frame + 1));
        of_frame.filter(|_| self.is_drawn).unwrap_or_default()
    }
}

/// The label of an arc as its lane has it.
pub fn on_lane(report: &ArcReport) -> String {
    let kind = report.label.kind().filter(|_| report.is_suspect());
    let suspect = SUSPECTS.iter().find(|(suspect, ..)| Some(*suspect) == kind);
    suspect.map_or_else(
        || style::name(report.label),
        |(_, name, _)| (*name).to_owned(),
    )
}

/// The colour of the dots of an arc.
pub fn dot_color(report: &ArcReport) -> rerun::Color {
    if report.is_suspect() {
        style::SUSPECT
    } else {
        style::color(report.label)
    }
}

/// How the lanes of these sonars look: of those that gave something, since the viewer would draw an empty lane
/// for any other.
pub fn put_lanes(
    seen: impl Iterator<Item = SonarId>,
    circles: bool,
    canvas: &mut Canvas<'_>,
) -> Result<(), Error> {
    let names = style::looks(circles).map(|look| style::name(look.label));
    let suspects = SUSPECTS.iter();
    let suspects = suspects.filter(|(kind, ..)| circles || *kind != Kind::Circle);
    let look = StateConfiguration::new()
        .with_values(names.chain(suspects.clone().map(|(_, name, _)| (*name).to_owned())))
        .with_labels(
            (style::looks(circles).map(|look| look.word))
                .chain(suspects.clone().map(|(.., word)| *word)),
        )
        .with_colors(
            (style::looks(circles).map(|look| look.shade)).chain(suspects.map(|_| style::SUSPECT)),
        );
    for sonar in seen {
        canvas.put_on(Entity::Labels(sonar), &look)?;
    }
    Ok(())
}
