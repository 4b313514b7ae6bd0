//! The joint estimate of a log of which odometry shows too much at once: of its start first, then of ever
//! more of it.
//!
//! Where poses are right so far, the map has everything once, and odometry drifts anew only from there on.

use crate::core::config::Config;
use crate::core::frames::Frame;
use crate::core::joint::path::CorrectedPath;
use crate::core::joint::{self, Evidence, JointEstimate, OdometryKept};
use crate::core::tmam::Tmam;
use crate::core::tmam::feature::MapFeature;
use crate::core::tmam::step::Extraction;

/// A stage ends where its map has so many features more than at the end of the stage before, or twice as many.
pub const GROWN: usize = 100;

/// A stage is longer than the one before by this share at least, so that their number is bounded.
const LONGER: f64 = 0.1;

/// The start of a log, replayed.
struct Stage {
    frames: usize,
    extractions: Vec<Extraction>,
    map: Vec<MapFeature>,
}

impl Stage {
    /// At a path that is right for the first `known` frames.
    fn of(
        frames: &[Frame],
        path: Option<&CorrectedPath>,
        known: usize,
        more: usize,
        config: &Config,
    ) -> Self {
        let longer = known + (LONGER * known as f64) as usize;
        let mut tmam = Tmam::new(config);
        let mut extractions = Vec::new();
        let mut most = more;
        let mut stepped = 0;
        for frame in frames {
            let step = match path {
                Some(path) => tmam.step(&path.frame(frame)),
                None => tmam.step(frame),
            };
            extractions.extend(step.extractions);
            stepped += 1;
            let features = tmam.map().features().len();
            if stepped <= known {
                most = features + features.max(more);
            } else if stepped > longer && features > most {
                break;
            }
        }
        extractions.extend(tmam.finish().extractions);
        Self {
            frames: stepped,
            extractions,
            map: tmam.map().features().to_vec(),
        }
    }
}

/// Estimates ever longer parts of a log, each from the path of the part before and with so many features more,
/// up to the whole.
///
/// # Errors
/// Where odometry is to be kept, and why.
pub fn grown(
    evidence: &Evidence,
    more: usize,
    config: &Config,
) -> Result<JointEstimate, OdometryKept> {
    let mut joint: Option<JointEstimate> = None;
    let mut known = 0;
    loop {
        let path = joint.as_ref().map(|joint| &joint.path);
        let stage = Stage::of(evidence.frames, path, known, more, config);
        known = stage.frames;
        let is_whole = known == evidence.frames.len();
        let part = evidence.until(known);
        let extractions: Vec<&Extraction> = stage.extractions.iter().collect();
        match joint::estimate(&part, &extractions, &stage.map, joint.as_ref(), config) {
            Ok(found) if is_whole => return Ok(found),
            Ok(found) => joint = Some(found),
            // What comes later may tell more.
            Err(OdometryKept::Agrees | OdometryKept::TooLittle { .. }) if !is_whole => {}
            Err(kept) => return Err(kept),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::core::joint::testing::drifting_room;
    use crate::core::replay::Replay;
    use crate::core::tmam::arc::Arc;

    #[test]
    fn a_log_in_stages_has_the_path_of_the_whole() {
        let config = Config::default();
        let log = drifting_room(3);
        let replay = Replay::new(&log, &config).unwrap();
        let frames = replay.frames();
        let arcs: Vec<Arc> = (frames.iter())
            .flat_map(|frame| {
                let entries = frame.entries.iter();
                entries.filter_map(|entry| Arc::of_entry(frame.index, entry, &config.noise))
            })
            .collect();
        let evidence = Evidence {
            frames,
            arcs: &arcs,
            hardly: &BTreeSet::new(),
        };
        let first = Stage::of(frames, None, 0, 20, &config);
        assert!(first.frames < frames.len() / 2, "{}", first.frames);
        let grown = grown(&evidence, 20, &config).unwrap();
        let whole = replay.run(&mut []).unwrap();
        let whole = whole.joint().unwrap();
        assert_eq!(grown.path.keys, whole.path.keys);
        let apart = grown.path.moved(&whole.path);
        assert!(
            whole.path.end_correction() > 0.05 && apart < 0.01,
            "{apart}"
        );
    }
}
