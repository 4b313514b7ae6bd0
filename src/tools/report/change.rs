//! Two maps over each other as SVG: what was, what is there instead, and the arcs whose label changed.

use svg::node::element::{Group, Line, Text, Title};
use svg::{Document, Node};

use super::plane::{Plane, sweep};
use crate::core::geometry::Vec2;
use crate::core::tmam::arc::Arc;
use crate::observe::drawing::{Overlay, Sketched};

const STYLE: &str = "\
line{stroke-linecap:round}.path{stroke:#b8d8c6}.as{stroke:#8b94a1;fill:#8b94a1;stroke-width:3}\
.before{stroke:#1d5fa8;fill:none;stroke-width:3;stroke-dasharray:9 9}circle.before{stroke-dasharray:none}\
.now{stroke:#d4002a;fill:#d4002a;stroke-width:4}circle.now{stroke:none}\
.halo{stroke:#ffc400;fill:none;stroke-width:16;stroke-opacity:.6}\
.label{fill:none;stroke:#8a2be2;stroke-width:2;stroke-opacity:.4}\
.head{fill:#15181d;font:bold 16px sans-serif}.word{fill:#15181d;font:12px sans-serif}\
.worst{paint-order:stroke;stroke:#fff;stroke-width:3px;fill:#d4002a;font:bold 14px sans-serif;text-anchor:middle}";

/// Room for the words above: a line a heading, and what the colours mean.
const ABOVE: f64 = 98.0;
/// From the left, where the words begin.
const LEFT: f64 = 36.0;

/// Draws what differs under three lines of words: along `path`, with the arcs whose label changed, and the worst of
/// what is elsewhere named so.
pub fn draw(
    [title, numbers, cause]: [&str; 3],
    path: &[Vec2],
    overlay: &Overlay,
    worst: Option<Sketched>,
    relabelled: &[Arc],
) -> Document {
    let layers = [
        (&overlay.golden, "as"),
        (&overlay.now, "now"),
        (&overlay.before, "before"),
    ];
    let ends = layers.iter().flat_map(|(all, _)| all.iter());
    let ends = ends.flat_map(|one| one.ends);
    let arcs = relabelled.iter().flat_map(sweep);
    let plane = Plane::of(path.iter().copied().chain(ends).chain(arcs), ABOVE);
    let mut picture = plane.picture(path, STYLE);
    for arc in relabelled {
        picture.append(plane.strip(sweep(arc).into_iter(), "label"));
    }
    if let Some(worst) = &worst {
        picture.append(sketch(worst, "halo", &plane));
    }
    for (all, class) in layers {
        for one in all {
            picture.append(sketch(one, class, &plane));
        }
    }
    if let Some(worst) = &worst {
        let [one, other] = worst.ends;
        let beside = (one + other) / 2.0 + Vec2::new(0.0, 12.0) / plane.scale;
        picture.append(plane.text(beside, "worst", "worst place".to_owned()));
    }
    for (text, class, y) in [
        (title, "head", 24),
        (numbers, "word", 44),
        (cause, "word", 62),
    ] {
        let line = Text::new(text).set("x", LEFT).set("y", y);
        picture.append(line.set("class", class));
    }
    legend(&mut picture);
    picture
}

/// A feature, which says its name where it is pointed at.
fn sketch(one: &Sketched, class: &str, plane: &Plane) -> Group {
    let named = Group::new().add(Title::new(one.name.clone()));
    if one.is_point {
        named.add(plane.dot(one.ends[0], class))
    } else if one.radius > 0.0 {
        named.add(plane.strip(one.places().into_iter(), class))
    } else {
        named.add(plane.line(one.ends, class))
    }
}

fn legend(picture: &mut Document) {
    let entries = [
        ("as", "the map as it was"),
        ("before", "moved or missing, as it was"),
        ("now", "moved or new, as it is"),
        ("label", "arc whose label changed"),
        ("path", "path"),
    ];
    let mut x = LEFT;
    for (class, word) in entries {
        let sample = Line::new().set("x1", x).set("x2", x + 28.0);
        let sample = sample.set("y1", 81).set("y2", 81);
        picture.append(sample.set("class", class));
        let text = Text::new(word).set("x", x + 36.0).set("y", 86);
        picture.append(text.set("class", "word"));
        x += 36.0 + 6.6 * word.len() as f64 + 20.0;
    }
}
