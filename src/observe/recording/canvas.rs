//! What the parts of a recording draw on: rows of an entity, and what holds at all times.
//!
//! Rows are gathered into chunks; what waits is written by [`Canvas::flush`].

use std::collections::BTreeMap;

use rerun::components::TextLogLevel;
use rerun::datatypes::Quaternion;
use rerun::external::re_log_types::EntityPathPart;
use rerun::{
    AsComponents, Color, EntityPath, LineStrips2D, Points2D, Scalars, SerializationResult,
    SerializedComponentColumn, SeriesPoints, StateChange, TextLog, Timeline, Transform3D,
};

use super::encode::{RrdWriter, Store};
use super::entity::{Entity, Look, Names, Paint};
use super::evidence::{Known, batches};
use super::plane::PlaneOrigin;
use super::style;
use crate::core::event::{Sonar, SonarId, name_of};
use crate::core::geometry::{Pose2, unit};
use crate::core::rounding::rounded;
use crate::observe::viewer::Error;

/// Rows in a chunk: enough to make the cost of a chunk small, few enough to stay in memory.
const CHUNK_ROWS: usize = 512;
/// Instances in a chunk, for entities whose rows are long.
const CHUNK_INSTANCES: usize = 16_384;

/// When something was: the place of a row on the timelines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    pub frame: i64,
    pub stamp_ns: i64,
    /// Whether rows of later frames may have been written: then these rows are chunks of their own,
    /// so that those of the others stay in order.
    pub late: bool,
}

impl Moment {
    pub fn new(frame: u32, stamp_ns: i64) -> Self {
        Self {
            frame: frame.into(),
            stamp_ns,
            late: false,
        }
    }
}

/// What an entity shows at one moment.
#[derive(Debug)]
pub enum Shown {
    Strips(Vec<Strip>),
    Dots(Vec<Dot>),
    /// Rounded as in the trace, so that the two can be compared.
    Numbers(Vec<f64>),
    /// The same, each as a dot of a colour.
    Dotted(Vec<(f64, Color)>),
    /// A row without one ends the label before it: a gap in the lane. (A null would say the same, but
    /// `rerun rrd verify` takes it for damage.)
    Labels(Vec<String>),
    Poses(Vec<Pose2>),
    Messages(Vec<LogLine>),
    Evidence(Vec<Known>),
}

/// A line through some places.
pub type Strip = Mark<Vec<[f32; 2]>>;

pub type Dot = Mark<[f32; 2]>;

/// Something in the map; what of it is recorded depends on the entity's [`Look`].
#[derive(Debug, Default)]
pub struct Mark<P> {
    pub at: P,
    pub class: u16,
    pub color: Option<Color>,
    /// Told where it is pointed at or selected.
    pub name: String,
}

impl<P> Mark<P> {
    pub fn named(at: P, name: String) -> Self {
        Self {
            at,
            class: 0,
            color: None,
            name,
        }
    }
}

impl<P> From<P> for Mark<P> {
    fn from(at: P) -> Self {
        Self::named(at, String::new())
    }
}

/// A line of the event log.
#[derive(Debug)]
pub struct LogLine {
    pub text: String,
    pub level: &'static str,
    pub color: Color,
}

/// The timelines of a recording.
#[derive(Debug, Clone, Copy)]
pub struct Timelines {
    /// Frames, counted from 0.
    pub frame: Timeline,
    /// The log's own clock.
    pub stamp: Timeline,
    /// From the log's first reading on.
    pub seconds: Timeline,
}

/// Clocks that started before this are counted from the start of the run, not from 1970.
const FIRST_PLAUSIBLE_STAMP_NS: i64 = 1_000_000_000_000_000_000;

impl Timelines {
    /// The stamps read as dates where they can be dates, else as the time since zero.
    pub fn new(start_ns: i64) -> Self {
        Self {
            frame: Timeline::new_sequence("frame"),
            stamp: if start_ns >= FIRST_PLAUSIBLE_STAMP_NS {
                Timeline::new_timestamp("stamp")
            } else {
                Timeline::new_duration("stamp")
            },
            seconds: Timeline::new_duration("seconds"),
        }
    }
}

/// A recording to draw on.
pub struct Canvas<'a> {
    file: RrdWriter<'a>,
    pub lines: Timelines,
    // What seconds are counted from.
    origin_ns: i64,
    pub origin: PlaneOrigin,
    pub sonars: Vec<Sonar>,
    tables: BTreeMap<Entity, Table>,
}

/// Rows of one entity that wait to be written together.
#[derive(Default)]
struct Table {
    moments: Vec<Moment>,
    lengths: Vec<usize>,
    rows: Option<Shown>,
}

impl<'a> Canvas<'a> {
    /// `origin_ns` is the stamp of the log's first reading.
    pub fn new(file: RrdWriter<'a>, origin_ns: i64, origin: PlaneOrigin, sonars: &[Sonar]) -> Self {
        Self {
            file,
            lines: Timelines::new(origin_ns),
            origin_ns,
            origin,
            sonars: sonars.to_vec(),
            tables: BTreeMap::new(),
        }
    }

    pub fn sonar(&self, id: SonarId) -> &str {
        name_of(&self.sonars, id)
    }

    /// Adds a row; moments must not decrease, unless they are late.
    pub fn row(&mut self, entity: Entity, at: Moment, row: Shown) -> Result<(), Error> {
        if at.late {
            let mut table = Table::default();
            table.push(at, row);
            return self.write(entity, table);
        }
        if entity.is_page() && !self.tables.contains_key(&entity) {
            self.put_look(entity)?;
        }
        let table = self.tables.entry(entity).or_default();
        let instances = table.push(at, row);
        if table.moments.len() >= CHUNK_ROWS || instances >= CHUNK_INSTANCES {
            let full = std::mem::take(table);
            self.write(entity, full)?;
        }
        Ok(())
    }

    /// A message that is not about a run.
    pub fn note(&mut self, at: Moment, level: &'static str, text: String) -> Result<(), Error> {
        let color = match level {
            TextLogLevel::WARN => style::REJECTED,
            TextLogLevel::ERROR => style::NOW,
            _ => style::WALL,
        };
        let message = LogLine { text, level, color };
        self.row(Entity::Log, at, Shown::Messages(vec![message]))
    }

    /// Writes all rows that wait.
    pub fn flush(&mut self) -> Result<(), Error> {
        for (entity, table) in std::mem::take(&mut self.tables) {
            self.write(entity, table)?;
        }
        Ok(())
    }

    fn write(&mut self, entity: Entity, table: Table) -> Result<(), Error> {
        let Some(rows) = table.rows else {
            return Ok(());
        };
        let columns = columns(&*rows.archetype(entity.look())?, &table.lengths)?;
        let moments = || table.moments.iter();
        let seconds = |at: &Moment| at.stamp_ns.saturating_sub(self.origin_ns);
        let times = vec![
            (self.lines.frame, moments().map(|at| at.frame).collect()),
            (self.lines.stamp, moments().map(|at| at.stamp_ns).collect()),
            (self.lines.seconds, moments().map(seconds).collect()),
        ];
        let path = self.path(entity);
        let rows = table.moments.len();
        self.file
            .chunk(Store::Recording, &path, rows, times, columns)
    }

    fn path(&self, entity: Entity) -> EntityPath {
        let path = EntityPath::from(entity.path());
        match entity.of_sonar() {
            // One part, whatever slashes are in the name.
            Some(sonar) => path.join(&EntityPath::new(vec![EntityPathPart::new(
                self.sonar(sonar),
            )])),
            None => path,
        }
    }

    /// Writes something that holds at all times.
    pub fn put(
        &mut self,
        path: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result<(), Error> {
        let columns = columns(what, &[])?;
        self.file
            .chunk(Store::Recording, &path.into(), 1, Vec::new(), columns)
    }

    /// The same, at an entity that has rows as well.
    pub fn put_on(&mut self, entity: Entity, what: &dyn AsComponents) -> Result<(), Error> {
        self.put(self.path(entity), what)
    }

    /// Writes how an entity looks.
    pub fn put_look(&mut self, entity: Entity) -> Result<(), Error> {
        match entity.look() {
            Some(look) => self.put_on(entity, &*look.archetype()),
            None => Ok(()),
        }
    }

    /// Writes a part of the blueprint.
    pub fn part(
        &mut self,
        path: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result<(), Error> {
        let times = vec![(Timeline::new_sequence("blueprint"), vec![0])];
        let columns = columns(what, &[])?;
        self.file
            .chunk(Store::Blueprint, &path.into(), 1, times, columns)
    }

    /// Shows the viewer, where there is one, a blueprint to go by until the one at the end.
    pub fn preview(
        &mut self,
        blueprint: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        if !self.file.begin_preview() {
            return Ok(());
        }
        blueprint(self)?;
        self.file.end_preview()
    }

    /// Closes the file; with why the viewer was not shown everything.
    pub fn close(self) -> Result<Option<Error>, Error> {
        self.file.finish()
    }
}

impl Table {
    /// Adds a row, and says how many instances there are now.
    fn push(&mut self, at: Moment, row: Shown) -> usize {
        self.moments.push(at);
        self.lengths.push(row.len());
        match &mut self.rows {
            None => self.rows = Some(row),
            Some(rows) => rows.extend(row),
        }
        self.rows.as_ref().map_or(0, Shown::len)
    }
}

impl Shown {
    fn len(&self) -> usize {
        match self {
            Self::Strips(all) => all.len(),
            Self::Dots(all) => all.len(),
            Self::Numbers(all) => all.len(),
            Self::Dotted(all) => all.len(),
            Self::Labels(all) => all.len(),
            Self::Poses(all) => all.len(),
            Self::Messages(all) => all.len(),
            Self::Evidence(all) => all.len(),
        }
    }

    /// The rows of an entity are all of one kind.
    fn extend(&mut self, more: Self) {
        match (self, more) {
            (Self::Strips(all), Self::Strips(more)) => all.extend(more),
            (Self::Dots(all), Self::Dots(more)) => all.extend(more),
            (Self::Numbers(all), Self::Numbers(more)) => all.extend(more),
            (Self::Dotted(all), Self::Dotted(more)) => all.extend(more),
            (Self::Labels(all), Self::Labels(more)) => all.extend(more),
            (Self::Poses(all), Self::Poses(more)) => all.extend(more),
            (Self::Messages(all), Self::Messages(more)) => all.extend(more),
            (Self::Evidence(all), Self::Evidence(more)) => all.extend(more),
            _ => {}
        }
    }

    /// All instances, one after another, as the viewer takes them.
    fn archetype(self, look: Option<Look>) -> SerializationResult<Box<dyn AsComponents>> {
        let by_class = look.is_some_and(|look| look.paint == Paint::Class);
        let each = look.is_some_and(|look| look.paint == Paint::Each);
        let has_names = look.is_some_and(|look| look.names != Names::None);
        Ok(match self {
            Self::Strips(marks) => {
                let classes = marks.iter().map(|mark| mark.class).collect::<Vec<_>>();
                let colors = marks.iter().filter_map(|mark| mark.color);
                let colors = colors.collect::<Vec<_>>();
                let marks = marks.into_iter().map(|mark| (mark.at, mark.name));
                let (places, names): (Vec<_>, Vec<_>) = marks.unzip();
                let mut all = LineStrips2D::update_fields().with_strips(places);
                if by_class {
                    all = all.with_class_ids(classes);
                }
                if each {
                    all = all.with_colors(colors);
                }
                Box::new(if has_names {
                    all.with_labels(names)
                } else {
                    all
                })
            }
            Self::Dots(marks) => {
                let places = marks.iter().map(|mark| mark.at);
                let mut all = Points2D::update_fields().with_positions(places);
                if by_class {
                    all = all.with_class_ids(marks.iter().map(|mark| mark.class));
                }
                if each {
                    all = all.with_colors(marks.iter().filter_map(|mark| mark.color));
                }
                Box::new(if has_names {
                    all.with_labels(marks.into_iter().map(|mark| mark.name))
                } else {
                    all
                })
            }
            Self::Numbers(numbers) => {
                let numbers = numbers.into_iter().map(rounded);
                Box::new(Scalars::update_fields().with_scalars(numbers))
            }
            Self::Dotted(numbers) => {
                let (numbers, colors): (Vec<_>, Vec<_>) = numbers.into_iter().unzip();
                let numbers =
                    Scalars::update_fields().with_scalars(numbers.into_iter().map(rounded));
                let colors = SeriesPoints::update_fields().with_colors(colors);
                let all = [
                    numbers.as_serialized_batches(),
                    colors.as_serialized_batches(),
                ];
                Box::new(all.concat())
            }
            Self::Labels(labels) => Box::new(StateChange::update_fields().with_state(labels)),
            Self::Poses(poses) => {
                let places = poses.iter().map(|at| [at.x as f32, at.y as f32, 0.0]);
                let turns = poses.iter().map(|pose| {
                    let half = unit(pose.yaw / 2.0);
                    Quaternion::from_xyzw([0.0, 0.0, half.y as f32, half.x as f32])
                });
                let all = Transform3D::update_fields().with_many_translation(places);
                Box::new(all.with_many_quaternion(turns))
            }
            Self::Messages(messages) => {
                let levels = messages.iter().map(|message| message.level);
                let colors = messages.iter().map(|message| message.color);
                let texts = messages.iter().map(|message| message.text.as_str());
                let all = TextLog::update_fields().with_many_text(texts);
                Box::new(all.with_many_level(levels).with_many_color(colors))
            }
            Self::Evidence(arcs) => Box::new(batches(&arcs)),
        })
    }
}

/// Instances as columns, cut into rows of these lengths; into a single row without any.
fn columns(
    what: &dyn AsComponents,
    lengths: &[usize],
) -> SerializationResult<Vec<SerializedComponentColumn>> {
    let batches = what.as_serialized_batches().into_iter();
    let columns = batches.map(|batch| match lengths {
        [] => {
            let all = batch.array.len();
            batch.partitioned([all])
        }
        lengths => batch.partitioned(lengths.iter().copied()),
    });
    columns.collect()
}
