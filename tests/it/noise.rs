//! A log whose noise is not what it is taken to be.

use std::path::Path;

use crate::support::Bench;
use serde_json::Value;

const REPLAY: &str = "replay {} --features out.json --set noise.trust_variance=false";

#[test]
fn wrong_noise_is_measured_and_the_advice_mends_it() {
    let bench = Bench::new();
    let made = bench.tmam(
        Path::new(""),
        "simulate -o drive.mcap --drive --noise 0.03 --seed 2",
    );
    assert_eq!(made.code, 0, "{}", made.stderr);
    let log = bench.path("drive.mcap");

    // The messages say 3 cm.
    let right = bench.tmam(&log, "replay {} --features out.json");
    assert!(!right.stderr.contains("scatter"), "{}", right.stderr);
    let wrong = bench.tmam(&log, &format!("{REPLAY} --set noise.sigma_abs=0.005"));
    let (_, advice) = wrong.stderr.split_once("set noise.sigma_abs = ").unwrap();
    let sigma = advice.split_whitespace().next().unwrap();
    assert!(
        (0.027..=0.033).contains(&sigma.parse::<f64>().unwrap()),
        "{sigma}"
    );
    let mended = bench.tmam(&log, &format!("{REPLAY} --set noise.sigma_abs={sigma}"));
    assert!(!mended.stderr.contains("scatter"), "{}", mended.stderr);

    let info = bench.tmam(
        &log,
        "info {} --json --set noise.trust_variance=false --set noise.sigma_abs=0.005",
    );
    let info: Value = serde_json::from_str(&info.stdout).unwrap();
    let finding = &info["findings"][0];
    assert_eq!(finding["code"], "noise", "{info:#}");
    assert!(finding["mend"].as_str().unwrap().contains(sigma));
    for sonar in ["sonar_00", "sonar_04", "sonar_08"] {
        let sonars = info["sonars"].as_array().unwrap();
        let facts = sonars.iter().find(|s| s["name"] == sonar).unwrap();
        let scatter = facts["scatter"].as_f64().unwrap();
        assert!((0.022..0.038).contains(&scatter), "{sonar}: {scatter}");
    }
}

#[test]
fn a_part_of_a_log_has_the_noise_of_the_whole_and_a_short_one_says_that_it_is_assumed() {
    let bench = Bench::new();
    bench.tmam(
        Path::new(""),
        "simulate -o drive.mcap --drive --noise 0.003 --seed 2",
    );
    bench.tmam(
        Path::new(""),
        "simulate -o short.mcap --steps 8 --sonars 2 --noise 0.003",
    );
    let sigma = |log: &str, flags: &str| {
        let run = bench.tmam(
            &bench.path(log),
            &format!("replay {{}} --features f.json --set noise.trust_variance=false {flags}"),
        );
        let features = bench.json("f.json");
        (
            features["config"]["noise"]["sigma_abs"].as_f64().unwrap(),
            run.stdout,
        )
    };
    let (whole, said) = sigma("drive.mcap", "");
    assert!((0.0025..0.0036).contains(&whole), "{whole}");
    assert!(said.contains(" mm  measured from the ranges"), "{said}");
    assert_eq!(sigma("drive.mcap", "--sensor sonar_09").0, whole);
    assert_eq!(sigma("drive.mcap", "--end 10").0, whole);
    let (assumed, said) = sigma("short.mcap", "");
    assert_eq!(assumed, 0.01);
    assert!(said.contains("10.0 mm  assumed: too little"), "{said}");
}
