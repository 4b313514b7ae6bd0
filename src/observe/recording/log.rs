//! The event log: what every closed run gave, in words.

use rerun::components::TextLogLevel;

use super::canvas::{Canvas, Message, Moment, Row};
use super::closed::color;
use super::entity::Entity;
use crate::core::observer::Setting;
use crate::core::rounding::fixed;
use crate::core::tmam::feature::{Action, Rejection, Shape};
use crate::core::tmam::step::Extraction;
use crate::core::wording::counted;
use crate::observe::viewer::Error;

/// One message per extraction.
pub fn tell(at: Moment, extractions: &[Extraction], canvas: &mut Canvas<'_>) -> Result<(), Error> {
    for extraction in extractions {
        let first = extraction.labelled.first();
        let sonar = first.map_or("?", |arc| canvas.sonar(arc.sonar));
        let message = Message {
            text: describe(extraction, sonar),
            level: match extraction.action {
                Action::Rejected(_) => TextLogLevel::WARN,
                _ => TextLogLevel::INFO,
            },
            color: color(extraction),
        };
        canvas.row(Entity::Log, at, Row::Messages(vec![message]))?;
    }
    Ok(())
}

/// A closed run in one sentence: what, whence, where, and what became of it.
fn describe(extraction: &Extraction, sonar: &str) -> String {
    let kind = extraction.kind.name();
    let frames = match (extraction.associated.first(), extraction.associated.last()) {
        (Some(first), Some(last)) => format!("frames {}-{}", first.frame, last.frame),
        _ => "no frames".to_owned(),
    };
    let fate = match extraction.action {
        Action::Registered(id) => format!("new map {kind} {id}"),
        Action::Merged(id) => match extraction.map_feature {
            Some(feature) => format!("merged into map {kind} {id} (n {})", feature.readings),
            None => format!("merged into map {kind} {id}"),
        },
        Action::Rejected(why) => format!("rejected, {}", in_words(why)),
    };
    format!(
        "{kind} {} from {sonar}, {frames} ({}): {}{fate}",
        extraction.id,
        counted(extraction.associated.len() as u64, "reading"),
        estimate(extraction),
    )
}

fn estimate(extraction: &Extraction) -> String {
    let place = match &extraction.shape {
        Some(Shape::Line(line)) => format!(
            "rho {:.3} m, theta {} deg",
            line.rho,
            fixed(line.theta.to_degrees(), 1)
        ),
        Some(Shape::Point(point)) => {
            let [x, y] = [point.position.x, point.position.y].map(|place| fixed(place, 3));
            format!("x {x} m, y {y} m")
        }
        None => return String::new(),
    };
    format!("{place}, rms {:.1} mm; ", extraction.residual_rms * 1e3)
}

fn in_words(why: Rejection) -> &'static str {
    match why {
        Rejection::NoStart => "no two of its arcs share a point to start the fit from",
        Rejection::Singular => "the readings do not determine it",
        Rejection::Diverged => "the fit ran away",
        Rejection::OutsideBeams => "it lies outside the beams it came from",
        Rejection::Misfit => "its readings do not all come from one feature",
        Rejection::Mirrored => "its mirror image at the robot's path fits as well",
    }
}

/// What the log says of the source.
pub fn opening(setting: &Setting<'_>) -> Vec<(&'static str, String)> {
    let source = setting.source;
    let start = format!(
        "start: {}, {}, {}",
        source.file,
        counted(setting.sonars.len() as u64, "sonar"),
        counted(source.messages, "message")
    );
    let mut said = vec![(TextLogLevel::INFO, start)];
    if !source.complete {
        let lost = source.lost.first().map_or("", String::as_str);
        let text = match source.lost.len() {
            0 | 1 => format!("the log is incomplete or damaged: {lost}"),
            n => format!("the log is incomplete or damaged in {n} places, first {lost}"),
        };
        said.push((TextLogLevel::WARN, text));
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::SonarId;
    use crate::core::geometry::Vec2;
    use crate::core::tmam::arc::ArcId;
    use crate::core::tmam::feature::{Kind, MapFeature, Segment, Status};
    use crate::core::tmam::hypothesis::{HypothesisTest, Support};
    use nalgebra::Matrix2;

    fn extraction(action: Action, shape: Option<Shape>) -> Extraction {
        let arcs: Vec<ArcId> = (12..=19)
            .map(|frame| ArcId {
                frame,
                sonar: SonarId(4),
            })
            .collect();
        Extraction {
            id: 3,
            kind: Kind::Line,
            labelled: arcs.iter().skip(1).take(6).copied().collect(),
            associated: arcs,
            shape,
            residual_rms: 0.0031,
            iterations: 4,
            converged: true,
            opinion: HypothesisTest {
                gate: 6.63,
                readings: 8,
                chi2_line: 5.0,
                chi2_point: 500.0,
                support: Support::Line,
            },
            outliers: Vec::new(),
            action,
            map_feature: None,
            absorbed: Vec::new(),
        }
    }

    #[test]
    fn a_message_says_what_a_person_wants_to_know() {
        let line = Shape::Line(Segment {
            rho: 2.0034,
            theta: 1.5725,
            covariance: Matrix2::zeros(),
            mid: Vec2::new(1.0, 2.0),
            half_length: 0.75,
        });
        let mut merged = extraction(Action::Merged(5), Some(line));
        merged.map_feature = Some(MapFeature {
            id: 5,
            shape: line,
            readings: 23,
            runs: 3,
            status: Status::Confirmed,
        });
        assert_eq!(
            describe(&merged, "sonar_04"),
            "line 3 from sonar_04, frames 12-19 (8 readings): \
             rho 2.003 m, theta 90.1 deg, rms 3.1 mm; merged into map line 5 (n 23)"
        );
        assert_eq!(
            describe(
                &extraction(Action::Rejected(Rejection::Singular), None),
                "sonar_04"
            ),
            "line 3 from sonar_04, frames 12-19 (8 readings): \
             rejected, the readings do not determine it"
        );
    }
}
