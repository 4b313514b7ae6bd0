//! Several logs in one run: one table, one folder of outputs, and none that stops another.

use std::fs;

use crate::support::{Bench, sample};

/// A folder `drives` with small logs: one whole, one in two parts, one packed, one cut off, one that is none.
fn drives() -> Bench {
    let bench = Bench::new();
    fs::create_dir_all(bench.path("drives/split")).unwrap();
    fs::create_dir_all(bench.path("other")).unwrap();
    for (name, options) in [
        ("short", "--steps 20"),
        ("long", "--steps 40 --noise 0.003"),
    ] {
        let made = bench.sh(&format!(
            "tmam simulate --sonars 8 {options} -o drives/{name}.mcap"
        ));
        assert_eq!(made.code, 0, "{}", made.stderr);
    }
    let whole = bench.bytes("drives/long.mcap");
    fs::copy(
        bench.path("drives/short.mcap"),
        bench.path("drives/split/split_0.mcap"),
    )
    .unwrap();
    bench.put("drives/split/metadata.yaml", "");
    bench.put("drives/cut.mcap", &whole[..whole.len() / 2]);
    bench.put("drives/none.mcap", "no log");
    fs::copy(sample("room_step.mcap"), bench.path("other/short.mcap")).unwrap();
    bench
}

#[test]
fn one_table_has_the_worst_log_first_and_none_stops_another() {
    let bench = drives();
    let run = bench.sh("tmam replay drives --features out --no-causes");
    assert_eq!(run.code, 2, "{}{}", run.stdout, run.stderr);
    let rows: Vec<&str> = run.stdout.lines().skip(2).collect();
    let names: Vec<&str> = rows
        .iter()
        .filter_map(|row| row.split_whitespace().next())
        .collect();
    assert_eq!(names.first(), Some(&"none"), "{}", run.stdout);
    assert_eq!(names.get(1), Some(&"cut"), "{}", run.stdout);
    assert!(
        names.contains(&"split") && names.len() >= 5,
        "{}",
        run.stdout
    );
    assert!(run.stderr.contains("none: error: "), "{}", run.stderr);
    assert!(run.stderr.contains("cut: warning: "), "{}", run.stderr);
    let expected = ["cut", "long", "short", "split"].map(|name| format!("{name}.features.json"));
    let mut written: Vec<String> = fs::read_dir(bench.path("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    written.sort();
    assert_eq!(written, expected);
}

#[test]
fn outputs_are_those_of_each_log_alone_for_any_number_of_jobs() {
    let bench = drives();
    let logs = "drives/long.mcap drives/short.mcap other/short.mcap 'drives/spl*'";
    for jobs in [1, 3] {
        let run = bench.sh(&format!(
            "tmam replay {logs} --jobs {jobs} --features f{jobs} --trace t{jobs} --no-causes"
        ));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    let alone = "tmam replay other/short.mcap --features a.json --trace a.jsonl --no-causes";
    assert_eq!(bench.sh(alone).code, 0);
    for name in ["long", "drives_short", "other_short", "split"] {
        for (folder, ending) in [('f', "features.json"), ('t', "trace.jsonl")] {
            let [one, three] =
                [1, 3].map(|jobs| bench.bytes(&format!("{folder}{jobs}/{name}.{ending}")));
            assert!(one == three, "{name}.{ending}");
        }
    }
    assert!(bench.bytes("a.json") == bench.bytes("f1/other_short.features.json"));
    assert!(bench.bytes("a.jsonl") == bench.bytes("t1/other_short.trace.jsonl"));
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn a_folder_takes_recordings_and_features() {
    let bench = drives();
    let run = bench.sh("tmam replay drives/short.mcap -o out/");
    assert_eq!(run.code, 0, "{}", run.stderr);
    for file in ["out/short.rrd", "out/short.features.json"] {
        assert!(!bench.bytes(file).is_empty());
    }
}

#[test]
fn what_only_one_log_can_have_is_refused_before_any_is_read() {
    let bench = drives();
    for (arguments, said) in [
        ("", "-o FOLDER"),
        ("--features -", "for one log, and 2 are given"),
        ("--path p.tum", "--path is for one log"),
    ] {
        let run = bench.sh(&format!(
            "tmam replay drives/long.mcap drives/short.mcap {arguments}"
        ));
        assert_eq!(run.code, 2);
        assert!(run.stderr.contains(said), "{}", run.stderr);
    }
    let none = bench.sh("tmam replay 'nowhere/*.mcap' -o out");
    assert_eq!(none.code, 2);
    assert!(none.stderr.contains("fits no file"), "{}", none.stderr);
}

#[test]
fn several_logs_are_told_and_held_against_the_truth_in_tables() {
    let bench = drives();
    let logs = "drives/long.mcap drives/none.mcap drives/short.mcap";
    for (command, column) in [("info --no-causes", "weightiest"), ("evaluate", "missed")] {
        let run = bench.sh(&format!("tmam {command} {logs}"));
        assert_eq!(run.code, 2, "{command}: {}", run.stderr);
        assert!(run.stdout.contains(column), "{}", run.stdout);
        let rows: Vec<&str> = run
            .stdout
            .lines()
            .filter(|row| row.contains("done"))
            .collect();
        assert_eq!(rows.len(), 2, "{}", run.stdout);
    }
    let run = bench.sh("tmam info --no-causes --json drives/long.mcap drives/short.mcap");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let documents =
        serde_json::Deserializer::from_str(&run.stdout).into_iter::<serde_json::Value>();
    let files = documents.map(|document| document.unwrap()["source"]["file"].clone());
    assert_eq!(files.count(), 2);
    assert_eq!(bench.sh(&format!("tmam info --skeleton {logs}")).code, 2);
}

#[test]
fn the_only_log_of_a_folder_goes_into_a_folder_like_those_of_several() {
    let bench = drives();
    for (named, out) in [
        ("'other/*.mcap'", "a"),
        ("other", "b"),
        ("drives/short.mcap", "c/"),
    ] {
        let arcs = match cfg!(feature = "parquet") {
            true => format!("--arcs {out}"),
            false => String::new(),
        };
        let run = bench.sh(&format!(
            "tmam replay {named} --features {out} {arcs} --no-causes"
        ));
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        let folder = bench.path(out);
        assert!(folder.join("short.features.json").is_file(), "{named}");
        assert!(
            arcs.is_empty() || folder.join("log=short/arcs.parquet").is_file(),
            "{named}"
        );
    }
}

#[test]
fn a_late_stretch_is_told_by_info_and_in_the_table() {
    let bench = Bench::new();
    fs::copy(sample("room_trouble.mcap"), bench.path("trouble.mcap")).unwrap();
    fs::copy(sample("room_drive.mcap"), bench.path("drive.mcap")).unwrap();
    let info = bench.sh("tmam info trouble.mcap");
    assert!(
        info.stdout.contains("arcs from 44.3 to 51.6 s"),
        "{}",
        info.stdout
    );
    let both = bench.sh("tmam replay drive.mcap trouble.mcap --features out");
    assert!(both.stdout.contains("44.3 to 51.6 s"), "{}", both.stdout);
    assert!(both.stdout.contains("none found"), "{}", both.stdout);
    let rival = bench.sh("tmam replay drive.mcap trouble.mcap --features tbf --method tbf");
    assert_eq!(rival.code, 0, "{}", rival.stderr);
    assert!(!rival.stdout.contains("none found"), "{}", rival.stdout);
}

#[test]
fn outputs_of_several_logs_go_into_folders_that_are_not_called_like_files() {
    let bench = drives();
    for command in [
        "replay drives/long.mcap drives/short.mcap --features all.json",
        "evaluate drives/long.mcap drives/short.mcap -o all.rrd",
    ] {
        let run = bench.sh(&format!("tmam {command}"));
        assert_eq!(run.code, 2, "{command}: {}", run.stderr);
        assert!(run.stderr.contains("such as all/"), "{}", run.stderr);
    }
    assert!(!bench.files().contains("all.json") && !bench.files().contains("all.rrd"));
}

#[test]
fn each_log_is_told_on_a_line_for_machines() {
    let bench = drives();
    let logs = "drives/long.mcap drives/none.mcap";
    let lines = |command: &str| -> Vec<serde_json::Value> {
        let run = bench.sh(&format!("tmam {command} --json"));
        let lines = run.stdout.lines();
        lines
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    };
    let replayed = lines(&format!("replay {logs} --features out"));
    assert_eq!(replayed[0]["log"], "none");
    assert_eq!(replayed[0]["exit_code"], 2);
    assert!(
        replayed[0]["error"]
            .as_str()
            .unwrap()
            .contains("not an MCAP file")
    );
    assert_eq!(replayed[1]["schema"], "tmam.replayed/1");
    assert!(replayed[1]["causes"].is_array());
    let alone = lines("replay drives/long.mcap --features one.json");
    assert_eq!(alone, replayed[1..]);
    let evaluated = lines(&format!("evaluate {logs}"));
    assert_eq!(evaluated[1]["truth"]["spurious"], 0);
    let run = bench.sh("tmam replay drives/long.mcap --features - --json");
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("standard output is named twice"),
        "{}",
        run.stderr
    );
}

#[test]
#[cfg_attr(not(feature = "parquet"), ignore = "needs tables of arcs")]
fn a_table_asked_for_in_its_partition_is_the_one_of_a_fleet() {
    let bench = drives();
    let both = bench.sh("tmam replay other/short.mcap drives/short.mcap --arcs arcs --no-causes");
    assert_eq!(both.code, 0, "{}", both.stderr);
    fs::create_dir_all(bench.path("alone/log=other_short")).unwrap();
    let table = "log=other_short/arcs.parquet";
    let one = bench.sh(&format!(
        "tmam replay other/short.mcap --arcs alone/{table} --no-causes"
    ));
    assert_eq!(one.code, 0, "{}", one.stderr);
    assert!(bench.bytes(&format!("arcs/{table}")) == bench.bytes(&format!("alone/{table}")));
}
