//! What blessing changes, and what it keeps.

use super::{bench_with, path_of, tmam};
use crate::support::Bench;

#[test]
fn blessing_shows_what_it_changes_and_keeps_the_terms() {
    let bench = bench_with("room_drive", |file| {
        file["config"]["triple"]["gamma"] = 0.15.into();
        file["tolerances"]["rho"] = 0.02.into();
    });
    let log = path_of("room_drive.mcap");
    let bless = ["check", &log, "--golden", "golden", "--bless"];
    let run = tmam(&bench, &bless, &[]);
    assert_eq!(run.code, 0);
    assert!(
        run.stdout.contains("contact -> unidentified (wide)"),
        "{}",
        run.stdout
    );
    let file = bench.json("golden/room_drive.golden.json");
    assert_eq!(file["config"]["triple"]["gamma"], 0.15);
    assert_eq!(file["tolerances"]["rho"], 0.02);
    let loose: Vec<&str> = bless
        .into_iter()
        .chain(["--tolerance", "rho=0.03", "--gamma", "10"])
        .collect();
    let run = tmam(&bench, &loose, &[]);
    for said in [
        "tolerance rho 0.02 -> 0.03",
        "triple.gamma 8.594366927 -> 10.0 deg",
        "contact",
    ] {
        assert!(run.stdout.contains(said), "no {said} in {}", run.stdout);
    }
}

#[test]
fn blessing_with_one_parameter_keeps_the_others() {
    let bench = Bench::new();
    let log = path_of("room_drive.mcap");
    bench.put("tmam.toml", "triple.turn_tolerance = 4\n");
    let bless = |more: &[&str]| {
        let mut all = vec!["check", &log, "--golden", "golden", "--bless"];
        all.extend(more);
        let run = tmam(&bench, &all, &[]);
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        let file = bench.json("golden/room_drive.golden.json");
        (run.stdout, file["config"].clone())
    };
    let sonar = "sonar_0*";
    let (_, first) = bless(&[
        "--rule",
        "paper",
        "--sensor",
        sonar,
        "--set",
        "map.match_distance=0.3",
    ]);
    assert_eq!(first["rule"], "paper");
    assert_eq!(first["input"]["sonars"], serde_json::json!([sonar]));
    let (said, second) = bless(&["--gamma", "8", "--config", "tmam.toml"]);
    assert!(said.contains("triple.gamma 10.0 -> 8.0 deg"), "{said}");
    let mut expected = first;
    for (key, degrees) in [("gamma", 8.0_f64), ("turn_tolerance", 4.0)] {
        let now = &second["triple"][key];
        assert!((now.as_f64().unwrap() - degrees.to_radians()).abs() < 1e-12);
        expected["triple"][key] = now.clone();
    }
    assert_eq!(second, expected);
    let (said, third) = bless(&["--rule", "noise-aware"]);
    assert!(
        said.contains("rule \"paper\" -> none")
            || said.contains("rule \"paper\" -> \"noise-aware\""),
        "{said}"
    );
    // The default is not recorded.
    expected.as_object_mut().unwrap().remove("rule").unwrap();
    assert_ne!(second, third);
    assert_eq!(third, expected);
}
