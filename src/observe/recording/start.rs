//! How a recording begins: everything that never changes.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

use rerun::{RecordingInfo, Scale3D, Transform3D};

use super::blueprint::{self, Layout};
use super::closed::{self, ClosedTables};
use super::decided::DecidedTables;
use super::encode::RrdWriter;
use super::evidence::EvidenceTable;
use super::extent::Extent;
use super::hold::Hold;
use super::live::Live;
use super::log::{LogTable, opening};
use super::map::MapTables;
use super::names::store_ids;
use super::origin::Origin;
use super::overlay::{Overlay, OverlayTable};
use super::plots::{self, Limits};
use super::robot::{self, RobotTables};
use super::suspects::{self, SuspectTables};
use super::table::{Timelines, put_static};
use super::truth::{Evaluated, TruthTables};
use super::{Error, Recording, about, arcs, style};
use crate::core::observer::Setting;

/// What the angle plots are laid out for until the beams are known, radians.
const USUAL_BEAM_WIDTH: f64 = 0.5;

impl<W: Write> Recording<W> {
    /// Starts a recording; everything that never changes is written now.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn new(out: W, setting: Setting<'_>) -> Result<Self, Error> {
        Self::start(out, setting, Overlay::default(), None, None)
    }

    /// Starts a recording of a replay that has been evaluated, with the truth and the errors in it.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn of_evaluated(
        out: W,
        setting: Setting<'_>,
        evaluated: Evaluated<'_>,
    ) -> Result<Self, Error> {
        Self::start(out, setting, Overlay::default(), Some(evaluated), None)
    }

    /// Starts a recording with something drawn over it.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn overlaid(out: W, setting: Setting<'_>, overlay: Overlay) -> Result<Self, Error> {
        Self::start(out, setting, overlay, None, None)
    }

    /// Starts a recording that an open viewer, where there is one, is shown as well. When it goes
    /// away that is an error where the recording is `only_live`; else it goes on without, and
    /// [`close`](Self::close) says so.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn with_viewer(
        out: W,
        viewer: Option<Live>,
        only_live: bool,
        setting: Setting<'_>,
    ) -> Result<Self, Error> {
        let live = viewer.map(|viewer| (viewer, only_live));
        Self::start(out, setting, Overlay::default(), None, live)
    }

    fn start(
        out: W,
        setting: Setting<'_>,
        overlay: Overlay,
        evaluated: Option<Evaluated<'_>>,
        live: Option<(Live, bool)>,
    ) -> Result<Self, Error> {
        let (viewer, only_live) = live.map_or((None, false), |(viewer, only)| (Some(viewer), only));
        let source = setting.source;
        let world = evaluated.map(|evaluated| evaluated.truth.world());
        let [recording, blueprint] = store_ids(&setting, world);
        let origin = Origin::of(setting.start);
        let start_ns = source.start_ns;
        let mut out = RrdWriter::new(out, viewer, recording, blueprint, start_ns, origin)?;
        let limits = Limits {
            gamma: setting.config.triple.gamma,
            gate: setting.config.opinion.gate,
        };
        put_static(
            "/__properties",
            &RecordingInfo::new()
                .with_name(source.file.as_str())
                .with_start_time(source.start_ns),
            &mut out,
        )?;
        origin.put(&mut out)?;
        put_static(
            "/about",
            &about::page(&setting, &overlay.about, origin),
            &mut out,
        )?;
        // A 2D view has y down: turn the world over.
        put_static(
            "/world",
            &Transform3D::from_scale(Scale3D::from([1.0, -1.0, 1.0])),
            &mut out,
        )?;
        put_static("/world", &style::annotations(), &mut out)?;
        arcs::put_styles(&mut out)?;
        plots::put_styles(setting.sonars, limits, &mut out)?;
        suspects::put_styles(&mut out)?;
        closed::put_styles(&mut out)?;
        let comes_and_goes = overlay.only.is_some();
        robot::put_styles(setting.sonars, comes_and_goes, &mut out)?;
        let truth = evaluated
            .map(|evaluated| TruthTables::new(&setting, evaluated, &mut out))
            .transpose()?;
        let lines = Timelines::new(source.start_ns);
        out.preview(|out| {
            let layout = Layout {
                bounds: None,
                frames: 0,
                lanes: setting.sonars.len(),
                sonars: setting.sonars.len(),
                beam_width: USUAL_BEAM_WIDTH.max(limits.gamma),
                gate: limits.gate,
                stamp: lines.stamp,
                evaluated: evaluated.is_some(),
                first: None,
            };
            blueprint::put(&layout, out)
        })?;
        if overlay != Overlay::default() {
            overlay.put(&mut out)?;
            overlay.note(setting.sonars, lines, &mut out)?;
        }
        Ok(Self {
            out,
            only_live,
            lost: None,
            lines,
            sonars: setting.sonars.to_vec(),
            limits,
            beam_width: limits.gamma,
            extent: Extent::default(),
            span: None,
            opening: opening(&setting),
            labels: BTreeMap::new(),
            hold: Hold::default(),
            seen: BTreeSet::new(),
            decided: DecidedTables::new(setting.sonars),
            evidence: EvidenceTable::new(setting.sonars),
            closed: ClosedTables::new(),
            map: MapTables::new(),
            robot: RobotTables::new(setting.sonars, comes_and_goes),
            log: LogTable::new(setting.sonars),
            suspects: SuspectTables::new(setting.sonars),
            truth,
            overlay,
            marks: OverlayTable::new(),
        })
    }
}
