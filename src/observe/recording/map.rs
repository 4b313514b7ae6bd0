//! The map as it grows: walls, points and how sure they are.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::Write;

use rerun::{
    AsComponents, Color, LineStrips2D, Points2D, SerializationResult, SerializedComponentColumn,
};

use super::Error;
use super::covariance::{band, ellipse};
use super::encode::RrdWriter;
use super::origin::Origin;
use super::shapes::{Dot, Strip};
use super::style::{self, order, ui};
use super::table::{Instance, Moment, Table, Timelines, put_static};
use crate::core::tmam::feature::{Kind, MapFeature, Shape, Status};
use crate::core::tmam::step::Step;
use crate::core::wording::counted;

struct Outline(Vec<[f32; 2]>);

impl Instance for Outline {
    fn columns(
        outlines: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(LineStrips2D::update_fields()
            .with_strips(outlines.into_iter().map(|outline| outline.0))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

/// The map so far and its rows.
///
/// A change rewrites the [`PAGE`] features around the changed one, not the whole map: else the
/// bytes of a long run would grow with the square of its length.
pub struct MapTables {
    features: BTreeMap<u32, MapFeature>,
    lines: Pages<Strip>,
    points: Pages<Dot>,
    covariance: Pages<Outline>,
}

/// Features per page: ids `PAGE * n` and up are at `/world/map/<what>/<n>`.
const PAGE: u32 = 16;

struct Pages<T> {
    path: &'static str,
    tables: BTreeMap<u32, Table<T>>,
}

impl<T: Instance> Pages<T> {
    fn new(path: &'static str) -> Self {
        Self {
            path,
            tables: BTreeMap::new(),
        }
    }

    fn push<W: Write>(
        &mut self,
        page: u32,
        at: Moment,
        row: Vec<T>,
        look: &dyn AsComponents,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let table = match self.tables.entry(page) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let path = format!("{}/{page}", self.path);
                put_static(path.as_str(), look, out)?;
                entry.insert(Table::new(path.as_str()))
            }
        };
        table.push(at, row, lines, out)
    }

    fn flush<W: Write>(&mut self, lines: Timelines, out: &mut RrdWriter<W>) -> Result<(), Error> {
        for table in self.tables.values_mut() {
            table.flush(lines, out)?;
        }
        Ok(())
    }
}

impl MapTables {
    /// An empty map.
    pub fn new() -> Self {
        Self {
            features: BTreeMap::new(),
            lines: Pages::new("/world/map/lines"),
            points: Pages::new("/world/map/points"),
            covariance: Pages::new("/world/map/covariance"),
        }
    }

    /// Takes in what a step changed in the map, and logs the map after it.
    pub fn update<W: Write>(
        &mut self,
        at: Moment,
        step: &Step,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let origin = out.origin();
        let mut touched = BTreeMap::<u32, [bool; 2]>::new();
        let mut touch = |feature: &MapFeature| {
            let [walls, corners] = touched.entry(feature.id / PAGE).or_default();
            match feature.shape.kind() {
                Kind::Line => *walls = true,
                Kind::Point => *corners = true,
            }
        };
        for extraction in &step.extractions {
            for id in &extraction.absorbed {
                if let Some(gone) = self.features.remove(id) {
                    touch(&gone);
                }
            }
            if let Some(feature) = extraction.map_feature {
                touch(&feature);
                self.features.insert(feature.id, feature);
            }
        }
        for feature in &step.settled {
            touch(feature);
            self.features.insert(feature.id, *feature);
        }
        for (page, [walls, corners]) in touched {
            if walls {
                let row = self.page(page).filter_map(|f| wall(f, origin)).collect();
                self.lines.push(page, at, row, &wall_look(), lines, out)?;
            }
            if corners {
                let row = self.page(page).filter_map(|f| corner(f, origin)).collect();
                self.points
                    .push(page, at, row, &corner_look(), lines, out)?;
            }
            let row = self.page(page).map(|f| outline(f, origin)).collect();
            self.covariance
                .push(page, at, row, &outline_look(), lines, out)?;
        }
        Ok(())
    }

    fn page(&self, page: u32) -> impl Iterator<Item = &MapFeature> {
        let first = page * PAGE;
        self.features
            .range(first..=first.saturating_add(PAGE - 1))
            .map(|(_, feature)| feature)
    }

    /// How many confirmed lines, confirmed points and tentative features the map has.
    pub fn counts(&self) -> [usize; 3] {
        let count = |wanted: &dyn Fn(&MapFeature) -> bool| {
            self.features.values().filter(|f| wanted(f)).count()
        };
        let confirmed = |f: &MapFeature| f.status == Status::Confirmed;
        [
            count(&|f| confirmed(f) && f.shape.kind() == Kind::Line),
            count(&|f| confirmed(f) && f.shape.kind() == Kind::Point),
            count(&|f| !confirmed(f)),
        ]
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.lines.flush(lines, out)?;
        self.points.flush(lines, out)?;
        self.covariance.flush(lines, out)
    }
}

fn wall(feature: &MapFeature, origin: Origin) -> Option<Strip> {
    match &feature.shape {
        Shape::Line(segment) => Some(Strip {
            points: segment.ends().map(|end| origin.xy(end)).to_vec(),
            color: Some(color(feature, style::WALL)),
            label: label(feature),
        }),
        Shape::Point(_) => None,
    }
}

fn corner(feature: &MapFeature, origin: Origin) -> Option<Dot> {
    match &feature.shape {
        Shape::Point(point) => Some(Dot {
            position: origin.xy(point.position),
            color: Some(color(feature, style::CORNER)),
            label: label(feature),
        }),
        Shape::Line(_) => None,
    }
}

fn color(feature: &MapFeature, confirmed: Color) -> Color {
    match feature.status {
        Status::Confirmed => confirmed,
        Status::Tentative => style::TENTATIVE,
    }
}

fn label(feature: &MapFeature) -> String {
    format!(
        "{} {}, {} ({}, {})",
        feature.shape.kind().name(),
        feature.id,
        feature.status.name(),
        counted(feature.readings.into(), "reading"),
        counted(feature.runs.into(), "run")
    )
}

fn outline(feature: &MapFeature, origin: Origin) -> Outline {
    let around = match &feature.shape {
        Shape::Line(segment) => band(segment),
        Shape::Point(point) => ellipse(point),
    };
    Outline(around.into_iter().map(|p| origin.xy(p)).collect())
}

fn wall_look() -> LineStrips2D {
    LineStrips2D::update_fields()
        .with_radii([ui(2.5)])
        .with_show_labels(false)
        .with_draw_order(order::WALL)
}

fn corner_look() -> Points2D {
    Points2D::update_fields()
        .with_radii([ui(4.5)])
        .with_show_labels(false)
        .with_draw_order(order::CORNER)
}

fn outline_look() -> LineStrips2D {
    LineStrips2D::update_fields()
        .with_radii([ui(0.5)])
        .with_colors([style::COVARIANCE])
        .with_draw_order(order::COVARIANCE)
}
