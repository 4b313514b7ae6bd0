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

use super::canvas::Canvas;
use super::entity::Entity;
use super::plane::Bounds;
use super::plots::Plot;
use crate::core::event::SonarId;
use crate::observe::viewer::Error;
pub use writer::Part;

/// What the layout depends on.
pub struct ViewLayout {
    /// The part of the plane to show; all that is drawn where not given.
    pub bounds: Option<Bounds>,
    /// How many frames there are; 0 where that is not known yet.
    pub frames: i64,
    /// How many label lanes there are.
    pub lanes: usize,
    /// How many sonars there are, silent ones too.
    pub sonars: usize,
    /// What decides the labels.
    pub plots: [Plot; 2],
    /// The name of the stamp timeline.
    pub stamp: Timeline,
    /// Whether it holds an evaluation.
    pub evaluated: bool,
    /// Whether poses were corrected.
    pub corrected: bool,
    /// Whether labels are suspect.
    pub suspects: bool,
    /// The frame to open at; the last one where not given.
    pub first: Option<i64>,
}

// The containers and views.
const ROOT: Part = Part::container(1);
const LEFT: Part = Part::container(2);
const RIGHT: Part = Part::container(3);
const ANGLES: Part = Part::container(4);
const SCENE: Part = Part::container(5);
const MAP: Part = Part::view(6);
const ABOUT: Part = Part::view(7);
const UPPER: Part = Part::view(8);
const LOWER: Part = Part::view(9);
const LABELS: Part = Part::view(10);
const DOTS: Part = Part::view(11);
const LANES: Part = Part::container(12);
const EVENTS: Part = Part::view(13);
const TOLD: Part = Part::container(14);
const SUSPECTS: Part = Part::view(15);
const ALL_ARCS: Part = Part::view(16);
const EVALUATION: Part = Part::view(18);
const BELOW: Part = Part::container(19);
const CORRECTION: Part = Part::container(20);
const MOVED: Part = Part::view(21);
const TURNED: Part = Part::view(22);
const POSES: Part = Part::view(23);

/// Writes the whole blueprint.
pub fn put(layout: &ViewLayout, w: &mut Canvas<'_>) -> Result<(), Error> {
    map(w, layout, MAP, "Map", &[Entity::Trajectory, Entity::Echoes])?;
    let all = [Entity::Trajectory, Entity::Echoes, Entity::Arcs];
    map(w, layout, ALL_ARCS, "All arcs so far", &all)?;
    w.view(ABOUT, "TextDocument", "About", &["+ /about"])?;
    for (id, shown) in [UPPER, LOWER].into_iter().zip(&layout.plots) {
        plot(w, id, shown)?;
    }
    labels(w, layout)?;
    events(w, layout)?;

    let mut tabs = vec![MAP, ALL_ARCS, ABOUT];
    if layout.evaluated {
        w.view(EVALUATION, "TextDocument", "Evaluation", &["+ /evaluation"])?;
        tabs.insert(1, EVALUATION);
    }
    let mut below = EVENTS;
    if layout.suspects {
        w.view(SUSPECTS, "TextDocument", "Suspects", &["+ /suspects"])?;
        w.container(TOLD, ContainerKind::Tabs, &[SUSPECTS, EVENTS], &[])?;
        below = TOLD;
    }
    if layout.corrected {
        correction(w, below)?;
        tabs.push(POSES);
        below = BELOW;
    }
    w.container(SCENE, ContainerKind::Tabs, &tabs, &[])?;
    w.container(LEFT, ContainerKind::Vertical, &[SCENE, below], &[2.4, 1.0])?;
    let (lanes, angles) = heights(layout.lanes);
    w.container(
        ANGLES,
        if angles > LOW {
            ContainerKind::Vertical
        } else {
            ContainerKind::Horizontal
        },
        &[UPPER, LOWER],
        &[1.0, 1.0],
    )?;
    w.container(
        RIGHT,
        ContainerKind::Vertical,
        &[ANGLES, LANES],
        &[angles, lanes],
    )?;
    w.container(ROOT, ContainerKind::Horizontal, &[LEFT, RIGHT], &[1.3, 1.0])?;
    w.window(ROOT)?;
    w.part("time_panel", &time_panel(layout))
}

/// Where the time cursor is when the recording opens.
fn time_panel(layout: &ViewLayout) -> TimePanelBlueprint {
    let panel = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_timeline("frame");
    let Some(first) = layout.first else {
        // Following puts the cursor on the last frame, where the whole map is to be seen.
        return panel.with_play_state(PlayState::Following);
    };
    // A blueprint cannot set the cursor. But one that plays comes into the range of a loop, soon enough at the
    // viewer's usual pace, and a loop of a single frame keeps it there until somebody moves it.
    panel
        .with_play_state(PlayState::Playing)
        .with_loop_mode(LoopMode::Selection)
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

/// A map: bounds that fit the run, and what is shown of all frames up to the cursor.
fn map(
    w: &mut Canvas<'_>,
    layout: &ViewLayout,
    id: Part,
    name: &str,
    so_far: &[Entity],
) -> Result<(), Error> {
    w.view(id, "2D", name, &["+ /world/**"])?;
    if let Some(bounds) = layout.bounds {
        show_only(w, id, bounds)?;
    }
    let up_to_cursor = |timeline: &str| {
        VisibleTimeRange(datatypes::VisibleTimeRange {
            timeline: timeline.into(),
            range: TimeRange {
                start: TimeRangeBoundary::Infinite,
                end: TimeRangeBoundary::CursorRelative(TimeInt(0)),
            },
        })
    };
    let corrected: &[Entity] = if layout.corrected {
        &[Entity::OdometryPath, Entity::Closures]
    } else {
        &[]
    };
    for entity in so_far.iter().chain(corrected) {
        w.part(
            ViewContents::blueprint_base_visualizer_path_for_entity(
                id.uuid(),
                &entity.path().into(),
            ),
            &VisibleTimeRanges::new(
                ["frame", layout.stamp.name().as_str(), "seconds"].map(up_to_cursor),
            ),
        )?;
    }
    Ok(())
}

/// The part of a world that a view shows.
pub fn show_only(w: &mut Canvas<'_>, id: Part, Bounds { min, max }: Bounds) -> Result<(), Error> {
    // The view's y axis points down; the world is drawn flipped, so its bounds are too.
    let bounds = VisualBounds2D::new(VisualBounds(Range2D {
        x_range: [min.x, max.x].into(),
        y_range: [-max.y, -min.y].into(),
    }));
    w.property(id, "VisualBounds2D", &bounds)
}

/// How far the poses were moved and turned, beside the events, and the page that says how to read it.
fn correction(w: &mut Canvas<'_>, told: Part) -> Result<(), Error> {
    w.view(POSES, "TextDocument", "Poses", &["+ /about/poses"])?;
    for (id, name, path) in [
        (MOVED, "poses moved [m]", "+ /correction/moved"),
        (TURNED, "turned [deg]", "+ /correction/turned"),
    ] {
        w.view(id, "TimeSeries", name, &[path])?;
        link(w, id)?;
    }
    w.container(CORRECTION, ContainerKind::Tabs, &[MOVED, TURNED], &[])?;
    w.container(
        BELOW,
        ContainerKind::Horizontal,
        &[told, CORRECTION],
        &[1.6, 1.0],
    )
}

/// What decided, over time, against its bounds.
fn plot(w: &mut Canvas<'_>, id: Part, plot: &Plot) -> Result<(), Error> {
    let dots = (plot.dots)(SonarId(0)).path();
    let mut contents = vec![format!("+ {dots}/**")];
    contents.extend(
        plot.bounds
            .iter()
            .map(|bound| format!("+ {}", bound.entity.path())),
    );
    let contents: Vec<&str> = contents.iter().map(String::as_str).collect();
    w.view(id, "TimeSeries", plot.title, &contents)?;
    let [low, high] = plot.range;
    let margin = 0.06 * (high - low);
    scale(w, id, [low - margin, high + margin])?;
    link(w, id)?;
    hide_legend(w, id)
}

fn scale(w: &mut Canvas<'_>, id: Part, range: [f64; 2]) -> Result<(), Error> {
    let axis = ScalarAxis::new().with_range(Range1D(range.into()));
    w.property(id, "ScalarAxis", &axis)
}

/// Sixteen names would cover the plot. Colours are those of the labels; each dot says its sonar when pointed at.
fn hide_legend(w: &mut Canvas<'_>, id: Part) -> Result<(), Error> {
    let legend = PlotLegend::new().with_visible(Visible(Bool(false)));
    w.property(id, "PlotLegend", &legend)
}

/// All views over time show the same part of it.
fn link(w: &mut Canvas<'_>, id: Part) -> Result<(), Error> {
    let axis = TimeAxis::new().with_link(LinkAxis::LinkToGlobal);
    w.property(id, "TimeAxis", &axis)
}

/// In longer runs most labels are too short to be drawn on a lane of names.
const FRAMES_ON_LANES: i64 = 400;

/// The labels, as lanes of names and as dots.
fn labels(w: &mut Canvas<'_>, layout: &ViewLayout) -> Result<(), Error> {
    w.view(LABELS, "StateTimeline", "Labels", &["+ /labels/**"])?;
    w.view(
        DOTS,
        "TimeSeries",
        "Labels by sonar number",
        &["+ /lanes/**"],
    )?;
    link(w, LABELS)?;
    link(w, DOTS)?;
    scale(w, DOTS, [-0.7, layout.sonars as f64 - 0.3])?;
    hide_legend(w, DOTS)?;
    let tabs = if layout.frames > FRAMES_ON_LANES {
        [DOTS, LABELS]
    } else {
        [LABELS, DOTS]
    };
    w.container(LANES, ContainerKind::Tabs, &tabs, &[])
}

/// The event log.
fn events(w: &mut Canvas<'_>, layout: &ViewLayout) -> Result<(), Error> {
    w.view(EVENTS, "TextLog", "Events", &["+ /log/**"])?;
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
        EVENTS,
        "TextLogColumns",
        &TextLogColumns::new()
            .with_timeline_columns([
                timeline("frame", true),
                timeline("seconds", false),
                timeline(layout.stamp.name().as_str(), false),
            ])
            .with_text_log_columns([
                column(TextLogColumnKind::EntityPath, false),
                column(TextLogColumnKind::LogLevel, true),
                column(TextLogColumnKind::Body, true),
            ]),
    )
}
