//! How a recording ends: what waited, what is known only now, and the layout that fits it.

use std::io::Write;

use rerun::components::TextLogLevel;

use super::blueprint::{self, Layout};
use super::table::Moment;
use super::{Error, Recording, plots};
use crate::core::tmam::step::Step;
use crate::core::wording::counted;

impl<W: Write> Recording<W> {
    pub(super) fn end(&mut self, step: &Step) -> Result<(), Error> {
        let last = self.span.map_or(
            Moment {
                frame: 0,
                stamp_ns: 0,
            },
            |(_, last)| last,
        );
        self.digest(last, step)?;
        let (lines, out) = (self.lines, &mut self.out);
        while let Some(ready) = self.hold.drain() {
            self.decided.write(&ready, &self.sonars, lines, out)?;
            self.marks
                .push(&ready, &self.overlay, &self.sonars, lines, out)?;
        }
        if let Some((first, last)) = self.span {
            self.closed.push(last, lines, out)?;
            let arcs = |label| self.labels.get(label).copied().unwrap_or_default();
            let [walls, points, tentative] = self.map.counts();
            let text = format!(
                "end: {}; {} contact, {} intersection, {} unidentified arcs, {} suspect; \
                 {} and {} in the map, {tentative} more tentative",
                counted((last.frame - first.frame + 1).unsigned_abs(), "frame"),
                arcs("contact"),
                arcs("intersection"),
                arcs("unidentified"),
                self.suspects.count(),
                counted(walls as u64, "line"),
                counted(points as u64, "point"),
            );
            self.log.note(last, TextLogLevel::INFO, text, lines, out)?;
        }
        if let Some(truth) = &mut self.truth {
            truth.finish(last, lines, out)?;
        }
        self.decided.flush(lines, out)?;
        self.evidence.flush(lines, out)?;
        self.marks.flush(lines, out)?;
        self.closed.flush(lines, out)?;
        self.map.flush(lines, out)?;
        self.robot.flush(lines, out)?;
        self.log.flush(lines, out)?;
        self.suspects.write(lines, out)?;
        let ends: Vec<Moment> = self.span.iter().flat_map(|(a, b)| [*a, *b]).collect();
        let seen = &self.seen;
        plots::put_last(&self.sonars, seen, self.limits, &ends, lines, out)?;
        let layout = Layout {
            bounds: Some(self.extent.bounds().seen_from(out.origin())),
            frames: self
                .span
                .map_or(0, |(first, last)| last.frame - first.frame + 1),
            lanes: self.seen.len(),
            sonars: self.sonars.len(),
            beam_width: self.beam_width,
            gate: self.limits.gate,
            stamp: lines.stamp,
            evaluated: self.truth.is_some(),
            first: self.overlay.first_frame,
        };
        blueprint::put(&layout, out)
    }
}
