//! Flags, configurations and outputs that cannot be.

use std::fs;

use super::refused;
use crate::support::{Bench, sample};

#[test]
fn topics_that_match_nothing_are_named() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    refused(
        &bench,
        &log,
        "replay {} --range-topic /us/*",
        2,
        &["/us/*", "/sonar/sonar_00"],
    );
    refused(
        &bench,
        &log,
        "replay {} --odom-topic /wheel",
        2,
        &["/wheel", "/odom"],
    );
    refused(
        &bench,
        &log,
        "replay {} --sensor front*",
        2,
        &["front*", "sonar_00"],
    );
}

#[test]
fn parameters_out_of_bounds() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    for (flags, said) in [
        (
            "--alpha 1",
            "triple.alpha is 1; it must be above 0 and below 1",
        ),
        ("--alpha nan", "triple.alpha is NaN"),
        ("--beta 0.9", "triple.beta is 0.9; it must be above 1"),
        (
            "--gamma 22.6",
            "must be below the beam width, which is 22.500001 deg for sonar `sonar_00`",
        ),
        ("--gamma 0", "triple.gamma is 0"),
        ("--step=-1", "frames.step is -1; it must be at least 0"),
        ("--start 5 --end 4", "ends at 4 s, before its start at 5 s"),
        ("--start 1e9", "Widen the window"),
        ("--sensor [", "is not a glob"),
        ("--set triple.gama=4", "did you mean `triple.gamma`?"),
        ("--set triple.gamma", "KEY=VALUE"),
    ] {
        let code = if flags == "--start 1e9" { 3 } else { 2 };
        refused(&bench, &log, &format!("replay {{}} {flags}"), code, &[said]);
    }
    assert_eq!(bench.tmam(&log, "replay {} --alpha").code, 2);
    assert_eq!(bench.tmam(&log, "replay {} --no-such-flag").code, 2);
}

#[test]
fn a_configuration_with_an_unknown_key() {
    let bench = Bench::new();
    bench.put("tmam.toml", "[triple]\nalhpa = 0.3\n");
    let said = [
        "tmam.toml: unknown key `triple.alhpa`",
        "did you mean `triple.alpha`?",
    ];
    refused(
        &bench,
        &sample("room_step.mcap"),
        "replay {} --config tmam.toml",
        2,
        &said,
    );
    refused(
        &bench,
        &sample("room_step.mcap"),
        "replay {} --config no.toml",
        2,
        &["no.toml"],
    );
    bench.put("tmam.toml", "[triple\n");
    refused(
        &bench,
        &sample("room_step.mcap"),
        "config --config tmam.toml",
        2,
        &["tmam.toml"],
    );
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn an_output_that_cannot_be_written_or_would_destroy_the_log() {
    let bench = Bench::new();
    let log = bench.put("log.mcap", fs::read(sample("room_step.mcap")).unwrap());
    refused(
        &bench,
        &log,
        "replay {} -o no/such/place.rrd",
        2,
        &["cannot write no/such/place.rrd"],
    );
    refused(
        &bench,
        &log,
        "replay {} --features log.mcap",
        2,
        &["no .mcap file; give a name that ends in .json"],
    );
    assert_eq!(
        fs::read(&log).unwrap(),
        fs::read(sample("room_step.mcap")).unwrap()
    );
}
