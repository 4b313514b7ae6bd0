//! Outputs replace no input, appear together or not at all, and a full one is an error.

use std::fs;

use crate::support::{Bench, sample};

#[test]
fn no_output_takes_the_place_of_an_input() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let config = bench.put("tmam.toml", "rule = \"noise-aware\"\n");
    let world = fs::read(sample("office.world.json")).unwrap();
    bench.put("world.json", &world);
    for command in [
        "replay {} --config tmam.toml --features tmam.toml",
        "replay {} --config tmam.toml -o ./tmam.toml",
        "report {} --config tmam.toml -o tmam.toml",
        "sweep {} --config tmam.toml --gamma 8,10 --csv tmam.toml",
        "evaluate {} --truth world.json -o world.json",
        "simulate -o world.json --world world.json --waypoints '1,1 2,1'",
    ] {
        let log = log.display().to_string();
        let run = bench.sh(&format!("tmam {}", command.replace("{}", &log)));
        assert_eq!(run.code, 2, "{command}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains("is named twice"), "{}", run.stderr);
        assert_eq!(
            fs::read_to_string(&config).unwrap(),
            "rule = \"noise-aware\"\n"
        );
        assert_eq!(bench.bytes("world.json"), world);
    }
    assert_eq!(bench.files().len(), 2, "{:?}", bench.files());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_output_is_an_error_and_leaves_none_of_the_others() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    for command in ["info", "explain --suspects", "config"] {
        let log = if command == "config" {
            String::new()
        } else {
            log.display().to_string()
        };
        let mut words = command.split(' ');
        let name = words.next().unwrap();
        let rest = words.collect::<Vec<_>>().join(" ");
        let run = bench.sh(&format!("tmam {name} {log} {rest} > /dev/full"));
        assert_eq!(run.code, 2, "{command}: {}", run.stderr);
        assert!(run.stderr.contains("cannot write"), "{}", run.stderr);
    }
    let run = bench.tmam(&log, "replay {} -o run.rrd --features /dev/full");
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}
