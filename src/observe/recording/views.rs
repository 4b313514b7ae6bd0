//! The views of the blueprint.

use std::io::Write;

use rerun::blueprint::components::{
    ContainerKind, LinkAxis, TextLogColumn, TimelineColumn, VisibleTimeRange,
    VisualBounds2D as VisualBounds,
};
use rerun::blueprint::datatypes::{
    TextLogColumn as TextLogColumnData, TextLogColumnKind, TimelineColumn as TimelineColumnData,
};
use rerun::components::{Range1D, Visible};
use rerun::datatypes::{self, Bool, Range2D, TimeInt, TimeRange, TimeRangeBoundary};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    PlotLegend, ScalarAxis, TextLogColumns, TimeAxis, ViewContents, VisibleTimeRanges,
    VisualBounds2D,
};

use super::Error;
use super::blueprint::{Id, Layout, Part as _, Writer};
use super::extent::Bounds;

/// The map: bounds that fit the run, and the trajectory up to the cursor.
pub fn map<W: Write>(w: &mut Writer<'_, W>, layout: &Layout) -> Result<(), Error> {
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
    w.put(
        ViewContents::blueprint_base_visualizer_path_for_entity(
            Id::Map.uuid(),
            &"/world/trajectory".into(),
        ),
        &VisibleTimeRanges::new([so_far("frame"), so_far(layout.stamp.name().as_str())]),
    )
}

/// What the values of a plot are held against.
#[derive(Debug, Clone, Copy)]
pub enum Bound {
    /// Angles.
    Gamma,
    /// Chi2.
    Gate,
}

/// A value over time against its bound.
pub fn plot<W: Write>(
    w: &mut Writer<'_, W>,
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
    w.property(
        id,
        "ScalarAxis",
        &ScalarAxis::new().with_range(Range1D([-0.06 * top, 1.12 * top].into())),
    )?;
    w.property(
        id,
        "TimeAxis",
        &TimeAxis::new().with_link(LinkAxis::LinkToGlobal),
    )?;
    // Sixteen names would cover the plot; each dot says its sonar when pointed at.
    w.property(
        id,
        "PlotLegend",
        &PlotLegend::new().with_visible(Visible(Bool(false))),
    )
}

/// In longer runs most labels are too short to be drawn on a lane of names.
const FRAMES_ON_LANES: i64 = 400;

/// The labels, as lanes of names and as dots.
pub fn labels<W: Write>(w: &mut Writer<'_, W>, layout: &Layout) -> Result<(), Error> {
    w.view(Id::Labels, "StateTimeline", "Labels", &["+ /labels/**"])?;
    w.view(
        Id::Dots,
        "TimeSeries",
        "Labels by sonar number",
        &["+ /lanes/**"],
    )?;
    for id in [Id::Labels, Id::Dots] {
        w.property(
            id,
            "TimeAxis",
            &TimeAxis::new().with_link(LinkAxis::LinkToGlobal),
        )?;
    }
    w.property(
        Id::Dots,
        "ScalarAxis",
        &ScalarAxis::new().with_range(Range1D([-0.7, layout.sonars as f64 - 0.3].into())),
    )?;
    w.property(
        Id::Dots,
        "PlotLegend",
        &PlotLegend::new().with_visible(Visible(Bool(false))),
    )?;
    let tabs = if layout.frames > FRAMES_ON_LANES {
        [Id::Dots, Id::Labels]
    } else {
        [Id::Labels, Id::Dots]
    };
    w.container(Id::Lanes, ContainerKind::Tabs, &tabs, &[])
}

/// The event log.
pub fn events<W: Write>(w: &mut Writer<'_, W>, layout: &Layout) -> Result<(), Error> {
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
