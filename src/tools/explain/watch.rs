//! Watches a replay and keeps what the story of any arc may need.

use std::collections::BTreeMap;

use crate::core::event::SonarId;
use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError};
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::step::Step;
use crate::core::tmam::report::ArcReport;

/// What a sonar gave a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// The frame.
    pub frame: u32,
    /// When.
    pub stamp_ns: i64,
    /// The echo; `None` where nothing came back.
    pub arc: Option<Arc>,
}

/// What was seen of a replay.
#[derive(Debug, Default)]
pub struct Watch {
    /// Every sonar's entries, in order.
    pub sequences: BTreeMap<SonarId, Vec<Given>>,
    /// Every arc's judgement.
    pub judgements: BTreeMap<ArcId, ArcReport>,
    /// Frames opened.
    pub frames: u32,
}

impl Watch {
    /// The entries of a sonar.
    pub fn sequence(&self, sonar: SonarId) -> &[Given] {
        self.sequences.get(&sonar).map_or(&[], Vec::as_slice)
    }

    /// Where in its sonar's sequence an arc stands.
    pub fn place(&self, arc: ArcId) -> Option<usize> {
        let sequence = self.sequence(arc.sonar);
        sequence.binary_search_by_key(&arc.frame, |g| g.frame).ok()
    }

    /// Every arc, by frame and then by sonar.
    pub fn arcs(&self) -> impl Iterator<Item = &Arc> {
        self.judgements.values().map(|judgement| &judgement.arc)
    }

    fn judge(&mut self, step: &Step) {
        let judgements = step.judgements.iter();
        self.judgements.extend(judgements.map(|j| (j.arc.id, *j)));
    }
}

impl Observer for Watch {
    fn frame(&mut self, frame: &Frame, step: &Step) -> Result<(), ObserverError> {
        self.frames = frame.index + 1;
        for entry in &frame.entries {
            let arc = step.arcs.iter().find(|arc| arc.id.sonar == entry.sonar);
            self.sequences.entry(entry.sonar).or_default().push(Given {
                frame: frame.index,
                stamp_ns: entry.stamp_ns,
                arc: arc.copied(),
            });
        }
        self.judge(step);
        Ok(())
    }

    fn finish(&mut self, step: &Step) -> Result<(), ObserverError> {
        self.judge(step);
        Ok(())
    }
}
