//! The truth below the map, and what the replay got wrong.

mod world;

use std::collections::BTreeMap;
use std::io::Write;

use rerun::TextDocument;
use rerun::components::TextLogLevel;

use super::Error;
use super::encode::RrdWriter;
use super::log::LogTable;
use super::origin::Origin;
use super::shapes::{Dot, Strip};
use super::table::{Moment, Table, Timelines, put_static};
use crate::core::event::Sonar;
use crate::core::observer::Setting;
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::{MapFeature, Shape};
use crate::core::world::Reflector;
use crate::tools::evaluate::map::KindScore;
use crate::tools::evaluate::matching::nearest_truth;
use crate::tools::evaluate::truth::Target;
use crate::tools::evaluate::{Evaluation, Truth, text};

/// A replay's evaluation, made before the replay is recorded: the same replay makes the same
/// mistakes again.
#[derive(Debug, Clone, Copy)]
pub struct Evaluated<'a> {
    /// What it was held against.
    pub truth: &'a Truth,
    /// How it did.
    pub evaluation: &'a Evaluation,
    /// The map it ended with.
    pub map: &'a [MapFeature],
}

/// What is drawn of an evaluation as the replay goes on.
pub struct TruthTables {
    sonars: Vec<String>,
    /// What is wrong with the label of an arc.
    wrong: BTreeMap<ArcId, String>,
    arcs: Table<Strip>,
    // Of the final map, so written at the end; taken then.
    errors: Vec<Strip>,
    spurious_lines: Vec<Strip>,
    spurious_points: Vec<Dot>,
}

impl TruthTables {
    /// Writes what holds at all times.
    pub fn new<W: Write>(
        setting: &Setting<'_>,
        evaluated: Evaluated<'_>,
        out: &mut RrdWriter<W>,
    ) -> Result<Self, Error> {
        let Evaluated {
            truth, evaluation, ..
        } = evaluated;
        put_static("/evaluation", &page(setting, evaluated), out)?;
        world::put_styles(out)?;
        world::put_world(truth, out)?;
        world::put_missed(truth, evaluation, out)?;
        let wrong = evaluation
            .arcs
            .iter()
            .filter(|arc| arc.is_right() == Some(false));
        let map = &evaluation.map;
        let (spurious_lines, spurious_points) =
            spurious(evaluated.map, &map.lines, &map.points, out.origin());
        Ok(Self {
            sonars: setting
                .sonars
                .iter()
                .map(|s: &Sonar| s.name.clone())
                .collect(),
            wrong: wrong
                .map(|arc| {
                    let echoed = in_words(arc.target);
                    (arc.arc, format!("{}, but {echoed}", arc.label.name()))
                })
                .collect(),
            arcs: Table::new("/world/truth/wrong_labels"),
            errors: errors(evaluated, out.origin()),
            spurious_lines,
            spurious_points,
        })
    }

    /// The arcs of a frame whose labels are, or will be, wrong.
    pub fn push<W: Write>(
        &mut self,
        at: Moment,
        arcs: &[Arc],
        log: &mut LogTable,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let (origin, mut row) = (out.origin(), Vec::new());
        for arc in arcs {
            let Some(wrong) = self.wrong.get(&arc.id) else {
                continue;
            };
            let sonar = self.sonars.get(arc.id.sonar.index());
            let sonar = sonar.map_or("?", String::as_str);
            let text = format!("wrong label: {sonar} {wrong}");
            log.note(at, TextLogLevel::WARN, text, lines, out)?;
            row.push(Strip {
                points: origin.sweep(arc),
                color: None,
                label: format!("{sonar}: {wrong}"),
            });
        }
        self.arcs.push(at, row, lines, out)
    }

    /// What is wrong with the final map.
    pub fn finish<W: Write>(
        &mut self,
        at: Moment,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.arcs.flush(lines, out)?;
        let mut errors = Table::new("/world/truth/errors");
        errors.push(at, std::mem::take(&mut self.errors), lines, out)?;
        errors.flush(lines, out)?;
        let mut strips = Table::new("/world/truth/spurious_lines");
        strips.push(at, std::mem::take(&mut self.spurious_lines), lines, out)?;
        strips.flush(lines, out)?;
        let mut dots = Table::new("/world/truth/spurious_points");
        dots.push(at, std::mem::take(&mut self.spurious_points), lines, out)?;
        dots.flush(lines, out)
    }
}

fn in_words(target: Target) -> String {
    match target {
        Target::Reflector(Reflector::Line(index)) => format!("wall {index} echoed"),
        Target::Reflector(Reflector::Point(index)) => format!("point {index} echoed"),
        Target::Other(other) => format!("neither a wall nor a point echoed ({})", other.name()),
    }
}

/// The scores, as they are told on the terminal.
fn page(setting: &Setting<'_>, evaluated: Evaluated<'_>) -> TextDocument {
    let scores = text::text(setting, evaluated.truth, evaluated.evaluation);
    TextDocument::from_markdown(format!("{HOW_TO_READ}\n```text\n{scores}```\n"))
}

const HOW_TO_READ: &str = "\
# Evaluation

On the map: the true walls and points broad and pale green below all else, red where the map misses one; \
pink around an arc whose label is wrong, with the truth in its name and in **Events**; pink map features, at \
the end of the run, are no wall or point of the world, or one twice; yellow from a map feature to where it \
should be.
";

/// From where each matched feature is to where it should be.
fn errors(evaluated: Evaluated<'_>, origin: Origin) -> Vec<Strip> {
    let map = &evaluated.evaluation.map;
    let world = evaluated.truth.world();
    let found = map.lines.matches.iter().chain(&map.points.matches);
    found
        .flat_map(|found| {
            let feature = evaluated.map.iter().find(|f| f.id == found.feature);
            let places = match feature.map(|feature| feature.shape) {
                Some(Shape::Line(segment)) => segment.ends().to_vec(),
                Some(Shape::Point(point)) => vec![point.position],
                None => Vec::new(),
            };
            places.into_iter().filter_map(move |place| {
                let truth = nearest_truth(place, found.reflector, world)?;
                Some(Strip {
                    points: vec![origin.xy(place), origin.xy(truth)],
                    color: None,
                    label: format!("{:.0} mm", (place - truth).norm() * 1e3),
                })
            })
        })
        .collect()
}

/// Features of the map that are too many.
fn spurious(
    map: &[MapFeature],
    lines: &KindScore,
    points: &KindScore,
    origin: Origin,
) -> (Vec<Strip>, Vec<Dot>) {
    let reason = |feature: &MapFeature, score: &KindScore| {
        if score.spurious.contains(&feature.id) {
            return Some("spurious".to_owned());
        }
        let twice = score.duplicates.iter().find(|(id, _)| *id == feature.id);
        twice.map(|(_, reflector)| match reflector {
            Reflector::Line(index) => format!("wall {index} once more"),
            Reflector::Point(index) => format!("point {index} once more"),
        })
    };
    let (mut strips, mut dots) = (Vec::new(), Vec::new());
    for feature in map {
        match &feature.shape {
            Shape::Line(segment) => strips.extend(reason(feature, lines).map(|why| Strip {
                points: segment.ends().map(|end| origin.xy(end)).to_vec(),
                color: None,
                label: format!("line {}: {why}", feature.id),
            })),
            Shape::Point(point) => dots.extend(reason(feature, points).map(|why| Dot {
                position: origin.xy(point.position),
                color: None,
                label: format!("point {}: {why}", feature.id),
            })),
        }
    }
    (strips, dots)
}

#[cfg(test)]
mod tests;
