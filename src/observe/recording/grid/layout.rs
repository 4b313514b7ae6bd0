//! How the pictures of a sweep are laid out.

use std::io::Write;

use rerun::blueprint::components::{ContainerKind, PanelState, VisualBounds2D as VisualBounds};
use rerun::datatypes::Range2D;
use rerun::external::re_sdk_types::blueprint::archetypes::{TimePanelBlueprint, VisualBounds2D};
use rerun::external::uuid::Uuid;

use super::super::Error;
use super::super::blueprint::{FIRST_UUID, Part, Writer};
use super::super::encode::RrdWriter;
use super::Group;
use super::drawing::{ABOVE, BELOW, HEIGHT, LEFT, RIGHT, WIDTH};
use crate::tools::sweep::Axis;
use crate::tools::sweep::columns::{Better, Column};

/// Views and containers.
#[derive(Debug, Clone, Copy)]
enum Id {
    Root,
    Groups,
    About,
    Group(usize),
    Picture(usize),
}

impl Part for Id {
    fn uuid(self) -> Uuid {
        let number = match self {
            Self::Root => 1,
            Self::Groups => 2,
            Self::About => 3,
            Self::Group(place) => 0x100 + place,
            Self::Picture(place) => 0x1000 + place,
        };
        Uuid::from_u128(FIRST_UUID | 1 << 32 | number as u128)
    }

    fn is_container(self) -> bool {
        !matches!(self, Self::About | Self::Picture(_))
    }
}

/// Where a picture is in the recording.
pub fn entity(picture: usize) -> String {
    format!("/pictures/{picture}")
}

/// What a key is called along a picture.
pub fn name(axis: &Axis) -> String {
    match axis.unit_name() {
        "" => axis.key(),
        unit => format!("{}, {unit}", axis.key()),
    }
}

/// What stands above a picture.
pub fn title(column: &Column, low: f64, high: f64) -> String {
    let decimals = column.decimals;
    let name = column.heading();
    let better = match column.better {
        Better::Low => "low is better",
        Better::High => "high is better",
    };
    let [low, high] = [low, high].map(|x| format!("{:.decimals$}", x * column.scale));
    if low == high {
        return format!("{name}: {low} everywhere");
    }
    format!("{name}: {low} to {high}, {better}")
}

/// Writes the blueprint.
pub fn put<W: Write>(groups: &[Group], out: &mut RrdWriter<W>) -> Result<(), Error> {
    let mut w = Writer::new(out);
    w.view(Id::About, "TextDocument", "Best cells", &["+ /about"])?;
    let mut next = 0;
    let mut tabs = Vec::new();
    for (place, group) in groups.iter().enumerate() {
        let mut views = Vec::new();
        for picture in &group.pictures {
            let id = Id::Picture(next);
            w.view(
                id,
                "2D",
                &picture.title,
                &[&format!("+ {}/**", entity(next))],
            )?;
            w.property(
                id,
                "VisualBounds2D",
                &VisualBounds2D::new(VisualBounds(Range2D {
                    x_range: [-f64::from(LEFT), f64::from(WIDTH + RIGHT)].into(),
                    y_range: [-f64::from(ABOVE), f64::from(HEIGHT + BELOW)].into(),
                })),
            )?;
            views.push(id);
            next += 1;
        }
        w.container(Id::Group(place), ContainerKind::Grid, &views, &[])?;
        w.name(Id::Group(place), &group.name)?;
        tabs.push(Id::Group(place));
    }
    w.container(Id::Groups, ContainerKind::Tabs, &tabs, &[])?;
    w.container(
        Id::Root,
        ContainerKind::Horizontal,
        &[Id::Groups, Id::About],
        &[1.6, 1.0],
    )?;
    w.window(Id::Root)?;
    w.put(
        "time_panel",
        &TimePanelBlueprint::new().with_state(PanelState::Hidden),
    )
}
