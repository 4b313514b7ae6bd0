//! What changes the file and not the drive: order, compression, chunks, threads.

use std::fs;

use super::{bench_with, report, tmam};
use crate::support::{rewrite, sample};

#[test]
fn another_order_compression_or_chunk_size_matches() {
    let log = sample("room_drive.mcap");
    let options = mcap::WriteOptions::new;
    for (what, options, late) in [
        (
            "zstd",
            options().compression(Some(mcap::Compression::Zstd)),
            false,
        ),
        (
            "lz4",
            options().compression(Some(mcap::Compression::Lz4)),
            false,
        ),
        ("none", options().compression(None), false),
        ("small chunks", options().chunk_size(Some(700)), false),
        ("one chunk", options().chunk_size(Some(100_000_000)), false),
        ("odometry last", options(), true),
    ] {
        let bench = bench_with("room_drive", |_| {});
        let other = rewrite(&log, options, |mut message| {
            message.rank = u8::from(late && !message.topic.starts_with("/sonar"));
            vec![message]
        });
        assert!(other != fs::read(&log).unwrap(), "{what} is another file");
        let other = bench.put("room_drive.mcap", other);
        let (code, said) = report(&bench, &other);
        assert_eq!(code, 0, "{what}: {said:#}");
        assert_eq!(said["logs"][0]["verdict"], "matches");
    }
}

#[test]
fn the_order_in_which_logs_are_named_and_the_number_of_threads_do_not_matter() {
    let bench = bench_with("room_drive", |_| {});
    fs::copy(
        super::golden().join("room_step.golden.json"),
        bench.path("golden/room_step.golden.json"),
    )
    .unwrap();
    let (a, b) = (
        super::path_of("room_drive.mcap"),
        super::path_of("room_step.mcap"),
    );
    let one = tmam(
        &bench,
        &["check", &a, &b, "--golden", "golden"],
        &[("RAYON_NUM_THREADS", "1")],
    );
    let two = tmam(
        &bench,
        &["check", &b, &a, "--golden", "golden"],
        &[("RAYON_NUM_THREADS", "7")],
    );
    assert_eq!((one.code, two.code), (0, 0));
    assert_eq!(one.stdout, two.stdout);
}

#[test]
fn ids_order_and_the_sign_of_a_line_in_the_golden_file_do_not_matter() {
    let bench = bench_with("room_drive", |file| {
        let lines = file["map"]["lines"].as_array_mut().unwrap();
        lines.reverse();
        for (id, line) in lines.iter_mut().enumerate() {
            line["id"] = (1000 + id).into();
            line["rho"] = (-line["rho"].as_f64().unwrap()).into();
            line["theta"] = (line["theta"].as_f64().unwrap() + std::f64::consts::PI).into();
        }
    });
    let (code, said) = report(&bench, &sample("room_drive.mcap"));
    assert_eq!(code, 0, "{said:#}");
}
