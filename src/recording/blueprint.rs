//! How the viewer lays the recording out. It rides in the same file.
//!
//! Written by hand rather than with the SDK's builder, which draws random ids and knows no visual
//! bounds, time ranges or legends.

use std::io::Write;

use rerun::blueprint::components::{
    AbsoluteTimeRange, ActiveTab, AutoLayout, AutoViews, ColumnShare, ContainerKind,
    IncludedContent, LoopMode, PanelState, PlayState, QueryExpression, RootContainer, RowShare,
    ViewClass,
};
use rerun::components::Name;
use rerun::datatypes::{self, Bool, Float32, TimeInt};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, PanelBlueprint, TimePanelBlueprint, ViewBlueprint, ViewContents,
    ViewportBlueprint,
};
use rerun::external::uuid::Uuid;
use rerun::{AsComponents, EntityPath, Timeline};

use super::Error;
use super::encode::{RrdWriter, Store};
use super::extent::Bounds;
use super::table::unit_columns;
use super::views::{self, Bound};

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
}

/// A container or view, the same in every recording.
pub trait Part: Copy {
    /// The number behind it.
    fn uuid(self) -> Uuid;

    /// Whether it holds others.
    fn is_container(self) -> bool;

    /// Where it stands in the blueprint.
    fn path(self) -> String {
        let kind = if self.is_container() {
            "container"
        } else {
            "view"
        };
        format!("{kind}/{}", self.uuid())
    }
}

/// The first of the ids; those of recordings of a replay follow, those of grids have the next bit set.
pub const FIRST_UUID: u128 = 0x746d_616d_0000_4000_8000_0000_0000_0000;

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
        )
    }
}

/// Writes the parts of the blueprint.
pub struct Writer<'a, W> {
    out: &'a mut RrdWriter<W>,
}

impl<'a, W: Write> Writer<'a, W> {
    /// A blueprint without parts.
    pub fn new(out: &'a mut RrdWriter<W>) -> Self {
        Self { out }
    }

    /// Any part.
    pub fn put(
        &mut self,
        path: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result<(), Error> {
        self.out.chunk(
            Store::Blueprint,
            &path.into(),
            1,
            vec![(Timeline::new_sequence("blueprint"), vec![0])],
            unit_columns(what)?,
        )
    }

    /// A view of the entities that `query` selects.
    pub fn view(
        &mut self,
        id: impl Part,
        class: &str,
        name: &str,
        query: &[&str],
    ) -> Result<(), Error> {
        let path = id.path();
        self.put(
            format!("{path}/ViewContents"),
            &ViewContents::new(query.iter().map(|q| QueryExpression((*q).into()))),
        )?;
        self.put(
            path,
            &ViewBlueprint::new(ViewClass(class.into()))
                .with_display_name(Name(name.into()))
                .with_space_origin("/"),
        )
    }

    /// A setting of a view.
    pub fn property(
        &mut self,
        id: impl Part,
        name: &str,
        what: &dyn AsComponents,
    ) -> Result<(), Error> {
        self.put(format!("{}/{name}", id.path()), what)
    }

    /// A container; the first of its tabs is open.
    pub fn container<P: Part>(
        &mut self,
        id: P,
        kind: ContainerKind,
        contents: &[P],
        shares: &[f32],
    ) -> Result<(), Error> {
        let container = ContainerBlueprint::new(kind).with_contents(
            contents
                .iter()
                .map(|child| IncludedContent(child.path().into())),
        );
        let shares = shares.iter().copied().map(Float32);
        let container = match kind {
            ContainerKind::Horizontal => container.with_col_shares(shares.map(ColumnShare)),
            ContainerKind::Vertical => container.with_row_shares(shares.map(RowShare)),
            _ => match contents.first() {
                Some(first) => container.with_active_tab(ActiveTab(first.path().into())),
                None => container,
            },
        };
        self.put(id.path(), &container)
    }

    /// What stands on the tab of a container.
    pub fn name(&mut self, id: impl Part, name: &str) -> Result<(), Error> {
        let name = ContainerBlueprint::update_fields().with_display_name(Name(name.into()));
        self.put(id.path(), &name)
    }

    /// The whole window, with the side panels folded.
    pub fn window(&mut self, root: impl Part) -> Result<(), Error> {
        self.put(
            "viewport",
            &ViewportBlueprint::new()
                .with_root_container(RootContainer(root.uuid().into()))
                .with_auto_layout(AutoLayout(Bool(false)))
                .with_auto_views(AutoViews(Bool(false))),
        )?;
        for panel in ["blueprint_panel", "selection_panel"] {
            self.put(
                panel,
                &PanelBlueprint::new().with_state(PanelState::Collapsed),
            )?;
        }
        Ok(())
    }
}

/// Writes the whole blueprint.
pub fn put<W: Write>(layout: &Layout, out: &mut RrdWriter<W>) -> Result<(), Error> {
    let mut w = Writer::new(out);
    views::map(&mut w, layout)?;
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
        views::plot(&mut w, layout, id, name, path, bound)?;
    }
    for (tabs, angle, chi2) in [
        (Id::Line, Id::ThetaC, Id::Chi2Line),
        (Id::Point, Id::ThetaI, Id::Chi2Point),
    ] {
        w.container(tabs, ContainerKind::Tabs, &[angle, chi2], &[])?;
    }
    views::labels(&mut w, layout)?;
    views::events(&mut w, layout)?;

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
    w.container(Id::Scene, ContainerKind::Tabs, &tabs, &[])?;
    w.container(
        Id::Left,
        ContainerKind::Vertical,
        &[Id::Scene, Id::Events],
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
