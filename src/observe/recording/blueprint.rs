//! How the viewer lays the recording out. It rides in the same file.
//!
//! Written by hand rather than with the SDK's builder, which draws random ids and knows no visual
//! bounds, time ranges or legends.

mod writer;

use rerun::Timeline;
use rerun::blueprint::components::{
    AbsoluteTimeRange, ContainerKind, LinkAxis, LoopMode, PanelState, PlayState, TextLogColumn,
    TimelineColumn, VisibleTimeRange, VisualBounds2D as VisualBounds,
};
use rerun::blueprint::datatypes::{
    TextLogColumn as TextLogColumnData, TextLogColumnKind, TimelineColumn as TimelineColumnData,
};
use rerun::components::{Range1D, Visible};
use rerun::datatypes::{self, Bool, Range2D, TimeInt, TimeRange, TimeRangeBoundary};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    PlotLegend, ScalarAxis, TextLogColumns, TimeAxis, TimePanelBlueprint, ViewContents,
    VisibleTimeRanges, VisualBounds2D,
};
use rerun::external::uuid::Uuid;

use super::canvas::Canvas;
use super::entity::Entity;
use super::plane::Bounds;
use crate::observe::viewer::Error;
pub use writer::{FIRST_UUID, Part, Writer};

/// What the layout depends on.
pub struct Layout {
    /// The part of the plane to show; all that is drawn where not given.
    pub bounds: Option<Bounds>,
    /// How many frames there are; 0 where that is not known yet.
    pub frames: i64,
    /// How many label lanes there are.
    pub lanes: usize,
    /// How many sonars there are, silent ones too.
    pub sonars: usize,
    /// Widest beam, radians: the top of the angle plots.
    pub beam_width: f64,
    /// On the chi2 of a triple.
    pub gate: f64,
    /// The name of the stamp timeline.
    pub stamp: Timeline,
    /// Whether it holds an evaluation.
    pub evaluated: bool,
    /// Whether poses were corrected.
    pub corrected: bool,
    /// The frame to open at; the last one where not given.
    pub first: Option<u32>,
}

/// Ids of the containers and views, the same in every recording.
#[derive(Debug, Clone, Copy)]
pub enum Id {
    Root = 1,
    Left,
    Right,
    Angles,
    Scene,
    Map,
    About,
    ThetaC,
    ThetaI,
    Labels,
    Dots,
    Lanes,
    Events,
    Line,
    Point,
    Chi2Line,
    Chi2Point,
    Evaluation,
    Below,
    Correction,
    Moved,
    Turned,
    Poses,
}

impl Part for Id {
    fn uuid(self) -> Uuid {
        Uuid::from_u128(FIRST_UUID | self as u128)
    }

    fn is_container(self) -> bool {
        matches!(
            self,
            Self::Root
                | Self::Left
                | Self::Right
                | Self::Angles
                | Self::Line
                | Self::Point
                | Self::Lanes
                | Self::Scene
                | Self::Below
                | Self::Correction
        )
    }
}

/// Writes the whole blueprint.
pub fn put(layout: &Layout, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    let mut w = Writer::new(canvas);
    map(&mut w, layout)?;
    w.view(Id::About, "TextDocument", "About", &["+ /about"])?;
    for (id, name, path, bound) in [
        (
            Id::ThetaC,
            "theta_c [rad]: low = wall",
            "+ /angles/theta_c",
            Bound::Gamma,
        ),
        (
            Id::ThetaI,
            "theta_i [rad]: low = point",
            "+ /angles/theta_i",
            Bound::Gamma,
        ),
        (Id::Chi2Line, "chi2 line", "+ /chi2/line", Bound::Gate),
        (Id::Chi2Point, "chi2 point", "+ /chi2/point", Bound::Gate),
    ] {
        plot(&mut w, layout, id, name, path, bound)?;
    }
    for (tabs, angle, chi2) in [
        (Id::Line, Id::ThetaC, Id::Chi2Line),
        (Id::Point, Id::ThetaI, Id::Chi2Point),
    ] {
        w.container(tabs, ContainerKind::Tabs, &[angle, chi2], &[])?;
    }
    labels(&mut w, layout)?;
    events(&mut w, layout)?;

    let mut tabs = vec![Id::Map, Id::About];
    if layout.evaluated {
        w.view(
            Id::Evaluation,
            "TextDocument",
            "Evaluation",
            &["+ /evaluation"],
        )?;
        tabs.insert(1, Id::Evaluation);
    }
    let mut below = Id::Events;
    if layout.corrected {
        correction(&mut w)?;
        tabs.push(Id::Poses);
        below = Id::Below;
    }
    w.container(Id::Scene, ContainerKind::Tabs, &tabs, &[])?;
    w.container(
        Id::Left,
        ContainerKind::Vertical,
        &[Id::Scene, below],
        &[3.0, 1.0],
    )?;
    let (lanes, angles) = heights(layout.lanes);
    w.container(
        Id::Angles,
        if angles > LOW {
            ContainerKind::Vertical
        } else {
            ContainerKind::Horizontal
        },
        &[Id::Line, Id::Point],
        &[1.0, 1.0],
    )?;
    w.container(
        Id::Right,
        ContainerKind::Vertical,
        &[Id::Angles, Id::Lanes],
        &[angles, lanes],
    )?;
    w.container(
        Id::Root,
        ContainerKind::Horizontal,
        &[Id::Left, Id::Right],
        &[1.3, 1.0],
    )?;
    w.window(Id::Root)?;
    w.put("time_panel", &time_panel(layout))
}

/// Where the time cursor is when the recording opens.
fn time_panel(layout: &Layout) -> TimePanelBlueprint {
    let panel = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_timeline("frame");
    let Some(first) = layout.first else {
        // Following puts the cursor on the last frame, where the whole map is to be seen.
        return panel.with_play_state(PlayState::Following);
    };
    // A blueprint cannot set the cursor. But a loop draws it into its range, and one of a single
    // frame keeps it there until somebody moves it.
    let first = i64::from(first);
    panel
        .with_play_state(PlayState::Playing)
        .with_loop_mode(LoopMode::Selection)
        .with_fps(1.0)
        .with_time_selection(AbsoluteTimeRange(datatypes::AbsoluteTimeRange {
            min: TimeInt(first),
            max: TimeInt(first + 1),
        }))
}

/// Height of the views in a window of ordinary size, in the viewer's points.
const HEIGHT: f32 = 900.0;
/// What a lane takes, and what the time axis and the title above the lanes take.
const LANE: f32 = 40.0;
const ABOVE_LANES: f32 = 50.0;
/// Angle plots are not made lower than this: they lie side by side before they become lower.
const LOW: f32 = 230.0;

/// Heights of the label lanes, all in sight if they can be, and of the angle plots above them.
fn heights(lanes: usize) -> (f32, f32) {
    let lanes = (LANE * lanes as f32 + ABOVE_LANES).clamp(0.25 * HEIGHT, HEIGHT - LOW);
    (lanes, HEIGHT - lanes)
}

/// The map: bounds that fit the run, and the trajectory up to the cursor.
fn map(w: &mut Writer<'_, '_>, layout: &Layout) -> Result<(), Error> {
    w.view(Id::Map, "2D", "Map", &["+ /world/**"])?;
    if let Some(Bounds { min, max }) = layout.bounds {
        // The view's y axis points down; the world is drawn flipped, so its bounds are too.
        w.property(
            Id::Map,
            "VisualBounds2D",
            &VisualBounds2D::new(VisualBounds(Range2D {
                x_range: [min.x, max.x].into(),
                y_range: [-max.y, -min.y].into(),
            })),
        )?;
    }
    let so_far = |timeline: &str| {
        VisibleTimeRange(datatypes::VisibleTimeRange {
            timeline: timeline.into(),
            range: TimeRange {
                start: TimeRangeBoundary::Infinite,
                end: TimeRangeBoundary::CursorRelative(TimeInt(0)),
            },
        })
    };
    let accumulated: &[Entity] = if layout.corrected {
        &[Entity::Trajectory, Entity::OdometryPath, Entity::Closures]
    } else {
        &[Entity::Trajectory]
    };
    for entity in accumulated {
        w.put(
            ViewContents::blueprint_base_visualizer_path_for_entity(
                Id::Map.uuid(),
                &entity.path().into(),
            ),
            &VisibleTimeRanges::new([so_far("frame"), so_far(layout.stamp.name().as_str())]),
        )?;
    }
    Ok(())
}

/// How far the poses were moved and turned, beside the events, and the page that says how to read it.
fn correction(w: &mut Writer<'_, '_>) -> Result<(), Error> {
    w.view(Id::Poses, "TextDocument", "Poses", &["+ /about/poses"])?;
    for (id, name, path) in [
        (Id::Moved, "poses moved [m]", "+ /correction/moved"),
        (Id::Turned, "turned [deg]", "+ /correction/turned"),
    ] {
        w.view(id, "TimeSeries", name, &[path])?;
        link(w, id)?;
    }
    let plots = [Id::Moved, Id::Turned];
    w.container(Id::Correction, ContainerKind::Tabs, &plots, &[])?;
    w.container(
        Id::Below,
        ContainerKind::Horizontal,
        &[Id::Events, Id::Correction],
        &[1.6, 1.0],
    )
}

/// What the values of a plot are held against.
#[derive(Debug, Clone, Copy)]
enum Bound {
    /// Angles.
    Gamma,
    /// Chi2.
    Gate,
}

/// A value over time against its bound.
fn plot(
    w: &mut Writer<'_, '_>,
    layout: &Layout,
    id: Id,
    name: &str,
    path: &str,
    bound: Bound,
) -> Result<(), Error> {
    let (bound, top) = match bound {
        Bound::Gamma => ("+ /angles/gamma", layout.beam_width),
        Bound::Gate => ("+ /chi2/gate", 4.0 * layout.gate),
    };
    w.view(id, "TimeSeries", name, &[path, bound])?;
    scale(w, id, [-0.06 * top, 1.12 * top])?;
    link(w, id)?;
    hide_legend(w, id)
}

fn scale(w: &mut Writer<'_, '_>, id: Id, range: [f64; 2]) -> Result<(), Error> {
    let axis = ScalarAxis::new().with_range(Range1D(range.into()));
    w.property(id, "ScalarAxis", &axis)
}

/// Sixteen names would cover the plot; each dot says its sonar when pointed at.
fn hide_legend(w: &mut Writer<'_, '_>, id: Id) -> Result<(), Error> {
    let legend = PlotLegend::new().with_visible(Visible(Bool(false)));
    w.property(id, "PlotLegend", &legend)
}

/// All views over time show the same part of it.
fn link(w: &mut Writer<'_, '_>, id: Id) -> Result<(), Error> {
    let axis = TimeAxis::new().with_link(LinkAxis::LinkToGlobal);
    w.property(id, "TimeAxis", &axis)
}

/// In longer runs most labels are too short to be drawn on a lane of names.
const FRAMES_ON_LANES: i64 = 400;

/// The labels, as lanes of names and as dots.
fn labels(w: &mut Writer<'_, '_>, layout: &Layout) -> Result<(), Error> {
    w.view(Id::Labels, "StateTimeline", "Labels", &["+ /labels/**"])?;
    w.view(
        Id::Dots,
        "TimeSeries",
        "Labels by sonar number",
        &["+ /lanes/**"],
    )?;
    link(w, Id::Labels)?;
    link(w, Id::Dots)?;
    scale(w, Id::Dots, [-0.7, layout.sonars as f64 - 0.3])?;
    hide_legend(w, Id::Dots)?;
    let tabs = if layout.frames > FRAMES_ON_LANES {
        [Id::Dots, Id::Labels]
    } else {
        [Id::Labels, Id::Dots]
    };
    w.container(Id::Lanes, ContainerKind::Tabs, &tabs, &[])
}

/// The event log.
fn events(w: &mut Writer<'_, '_>, layout: &Layout) -> Result<(), Error> {
    w.view(Id::Events, "TextLog", "Events", &["+ /log/**"])?;
    let timeline = |name: &str, visible: bool| {
        TimelineColumn(TimelineColumnData {
            visible: Bool(visible),
            timeline: name.into(),
        })
    };
    let column = |kind, visible| {
        TextLogColumn(TextLogColumnData {
            visible: Bool(visible),
            kind,
        })
    };
    w.property(
        Id::Events,
        "TextLogColumns",
        &TextLogColumns::new()
            .with_timeline_columns([
                timeline("frame", true),
                timeline(layout.stamp.name().as_str(), false),
            ])
            .with_text_log_columns([
                column(TextLogColumnKind::EntityPath, false),
                column(TextLogColumnKind::LogLevel, true),
                column(TextLogColumnKind::Body, true),
            ]),
    )
}
