//! A method other than TMAM, and what a replay shows of it.

use std::collections::BTreeMap;
use std::sync::Arc as Shared;

use super::mapper::Mapper;
use crate::core::config::{Config, Map as Bounds, Noise};
use crate::core::event::SonarId;
use crate::core::frames::Frame;
use crate::core::geometry::{angle_between, unit};
use crate::core::ties;
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::{Action, MapFeature, Segment, Shape, Status};
use crate::core::tmam::label::{Kind, Label, Reason};
use crate::core::tmam::map::fusion::{fuse_by_readings, overlap, signed_like};
use crate::core::tmam::report::{ArcReport, RunTest};
use crate::core::tmam::step::{Extraction, Step};

/// Lines whose normals are turned more than this against each other are two, radians.
const PARALLEL: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// What all sonars gave one frame.
#[derive(Debug, Clone, Default)]
pub struct Scan {
    /// By sonar.
    pub arcs: Vec<Arc>,
    /// Sonars to which nothing echoed.
    pub silent: Vec<SonarId>,
}

/// A feature that a method found.
#[derive(Debug, Clone)]
pub struct Found {
    pub shape: Shape,
    /// The readings that it comes from.
    pub arcs: Vec<Arc>,
}

/// From scans to features.
pub trait Rival {
    /// What the next scan brings about.
    fn take(&mut self, scan: &Scan) -> Vec<Found>;

    /// What is found at the end of the log.
    fn finish(&mut self) -> Vec<Found> {
        Vec::new()
    }

    /// How far a feature is from one of the map of its kind; `None` where they are not the same.
    fn distance(&self, known: &MapFeature, shape: &Shape, bounds: &Bounds) -> Option<f64> {
        match (&known.shape, shape) {
            (Shape::Point(known), Shape::Point(point)) => {
                let distance = (known.position - point.position).norm();
                (distance < bounds.match_distance).then_some(distance)
            }
            (Shape::Line(known), Shape::Line(line)) => line_distance(known, line, bounds),
            _ => None,
        }
    }

    /// A feature of the map and another one that is the same: the mean by readings.
    fn fused(&self, known: &MapFeature, shape: &Shape, readings: u32) -> Shape {
        fuse_by_readings(known, shape, readings)
    }

    /// Why an arc belongs to no feature.
    fn reason(&self, _arc: ArcId) -> Reason {
        Reason::Unused
    }

    /// What the log lacks for the method.
    fn lacking(&self) -> Option<String> {
        None
    }
}

/// How far a line passes the middle of another one, metres; `None` where they are two walls.
fn line_distance(known: &Segment, line: &Segment, bounds: &Bounds) -> Option<f64> {
    let turned = angle_between(known.theta, signed_like(line, known).theta);
    let offset = (unit(known.theta).dot(&line.mid) - known.rho).abs();
    let same = turned < PARALLEL
        && offset < bounds.match_distance
        && overlap(known, line) > -bounds.max_wall_gap;
    same.then_some(offset)
}

/// A rival with its map.
pub struct RivalMapper {
    rival: Box<dyn Rival>,
    noise: Noise,
    bounds: Bounds,
    map: Vec<MapFeature>,
    extracted: u32,
    arcs: Vec<Arc>,
    /// The first feature that each arc went into.
    used: BTreeMap<ArcId, (Kind, u32)>,
}

impl RivalMapper {
    pub fn new(rival: Box<dyn Rival>, config: &Config) -> Self {
        Self {
            rival,
            noise: config.noise.clone(),
            bounds: config.map.clone(),
            map: Vec::new(),
            extracted: 0,
            arcs: Vec::new(),
            used: BTreeMap::new(),
        }
    }

    fn register(&mut self, mut found: Found, step: &mut Step) {
        // Some methods find them in the order along a wall.
        found.arcs.sort_by_key(|arc| arc.id);
        let kind = found.shape.kind();
        let id = self.extracted;
        self.extracted += 1;
        for arc in &found.arcs {
            self.used.entry(arc.id).or_insert((kind, id));
        }
        let readings = u32::try_from(found.arcs.len()).unwrap_or(u32::MAX);
        let known = self.map.iter().enumerate().filter_map(|(place, known)| {
            let distance = self.rival.distance(known, &found.shape, &self.bounds)?;
            Some((distance, place))
        });
        let known = ties::first_least(known, |_, _| ties::LENGTH);
        let known = known.and_then(|(_, place)| self.map.get_mut(place));
        let (action, feature) = match known {
            Some(known) => {
                known.shape = self.rival.fused(known, &found.shape, readings);
                known.readings = known.readings.saturating_add(readings);
                known.runs = known.runs.saturating_add(1);
                known.status = status(known, &self.bounds);
                (Action::Merged(known.id), *known)
            }
            None => {
                let mut feature = MapFeature {
                    id: u32::try_from(self.map.len()).unwrap_or(u32::MAX),
                    shape: found.shape,
                    readings,
                    runs: 1,
                    status: Status::Confirmed,
                };
                feature.status = status(&feature, &self.bounds);
                self.map.push(feature);
                (Action::Registered(feature.id), feature)
            }
        };
        let squares = found.arcs.iter().map(|arc| {
            let residual = found.shape.distance(arc.center()) - arc.range;
            residual * residual
        });
        let squares = squares.fold(0.0, |sum, square| sum + square);
        let ids: Vec<ArcId> = found.arcs.iter().map(|arc| arc.id).collect();
        step.extractions.push(Extraction {
            id,
            kind,
            labelled: ids.clone(),
            associated: ids,
            shape: Some(found.shape),
            residual_rms: (squares / found.arcs.len().max(1) as f64).sqrt(),
            iterations: 0,
            converged: true,
            opinion: None,
            outliers: Vec::new(),
            action,
            map_feature: Some(feature),
            absorbed: Vec::new(),
        });
    }

    fn report(&self, arc: &Arc) -> ArcReport {
        let used = self.used.get(&arc.id);
        ArcReport {
            label: used.map_or_else(
                || Label::Unidentified(self.rival.reason(arc.id)),
                |(kind, _)| kind.label(),
            ),
            run: used.map(|(_, extraction)| RunTest {
                extraction: *extraction,
                test: None,
            }),
            ..ArcReport::new(*arc)
        }
    }
}

/// As for TMAM: several features that agree confirm one, or many readings.
fn status(feature: &MapFeature, bounds: &Bounds) -> Status {
    if feature.runs >= bounds.confirm_runs || feature.readings >= bounds.confirm_readings {
        Status::Confirmed
    } else {
        Status::Tentative
    }
}

impl Mapper for RivalMapper {
    fn step(&mut self, frame: &Frame) -> Step {
        let mut scan = Scan::default();
        for entry in &frame.entries {
            match Arc::of_entry(frame.index, entry, &self.noise) {
                Some(arc) => scan.arcs.push(arc),
                None => scan.silent.push(entry.sonar),
            }
        }
        self.arcs.extend(&scan.arcs);
        let mut step = Step::default();
        for found in self.rival.take(&scan) {
            self.register(found, &mut step);
        }
        step.arcs = scan.arcs;
        step
    }

    /// Labels come with the end: until then an arc may go into another feature.
    fn finish(&mut self) -> Step {
        let mut step = Step::default();
        for found in self.rival.finish() {
            self.register(found, &mut step);
        }
        let arcs = std::mem::take(&mut self.arcs);
        step.reports = Shared::new(arcs.iter().map(|arc| self.report(arc)).collect());
        step.labelled = step.reports.to_vec();
        step.triples = vec![None; step.reports.len()];
        step
    }

    fn features(&self) -> &[MapFeature] {
        &self.map
    }

    fn lacking(&self) -> Option<String> {
        self.rival.lacking()
    }
}
