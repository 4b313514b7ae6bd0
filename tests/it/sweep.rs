//! `tmam sweep`: the best cell, with the truth and without it.

use std::path::Path;

use crate::support::{Bench, Run, rewrite, sample};
use serde_json::Value;

fn ok(run: &Run) -> &str {
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    &run.stdout
}

/// A drive through the room with 3 mm of range noise.
fn drive(bench: &Bench) {
    ok(&bench.tmam(
        Path::new(""),
        "simulate -o drive.mcap --drive --noise 0.003 --seed 5",
    ));
}

/// The values of the best cell, ranked without the truth.
fn best_without_truth(bench: &Bench, arguments: &str) -> Vec<f64> {
    let run = bench.tmam(
        &bench.path("drive.mcap"),
        &format!("sweep {{}} --no-truth --json {arguments}"),
    );
    let sweep: Value = serde_json::from_str(ok(&run)).unwrap();
    assert_eq!(sweep["truth"], false);
    let values = sweep["cells"][0]["values"].as_array().unwrap();
    values.iter().map(|value| value.as_f64().unwrap()).collect()
}

#[test]
fn a_mount_that_is_off_by_five_degrees_is_found_without_the_truth() {
    let bench = Bench::new();
    drive(&bench);
    // The log has 67.5; the configuration is wrong.
    bench.put("wrong.toml", "[sonar.sonar_03]\nyaw = 72.5\n");
    let best = best_without_truth(
        &bench,
        "--config wrong.toml --set sonar.sonar_03.yaw=57.5:77.5:2.5",
    );
    assert_eq!(best, [67.5]);
}

#[test]
fn the_lead_over_what_is_configured_is_told() {
    let bench = Bench::new();
    drive(&bench);
    bench.put("wrong.toml", "[sonar.sonar_03]\nyaw = 72.5\n");
    let log = bench.path("drive.mcap");
    let table = |flags: &str| ok(&bench.tmam(&log, &format!("sweep {{}} {flags}"))).to_owned();
    let sweep = "--no-truth --set sonar.sonar_03.yaw";
    let wrong = table(&format!("--config wrong.toml {sweep}=65:70:2.5"));
    assert!(
        wrong.contains("configured: sonar.sonar_03.yaw=72.5\n  the best cell is better by 0."),
        "{wrong}"
    );
    // The log's own mount is right.
    let right = table(&format!("{sweep}=65:70:2.5"));
    assert!(
        right.contains(
            "configured: sonar.sonar_03.yaw=67.5\n  the best cell is no better than that"
        ),
        "{right}"
    );
    let outside = table(&format!("{sweep}=75:80:2.5"));
    assert!(
        outside.contains("no cell is as good as that; the best one is worse by 0."),
        "{outside}"
    );
    // With the truth, the column that tells them apart is named.
    let truth = table("--rule paper --alpha 0.3,0.8");
    assert!(truth.contains("configured: triple.alpha=0.5\n"), "{truth}");
    assert!(truth.contains(" map errors ("), "{truth}");
}

#[test]
fn ties_are_told_and_so_is_what_changes_nothing() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let run = bench.tmam(&log, "sweep {} --alpha 0.3,0.5,0.7");
    assert!(ok(&run).contains("All cells are alike"), "{}", run.stdout);
    assert!(
        run.stderr
            .contains("no label depends on triple.alpha under the noise-aware rule"),
        "{}",
        run.stderr
    );
    let run = bench.tmam(&log, "sweep {} --alpha 0.3,0.5,0.7 --step 0.1,0.5");
    let table = ok(&run);
    assert!(table.contains("2 other cells do just as well"), "{table}");
    assert!(
        table.contains("triple.alpha makes no difference among them"),
        "{table}"
    );
    assert!(!table.contains("triple.alpha is best at an end"), "{table}");
}

#[test]
fn a_clock_that_is_late_is_found_without_the_truth() {
    let bench = Bench::new();
    drive(&bench);
    // Every range is stamped 0.2 s late.
    let late = rewrite(
        &bench.path("drive.mcap"),
        mcap::WriteOptions::new(),
        |mut message| {
            if message.topic.starts_with("/sonar") {
                let field = |at: usize| -> [u8; 4] { message.data[at..at + 4].try_into().unwrap() };
                let stamp = i64::from(i32::from_le_bytes(field(4))) * 1_000_000_000
                    + i64::from(u32::from_le_bytes(field(8)))
                    + 200_000_000;
                let seconds = i32::try_from(stamp / 1_000_000_000).unwrap();
                let nanoseconds = u32::try_from(stamp % 1_000_000_000).unwrap();
                message.data[4..8].copy_from_slice(&seconds.to_le_bytes());
                message.data[8..12].copy_from_slice(&nanoseconds.to_le_bytes());
            }
            vec![message]
        },
    );
    bench.put("drive.mcap", late);
    let best = best_without_truth(&bench, "--set input.range_delay=-0.1:0.4:0.05");
    assert_eq!(best, [0.2]);
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let arguments = "sweep {} --alpha 0.4:0.6:0.1 --gamma 8,10,40 --set frames.step=0.1";
    let mut told = Vec::new();
    for threads in [1, 3] {
        let run = bench.tmam(
            &log,
            &format!("{arguments} --threads {threads} --csv {threads}.csv -o {threads}.rrd"),
        );
        told.push(ok(&run).to_owned());
    }
    assert_eq!(told[0], told[1]);
    assert_eq!(bench.bytes("1.csv"), bench.bytes("3.csv"));
    assert_eq!(bench.bytes("1.rrd"), bench.bytes("3.rrd"));
    // A gate beyond the beam fails, and is told as such.
    assert!(
        told[0].contains("and 2 more: triple.gamma is 40"),
        "{}",
        told[0]
    );
    let csv = String::from_utf8(bench.bytes("1.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 10);
    assert!(lines[0].starts_with("rank,triple.alpha,triple.gamma [deg],frames.step,"));
    assert!(lines[9].contains("must be below the beam width"));
    assert!(!lines[6].contains("must be below the beam width"));
}

#[test]
fn a_cell_is_what_replay_makes_of_its_flags() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let run = bench.tmam(
        &log,
        "sweep {} --set sonar.sonar_02.yaw=40,50 --alpha 0.6 --json",
    );
    let sweep: Value = serde_json::from_str(ok(&run)).unwrap();
    // What is configured is a cell like the others, with the log's mount.
    assert_eq!(
        sweep["configured"]["values"],
        serde_json::json!([0.5, 45.0])
    );
    assert_ne!(sweep["configured"]["scores"], Value::Null);
    // Flags with a key of their own come first.
    for cell in sweep["cells"].as_array().unwrap() {
        let yaw = cell["values"][1].as_f64().unwrap();
        let flags = format!("replay {{}} --features f --set sonar.sonar_02.yaw={yaw} --alpha 0.6");
        ok(&bench.tmam(&log, &flags));
        let counts = &bench.json("f")["counts"];
        for name in ["contact", "intersection", "suspects", "frames"] {
            assert_eq!(cell["scores"][name], counts[name], "{name} at {yaw}");
        }
    }
    assert_ne!(
        sweep["cells"][0]["scores"]["contact"],
        sweep["cells"][1]["scores"]["contact"]
    );
}

#[test]
fn the_truth_in_the_log_ranks_and_a_column_can_be_asked_for() {
    let bench = Bench::new();
    drive(&bench);
    let log = bench.path("drive.mcap");
    let wrong = |run: &Run| -> Vec<f64> {
        let sweep: Value = serde_json::from_str(ok(run)).unwrap();
        assert_eq!(sweep["truth"], true);
        let cells = sweep["cells"].as_array().unwrap().clone();
        let share = |cell: &Value| cell["scores"]["wrong_share"].as_f64().unwrap();
        cells.iter().map(share).collect()
    };
    let flags = "sweep {} --rule paper --alpha 0.2:0.8:0.3 --sort wrong_share --json";
    let shares = wrong(&bench.tmam(&log, flags));
    assert_eq!(shares.len(), 3);
    assert!(shares.is_sorted() && shares[0] < shares[2], "{shares:?}");
    // As `evaluate` has it.
    let evaluated = bench.tmam(&log, "evaluate {} --rule paper --alpha 0.5 --json");
    let evaluation: Value = serde_json::from_str(ok(&evaluated)).unwrap();
    let share = evaluation["labels"]["wrong_share"].as_f64().unwrap();
    assert!(shares.contains(&share), "{shares:?} {share}");
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn what_cannot_be_swept_is_said_and_nothing_is_written() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    for (flags, said) in [
        ("", "nothing to sweep"),
        ("--alpha 0.1:0.5", "has no step"),
        ("--alpha 0.1:1.5:0.1", "must be above 0 and below 1"),
        ("--alpha 0.4 --set triple.alpha=0.5", "given twice"),
        ("--start 1 --set input.start=1,2", "given twice"),
        ("--set triple.gama=5:10:1", "did you mean `triple.gamma`"),
        ("--set sonar.sonar_99.yaw=1,2", "no sonar `sonar_99`"),
        ("--alpha 0.4 --sort best", "there is no such column"),
        (
            "--alpha 0.4 --sort wrong_share --no-truth",
            "there is no such column",
        ),
        (
            "--alpha 0.01:0.99:0.001 --gamma 1:20:0.1",
            "more than 100000",
        ),
        ("--gamma 40,50", "not one of 2 cells"),
        ("--alpha 0.4 --csv x -o x", "named twice"),
    ] {
        let run = bench.tmam(&log, &format!("sweep {{}} {flags} -o out.rrd"));
        let run = if flags.contains("-o x") {
            bench.tmam(&log, &format!("sweep {{}} {flags}"))
        } else {
            run
        };
        assert_eq!(run.code, 2, "{flags}: {}", run.stderr);
        assert!(run.stderr.contains(said), "{flags}: {}", run.stderr);
        assert!(run.stdout.is_empty(), "{flags}");
    }
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}

#[test]
fn a_damaged_log_is_swept_as_far_as_it_goes() {
    let bench = Bench::new();
    let whole = std::fs::read(sample("room_drive.mcap")).unwrap();
    let half = bench.put("half.mcap", &whole[..whole.len() / 2]);
    let run = bench.tmam(&half, "sweep {} --alpha 0.4,0.5");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(run.stdout.contains("INCOMPLETE"), "{}", run.stdout);
    assert!(
        run.stderr.contains("could not be read whole"),
        "{}",
        run.stderr
    );
}

#[test]
fn no_delay_changes_nothing_and_a_delay_moves_the_poses() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    for (name, delay) in [("none", "0"), ("late", "0.1")] {
        let flags = format!("replay {{}} --trace {name} --set input.range_delay={delay}");
        ok(&bench.tmam(&log, &flags));
    }
    ok(&bench.tmam(&log, "replay {} --trace plain"));
    assert_eq!(bench.bytes("plain"), bench.bytes("none"));
    assert_ne!(bench.bytes("plain"), bench.bytes("late"));
}
