//! Labels that are contradicted: all of them faintly in the map at all times, bright in their frame with what
//! the map has there instead, as a table with the worst first, and as warnings in the event log.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use rerun::LineStrips2D;
use rerun::components::TextLogLevel;

use super::canvas::{Canvas, Dot, LogLine, Moment, Shown, Strip};
use super::entity::Entity;
use super::reports::Reports;
use super::style;
use crate::core::event::name_of;
use crate::core::geometry::{Vec2, unit};
use crate::core::observer::Setting;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::feature::{MapFeature, Shape};
use crate::core::tmam::report::ArcReport;
use crate::core::wording::counted;
use crate::observe::contradiction::{against, in_words, word};
use crate::observe::viewer::Error;

/// More rows than this are counted, not listed.
const MOST_ROWS: usize = 200;

/// What is known of the suspects.
#[derive(Default)]
pub struct Suspects {
    /// How many there are.
    pub count: usize,
    /// The frame of the worst one that is drawn.
    pub worst: Option<u32>,
}

impl Suspects {
    /// Draws them.
    pub fn draw(
        reports: &Reports,
        all: &[ArcReport],
        ghosts: &Ghosts<'_>,
        canvas: &mut Canvas<'_>,
    ) -> Result<Self, Error> {
        let mut drawn: Vec<(Moment, &ArcReport)> = Vec::new();
        let mut shown = false;
        for (at, reports) in reports.with(all) {
            let suspects: Vec<&ArcReport> = reports.iter().filter(|r| r.is_suspect()).collect();
            if !suspects.is_empty() || shown {
                let strips = suspects.iter().map(|report| {
                    let sonar = canvas.sonar(report.arc.id.sonar);
                    let label = report.label.kind().map_or("", word);
                    let name = format!("{sonar}: {label}?");
                    Strip::named(canvas.origin.sweep(&report.arc), name)
                });
                let strips = Shown::Strips(strips.collect());
                canvas.row(Entity::Suspects, at, strips)?;
                let ids = suspects.iter().filter_map(|report| report.map?.feature);
                let against = ghosts.of(ids.collect());
                let outlines = against.iter().map(|feature| outline(feature, canvas));
                let outlines = Shown::Strips(outlines.collect());
                canvas.row(Entity::Contradicting, at, outlines)?;
                let names = against.iter().map(|feature| ghosts.name(feature, canvas));
                let names = Shown::Dots(names.collect());
                canvas.row(Entity::ContradictingNames, at, names)?;
            }
            shown = !suspects.is_empty();
            for report in &suspects {
                let ArcId { frame, sonar } = report.arc.id;
                let sonar = canvas.sonar(sonar);
                let message = LogLine {
                    text: format!("suspect: {sonar}, frame {frame}: {}", in_words(report)),
                    level: TextLogLevel::WARN,
                    color: style::SUSPECT,
                };
                canvas.row(Entity::SuspectLog, at, Shown::Messages(vec![message]))?;
            }
            drawn.extend(suspects.into_iter().map(|suspect| (at, suspect)));
        }
        canvas.flush()?;
        drawn.sort_by(|(_, a), (_, b)| a.worse_first(b));
        let arcs = drawn
            .iter()
            .map(|(_, report)| canvas.origin.sweep(&report.arc));
        let names = drawn.iter().map(|(_, report)| {
            let ArcId { frame, sonar } = report.arc.id;
            format!(
                "{}, frame {frame}: {}",
                canvas.sonar(sonar),
                in_words(report)
            )
        });
        let strips = LineStrips2D::update_fields()
            .with_strips(arcs)
            .with_labels(names);
        if let Some(look) = Entity::AllSuspects.look().filter(|_| !drawn.is_empty()) {
            canvas.put_on(Entity::AllSuspects, &look.of_strips(strips))?;
        }
        Ok(Self {
            count: all.iter().filter(|report| report.is_suspect()).count(),
            worst: drawn.first().map(|(_, report)| report.arc.id.frame),
        })
    }
}

/// What the map has where suspects are.
pub struct Ghosts<'a> {
    /// The features that the map's predictions name.
    pub features: &'a [MapFeature],
    /// Whether their ids are those of the map that is drawn.
    pub has_ids: bool,
    /// How far above a feature its name stands, metres.
    pub above: f64,
}

impl Ghosts<'_> {
    fn of(&self, ids: BTreeSet<u32>) -> Vec<&MapFeature> {
        let features = self.features.iter();
        features
            .filter(|feature| ids.contains(&feature.id))
            .collect()
    }

    fn name(&self, feature: &MapFeature, canvas: &Canvas<'_>) -> Dot {
        let at = feature.shape.middle() + Vec2::new(0.0, self.above);
        let mut name = format!("the map: {}", word(feature.shape.kind()));
        if self.has_ids {
            // Writing to a string cannot fail.
            let _ = write!(name, " {}", feature.id);
        }
        Dot::named(canvas.origin.xy(at), name)
    }
}

/// A feature of the map as a line.
fn outline(feature: &MapFeature, canvas: &Canvas<'_>) -> Strip {
    /// Of the square round a point, metres.
    const RADIUS: f64 = 0.12;
    let places: Vec<Vec2> = match &feature.shape {
        Shape::Line(line) => line.ends().to_vec(),
        Shape::Point(point) => (0..=4)
            .map(|quarter| unit(std::f64::consts::FRAC_PI_2 * f64::from(quarter % 4)))
            .map(|corner| point.position + corner * RADIUS)
            .collect(),
        Shape::Circle(circle) => circle.outline().collect(),
    };
    let places = places.into_iter().map(|place| canvas.origin.xy(place));
    Strip::from(places.collect::<Vec<_>>())
}

/// The table of the suspects, in Markdown.
pub fn table(all: &[ArcReport], setting: &Setting<'_>) -> String {
    let labels = all
        .iter()
        .filter(|report| report.label.kind().is_some())
        .count();
    let mut suspects: Vec<&ArcReport> = all.iter().filter(|report| report.is_suspect()).collect();
    suspects.sort_by(|a, b| a.worse_first(b));
    let mut text = format!(
        "**{} of {} are suspect**: the map of all readings, or the readings beside them, say otherwise. \
         Worst first.\n\n\
         | frame | time s | sonar | taken for a | but |\n|---:|---:|---|---|---|\n",
        suspects.len(),
        counted(labels as u64, "label"),
    );
    for report in suspects.iter().take(MOST_ROWS) {
        let ArcId { frame, sonar } = report.arc.id;
        let seconds = report.arc.stamp_ns.saturating_sub(setting.origin_ns) as f64 * 1e-9;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {frame} | {seconds:.2} | {} | {} | {} |",
            name_of(setting.sonars, sonar),
            report.label.kind().map_or("", word),
            against(report),
        );
    }
    if suspects.len() > MOST_ROWS {
        let _ = writeln!(text, "\n... and {} more.", suspects.len() - MOST_ROWS);
    }
    let _ = write!(
        text,
        "\nThe whole story of one: `tmam explain {} --sensor SONAR --frame FRAME`\n",
        setting.source.file
    );
    text
}
