//! What became of an arc: its runs, what contradicts its label, and what it really was.

use std::fmt::Write as _;

use serde::Serialize;

use super::triple::place;
use crate::core::geometry::{Vec2, angle_between, direction};
use crate::core::replay::Outcome;
use crate::core::rounding::{number, optional, rounded};
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::{MapFeature, Rejection, Shape, Status};
use crate::core::tmam::hypothesis::Support;
use crate::core::tmam::label::{Kind, Label};
use crate::core::tmam::prediction::Prediction;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Extraction;
use crate::core::wording::counted;
use crate::core::world::Reflector;
use crate::tools::evaluate::truth::{AGREEING_SIGMAS, Origin, Other, Target, Truth};

/// What lies beside a beam by less is in it, radians: poses and mounts are no better known.
const BESIDE: f64 = 0.01;

/// A run that an arc stands behind, and the feature it gave.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunStory {
    /// The id of the extracted feature.
    pub feature: u32,
    pub kind: Kind,
    /// Whether the arc has the run's label; else it is only a neighbour of its arcs.
    pub labelled: bool,
    /// Labelled arcs of the run.
    pub arcs: usize,
    /// Associated readings.
    pub readings: usize,
    pub first_frame: u32,
    pub last_frame: u32,
    /// Readings that the fit left out.
    pub outliers: usize,
    /// Whether the arc is one of them.
    pub left_out: bool,
    /// Root mean square of what remains, metres.
    #[serde(serialize_with = "number")]
    pub residual_rms: f64,
    /// What all its readings support.
    pub opinion: Support,
    /// The squares that remain of the best line through them.
    #[serde(serialize_with = "number")]
    pub chi2_line: f64,
    #[serde(serialize_with = "number")]
    pub chi2_point: f64,
    /// Where circles are asked for.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional")]
    pub chi2_circle: Option<f64>,
    /// `registered`, `merged` or `rejected`.
    pub action: &'static str,
    /// Why it was rejected.
    pub reason: Option<Rejection>,
    /// The feature of the map that it went into.
    pub map_id: Option<u32>,
    /// That feature at the end of the run; under another id where it turned out to be the same as
    /// another one.
    pub in_the_end: Option<FinalFeature>,
}

/// A feature of the map, in the end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FinalFeature {
    pub id: u32,
    pub status: Status,
    /// Runs behind it.
    pub runs: u32,
    /// Readings behind it.
    pub readings: u32,
    #[serde(flatten)]
    pub place: FeaturePlace,
}

/// Where a feature is, metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum FeaturePlace {
    Line {
        rho: f64,
        theta: f64,
        ends: [[f64; 2]; 2],
    },
    Point {
        x: f64,
        y: f64,
    },
    Circle {
        x: f64,
        y: f64,
        radius: f64,
    },
}

fn xy(v: Vec2) -> [f64; 2] {
    [rounded(v.x), rounded(v.y)]
}

impl FinalFeature {
    fn new(feature: &MapFeature) -> Self {
        Self {
            id: feature.id,
            status: feature.status,
            runs: feature.runs,
            readings: feature.readings,
            place: match &feature.shape {
                Shape::Line(segment) => FeaturePlace::Line {
                    rho: rounded(segment.rho),
                    theta: rounded(segment.theta),
                    ends: segment.ends().map(xy),
                },
                Shape::Point(point) => FeaturePlace::Point {
                    x: rounded(point.position.x),
                    y: rounded(point.position.y),
                },
                Shape::Circle(circle) => FeaturePlace::Circle {
                    x: rounded(circle.center.x),
                    y: rounded(circle.center.y),
                    radius: rounded(circle.radius),
                },
            },
        }
    }

    /// A feature of the map by its id, or the one that absorbed it.
    fn in_the_end(mut id: u32, outcome: &Outcome) -> Option<Self> {
        // Every absorption leads to an older or a newer feature that still was there, so no chain is
        // longer than the extractions are many.
        for extraction in &outcome.extractions {
            if extraction.absorbed.contains(&id) {
                id = extraction.map_feature.map_or(id, |feature| feature.id);
            }
        }
        let feature = outcome.map.iter().find(|feature| feature.id == id)?;
        Some(Self::new(feature))
    }
}

impl RunStory {
    /// The runs that an arc stands behind, in the order of extraction.
    pub fn all(arc: ArcId, outcome: &Outcome) -> Vec<Self> {
        let of = outcome.extractions.iter();
        of.filter(|extraction| extraction.associated.contains(&arc))
            .filter_map(|extraction| Self::new(arc, extraction, outcome))
            .collect()
    }

    /// `None` by methods other than TMAM.
    fn new(arc: ArcId, extraction: &Extraction, outcome: &Outcome) -> Option<Self> {
        let opinion = extraction.opinion?;
        let map_id = extraction.action.map_id();
        let frame = |arc: Option<&ArcId>| arc.map_or(0, |arc| arc.frame);
        Some(Self {
            feature: extraction.id,
            kind: extraction.kind,
            labelled: extraction.labelled.contains(&arc),
            arcs: extraction.labelled.len(),
            readings: extraction.associated.len(),
            first_frame: frame(extraction.associated.first()),
            last_frame: frame(extraction.associated.last()),
            outliers: extraction.outliers.len(),
            left_out: extraction.outliers.contains(&arc),
            residual_rms: extraction.residual_rms,
            opinion: opinion.support,
            chi2_line: opinion.chi2_line,
            chi2_point: opinion.chi2_point,
            chi2_circle: opinion.chi2_circle,
            action: extraction.action.name(),
            reason: extraction.action.rejection(),
            map_id,
            in_the_end: map_id.and_then(|id| FinalFeature::in_the_end(id, outcome)),
        })
    }

    fn text(&self) -> String {
        let part = match (self.labelled, self.left_out) {
            (_, true) => ", which leaves this one out",
            (true, false) => "",
            (false, false) => ", this one unlabelled",
        };
        let became = match (self.action, self.map_id) {
            ("registered", Some(id)) => format!("new in the map as {id}"),
            (_, Some(id)) => format!("merged into {id} of the map"),
            (_, None) => format!("rejected: {}", self.reason.map_or("", rejection)),
        };
        let mut text = format!(
            "  feature {}: a {} from {}, {} (frames {}-{}){part}\n    residual {:.2} mm rms; all its \
             readings support: {} (chi2 line {}, point {}{})\n    {became}\n",
            self.feature,
            self.kind.name(),
            counted(self.arcs as u64, "labelled arc"),
            counted(self.readings as u64, "reading"),
            self.first_frame,
            self.last_frame,
            self.residual_rms * 1e3,
            self.opinion.name(),
            chi2(self.chi2_line),
            chi2(self.chi2_point),
            (self.chi2_circle)
                .map_or_else(String::new, |circle| format!(", circle {}", chi2(circle))),
        );
        if let Some(feature) = &self.in_the_end {
            let moved = match self.map_id == Some(feature.id) {
                true => "",
                false => "it turned out to be the same as another one; ",
            };
            let at = match feature.place {
                FeaturePlace::Line { ends: [a, b], .. } => {
                    format!("line {} - {}", place(a), place(b))
                }
                FeaturePlace::Point { x, y } => format!("point {}", place([x, y])),
                FeaturePlace::Circle { x, y, radius } => {
                    format!("circle {}, radius {radius:.3}", place([x, y]))
                }
            };
            let _ = writeln!(
                text,
                "    {moved}in the end {} {at}, {}, {} and {}",
                feature.id,
                feature.status.name(),
                counted(feature.runs.into(), "run"),
                counted(feature.readings.into(), "reading"),
            );
        }
        text
    }
}

/// The runs that the arc stands behind, and what the map says of it; whether that has it from `crossings`.
pub fn text(runs: &[RunStory], map: Option<Prediction>, crossings: bool) -> String {
    let mut text: String = runs.iter().map(RunStory::text).collect();
    if runs.is_empty() {
        text.push_str("  It stands behind no feature.\n");
    }
    if let Some(map) = map {
        let says = match (map.support, map.feature) {
            (Support::Line, Some(id)) => format!("a line explains this reading (its {id})"),
            (Support::Point, Some(id)) => format!("a point explains this reading (its {id})"),
            (Support::Circle, Some(id)) => format!("a circle explains this reading (its {id})"),
            (Support::Ambiguous, _) => "it may be a wall or the point at its end".to_owned(),
            _ => "no confirmed feature explains this reading".to_owned(),
        };
        let _ = writeln!(text, "  The noise-aware map of the whole log says: {says}.");
        if crossings {
            text.push_str("  No run gave that point: arcs of several sonars cross there.\n");
        }
    }
    text
}

fn rejection(reason: Rejection) -> &'static str {
    match reason {
        Rejection::NoStart => "no two of its arcs give a point to start the fit from (no-start)",
        Rejection::Singular => "its readings do not determine it (singular)",
        Rejection::Diverged => "the fit ran away (diverged)",
        Rejection::OutsideBeams => "it lies outside the beams that it came from (outside-beams)",
        Rejection::Misfit => "its readings do not all come from one feature (misfit)",
        Rejection::Mirrored => "its mirror image at the robot's path fits as well (mirrored)",
    }
}

/// A chi2; infinite where the beams have no place for the model.
pub fn chi2(x: f64) -> String {
    if x.is_finite() {
        format!("{x:.2}")
    } else {
        "none".to_owned()
    }
}

/// Something that contradicts a label.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Doubt {
    /// Who says so: `map`, `triple`, `window` or `run`.
    pub by: &'static str,
    /// What it says instead: a line, a point or neither.
    pub says: Support,
    /// The map's feature that explains the reading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feature: Option<u32>,
    /// How many readings were asked; `None` for the map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readings: Option<usize>,
}

impl Doubt {
    /// Everything that makes an arc suspect; empty for one that is not.
    pub fn all(report: &ArcReport) -> Vec<Self> {
        if !report.is_suspect() {
            return Vec::new();
        }
        if let Some(map) = report.map.filter(|map| map.support.kind().is_some()) {
            return vec![Self {
                by: "map",
                says: map.support,
                feature: map.feature,
                readings: None,
            }];
        }
        // The window of a triple that decided is the triple.
        let tests = (report.tests()).filter(|(by, test)| *by != "window" || test.readings > 3);
        tests
            .filter(|(_, test)| test.contradicts(report.label))
            .map(|(by, test)| Self {
                by,
                says: test.support,
                feature: None,
                readings: Some(test.readings),
            })
            .collect()
    }

    pub fn text(&self) -> String {
        let says = match self.says {
            Support::Line => "only a line explains",
            Support::Point => "only a point explains",
            Support::Circle => "only a circle explains",
            _ => "neither a line nor a point explains",
        };
        match (self.by, self.readings) {
            ("triple", _) => format!("{says} its three readings"),
            ("window", Some(n)) => format!("{says} the {n} readings around it"),
            ("run", Some(n)) => format!("{says} all {n} readings of its run"),
            _ => format!(
                "in the map of all readings it is a {} that explains it",
                self.says.name()
            ),
        }
    }
}

/// What echoed, and whether the label says so.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TruthStory {
    pub from: Origin,
    pub echoed: Echoed,
    /// What echoed at the arc before.
    pub before: Option<Echoed>,
    pub after: Option<Echoed>,
    /// Whether the label is right; `None` for an arc without one.
    pub right: Option<bool>,
    /// The readings that decided.
    pub readings: usize,
    /// Those of them that came from what the arc came from.
    pub of_its_target: usize,
    /// Where these have that target, at the poses and mounts of the replay, against where it is.
    pub offset: Option<Offset>,
    /// Whether a pillar could have had a label of its own.
    #[serde(skip)]
    knows_pillars: bool,
}

/// How far a target is from where readings have it, at the poses and mounts of a replay.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Offset {
    /// What a range is off most, metres.
    #[serde(serialize_with = "number")]
    pub range: f64,
    /// What one is off most in standard deviations.
    #[serde(serialize_with = "number")]
    pub sigmas: f64,
    /// How far the target is outside of a beam at most, radians.
    #[serde(serialize_with = "number")]
    pub beside_beam: f64,
}

impl Offset {
    fn new(arcs: &[Arc], target: Target, truth: &Truth) -> Option<Self> {
        let Target::Reflector(reflector) = target else {
            return None;
        };
        let mut most = Self::default();
        for arc in arcs {
            let pose = arc.world_from_sensor;
            let to = truth.world().place_of(reflector, pose.position())? - pose.position();
            let off = (arc.range - to.norm()).abs();
            let off_axis = angle_between(direction(to), pose.yaw);
            most.range = most.range.max(off);
            most.sigmas = most
                .sigmas
                .max(off / arc.variance.max(f64::MIN_POSITIVE).sqrt());
            most.beside_beam = most.beside_beam.max(off_axis - arc.beam_width / 2.0);
        }
        Some(most)
    }

    /// What is off besides the ranges, or that it is these alone.
    fn text(&self) -> String {
        let mut off = Vec::new();
        if self.sigmas > AGREEING_SIGMAS {
            let millimetres = self.range * 1e3;
            off.push(format!(
                "ranges up to {millimetres:.0} mm ({:.0} sigma) off it",
                self.sigmas
            ));
        }
        if self.beside_beam > BESIDE {
            let degrees = self.beside_beam.to_degrees();
            off.push(format!("it up to {degrees:.1} deg outside of the beam"));
        }
        match off.is_empty() {
            true => {
                "  that is within the noise of where it is: the noise misled the rule\n".to_owned()
            }
            false => format!(
                "  at the poses and mounts of this replay that has {}:\n  a pose, a mount, a clock or a scale \
                 is off, or the noise is taken for too small\n",
                off.join(" and ")
            ),
        }
    }
}

/// What echoed at an arc.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Echoed {
    /// `line`, `point` or `circle`; else why it was none.
    pub what: &'static str,
    /// Which wall or point of the world, from 0.
    pub index: Option<usize>,
    /// Where it is: the two ends of a wall, a point, or the axis of a pillar; metres.
    pub at: [Option<[f64; 2]>; 2],
    #[serde(skip)]
    target: Target,
}

impl Echoed {
    fn new(arc: &Arc, truth: &Truth) -> Self {
        let (target, world) = (truth.target(arc), truth.world());
        let (index, at) = match target {
            Target::Reflector(Reflector::Line(index)) => {
                let wall = world.walls().get(index);
                let ends = wall.map(|wall| [wall.start, wall.end].map(|end| Some(xy(end))));
                (Some(index), ends.unwrap_or_default())
            }
            Target::Reflector(Reflector::Point(index)) => {
                let point = world.points().get(index);
                (Some(index), [point.copied().map(xy), None])
            }
            Target::Reflector(Reflector::Circle(index)) => {
                let pillar = world.pillars().get(index);
                (Some(index), [pillar.map(|pillar| xy(pillar.center)), None])
            }
            Target::Other(_) => (None, [None; 2]),
        };
        Self {
            what: target.name(),
            index,
            at,
            target,
        }
    }

    fn text(&self) -> String {
        match (self.target, self.at) {
            (Target::Reflector(Reflector::Line(index)), [Some(a), Some(b)]) => {
                format!("wall {index}, {} - {}", place(a), place(b))
            }
            (Target::Reflector(Reflector::Point(index)), [Some(at), _]) => {
                format!("point {index} at {}", place(at))
            }
            (Target::Reflector(Reflector::Circle(index)), [Some(at), _]) => {
                format!("pillar {index} at {}", place(at))
            }
            (Target::Other(Other::Outlier), _) => {
                "nowhere: its range was replaced by a random one".to_owned()
            }
            (Target::Other(Other::CrossTalk), _) => {
                "another sonar: it heard that one's sound".to_owned()
            }
            (Target::Other(Other::DoubleReflection), _) => {
                "two walls, one after the other".to_owned()
            }
            (Target::Other(Other::Oblique), _) => {
                "a rough wall, beside the foot of the perpendicular".to_owned()
            }
            (Target::Other(Other::Nothing), _) => {
                "something that the world does not have".to_owned()
            }
            _ => "something else: the world has its echo at another range".to_owned(),
        }
    }
}

impl TruthStory {
    /// The truth about an arc with a label, about the three that it is in the middle of, and about the readings that
    /// decided. `knows_pillars`: circles are among the labels.
    pub fn new(
        arc: &Arc,
        label: Label,
        (three, decided): (Option<&[Arc; 3]>, &[Arc]),
        knows_pillars: bool,
        truth: &Truth,
    ) -> Self {
        let echoed = Echoed::new(arc, truth);
        let own = decided
            .iter()
            .filter(|arc| truth.target(arc) == echoed.target);
        let own: Vec<Arc> = own.copied().collect();
        Self {
            from: truth.origin(),
            echoed,
            before: three.map(|[before, ..]| Echoed::new(before, truth)),
            after: three.map(|[.., after]| Echoed::new(after, truth)),
            right: label.kind().map(|kind| kind.name() == echoed.what),
            readings: decided.len(),
            of_its_target: own.len(),
            offset: Offset::new(&own, echoed.target, truth),
            knows_pillars,
        }
    }

    pub fn text(&self) -> String {
        let source = match self.from {
            Origin::Log => "the log says so",
            Origin::EchoModel => "by the echo model",
        };
        let mut text = format!("  this arc came from {} ({source})\n", self.echoed.text());
        if let Some((before, after)) = self.before.zip(self.after) {
            let _ = writeln!(text, "  the one before from {}", before.text());
            let _ = writeln!(text, "  the one after from {}", after.text());
        }
        match self.right {
            Some(true) => text.push_str("  so the label is right\n"),
            Some(false) => text.push_str(&self.why_wrong()),
            None => text.push_str("  it has no label to be right or wrong\n"),
        }
        text
    }

    /// That the label is wrong, and what is known of the reason.
    fn why_wrong(&self) -> String {
        let (all, own) = (self.readings, self.of_its_target);
        let saw = match (self.echoed.target, all - own) {
            (Target::Other(_), _) => "no wall or corner echoed".to_owned(),
            (_, 0) => format!("all {all} readings that decided saw this one target"),
            (_, others) => {
                format!("of the {all} readings that decided {others} saw something else")
            }
        };
        let mut text = format!("  so the label is WRONG: {saw}\n");
        match (self.echoed.target, self.offset) {
            (Target::Reflector(Reflector::Circle(_)), _) if !self.knows_pillars => {
                text.push_str("  a pillar has no label of its own: noise_aware.circles = true looks for them\n");
            }
            (Target::Reflector(Reflector::Line(_) | Reflector::Point(_)), Some(offset))
                if own == all =>
            {
                text.push_str(&offset.text());
            }
            _ => {}
        }
        text
    }
}
