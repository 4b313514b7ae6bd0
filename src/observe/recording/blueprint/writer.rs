//! Writes the parts of a blueprint: views, containers and their settings.

use rerun::blueprint::components::{
    ActiveTab, AutoLayout, AutoViews, ColumnShare, ContainerKind, IncludedContent, PanelState,
    QueryExpression, RootContainer, RowShare, ViewClass,
};
use rerun::components::Name;
use rerun::datatypes::{Bool, Float32};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, PanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint,
};
use rerun::external::uuid::Uuid;
use rerun::{AsComponents, EntityPath};

use crate::observe::recording::canvas::Canvas;
use crate::observe::viewer::Error;

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

/// Writes the parts of the blueprint.
pub struct Writer<'a, 'b> {
    canvas: &'a mut Canvas<'b>,
}

impl<'a, 'b> Writer<'a, 'b> {
    /// A blueprint without parts.
    pub fn new(canvas: &'a mut Canvas<'b>) -> Self {
        Self { canvas }
    }

    /// Any part.
    pub fn put(
        &mut self,
        path: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result<(), Error> {
        self.canvas.part(path, what)
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
