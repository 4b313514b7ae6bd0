//! Writes the parts of a blueprint: views, containers and their settings.

use rerun::AsComponents;
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

use crate::observe::recording::canvas::Canvas;
use crate::observe::viewer::Error;

/// The first of the ids; those of recordings of a replay follow, those of grids have the next bit set.
const FIRST_UUID: u128 = 0x746d_616d_0000_4000_8000_0000_0000_0000;

/// A container or view, with the same id in every recording.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    kind: &'static str,
    number: u128,
}

impl Part {
    pub const fn view(number: u128) -> Self {
        Self {
            kind: "view",
            number,
        }
    }

    pub const fn container(number: u128) -> Self {
        Self {
            kind: "container",
            number,
        }
    }

    pub fn uuid(self) -> Uuid {
        Uuid::from_u128(FIRST_UUID | self.number)
    }

    /// Where it stands in the blueprint.
    fn path(self) -> String {
        format!("{}/{}", self.kind, self.uuid())
    }
}

/// The parts of a blueprint.
impl Canvas<'_> {
    /// A view of the entities that `query` selects.
    pub fn view(&mut self, id: Part, class: &str, name: &str, query: &[&str]) -> Result<(), Error> {
        let path = id.path();
        self.part(
            format!("{path}/ViewContents"),
            &ViewContents::new(query.iter().map(|q| QueryExpression((*q).into()))),
        )?;
        self.part(
            path,
            &ViewBlueprint::new(ViewClass(class.into()))
                .with_display_name(Name(name.into()))
                .with_space_origin("/"),
        )
    }

    /// A setting of a view.
    pub fn property(&mut self, id: Part, name: &str, what: &dyn AsComponents) -> Result<(), Error> {
        self.part(format!("{}/{name}", id.path()), what)
    }

    /// A container; the first of its tabs is open.
    pub fn container(
        &mut self,
        id: Part,
        kind: ContainerKind,
        contents: &[Part],
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
        self.part(id.path(), &container)
    }

    /// What stands on the tab of a container.
    pub fn name(&mut self, id: Part, name: &str) -> Result<(), Error> {
        let name = ContainerBlueprint::update_fields().with_display_name(Name(name.into()));
        self.part(id.path(), &name)
    }

    /// The whole window, with the side panels folded.
    pub fn window(&mut self, root: Part) -> Result<(), Error> {
        self.part(
            "viewport",
            &ViewportBlueprint::new()
                .with_root_container(RootContainer(root.uuid().into()))
                .with_auto_layout(AutoLayout(Bool(false)))
                .with_auto_views(AutoViews(Bool(false))),
        )?;
        for panel in ["blueprint_panel", "selection_panel"] {
            self.part(
                panel,
                &PanelBlueprint::new().with_state(PanelState::Collapsed),
            )?;
        }
        Ok(())
    }
}
