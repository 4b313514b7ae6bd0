//! Pillars: with `noise_aware.circles` they are circles of the map, and without it nothing is otherwise.

use serde_json::Value;

use crate::support::Bench;

/// A hall with two pillars of 25 cm, and a drive round them.
const HALL: &str = r#"{"walls": [[0,0,8,0],[8,0,8,5],[8,5,0,5],[0,5,0,0]],
    "pillars": [[2.5,2.5,0.25],[5.5,2.5,0.25]]}"#;

fn simulated() -> Bench {
    let bench = Bench::new();
    bench.put("hall.json", HALL);
    let run = bench.sh(
        "tmam simulate -o log.mcap --world hall.json --noise 0.001 --waypoints '1,1 7,1 7,4 1,4 1,1'",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    bench
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn pillars_are_found_and_everything_says_so() {
    let bench = simulated();
    let with = "--set noise_aware.circles=true";
    let run = bench.sh(&format!("tmam evaluate log.mcap --json {with}"));
    let scores = json(&run.stdout);
    let circles = &scores["confirmed"]["circles"];
    assert_eq!(circles["matched"], 2, "{circles}");
    assert_eq!(circles["spurious"], serde_json::json!([]), "{circles}");
    let off = |what: &str| circles["errors"][what]["max"].as_f64().unwrap();
    assert!(off("position") < 0.01 && off("radius") < 0.01, "{circles}");
    assert!(circles["errors"]["nees"]["mean"].as_f64().unwrap() < 5.0);
    assert_eq!(scores["confirmed"]["lines"]["matched"], 4);

    let run = bench.sh(&format!(
        "tmam replay log.mcap --no-recording --no-causes --features out.json --trace out.jsonl --map map.geojson {with}"
    ));
    assert!(run.stdout.contains(" 2 circles"), "{}", run.stdout);
    let features = json(&String::from_utf8(bench.bytes("out.json")).unwrap());
    let found = features["map"]["circles"].as_array().unwrap();
    assert_eq!(found.len(), 2);
    for circle in found {
        assert!(
            (circle["radius"].as_f64().unwrap() - 0.25).abs() < 0.01,
            "{circle}"
        );
        assert_eq!(circle["covariance"].as_array().unwrap().len(), 3);
    }
    let trace = String::from_utf8(bench.bytes("out.jsonl")).unwrap();
    let row = trace
        .lines()
        .map(json)
        .find(|row| row["map_opinion"] == "circle" && row["readings"].as_u64() > Some(4))
        .unwrap();
    assert!(row.get("wide_chi2_circle").is_some(), "{row}");
    let map = String::from_utf8(bench.bytes("map.geojson")).unwrap();
    assert_eq!(map.matches("\"Polygon\"").count(), 2);

    // The same features compare as equal, and a moved pillar as different.
    bench.sh(&format!(
        "tmam replay log.mcap --no-recording --no-causes --features again.json {with}"
    ));
    assert_eq!(bench.bytes("out.json"), bench.bytes("again.json"));
    let mut moved = features.clone();
    let radius = &mut moved["map"]["circles"][0]["radius"];
    *radius = Value::from(radius.as_f64().unwrap() + 0.05);
    bench.put("moved.json", moved.to_string());
    let run = bench.sh("tmam diff out.json moved.json");
    assert_eq!(run.code, 1, "{}", run.stdout);
    assert!(run.stdout.contains("radius"), "{}", run.stdout);
}

#[test]
fn an_explanation_has_a_third_hypothesis_and_goldens_hold_circles() {
    let bench = simulated();
    bench.put("tmam.toml", "[noise_aware]\ncircles = true\n");
    let check = "tmam check log.mcap --config tmam.toml --golden golden";
    bench.sh(&format!("{check} --bless"));
    let golden = json(&String::from_utf8(bench.bytes("golden/log.golden.json")).unwrap());
    assert_eq!(golden["map"]["circles"].as_array().unwrap().len(), 2);
    let run = bench.sh(check);
    assert_eq!(run.code, 0, "{}", run.stdout);
    bench
        .sh("tmam replay log.mcap --config tmam.toml --no-recording --no-causes --trace out.jsonl");
    let trace = String::from_utf8(bench.bytes("out.jsonl")).unwrap();
    let row = trace
        .lines()
        .map(json)
        .find(|row| row["map_opinion"] == "circle" && row["readings"].as_u64() > Some(4));
    let row = row.unwrap();
    let (sensor, frame) = (row["sensor"].as_str().unwrap(), &row["frame"]);
    let run = bench.sh(&format!(
        "tmam explain log.mcap --config tmam.toml --verbose --sensor {sensor} --frame {frame}"
    ));
    assert!(
        run.stdout.contains("circle") && run.stdout.contains("pillar"),
        "{}",
        run.stdout
    );
}

#[test]
fn without_the_key_files_know_no_circles() {
    let bench = simulated();
    bench.sh(
        "tmam replay log.mcap --no-recording --no-causes --features out.json --trace out.jsonl",
    );
    for file in ["out.json", "out.jsonl"] {
        let text = String::from_utf8(bench.bytes(file)).unwrap();
        assert!(!text.contains("\"circle"), "{file}");
    }
}

#[test]
fn pillars_are_named_where_they_are_not_looked_for() {
    let bench = simulated();
    let run = bench.sh("tmam replay log.mcap --no-recording --features out.json");
    let cause = (run.stdout.lines()).find(|line| line.starts_with("cause 1"));
    let cause = cause.unwrap_or_else(|| panic!("{}", run.stdout));
    assert!(
        cause.contains("round pillars") && cause.contains("noise_aware.circles=true"),
        "{cause}"
    );
    let with = "--set noise_aware.circles=true";
    let run = bench.sh(&format!(
        "tmam replay log.mcap --no-recording --features out.json {with}"
    ));
    assert!(
        run.stdout.contains("causes     none found"),
        "{}",
        run.stdout
    );
}
