//! An evaluation as something to draw.

use std::collections::BTreeMap;

use super::map::{KindScore, MapScore};
use super::matching::nearest_truth;
use super::truth::Target;
use super::{Evaluation, Truth, text};
use crate::core::geometry::Vec2;
use crate::core::observer::Setting;
use crate::core::tmam::feature::{MapFeature, Shape};
use crate::core::wording::counted;
use crate::core::world::Reflector;
use crate::observe::drawing::{self, Overlay, Sketched};

/// What is drawn over a run that ended with this map.
pub fn overlay(
    setting: &Setting<'_>,
    truth: &Truth,
    evaluation: &Evaluation,
    map: &[MapFeature],
) -> Overlay {
    let world = truth.world();
    let scores = text::text(setting, truth, evaluation);
    let walls = (0..world.walls().len()).map(Reflector::Line);
    let points = (0..world.points().len()).map(Reflector::Point);
    let pillars = (0..world.pillars().len()).map(Reflector::Circle);
    let missed = kinds(&evaluation.map).flat_map(|kind| &kind.missed);
    let missed = missed.map(|missed| missed.reflector);
    let sketched = |reflector| sketched(truth, reflector);
    let truth = drawing::DrawnTruth {
        page: format!("{HOW_TO_READ}\n```text\n{scores}```\n"),
        world: serde_json::to_string(world).unwrap_or_default(),
        real: walls
            .chain(points)
            .chain(pillars)
            .filter_map(sketched)
            .collect(),
        missed: missed.filter_map(sketched).collect(),
        wrong: wrong(setting, evaluation),
        errors: errors(truth, evaluation, map),
        spurious: map
            .iter()
            .filter_map(|feature| spurious(feature, &evaluation.map))
            .collect(),
    };
    Overlay {
        truth: Some(truth),
        ..Overlay::default()
    }
}

const HOW_TO_READ: &str = "\
# Evaluation

On the map: the true walls and points broad and pale green below all else, red where the map misses one; \
pink around an arc whose label is wrong, with the truth in its name and in **Events**; pink map features, at \
the end of the run, are no wall or point of the world, or one twice; yellow from a map feature to where it \
should be.
";

fn sketched(truth: &Truth, reflector: Reflector) -> Option<Sketched> {
    let (kind, index, ends, radius) = match reflector {
        Reflector::Line(index) => {
            let wall = truth.world().walls().get(index)?;
            ("wall", index, [wall.start, wall.end], 0.0)
        }
        Reflector::Circle(index) => {
            let pillar = truth.world().pillars().get(index)?;
            ("pillar", index, [pillar.center; 2], pillar.radius)
        }
        Reflector::Point(index) => (
            "point",
            index,
            [*truth.world().points().get(index)?; 2],
            0.0,
        ),
    };
    let echoes = counted(truth.echoes(reflector), "echo");
    let name = format!("{kind} {index} ({echoes})");
    Some(Sketched {
        ends,
        is_point: matches!(reflector, Reflector::Point(_)),
        radius,
        name,
    })
}

/// The scores of every kind.
fn kinds(map: &MapScore) -> impl Iterator<Item = &KindScore> {
    [&map.lines, &map.points].into_iter().chain(&map.circles)
}

fn wrong(setting: &Setting<'_>, evaluation: &Evaluation) -> BTreeMap<(u32, String), String> {
    let wrong = evaluation
        .arcs
        .iter()
        .filter(|arc| arc.is_right() == Some(false));
    let told = wrong.filter_map(|arc| {
        let echoed = match arc.target {
            Target::Reflector(Reflector::Line(index)) => format!("wall {index} echoed"),
            Target::Reflector(Reflector::Point(index)) => format!("point {index} echoed"),
            Target::Reflector(Reflector::Circle(index)) => format!("pillar {index} echoed"),
            Target::Other(other) => {
                format!("neither a wall nor a point echoed ({})", other.name())
            }
        };
        let sonar = setting.sonars.get(arc.arc.sonar.index())?;
        let what = format!("{}, but {echoed}", arc.label.name());
        Some(((arc.arc.frame, sonar.name.clone()), what))
    });
    told.collect()
}

/// From where each matched feature is to where it should be.
fn errors(truth: &Truth, evaluation: &Evaluation, map: &[MapFeature]) -> Vec<Sketched> {
    let mut errors = Vec::new();
    for found in kinds(&evaluation.map).flat_map(|kind| &kind.matches) {
        let feature = map.iter().find(|feature| feature.id == found.feature);
        let places: &[Vec2] = match feature.map(|feature| feature.shape) {
            Some(Shape::Line(segment)) => &segment.ends(),
            Some(Shape::Point(point)) => &[point.position],
            Some(Shape::Circle(circle)) => &[circle.center],
            None => &[],
        };
        for place in places {
            if let Some(truth) = nearest_truth(*place, found.reflector, truth.world()) {
                errors.push(Sketched {
                    ends: [*place, truth],
                    is_point: false,
                    radius: 0.0,
                    name: format!("{:.0} mm", (place - truth).norm() * 1e3),
                });
            }
        }
    }
    errors
}

/// A feature of the map that is too many.
fn spurious(feature: &MapFeature, map: &MapScore) -> Option<Sketched> {
    let (score, ends, radius) = match feature.shape {
        Shape::Line(segment) => (&map.lines, segment.ends(), 0.0),
        Shape::Point(point) => (&map.points, [point.position; 2], 0.0),
        Shape::Circle(circle) => (map.circles.as_ref()?, [circle.center; 2], circle.radius),
    };
    let twice = score.duplicates.iter().find(|(id, _)| *id == feature.id);
    let why = match twice {
        _ if score.spurious.contains(&feature.id) => "spurious".to_owned(),
        Some((_, Reflector::Line(index))) => format!("wall {index} once more"),
        Some((_, Reflector::Point(index))) => format!("point {index} once more"),
        Some((_, Reflector::Circle(index))) => format!("pillar {index} once more"),
        None => return None,
    };
    let name = format!("{} {}: {why}", feature.shape.kind().name(), feature.id);
    Some(Sketched {
        ends,
        is_point: matches!(feature.shape, Shape::Point(_)),
        radius,
        name,
    })
}
