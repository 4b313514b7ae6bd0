//! The table of arcs, read back: what the trace says, a row an arc.

use std::fs::File;

use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;
use serde_json::Value;

use crate::support::Bench;

/// A row by column.
type Row = serde_json::Map<String, Value>;

struct Table {
    rows: Vec<Row>,
    /// What the footer says.
    footer: Row,
}

fn table(bench: &Bench, name: &str) -> Table {
    let file = File::open(bench.path(name)).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let footer = reader.metadata().file_metadata().key_value_metadata();
    let footer = footer.unwrap().iter().map(|pair| {
        let value = pair.value.clone().unwrap();
        (pair.key.clone(), value.into())
    });
    let rows = reader.get_row_iter(None).unwrap().map(|row| {
        let row = row.unwrap();
        let cells = row.get_column_iter();
        cells
            .map(|(name, field)| (name.clone(), value(field)))
            .collect()
    });
    Table {
        footer: footer.collect(),
        rows: rows.collect(),
    }
}

fn value(field: &Field) -> Value {
    match field {
        Field::Null => Value::Null,
        Field::Bool(flag) => (*flag).into(),
        Field::Long(number) => (*number).into(),
        Field::Double(number) => (*number).into(),
        Field::Str(text) => text.clone().into(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_table_says_what_the_trace_says_and_what_was_true() {
    let bench = Bench::new();
    // With odometry that drifts, so that poses are corrected, and a mount that is off.
    let made = bench.sh(
        "tmam simulate --drive --noise 0.003 --needs sonar.sonar_04.yaw=95 --outliers 0.02 -o drive.mcap",
    );
    assert_eq!(made.code, 0, "{}", made.stderr);
    let run = bench
        .sh("tmam replay drive.mcap --end 40 --trace t.jsonl --arcs a.parquet --features f.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let (table, trace) = (table(&bench, "a.parquet"), bench.json_lines("t.jsonl"));
    assert_eq!(table.rows.len(), trace.len());
    for (row, line) in table.rows.iter().zip(&trace) {
        for (name, told) in line.as_object().unwrap() {
            match name.as_str() {
                "odometry" => {
                    let names = ["odometry_x", "odometry_y", "odometry_yaw"];
                    let cells: Vec<Value> = names.iter().map(|name| row[*name].clone()).collect();
                    assert_eq!(*told, Value::Array(cells));
                }
                "contact_points" | "intersection_points" => {}
                name => assert_eq!(row[name], *told, "{name} of {line}"),
            }
        }
        assert_eq!(row["log"], "drive");
    }
    let of = |name: &str, value: &str| {
        let rows = table.rows.iter();
        rows.filter(|row| row[name] == value).count()
    };
    assert!(of("truth", "line") > 100 && of("truth", "outlier") > 5);
    assert_eq!(table.footer["tmam.schema"], "tmam.arcs/1");
    let config: Value =
        serde_json::from_str(table.footer["tmam.config"].as_str().unwrap()).unwrap();
    let features = bench.json("f.json");
    assert_eq!(config, features["config"]);
    for digest in ["tmam.events_sha256", "tmam.config_sha256"] {
        assert_eq!(table.footer[digest].as_str().unwrap().len(), 64);
    }
    // What is off with one sonar is told in its rows alone.
    let causes: Vec<&Row> = table
        .rows
        .iter()
        .filter(|row| !row["cause"].is_null())
        .collect();
    if let Some(first) = features["causes"].get(0) {
        let settings = first["settings"][0].as_str().unwrap();
        assert!(
            causes.iter().any(|row| row["cause"] == settings),
            "{settings}"
        );
        assert!(causes.iter().all(|row| row["sensor"] == "sonar_04"));
    }
}

#[test]
fn tables_of_several_logs_lie_in_partitions() {
    let bench = Bench::new();
    for (name, options) in [("monday 1", "--steps 20"), ("tuesday", "--steps 30")] {
        let made = bench.sh(&format!(
            "tmam simulate --sonars 8 {options} -o '{name}.mcap'"
        ));
        assert_eq!(made.code, 0, "{}", made.stderr);
    }
    for folder in ["arcs", "again"] {
        let run = bench.sh(&format!(
            "tmam replay *.mcap --arcs {folder} --no-causes -q"
        ));
        assert_eq!((run.code, run.stdout.as_str()), (0, ""), "{}", run.stderr);
    }
    let paths = ["log=monday%201/arcs.parquet", "log=tuesday/arcs.parquet"];
    for (path, log) in paths.into_iter().zip(["monday 1", "tuesday"]) {
        let table = table(&bench, &format!("arcs/{path}"));
        assert!(table.rows.len() > 50 && table.footer["tmam.log"] == log);
        // The folder says it.
        assert!(table.rows.iter().all(|row| !row.contains_key("log")));
        assert!(bench.bytes(&format!("arcs/{path}")) == bench.bytes(&format!("again/{path}")));
    }
}
