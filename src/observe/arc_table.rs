//! A table of arcs in Parquet: a row per arc, for engines that ask questions of many logs.
//!
//! Columns are called, and numbers rounded, as in the trace. What holds for all rows is in the file's footer:
//! the format, the version, the log, the configuration, and digests of events and configuration.

use std::io::{self, Write};
use std::sync::Arc as Shared;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnPath, Type};
use sha2::{Digest as _, Sha256};

use super::trace::{TraceRow, row};
use crate::core::observer::Setting;
use crate::core::replay::{CauseTold, Outcome};
use crate::core::rounding::rounded;
use crate::core::statistics::seconds;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::report::ArcReport;

/// The format's name and version.
pub const SCHEMA: &str = "tmam.arcs/1";

/// Rows that are written, and held, together.
const GROUP: usize = 1 << 16;

/// What really echoed at an arc, where that is known: its kind, and which wall or point of the world it is.
pub type TruthOf<'t> = dyn Fn(&Arc) -> Option<(&'static str, Option<usize>)> + 't;

/// All that a row is made of.
struct TableRow<'a> {
    log: &'a str,
    /// From the log's first reading on.
    seconds: f64,
    trace: TraceRow<'a>,
    report: &'a ArcReport,
    /// How much longer the range is than what the map has there, metres.
    residual: Option<f64>,
    /// The keys that mend what is off with its sonar.
    cause: Option<&'a str>,
    truth: Option<(&'static str, Option<usize>)>,
}

/// The cells of a column, by what they hold.
#[derive(Clone, Copy)]
enum Cells {
    Whole(fn(&TableRow<'_>) -> Option<i64>),
    /// Null where it has no end.
    Number(fn(&TableRow<'_>) -> Option<f64>),
    Text(for<'r> fn(&'r TableRow<'_>) -> Option<&'r str>),
    Flag(fn(&TableRow<'_>) -> Option<bool>),
}

use Cells::{Flag, Number, Text, Whole};

/// What a column is called, and its cells.
type Column = (&'static str, Cells);

/// The log's name comes first.
const COLUMNS: [Column; 39] = [
    ("log", Text(|row| Some(row.log))),
    ("sensor", Text(|row| Some(row.trace.sensor))),
    ("frame", Whole(|row| Some(row.trace.frame.into()))),
    ("stamp_ns", Whole(|row| Some(row.trace.stamp_ns))),
    ("seconds", Number(|row| Some(row.seconds))),
    ("x", Number(|row| Some(row.trace.x))),
    ("y", Number(|row| Some(row.trace.y))),
    ("yaw", Number(|row| Some(row.trace.yaw))),
    (
        "odometry_x",
        Number(|row| row.trace.odometry.map(|[x, _, _]| x)),
    ),
    (
        "odometry_y",
        Number(|row| row.trace.odometry.map(|[_, y, _]| y)),
    ),
    (
        "odometry_yaw",
        Number(|row| row.trace.odometry.map(|[_, _, yaw]| yaw)),
    ),
    ("range", Number(|row| Some(row.trace.range))),
    ("label", Text(|row| Some(row.trace.label))),
    ("reason", Text(|row| row.trace.reason)),
    ("theta_c", Number(|row| row.trace.theta_c)),
    ("theta_i", Number(|row| row.trace.theta_i)),
    ("theta_c_sigma", Number(|row| row.trace.theta_c_sigma)),
    ("theta_i_sigma", Number(|row| row.trace.theta_i_sigma)),
    ("margin", Number(|row| row.trace.margin)),
    ("opinion", Text(|row| row.trace.opinion)),
    ("chi2_line", Number(|row| row.trace.chi2_line)),
    ("chi2_point", Number(|row| row.trace.chi2_point)),
    (
        "chi2_margin",
        Number(|row| row.report.chi2_margin().map(rounded)),
    ),
    ("readings", Whole(|row| whole(row.trace.readings))),
    ("wide_opinion", Text(|row| row.trace.wide_opinion)),
    ("wide_chi2_line", Number(|row| row.trace.wide_chi2_line)),
    ("wide_chi2_point", Number(|row| row.trace.wide_chi2_point)),
    (
        "lead",
        Number(|row| {
            Some(rounded(
                row.trace.wide_chi2_point? - row.trace.wide_chi2_line?,
            ))
        }),
    ),
    ("incidence", Number(|row| row.trace.incidence)),
    ("map_opinion", Text(|row| row.trace.map_opinion)),
    (
        "map_feature",
        Whole(|row| row.report.map?.feature.map(i64::from)),
    ),
    ("map_residual", Number(|row| row.residual)),
    ("doubt", Number(|row| Some(rounded(row.report.doubt())))),
    ("suspect", Flag(|row| Some(row.trace.suspect))),
    ("feature", Whole(|row| row.trace.feature.map(i64::from))),
    ("cause", Text(|row| row.cause)),
    ("truth", Text(|row| row.truth.map(|(kind, _)| kind))),
    ("truth_feature", Whole(|row| whole(row.truth?.1))),
    (
        "beam_width",
        Number(|row| Some(rounded(row.report.arc.beam_width))),
    ),
];

/// What the log is called among others, and whether the folder that the table lies in says so: a column of that name
/// in the table itself would then be in the way of engines that read folders.
#[derive(Debug, Clone, Copy)]
pub struct TableName<'a> {
    pub drive: &'a str,
    pub is_partition: bool,
}

/// Writes a row per arc, in the order of frames and sonars.
///
/// # Errors
/// When `out` cannot be written.
pub fn write(
    out: impl Write + Send,
    name: TableName<'_>,
    setting: &Setting<'_>,
    outcome: &Outcome,
    truth: &TruthOf<'_>,
) -> io::Result<()> {
    let causes = causes(setting, outcome);
    let table = ArcTable {
        drive: name.drive,
        setting,
        outcome,
        causes: &causes,
        truth,
    };
    let properties = properties(name.drive, setting)?;
    let columns = || COLUMNS.iter().skip(usize::from(name.is_partition));
    let mut writer = SerializedFileWriter::new(out, schema(columns())?, properties.into())?;
    for reports in outcome.reports.chunks(GROUP) {
        let rows: Vec<TableRow<'_>> = reports.iter().map(|report| table.row(report)).collect();
        let mut group = writer.next_row_group()?;
        for (_, cells) in columns() {
            write_column(&mut group, *cells, &rows)?;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}

/// What rows are made from.
struct ArcTable<'a> {
    drive: &'a str,
    setting: &'a Setting<'a>,
    outcome: &'a Outcome,
    /// By sonar.
    causes: &'a [Option<String>],
    truth: &'a TruthOf<'a>,
}

impl<'a> ArcTable<'a> {
    fn row(&self, report: &'a ArcReport) -> TableRow<'a> {
        let (arc, setting) = (&report.arc, self.setting);
        let joint = self.outcome.joint();
        let odometry = joint.and_then(|joint| joint.odom_from_sensor.get(&arc.id));
        let prediction = self.outcome.prediction.as_ref();
        let residual = prediction.and_then(|prediction| prediction.residual(arc));
        let cause = self.causes.get(arc.id.sonar.index());
        TableRow {
            log: self.drive,
            seconds: rounded(seconds(setting.origin_ns, arc.stamp_ns)),
            trace: row(report, setting.sonars, odometry),
            report,
            residual: residual.map(|residual| rounded(residual.residual)),
            cause: cause.and_then(Option::as_deref),
            truth: (self.truth)(arc),
        }
    }
}

/// The weightiest cause of each sonar: one of its own, or of all.
fn causes(setting: &Setting<'_>, outcome: &Outcome) -> Vec<Option<String>> {
    let causes = outcome.causes.as_deref().unwrap_or_default();
    let sonars = setting.sonars.iter().enumerate();
    let of_sonar = |sonar: usize| {
        let is_of = |cause: &&CauseTold| cause.sonar.is_none_or(|one| one.index() == sonar);
        causes.iter().find(is_of)
    };
    let keys = sonars.map(|(sonar, _)| Some(of_sonar(sonar)?.settings.join(", ")));
    keys.collect()
}

fn whole(number: Option<usize>) -> Option<i64> {
    i64::try_from(number?).ok()
}

/// Every column may be null, so that all are written in one way.
fn schema<'c>(columns: impl Iterator<Item = &'c Column>) -> Result<Shared<Type>, ParquetError> {
    let columns = columns.map(|(name, cells)| {
        let (physical, logical) = match cells {
            Whole(_) => (Physical::INT64, None),
            Number(_) => (Physical::DOUBLE, None),
            Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Flag(_) => (Physical::BOOLEAN, None),
        };
        let column = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical);
        Ok(Shared::new(column.build()?))
    });
    let columns = columns.collect::<Result<Vec<_>, ParquetError>>()?;
    let arcs = Type::group_type_builder("arcs").with_fields(columns);
    Ok(Shared::new(arcs.build()?))
}

fn properties(drive: &str, setting: &Setting<'_>) -> io::Result<WriterProperties> {
    let config = serde_json::to_string(setting.config)?;
    let version = env!("CARGO_PKG_VERSION");
    let footer = [
        ("schema", SCHEMA.to_owned()),
        ("version", version.to_owned()),
        ("log", drive.to_owned()),
        ("file", setting.source.file.clone()),
        ("complete", setting.source.complete.to_string()),
        ("events_sha256", setting.events_sha256.to_owned()),
        ("config_sha256", format!("{:x}", Sha256::digest(&config))),
        ("config", config),
    ];
    let footer = footer.map(|(key, value)| KeyValue::new(format!("tmam.{key}"), value));
    let mut properties = WriterProperties::builder()
        .set_created_by(format!("tmam version {version}"))
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_key_value_metadata(Some(footer.to_vec()));
    for (name, cells) in COLUMNS {
        // Hardly a number comes twice, but their first bytes are alike.
        if matches!(cells, Number(_)) {
            let column = ColumnPath::from(name);
            properties = properties
                .set_column_dictionary_enabled(column.clone(), false)
                .set_column_encoding(column, Encoding::BYTE_STREAM_SPLIT);
        }
    }
    Ok(properties.build())
}

fn write_column<W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: Cells,
    rows: &[TableRow<'_>],
) -> Result<(), ParquetError> {
    let rows = rows.iter();
    match cells {
        Whole(of) => write_cells::<Int64Type, W>(group, rows.map(of)),
        Number(of) => {
            let finite = rows.map(|row| of(row).filter(|number| number.is_finite()));
            write_cells::<DoubleType, W>(group, finite)
        }
        Text(of) => {
            write_cells::<ByteArrayType, W>(group, rows.map(|row| of(row).map(ByteArray::from)))
        }
        Flag(of) => write_cells::<BoolType, W>(group, rows.map(of)),
    }
}

fn write_cells<T: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: impl Iterator<Item = Option<T::T>>,
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General(
            "the schema lacks a column".to_owned(),
        ));
    };
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    for cell in cells {
        levels.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    column
        .typed::<T>()
        .write_batch(&values, Some(&levels), None)?;
    column.close()
}
