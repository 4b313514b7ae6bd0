//! Logs that are called otherwise than when they were blessed, and folders of logs.

use std::fs;

use super::{bench_with, golden, tmam};
use crate::support::sample;

#[test]
fn the_golden_file_of_a_log_that_was_renamed_is_found_and_said() {
    let bench = bench_with("room_drive", |file| {
        file["tolerances"]["rho"] = 0.02.into();
    });
    fs::copy(
        golden().join("room_step.golden.json"),
        bench.path("golden/a_room.golden.json"),
    )
    .unwrap();
    fs::copy(sample("room_drive.mcap"), bench.path("monday.mcap")).unwrap();
    let check = ["check", "monday.mcap", "--golden", "golden"];
    let run = tmam(&bench, &check, &[]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    for said in [
        "golden/room_drive.golden.json was made from this drive",
        "when the log was called room_drive.mcap; name it golden/monday.golden.json",
        "no log was given for golden/a_room.golden.json\n",
    ] {
        assert!(run.stdout.contains(said), "{said}: {}", run.stdout);
    }

    // A blessing goes on with its terms under the new name.
    let run = tmam(&bench, &[&check[..], &["--bless"]].concat(), &[]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let said = "golden/room_drive.golden.json, which was made from the same drive: remove that";
    assert!(run.stdout.contains(said), "{}", run.stdout);
    let file = bench.json("golden/monday.golden.json");
    assert_eq!(
        (&file["tolerances"]["rho"], &file["log"]["file"]),
        (&0.02.into(), &"monday.mcap".into())
    );

    // Another drive is another drive.
    fs::remove_file(bench.path("golden/monday.golden.json")).unwrap();
    fs::copy(sample("room_step.mcap"), bench.path("monday.mcap")).unwrap();
    fs::remove_file(bench.path("golden/a_room.golden.json")).unwrap();
    assert_eq!(tmam(&bench, &check, &[]).code, 3);
}

#[test]
fn each_log_of_a_folder_is_a_drive_of_its_own() {
    let bench = bench_with("room_drive", |_| {});
    fs::create_dir(bench.path("drives")).unwrap();
    for log in ["room_drive.mcap", "room_step.mcap"] {
        fs::copy(sample(log), bench.path(&format!("drives/{log}"))).unwrap();
    }
    let bless = ["check", "drives", "--golden", "golden", "--bless"];
    let run = tmam(&bench, &bless, &[]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("2 logs:"), "{}", run.stdout);
    assert!(bench.path("golden/room_step.golden.json").exists());
    assert!(!bench.path("golden/drives.golden.json").exists());
}

#[test]
fn a_blessing_says_what_it_keeps_and_what_is_required_in_vain() {
    let bench = bench_with("room_drive", |_| {});
    fs::copy(sample("room_drive.mcap"), bench.path("room_drive.mcap")).unwrap();
    bench.put("tmam.toml", "triple.turn_tolerance = 4\n");
    bench.put("suite.toml", "[require]\nwalls = '>= 700'\n");
    let bless = ["check", "room_drive.mcap", "--golden", "golden", "--bless"];
    let more = ["--config", "tmam.toml", "--suite", "suite.toml"];
    let run = tmam(&bench, &[&bless[..], &more].concat(), &[]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    for said in [
        "the golden file keeps of its own configuration",
        "rule \"noise-aware\" -> \"paper\"",
        "a check will fail, for walls is",
    ] {
        assert!(run.stdout.contains(said), "{said}: {}", run.stdout);
    }
    assert_eq!(
        bench.json("golden/room_drive.golden.json")["config"]["rule"],
        "paper"
    );
}
