//! Turns a replay into a Rerun recording with its own layout.
//!
//! The one place where Rerun types appear. The same replay gives the same bytes: see [`encode`].
//! [`entity`] lists everything that is drawn and how it looks, [`blueprint`] the views.

mod about;
mod arcs;
mod blueprint;
mod canvas;
mod carried;
mod closed;
mod corrections;
mod encode;
mod entity;
mod evidence;
mod grid;
mod ground;
mod hold;
mod live;
mod map;
mod overlay;
mod pairs;
mod plane;
mod plots;
mod reports;
mod robot;
mod style;
mod suspects;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

use rerun::components::TextLogLevel;
use rerun::{RecordingInfo, Scalars, TextDocument};

use self::about::opening;
use self::blueprint::ViewLayout;
use self::canvas::{Canvas, Moment};
pub use self::carried::read_carried;
use self::closed::Closed;
use self::corrections::Corrections;
use self::encode::{RrdWriter, identity};
use self::entity::Entity;
pub use self::grid::write_grid;
use self::hold::{HeldFrame, Hold};
pub use self::live::Live;
use self::map::DrawnMap;
pub use self::pairs::write_pairs;
use self::plane::{Extent, PlaneOrigin};
use self::reports::Reports;
use self::robot::Robot;
use self::suspects::{Ghosts, Suspects};
use crate::core::config::Rule;
use crate::core::event::SonarId;
use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError, Setting};
use crate::core::replay::Outcome;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Step;
use crate::core::wording::counted;
use crate::observe::drawing::Overlay;
use crate::observe::viewer::{Carried, Error};

/// What the angle plots are laid out for until the beams are known, radians.
const USUAL_BEAM_WIDTH: f64 = 0.5;

/// How far above a feature the name of what contradicts a label stands, of the greater side of the map.
const NAME_ABOVE: f64 = 0.04;

/// What looks the same in every recording.
const LOOKS: [Entity; 11] = [
    Entity::Arcs,
    Entity::Beams,
    Entity::ContactPoints,
    Entity::IntersectionPoints,
    Entity::Suspects,
    Entity::Contradicting,
    Entity::ContradictingNames,
    Entity::Echoes,
    Entity::ClosedArcs,
    Entity::ClosedLines,
    Entity::ClosedPoints,
];

/// A Rerun recording being written.
pub struct Recording<'a> {
    canvas: Canvas<'a>,
    setting: Setting<'a>,
    beam_width: f64,
    extent: Extent,
    seen: BTreeSet<SonarId>,
    // The frames that are shown and in which something echoed.
    echoing: BTreeSet<i64>,
    // The first frame and the last one so far.
    span: Option<[Moment; 2]>,
    // What the log says at the first frame; taken then.
    opening: Vec<(&'static str, String)>,
    labels: BTreeMap<&'static str, u64>,
    hold: Hold,
    closed: Closed,
    map: DrawnMap,
    robot: Robot,
    corrections: Corrections,
    reports: Reports,
    overlay: Overlay,
    // What is off, and then the table of the suspects, for one page.
    found: Vec<String>,
    suspects: Option<String>,
}

impl<'a> Recording<'a> {
    /// Starts a recording, with `overlay` drawn over it; an open viewer, where there is one, is shown
    /// it as well. When that goes away it is an error where there is no `out`; else the recording goes
    /// on without, and [`close`](Self::close) says so.
    ///
    /// # Errors
    /// When it cannot be written to.
    pub fn new(
        out: Option<&'a mut (dyn Write + Send)>,
        viewer: Option<Live>,
        setting: Setting<'a>,
        overlay: Overlay,
    ) -> Result<Self, Error> {
        let (ids, digest) = identity(&setting, &overlay);
        let file = RrdWriter::new(out, viewer, ids, digest)?;
        let origin = PlaneOrigin::of(setting.start);
        let mut recording = Self {
            canvas: Canvas::new(file, setting.origin_ns, origin, setting.sonars),
            setting,
            beam_width: setting.config.triple.gamma,
            extent: Extent::default(),
            seen: BTreeSet::new(),
            echoing: BTreeSet::new(),
            span: None,
            opening: opening(&setting),
            labels: BTreeMap::new(),
            hold: Hold::default(),
            closed: Closed::default(),
            map: DrawnMap::default(),
            robot: Robot::new(overlay.only.is_some()),
            corrections: Corrections::default(),
            reports: Reports::default(),
            overlay,
            found: Vec::new(),
            suspects: None,
        };
        recording.begin()?;
        Ok(recording)
    }

    /// Writes everything that never changes.
    fn begin(&mut self) -> Result<(), Error> {
        let (canvas, setting) = (&mut self.canvas, &self.setting);
        let source = setting.source;
        let info = RecordingInfo::new().with_name(source.file.as_str());
        let info = info.with_start_time(source.start_ns);
        canvas.put("/__properties", &info)?;
        if let Some(at) = canvas.origin.shift() {
            canvas.put("/__properties/origin", &Scalars::new([at.x, at.y]))?;
        }
        let about = about::page(setting, &self.overlay.about, canvas.origin);
        canvas.put("/about", &about)?;
        canvas.put("/world", &plane::upright())?;
        canvas.put(
            "/world",
            &style::annotations(setting.sonars, setting.config.departures().circles),
        )?;
        for entity in LOOKS {
            canvas.put_look(entity)?;
        }
        robot::put_styles(self.overlay.only.is_some(), canvas)?;
        overlay::put(&self.overlay, canvas)?;
        let layout = ViewLayout {
            bounds: None,
            frames: 0,
            lanes: setting.sonars.len(),
            first: None,
            ..self.layout(USUAL_BEAM_WIDTH.max(self.beam_width), &Suspects::default())
        };
        let preview = |canvas: &mut Canvas<'_>| blueprint::put(&layout, canvas);
        self.canvas.preview(preview)
    }

    fn watch(&mut self, frame: &Frame, step: &Step) -> Result<(), Error> {
        let at = Moment::new(frame.index, frame.stamp_ns);
        if let Some([_, last]) = self.span {
            self.closed.draw(last, &mut self.canvas)?;
        }
        self.span = Some([self.span.map_or(at, |[first, _]| first), at]);

        let sonars = frame.entries.iter().map(|entry| entry.sonar);
        self.seen.extend(sonars);
        self.extent.visit(&frame.world_from_robot);
        for arc in &step.arcs {
            self.extent.echo(arc);
            self.beam_width = self.beam_width.max(arc.beam_width);
        }
        let shows = self.overlay.shows(frame.index);
        let before = frame.index.checked_sub(1);
        let leaves = !shows && before.is_some_and(|before| self.overlay.shows(before));
        if shows {
            if !step.arcs.is_empty() {
                self.echoing.insert(at.frame);
            }
            let pose = frame.world_from_robot;
            self.robot.draw(at, pose, &mut self.canvas)?;
            self.corrections.draw(at, frame, &mut self.canvas)?;
            self.hold.push(HeldFrame::new(at, frame, step));
            arcs::draw_echoes(at, &step.arcs, &mut self.canvas)?;
            let sonars = frame.entries.iter().map(|entry| entry.sonar);
            self.reports.frame(at, sonars);
        } else if leaves {
            // The viewer would go on showing the last frame before frames that are not shown.
            self.robot.leave(at, &mut self.canvas)?;
            self.corrections.leave(at, &mut self.canvas)?;
            let sonars = self.seen.iter().copied();
            self.hold.push(HeldFrame::blank(at, sonars.clone()));
            self.reports.leave(at, sonars);
        }
        self.closed.note(step, self.canvas.origin);
        self.take(at, step)?;
        if shows || leaves {
            let arcs = if shows { step.arcs.as_slice() } else { &[] };
            overlay::mark(&self.overlay, at, arcs, &mut self.canvas)?;
        }
        Ok(())
    }

    /// Takes in what a step decided, whether a frame came with it or not.
    fn take(&mut self, at: Moment, step: &Step) -> Result<(), Error> {
        let canvas = &mut self.canvas;
        for (level, text) in std::mem::take(&mut self.opening) {
            canvas.note(at, level, text)?;
        }
        for (report, triple) in step.labelled.iter().zip(&step.triples) {
            self.hold.decide(report, *triple);
            *self.labels.entry(report.label.name()).or_default() += 1;
        }
        while let Some(ready) = self.hold.pop() {
            arcs::draw(&ready, canvas)?;
        }
        closed::tell(at, &step.extractions, canvas)?;
        self.map.draw(at, step, canvas)
    }

    /// Writes what waited, what is known only now, and the layout that fits it.
    fn end(&mut self, step: &Step) -> Result<(), Error> {
        let last = self.span.map_or(Moment::new(0, 0), |[_, last]| last);
        self.reports
            .draw_evidence(&step.reports, &mut self.canvas)?;
        self.take(last, step)?;
        let canvas = &mut self.canvas;
        while let Some(ready) = self.hold.drain() {
            arcs::draw(&ready, canvas)?;
        }
        if self.span.is_some() {
            self.closed.draw(last, canvas)?;
            let text = self.summary(&step.reports);
            self.canvas.note(last, TextLogLevel::INFO, text)?;
        }
        let canvas = &mut self.canvas;
        self.corrections.close_loops(&step.closures, canvas)?;
        overlay::finish(&self.overlay, last, canvas)?;
        self.reports.draw_labels(&step.reports, canvas)?;
        canvas.flush()?;
        let circles = self.setting.config.departures().circles;
        reports::put_lanes(self.seen.iter().copied(), circles, canvas)?;
        let ghosts = Ghosts {
            features: &step.predicting,
            // Under the paper's rule another map than the one that is drawn predicts.
            has_ids: self.setting.config.rule == Rule::NoiseAware,
            // A name stands clear of the id below the feature.
            above: NAME_ABOVE * self.extent.bounds().size().amax(),
        };
        let suspects = Suspects::draw(&self.reports, &step.reports, &ghosts, canvas)?;
        if suspects.count > 0 {
            self.suspects = Some(suspects::table(&step.reports, &self.setting));
        }
        let plots = plots::deciding(self.setting.config, self.beam_width);
        let ends = self.span.as_slice().concat();
        plots::draw(&plots, &self.reports, &step.reports, &ends, canvas)?;
        ground::put("/world", &self.extent.bounds(), canvas)?;
        let layout = self.layout(self.beam_width, &suspects);
        blueprint::put(&layout, &mut self.canvas)
    }

    fn summary(&self, reports: &[ArcReport]) -> String {
        let arcs = |label| self.labels.get(label).copied().unwrap_or_default();
        let [walls, points, circles, tentative] = self.map.counts();
        let round = match (arcs("circle"), circles) {
            (0, 0) => [String::new(), String::new()],
            (arcs, circles) => [
                format!("{arcs} circle, "),
                format!(" and {}", counted(circles as u64, "circle")),
            ],
        };
        let [round_arcs, round_features] = round;
        format!(
            "end: {}; {} contact, {} intersection, {round_arcs}{} unidentified arcs, {} suspect; {} and \
             {}{round_features} in the map, {tentative} more tentative",
            counted(self.frames().unsigned_abs(), "frame"),
            arcs("contact"),
            arcs("intersection"),
            arcs("unidentified"),
            reports.iter().filter(|report| report.is_suspect()).count(),
            counted(walls as u64, "line"),
            counted(points as u64, "point"),
        )
    }

    fn frames(&self) -> i64 {
        self.span
            .map_or(0, |[first, last]| last.frame - first.frame + 1)
    }

    fn layout(&self, beam_width: f64, suspects: &Suspects) -> ViewLayout {
        let bounds = self.extent.bounds();
        ViewLayout {
            bounds: Some(bounds.seen_from(self.canvas.origin)),
            frames: self.frames(),
            lanes: self.seen.len(),
            sonars: self.canvas.sonars.len(),
            plots: plots::deciding(self.setting.config, beam_width),
            stamp: self.canvas.lines.stamp,
            evaluated: self.overlay.truth.is_some(),
            corrected: self.corrections.are_there(),
            suspects: suspects.count > 0,
            first: self.first(suspects),
        }
    }

    /// Tells what is off in the log: at the first frame, and above the suspects.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn tell(&mut self, outcome: &Outcome) -> Result<(), Error> {
        let Some([first, _]) = self.span else {
            return Ok(());
        };
        let causes = outcome.causes.iter().flatten().enumerate();
        let causes = causes.map(|(place, cause)| format!("cause {}: {}", place + 1, cause.text));
        self.found.extend(causes);
        let stretch = outcome.stretch.as_ref();
        let stretch = stretch.map(|one| format!("stretch: {} {}", one.arcs, one.in_words()));
        self.found.extend(stretch);
        for text in &self.found {
            self.canvas.note(first, TextLogLevel::WARN, text.clone())?;
        }
        self.canvas.flush()
    }

    /// The frame to open at, where that is not the last one: of the first difference, else of the worst
    /// suspect, else the last one in which something echoed.
    fn first(&self, suspects: &Suspects) -> Option<i64> {
        let shown = |frame: &i64| self.echoing.contains(frame);
        let asked = self.overlay.first_frame.map(i64::from).filter(shown);
        let last = self.span.map(|[_, last]| last.frame);
        let echoing = self
            .echoing
            .last()
            .copied()
            .filter(|frame| Some(*frame) != last);
        asked.or(suspects.worst.map(i64::from)).or(echoing)
    }

    /// Closes the file after [`Observer::finish`], with the results of the run in it where they are
    /// `carried`; gives back why the viewer was not shown everything.
    ///
    /// # Errors
    /// When the rest cannot be written.
    pub fn close(mut self, carried: Option<&Carried>) -> Result<Option<Error>, Error> {
        if let Some(table) = &self.suspects {
            let found = self.found.iter().map(|text| format!("**{text}**\n\n"));
            let page = found.collect::<String>() + table;
            self.canvas
                .put("/suspects", &TextDocument::from_markdown(page))?;
        }
        if let Some(carried) = carried {
            carried::put(carried, &mut self.canvas)?;
        }
        self.canvas.close()
    }
}

impl Observer for Recording<'_> {
    fn frame(&mut self, frame: &Frame, step: &Step) -> Result<(), ObserverError> {
        self.watch(frame, step).map_err(ObserverError::new)
    }

    fn finish(&mut self, step: &Step) -> Result<(), ObserverError> {
        self.end(step).map_err(ObserverError::new)
    }
}
