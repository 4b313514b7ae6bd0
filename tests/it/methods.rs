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

/// Way-points of circles whose middle goes through the room once: 0.3 m and a turn of 14 degrees from one to the next.
fn circles() -> String {
    let turn = 14_f64.to_radians();
    let radius = 0.15 / libm::sin(turn / 2.0);
    let steps = 72 * 360 / 14;
    let place = |step: i32| {
        // From the lower part of the room up, and along the upper part to the right.
        let way = 6.5 * f64::from(step) / f64::from(steps);
        let middle = (2.0 + (way - 2.1).max(0.0), 1.4 + way.min(2.1));
        let bearing = turn * f64::from(step);
        let (x, y) = (
            middle.0 + radius * libm::cos(bearing),
            middle.1 + radius * libm::sin(bearing),
        );
        format!("{x:.4},{y:.4}")
    };
    (0..=steps).map(place).collect::<Vec<_>>().join(" ")
}

#[test]
fn two_measurements_tell_walls_and_points_by_the_turn_between_them() {
    // Inside of a curve a sonar turns after what it passes, and both beams hold a crossing without the tangent; outside
    // of it it turns away, and they hold the tangent without the crossing.
    let path = circles();
    let curves = found(
        &format!("--step 0.3 --waypoints '{path}'"),
        "--method two-measurement",
    );
    assert_eq!(curves.missed, [Vec::<u64>::new(), Vec::new()]);
    assert!(
        curves.off.iter().all(|off| *off < 0.001),
        "{:?}",
        curves.off
    );
    // Two readings of two targets may have a radius, too.
    assert_eq!(curves.features[1], 6);

    // On a ring that turns on the spot every sonar turns away.
    let ring = found(
        "--step 0.6 --scan 10 --ring-radius 0.5",
        "--method two-measurement",
    );
    assert!(
        ring.missed[0].is_empty() && ring.missed[1].len() >= 5,
        "{:?}",
        ring.missed
    );

    // Straight on, arcs have the tangent and the crossing.
    let straight = found("", "--method two-measurement");
    assert_eq!(straight.features, [0, 0]);
    assert!(
        straight.reasons["ambiguous"] > 900,
        "{:?}",
        straight.reasons
    );
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
fn atm_finds_the_six_points_where_they_are_seen_from_far_apart_and_no_wall() {
    let twice = found("--laps 2", "--method atm");
    assert_eq!(twice.missed, [ALL.to_vec(), Vec::new()]);
    assert_eq!(twice.features, [0, 6]);
    assert!(twice.off[1] < 0.005, "{:?}", twice.off);
    // Of a single lap, which begins and ends at point 0, no window of scans holds that from far enough apart.
    let once = found("", "--method atm");
    assert_eq!(once.missed, [ALL.to_vec(), vec![0]]);
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
#[cfg(feature = "viewer")]
fn the_recording_of_two_methods_holds_both_maps_and_what_differs() {
    let bench = Bench::new();
    bench.sh("tmam simulate -o log.mcap --noise 0.003");
    let diff = "tmam diff log.mcap --method-a tmam --method-b tbf";
    let run = bench.sh(&format!("{diff} -o out.rrd --show 999"));
    assert_eq!(run.code, 1, "{}", run.stderr);
    let told: Value = serde_json::from_str(&bench.sh(&format!("{diff} --json")).stdout).unwrap();
    let of_map = told["differences"].as_array().unwrap().iter();
    let of_map: Vec<&Value> = of_map.filter(|one| one["kind"] == "map").collect();
    assert!(of_map.len() > 10, "{of_map:?}");
    for one in &of_map {
        let text = one["text"].as_str().unwrap();
        assert!(run.stdout.contains(text), "{text}\n{}", run.stdout);
    }

    let recorded = bench.bytes("out.rrd");
    let Drawn { dots, strips } = Drawn::at_the_end(&recorded);
    for (method, at) in [("tmam", "/world/golden/"), ("tbf", "/world/map/")] {
        bench.sh(&format!(
            "tmam replay log.mcap --method {method} --no-recording --features {method}.json"
        ));
        let map = bench.json(&format!("{method}.json"))["map"].clone();
        let points = map["points"].as_array().unwrap();
        let [points_at, lines_at] = ["points", "lines"].map(|of| format!("{at}{of}"));
        let there: Vec<&[f32; 2]> = under(&dots, &points_at).flatten().collect();
        assert_eq!(there.len(), points.len(), "{method}");
        for (point, [x, y]) in points.iter().zip(there) {
            let is_near = |axis: &str, there: &f32| {
                (point[axis].as_f64().unwrap() - f64::from(*there)).abs() < 1e-5
            };
            assert!(
                is_near("x", x) && is_near("y", y),
                "{method}: {point} {x} {y}"
            );
        }
        let there: usize = under(&strips, &lines_at).sum();
        assert_eq!(there, map["lines"].as_array().unwrap().len(), "{method}");
    }
    // What is listed and elsewhere is drawn bright: as it was, and as it is.
    let is_elsewhere = |one: &&&Value| {
        let mut changes = one["changes"].as_array().unwrap().iter();
        one["state"] != "changed" || changes.any(|change| change["what"] != "readings")
    };
    for (at, without) in [("before", "new"), ("now", "missing")] {
        let at = format!("/world/differences/{at}");
        let dots: usize = under(&dots, &at).map(Vec::len).sum();
        let drawn = dots + under(&strips, &at).sum::<usize>();
        let listed = of_map.iter().filter(|one| one["state"] != without);
        assert_eq!(drawn, listed.filter(is_elsewhere).count(), "{at}");
    }
}

/// What stands at an entity of a recording and below.
#[cfg(feature = "viewer")]
fn under<'a, T>(of: &'a BTreeMap<String, T>, entity: &'a str) -> impl Iterator<Item = &'a T> {
    let of = of.iter();
    of.filter(move |(path, _)| path.starts_with(entity))
        .map(|(_, what)| what)
}

/// What a recording holds at its end, by entity: where dots are, and how many strips there are.
#[cfg(feature = "viewer")]
#[derive(Default)]
struct Drawn {
    dots: BTreeMap<String, Vec<[f32; 2]>>,
    strips: BTreeMap<String, usize>,
}

#[cfg(feature = "viewer")]
impl Drawn {
    fn at_the_end(recording: &[u8]) -> Self {
        use rerun::external::re_log_encoding::DecoderApp;
        use rerun::log::{Chunk, LogMsg};

        let dots = rerun::Points2D::descriptor_positions().component;
        let strips = rerun::LineStrips2D::descriptor_strips().component;
        let mut drawn = Self::default();
        for message in DecoderApp::decode_lazy(recording) {
            let LogMsg::ArrowMsg(_, message) = message.unwrap() else {
                continue;
            };
            let chunk = Chunk::from_arrow_msg(&message).unwrap();
            let entity = chunk.entity_path().to_string();
            if let Some(last) = chunk.iter_slices::<[f32; 2]>(dots).last() {
                drawn.dots.insert(entity.clone(), last.to_vec());
            }
            if let Some(column) = chunk.components().get(strips)
                && let [.., begin, end] = column.list_array.value_offsets()
            {
                drawn.strips.insert(entity, (end - begin) as usize);
            }
        }
        drawn
    }
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
