//! A log whose noise is not what it is taken to be.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test that meets something unexpected should fail on the spot"
)]

mod support;

use std::path::Path;

use serde_json::Value;
use support::Bench;

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
    assert!((0.027..0.033).contains(&sigma.parse().unwrap()), "{sigma}");
    let mended = bench.tmam(&log, &format!("{REPLAY} --set noise.sigma_abs={sigma}"));
    assert!(!mended.stderr.contains("scatter"), "{}", mended.stderr);

    let info = bench.tmam(&log, "info {} --json --set noise.trust_variance=false");
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
