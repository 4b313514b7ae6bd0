//! A replay, sonar by sonar.

use std::collections::BTreeMap;

use crate::core::event::SonarId;
use crate::core::replay::{Outcome, Replay};
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::Way;

/// What a sonar gave a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SonarEntry<'a> {
    pub frame: u32,
    /// The echo; `None` where nothing came back.
    pub report: Option<&'a ArcReport>,
}

/// The way of the sensor to the echo at `place` of a sequence; `None` where nothing echoed before it.
pub fn way_to(sequence: &[SonarEntry<'_>], place: usize) -> Option<Way> {
    let arc = |at: usize| Some(&sequence.get(at)?.report?.arc);
    Some(Way::between(arc(place.checked_sub(1)?)?, arc(place)?))
}

/// Every sonar's entries, in order.
#[derive(Debug)]
pub struct Sequences<'a> {
    sonars: BTreeMap<SonarId, Vec<SonarEntry<'a>>>,
    reports: &'a [ArcReport],
    /// The first frame and the last one.
    pub frames: [u32; 2],
}

impl<'a> Sequences<'a> {
    pub fn new(replay: &Replay<'_>, outcome: &'a Outcome) -> Self {
        let reports = outcome.reports.as_slice();
        let mut sonars = BTreeMap::<SonarId, Vec<SonarEntry<'a>>>::new();
        for frame in replay.frames() {
            for entry in &frame.entries {
                let id = ArcId {
                    frame: frame.index,
                    sonar: entry.sonar,
                };
                let at = reports.binary_search_by_key(&id, |report| report.arc.id);
                sonars.entry(entry.sonar).or_default().push(SonarEntry {
                    frame: frame.index,
                    report: at.ok().and_then(|at| reports.get(at)),
                });
            }
        }
        Self {
            sonars,
            reports,
            frames: [replay.frames().first(), replay.frames().last()]
                .map(|frame| frame.map_or(0, |frame| frame.index)),
        }
    }

    /// The sonars that have entries.
    pub fn sonars(&self) -> impl Iterator<Item = SonarId> {
        self.sonars.keys().copied()
    }

    /// The entries of a sonar.
    pub fn of(&self, sonar: SonarId) -> &[SonarEntry<'a>] {
        self.sonars.get(&sonar).map_or(&[], Vec::as_slice)
    }

    /// The sequence that an arc is in, and its place there.
    pub fn around(&self, arc: ArcId) -> Option<(&[SonarEntry<'a>], usize)> {
        let sequence = self.of(arc.sonar);
        let place = sequence.binary_search_by_key(&arc.frame, |given| given.frame);
        Some((sequence, place.ok()?))
    }

    /// Every arc, by frame and then by sonar.
    pub fn arcs(&self) -> impl Iterator<Item = &'a Arc> {
        self.reports.iter().map(|report| &report.arc)
    }
}
