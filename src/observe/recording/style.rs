//! Colours, sizes and the numbers that stand for labels.

use rerun::{AnnotationContext, ClassDescription, Color, Rgba32};

use crate::core::event::{Sonar, SonarId};
use crate::core::tmam::label::Label::{self, Unidentified};
use crate::core::tmam::label::Reason::{
    Ambiguous, Gap, Missing, Neither, NoPoints, Oblique, Turning, Wide,
};

/// A line: contact arcs, contact points, walls.
pub const CONTACT: Color = rgb(0x4d, 0xa6, 0xff);
/// A point: intersection arcs, intersection points, corners.
pub const INTERSECTION: Color = rgb(0xff, 0xa6, 0x2b);
/// A circle: its arcs.
pub const CIRCLE: Color = rgb(0xd6, 0x5b, 0xff);
/// Neither could be told.
pub const UNIDENTIFIED: Color = rgb(0x62, 0x66, 0x6e);
/// A fit that was not used.
pub const REJECTED: Color = rgb(0xff, 0x4d, 0x5e);
/// The robot and its heading.
pub const ROBOT: Color = rgb(0x5f, 0xe0, 0x8f);
/// Where the robot has been.
pub const TRAJECTORY: Color = rgb(0x2f, 0x86, 0x57);
/// Where odometry has the robot, and its path.
pub const ODOMETRY: Color = rgb(0x7d, 0x83, 0x90);
/// From where something was seen to where it was seen again.
pub const CLOSURE: Color = rgb(0x36, 0x9a, 0xa6);
/// The same as a link in the map, where there are many.
pub const LINK: Color = rgb(0x1b, 0x4c, 0x54);
/// From a sonar to the middle of its arc.
pub const BEAM: Color = rgb(0x34, 0x38, 0x40);
/// Walls of the map.
pub const WALL: Color = rgb(0xf2, 0xf4, 0xf8);
/// Points of the map.
pub const CORNER: Color = rgb(0xff, 0xe0, 0x8a);
/// Circles of the map.
pub const PILLAR: Color = rgb(0xe9, 0xa8, 0xff);
/// Features of the map that too little speaks for.
pub const TENTATIVE: Color = rgb(0x7d, 0x83, 0x90);
/// Arcs whose label is contradicted.
pub const SUSPECT: Color = rgb(0xb8, 0xff, 0x3a);
/// The same where all of them are shown.
pub const FAINT_SUSPECT: Color = rgb(0x3e, 0x54, 0x1e);
/// What the map has where a label says otherwise.
pub const CONTRADICTING: Color = rgb(0xe4, 0xff, 0xb0);
/// The ids of map features.
pub const IDS: Color = rgb(0xb4, 0xba, 0xc6);
/// The metric grid, its axes, and the numbers on it.
pub const GRID: Color = rgb(0x1a, 0x1e, 0x25);
pub const AXES: Color = rgb(0x36, 0x3d, 0x48);
pub const GRID_NUMBERS: Color = rgb(0x6c, 0x74, 0x82);
/// Three standard deviations of a map feature.
pub const COVARIANCE: Color = rgb(0x66, 0x48, 0x8e);
/// The same as a line in a plot, which is thin.
pub const SIGMA: Color = rgb(0x9a, 0x78, 0xc8);
/// A bound that a value is held against.
pub const BOUND: Color = rgb(0xff, 0x4d, 0x5e);

/// What is really there.
pub const TRUTH: Color = rgb(0x3c, 0x56, 0x48);
/// What the replay took for something else.
pub const WRONG: Color = rgb(0xff, 0x5c, 0xd6);
/// From where something is to where it should be.
pub const ERROR: Color = rgb(0xff, 0xe9, 0x3b);
/// A feature of a golden file.
pub const GOLDEN: Color = rgb(0x2c, 0x6a, 0x63);
/// A feature of a golden file that moved or is missing.
pub const BEFORE: Color = rgb(0x2e, 0xe6, 0xcf);
/// What is now otherwise than in a golden file.
pub const NOW: Color = rgb(0xff, 0x4d, 0xe1);

pub const fn rgb(r: u8, g: u8, b: u8) -> Color {
    Color(Rgba32::from_rgb(r, g, b))
}

/// The class of the first sonar's echoes; the others follow.
pub const FIRST_SONAR: u16 = 1000;

/// How a label is shown.
#[derive(Debug, Clone, Copy)]
pub struct LabelLook {
    pub label: Label,
    /// The number that stands for it in `class_ids`; 10 and up are the reasons.
    class: u16,
    /// What a lane says.
    pub word: &'static str,
    /// Its colour on a lane: dark where there was no triple, lighter where its readings did not decide,
    /// brown where they contradict both.
    pub shade: Color,
}

const fn look(label: Label, class: u16, word: &'static str, shade: Color) -> LabelLook {
    LabelLook {
        label,
        class,
        word,
        shade,
    }
}

/// What is added where circles are a hypothesis.
pub const ROUND: LabelLook = look(Label::Circle, 3, "pillar", CIRCLE);

/// Every label an arc can have where they are, or are not.
pub fn looks(circles: bool) -> impl Iterator<Item = &'static LabelLook> {
    LABELS.iter().chain(circles.then_some(&ROUND))
}

/// Every label an arc can have without circles.
pub const LABELS: [LabelLook; 10] = [
    look(Label::Contact, 1, "wall", CONTACT),
    look(Label::Intersection, 2, "corner", INTERSECTION),
    look(
        Unidentified(Missing),
        10,
        "no neighbour",
        rgb(0x2e, 0x31, 0x38),
    ),
    look(Unidentified(Gap), 11, "gap", rgb(0x3d, 0x37, 0x48)),
    look(Unidentified(Turning), 12, "turning", rgb(0x2c, 0x44, 0x46)),
    look(
        Unidentified(NoPoints),
        13,
        "no points",
        rgb(0x4e, 0x52, 0x5a),
    ),
    look(Unidentified(Wide), 14, "wide", rgb(0x66, 0x6b, 0x75)),
    look(
        Unidentified(Ambiguous),
        15,
        "both fit",
        rgb(0x80, 0x86, 0x93),
    ),
    look(
        Unidentified(Neither),
        16,
        "neither fits",
        rgb(0x7a, 0x57, 0x4a),
    ),
    look(
        Unidentified(Oblique),
        17,
        "rough wall",
        rgb(0x8a, 0x7a, 0x3c),
    ),
];

/// The number that stands for a label.
pub fn class(label: Label) -> u16 {
    let look = looks(true).find(|look| look.label == label);
    look.map_or(0, |look| look.class)
}

/// The colour of a label.
pub fn color(label: Label) -> Color {
    match label {
        Label::Contact => CONTACT,
        Label::Intersection => INTERSECTION,
        Label::Circle => CIRCLE,
        Label::Unidentified(_) => UNIDENTIFIED,
    }
}

/// A label, with the reason where there is none.
pub fn name(label: Label) -> String {
    match label.reason() {
        Some(reason) => format!("{}: {}", label.name(), reason.name()),
        None => label.name().to_owned(),
    }
}

/// Name and colour of every class.
pub fn annotations(sonars: &[Sonar], circles: bool) -> AnnotationContext {
    let labels = looks(circles).map(|LabelLook { label, class, .. }| {
        ClassDescription::from((*class, name(*label).as_str(), color(*label).0))
    });
    let sonars = (FIRST_SONAR..).zip(sonars).zip(wheel(sonars.len()));
    let sonars = sonars.map(|((class, sonar), color)| {
        ClassDescription::from((class, sonar.name.as_str(), faint(color).0))
    });
    AnnotationContext::new(labels.chain(sonars))
}

/// The class of a sonar's echoes.
pub fn class_of(sonar: SonarId) -> u16 {
    FIRST_SONAR.saturating_add(sonar.0)
}

/// A colour at half its light.
fn faint(color: Color) -> Color {
    let [r, g, b, _] = color.0.to_array();
    let [r, g, b] = [r, g, b].map(|light| (u16::from(light) / 2) as u8);
    rgb(r, g, b)
}

/// Colours for `count` sonars, once around the colour wheel: neighbours in the ring look alike,
/// opposites do not.
pub fn wheel(count: usize) -> Vec<Color> {
    (0..count)
        .map(|i| {
            let hue = 6.0 * i as f32 / count.max(1) as f32;
            let channel = |offset: f32| {
                let x = (hue + offset) % 6.0;
                let ramp = (2.0 - (x - 3.0).abs()).clamp(0.0, 1.0);
                // Not below 70, so that no colour sinks into the dark background.
                (70.0 + 185.0 * (1.0 - ramp)).round() as u8
            };
            rgb(channel(0.0), channel(4.0), channel(2.0))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_label_has_its_own_class() {
        let mut classes = LABELS.map(|look| look.class).to_vec();
        classes.dedup();
        assert_eq!(classes.len(), LABELS.len());
    }

    #[test]
    fn every_reason_has_its_own_word_and_shade() {
        let mut words = LABELS.map(|look| look.word).to_vec();
        words.sort_unstable();
        words.dedup();
        let mut shades = LABELS.map(|look| look.shade.0.to_u32()).to_vec();
        shades.sort_unstable();
        shades.dedup();
        assert_eq!((words.len(), shades.len()), (LABELS.len(), LABELS.len()));
    }

    #[test]
    fn the_wheel_never_repeats_a_colour() {
        for count in [1, 4, 8, 16, 32] {
            let mut colors: Vec<u32> = wheel(count).iter().map(|c| c.0.to_u32()).collect();
            colors.sort_unstable();
            colors.dedup();
            assert_eq!(colors.len(), count);
        }
    }
}
