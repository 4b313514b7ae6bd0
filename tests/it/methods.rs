//! The rivals of TMAM: each finds without noise what it is made for, and what it cannot find is named.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::support::Bench;

/// Walls and points of the room that a method's confirmed map misses, and its features.
struct Found {
    missed: [Vec<u64>; 2],
    features: [u64; 2],
    /// The largest error of a matched line's distance and of a matched point, metres.
    off: [f64; 2],
    reasons: BTreeMap<String, u64>,
}

fn found(simulated: &str, asked: &str) -> Found {
    let bench = Bench::new();
    let run = bench.sh(&format!("tmam simulate -o log.mcap {simulated}"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = bench.sh(&format!("tmam evaluate log.mcap --json {asked}"));
    let scores: Value =
        serde_json::from_str(&run.stdout).unwrap_or_else(|_| panic!("{}", run.stderr));
    let map = |kind: &str| &scores["confirmed"][kind];
    let missed = |kind| {
        let missed = map(kind)["missed"].as_array().unwrap().iter();
        missed.map(|one| one["index"].as_u64().unwrap()).collect()
    };
    let off = |kind, what| map(kind)["errors"][what]["max"].as_f64().unwrap_or(0.0);
    let reasons = scores["labels"]["reasons"].as_object().unwrap().iter();
    let total = |of: &Value| -> u64 {
        ["line", "point", "other"]
            .iter()
            .map(|t| of[*t].as_u64().unwrap())
            .sum()
    };
    Found {
        missed: ["lines", "points"].map(missed),
        features: ["lines", "points"].map(|kind| map(kind)["features"].as_u64().unwrap()),
        off: [off("lines", "rho"), off("points", "position")],
        reasons: reasons
            .map(|(name, of)| (name.clone(), total(of)))
            .collect(),
    }
}

/// All six walls, and all six points, are missed.
const ALL: [u64; 6] = [0, 1, 2, 3, 4, 5];

#[test]
fn two_measurements_fail_where_tangent_and_crossing_exist() {
    // Its sonars face walls and drive straight: their arcs have a common tangent and a crossing.
    let found = found("", "--method two-measurement");
    assert_eq!(found.features, [0, 0]);
    assert!(found.reasons["ambiguous"] > 900, "{:?}", found.reasons);
}

#[test]
fn tbf_finds_the_six_points_and_walls_that_it_passes() {
    let found = found("", "--method tbf");
    assert!(found.missed[1].is_empty(), "{:?}", found.missed);
    assert!(found.off[1] < 0.005, "{:?}", found.off);
    // A line needs ten places of agreeing crossings, and behind a wall few arcs agree.
    assert!(!found.missed[0].is_empty() && found.missed[0].len() < 6);
}

#[test]
fn atm_finds_points_that_were_seen_from_far_apart_and_no_wall() {
    let found = found("", "--method atm");
    // Point 0 is where the loop begins and ends: no window of scans holds it from far enough apart.
    assert_eq!(found.missed, [ALL.to_vec(), vec![0]]);
    assert!(found.off[1] < 0.005, "{:?}", found.off);
}

#[test]
fn rcd_finds_everything_in_dense_scans_and_says_that_a_sparse_log_has_none() {
    let dense = found(
        "--step 0.6 --scan 2 --sonars 4",
        "--method rcd --step-angle 1",
    );
    assert_eq!(dense.missed, [Vec::<u64>::new(), Vec::new()]);
    assert_eq!(dense.features, [6, 6]);
    assert!(
        dense.off[0] < 0.005 && dense.off[1] < 0.02,
        "{:?}",
        dense.off
    );

    let bench = Bench::new();
    bench.sh("tmam simulate -o log.mcap");
    let run = bench.sh("tmam replay log.mcap --method rcd --features out.json");
    assert!(
        run.stderr
            .contains("no region of constant depth: no sonar turned on the spot"),
        "{}",
        run.stderr
    );
    let features: Value = serde_json::from_slice(&bench.bytes("out.json")).unwrap();
    assert_eq!(features["features"], serde_json::json!([]));
}

#[test]
fn crowley_finds_the_walls_and_takes_corners_for_walls_too() {
    let found = found("", "--method crowley");
    assert_eq!(found.missed, [Vec::new(), ALL.to_vec()]);
    assert!(found.off[0] < 0.001, "{:?}", found.off);
    assert!(found.features[0] > 6);
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn features_without_covariance_say_so_and_what_is_tmams_is_off() {
    let bench = Bench::new();
    bench.sh("tmam simulate -o log.mcap --noise 0.003");
    let run = bench
        .sh("tmam replay log.mcap --method tbf --features out.json --trace out.jsonl -o out.rrd");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout.contains("features have no covariances"),
        "{}",
        run.stdout
    );
    assert!(!run.stdout.contains("\ncauses") && !run.stdout.contains("\nexplained"));
    let out: Value = serde_json::from_slice(&bench.bytes("out.json")).unwrap();
    assert_eq!(out["config"]["method"], "tbf");
    assert!(out.get("causes").is_none() && out.get("poses").is_none());
    let points = out["map"]["points"].as_array().unwrap();
    assert!(!points.is_empty());
    for point in points {
        assert!(point["covariance"].is_null() && point["polar_covariance"].is_null());
    }
    let trace = String::from_utf8(bench.bytes("out.jsonl")).unwrap();
    for line in trace.lines() {
        let row: Value = serde_json::from_str(line).unwrap();
        assert!(row["map_opinion"].is_null() && row["theta_c"].is_null());
        assert_eq!(row["label"] == "unidentified", row["feature"].is_null());
    }
    // The same log, the same bytes.
    bench.sh("tmam replay log.mcap --method tbf --features again.json");
    assert_eq!(bench.bytes("out.json"), bench.bytes("again.json"));

    for command in ["explain log.mcap --suspects", "calibrate log.mcap"] {
        let run = bench.sh(&format!("tmam {command} --method tbf"));
        assert_eq!(run.code, 2);
        assert!(
            run.stderr.contains("looks into TMAM alone"),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn what_a_rival_does_not_know_is_not_called_nothing() {
    let bench = Bench::new();
    bench.sh("tmam simulate -o log.mcap --noise 0.003");
    let json = |command: &str| -> Value {
        let run = bench.sh(command);
        serde_json::from_str(&run.stdout).unwrap_or_else(|_| panic!("{}", run.stderr))
    };
    bench.put(
        "suite.toml",
        "[require]\nexplained = '>= 0.9'\nsuspects = '<= 9'\nwalls = '>= 1'\n",
    );
    bench.put("tmam.toml", "method = 'tbf'\n");
    let check = "tmam check log.mcap --config tmam.toml --golden golden --suite suite.toml";
    bench.sh(&format!("{check} --bless"));
    let run = bench.sh(check);
    assert_eq!(run.code, 1, "{}", run.stdout);
    for told in [
        "explained -, ",
        "suspects -, ",
        "explained is not known, as only TMAM's map says what should have echoed, and >= 0.9 is required",
        "suspects is not known, as only TMAM's map",
    ] {
        assert!(run.stdout.contains(told), "{told}: {}", run.stdout);
    }
    let diff = json("tmam diff log.mcap --method-a tmam --method-b tbf --json");
    let quality = &diff["quality"];
    assert!(quality["a"]["explained"].is_number() && quality["a"]["suspects"].is_number());
    assert!(quality["b"].get("explained").is_none() && quality["b"].get("suspects").is_none());
    let sweep = json("tmam sweep log.mcap --method tbf --step 0.1,0.2 --json");
    for cell in sweep["cells"].as_array().unwrap() {
        let scores = &cell["scores"];
        for unknown in ["bits", "explained_share", "suspects"] {
            assert!(scores[unknown].is_null(), "{cell}");
        }
        assert!(scores["lines"].is_number(), "{cell}");
    }
    let scores = json("tmam evaluate log.mcap --method tbf --json");
    assert!(scores["suspects"].is_null() && scores["labels"].is_object());
    bench.sh("tmam replay log.mcap --method tbf --no-recording --features out.json");
    let out: Value = serde_json::from_slice(&bench.bytes("out.json")).unwrap();
    assert!(out["counts"].get("suspects").is_none());
}

#[test]
fn two_methods_are_compared_on_one_log() {
    let bench = Bench::new();
    bench.sh("tmam simulate -o log.mcap --noise 0.003");
    let run = bench.sh("tmam diff log.mcap --method-a tbf --method-b atm --json");
    assert_eq!(run.code, 1, "{}", run.stderr);
    let diff: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(!diff["differences"].as_array().unwrap().is_empty());
    let same = bench.sh("tmam diff log.mcap --method tbf --set-b map.gate=25");
    assert_eq!(same.code, 0, "{}", same.stdout);
}

#[test]
fn what_tbf_knew_a_corner_whose_triples_outliers_break_is_where_arcs_of_several_sonars_cross() {
    let bench = Bench::new();
    bench.sh("tmam simulate -o log.mcap --drive --noise 0.003 --outliers 0.05 --seed 2");
    let points = |crossings: bool| {
        let run = bench.sh(&format!(
            "tmam evaluate log.mcap --json --set noise_aware.crossings={crossings}"
        ));
        let scores: Value = serde_json::from_str(&run.stdout).unwrap();
        scores["confirmed"]["points"].clone()
    };
    let (without, with) = (points(false), points(true));
    assert_eq!(without["missed"][0]["index"], 3, "{without}");
    assert_eq!(with["missed"], serde_json::json!([]), "{with}");
    assert_eq!(with["features"], 6, "{with}");
    let nees = with["errors"]["nees"]["mean"].as_f64().unwrap();
    assert!((0.3..2.0).contains(&nees), "{nees}");
    let run = bench.sh("tmam explain log.mcap --at 8,2");
    assert!(
        run.stdout
            .contains("No run gave that point: arcs of several sonars cross there."),
        "{}",
        run.stdout
    );
}
