//! The fuzzers' corpora, as ordinary tests.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use tmam_replay::io::log::fuzzing::TARGETS;

use super::damage::{Dice, Fault};
use super::pristine::logs;
use super::raw::{end, file, good, message};
use crate::support::sample;

fn corpus(target: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("fuzz/corpus").join(target)
}

fn seeds(target: &str) -> Vec<Vec<u8>> {
    let files = fs::read_dir(corpus(target)).unwrap();
    let mut paths: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

#[test]
fn every_file_of_every_corpus() {
    for (name, target) in TARGETS {
        let seeds = seeds(name);
        assert!(!seeds.is_empty(), "{name} has no corpus");
        seeds.iter().for_each(|seed| target(seed));
    }
}

#[test]
fn some_mutations_of_every_corpus() {
    mutate(3000);
}

/// What a fuzzer does, without its feedback: `cargo test --test it -- --ignored a_million`.
#[test]
#[ignore = "takes minutes"]
fn a_million_mutations_of_every_corpus() {
    mutate(1_000_000);
}

fn mutate(times: u64) {
    for (name, target) in TARGETS {
        let seeds = seeds(name);
        let mut dice = Dice(7);
        for _ in 0..times {
            let mut bytes = seeds[dice.below(seeds.len())].clone();
            for _ in 0..=dice.below(3) {
                if bytes.len() > 9 {
                    bytes = Fault::random(&mut dice, bytes.len()).apply(&bytes);
                }
            }
            target(&bytes);
        }
    }
}

/// Writes the seeds: `cargo test --test it -- --ignored writes_the_seeds`.
#[test]
#[ignore = "changes the source tree"]
fn writes_the_seeds() {
    for log in logs() {
        let name = log.name.replace(", ", "-").replace(' ', "-");
        let cut = &log.bytes[..1200];
        fs::write(corpus("container").join(format!("{name}-cut")), cut).unwrap();
    }
    for (name, compression) in [
        ("plain", None),
        ("zstd", Some(mcap::Compression::Zstd)),
        ("lz4", Some(mcap::Compression::Lz4)),
    ] {
        let options = mcap::WriteOptions::new().chunk_size(Some(60));
        let whole = tiny(options.compression(compression));
        fs::write(corpus("container").join(format!("{name}-tiny")), whole).unwrap();
    }
    let whole = tiny(mcap::WriteOptions::new().use_chunks(false));
    fs::write(corpus("container").join("unchunked-tiny"), whole).unwrap();
    fs::write(
        corpus("container").join("no-checksums"),
        [
            &file(&[good(&[1, 2]), message(1, 5), good(&[3])])[..],
            &end(),
        ]
        .concat(),
    )
    .unwrap();
    let bytes = fs::read(sample("room_step.mcap")).unwrap();
    let mut done = std::collections::BTreeSet::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        if done.insert(schema.name.clone()) {
            let length = (schema.data.len() as u16).to_le_bytes();
            let seed = [&length[..], &schema.data, &message.data].concat();
            let name = schema.name.rsplit('/').next().unwrap().to_lowercase();
            fs::write(corpus("ros2").join(name), seed).unwrap();
        }
    }
    let arrays = "uint8[] a\nfloat32[<=4] b\nstring[2] c\nint64 d\nbool e\n";
    let message = b"\0\x01\0\0\x02\0\0\0ab\0\0\x01\0\0\0\0\0\x80\x3f\x02\0\0\0x\0\0\0\x01\0\0\0\0";
    let length = (arrays.len() as u16).to_le_bytes();
    let seed = [&length[..], arrays.as_bytes(), message].concat();
    fs::write(corpus("ros2").join("arrays"), seed).unwrap();
}

/// A few messages and everything that a writer puts around them.
fn tiny(options: mcap::WriteOptions) -> Vec<u8> {
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema("t/T", "ros2msg", b"int8 a").unwrap();
    for log_time in 0..6 {
        let topic = if log_time % 2 == 0 { "/a" } else { "/b" };
        let channel_id = writer
            .add_channel(schema, topic, "cdr", &Default::default())
            .unwrap();
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        writer
            .write_to_known_channel(&header, b"\0\x01\0\0\x05")
            .unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}
