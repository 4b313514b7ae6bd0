//! Files made to break a reader.

use tmam_replay::io::log::container::Unchecked;

use super::pristine::{read, read_with};
use super::raw::{Chunk, channel, claiming, end, file, good, message, record};

/// Reads a file between two good chunks, which must both be used, and gives all that was lost.
fn between(middle: Vec<u8>) -> (Vec<u64>, Vec<String>) {
    let (found, losses) = read(&file(&[good(&[1, 2]), middle, good(&[8, 9]), end()])).unwrap();
    let times: Vec<u64> = found.iter().map(|(_, time, _)| *time).collect();
    assert!(times.starts_with(&[1, 2]), "{times:?} {losses:?}");
    assert!(times.ends_with(&[8, 9]), "{times:?} {losses:?}");
    let inside = times[2..times.len() - 2].to_vec();
    (inside, losses.iter().map(ToString::to_string).collect())
}

fn lost(middle: Vec<u8>, said: &str) {
    let (times, losses) = between(middle);
    assert!(times.is_empty(), "{times:?}");
    assert!(losses.iter().any(|loss| loss.contains(said)), "{losses:?}");
}

#[test]
fn lengths_that_no_file_has() {
    for length in [u64::MAX, u64::MAX - 8, 1 << 63, 1 << 40, 200 << 20] {
        for opcode in [3, 4, 5, 6, 7, 9, 12, 0x90] {
            lost(claiming(opcode, length, &[7; 50]), "its length is damaged");
        }
    }
    // Inside a chunk: what stands before is used.
    let inside = [message(1, 5), claiming(5, u64::MAX, &[1; 30])].concat();
    let (times, losses) = between(Chunk::plain(&inside).bytes());
    assert_eq!(times, [5]);
    assert!(losses[0].contains("runs beyond its end"), "{losses:?}");
    // Inside a message's and a schema's fields.
    for opcode in [3, 4] {
        let (_, losses) = between(record(opcode, &[0xff; 40]));
        assert!(losses[0].contains("a field runs beyond"), "{losses:?}");
    }
    lost(record(6, &[0xff; 80]), "its header is damaged");
}

#[test]
fn chunks_that_unpack_to_more_or_less_than_they_say() {
    let zeros = vec![0; 100 << 20];
    let bomb = zstd::encode_all(zeros.as_slice(), 1).unwrap();
    let chunk = |uncompressed, records: &[u8]| {
        Chunk {
            records,
            uncompressed,
            checksum: 0,
            compression: "zstd",
        }
        .bytes()
    };
    lost(
        chunk(1000, &bomb),
        "it holds 1001 bytes uncompressed and should hold 1000",
    );
    lost(chunk(u64::MAX, &bomb), "no more than 134217728 are read");
    lost(chunk(128 << 20, &bomb), "it holds 104857600 bytes");
    let few = zstd::encode_all(&b"abc"[..], 1).unwrap();
    lost(chunk(100 << 20, &few), "it holds 3 bytes");
}

#[test]
fn a_file_of_bombs_ends() {
    let bomb = zstd::encode_all(vec![0; 120 << 20].as_slice(), 1).unwrap();
    let chunk = Chunk {
        records: &bomb,
        uncompressed: 120 << 20,
        checksum: 0,
        compression: "zstd",
    };
    let (_, losses) = read(&file(&vec![chunk.bytes(); 60])).unwrap();
    assert!(
        losses
            .iter()
            .any(|l| l.to_string().contains("unpack to more"))
    );
}

#[test]
fn compressions_that_are_none() {
    let records = message(1, 5);
    for (compression, said) in [
        ("brotli", "its compression, `brotli`, is not known"),
        ("zstd", "it cannot be decompressed"),
        ("lz4", "it cannot be decompressed"),
    ] {
        let chunk = Chunk {
            compression,
            ..Chunk::plain(&records)
        };
        lost(chunk.bytes(), said);
    }
}

#[test]
fn chunks_with_and_without_checksum() {
    let records = message(1, 5);
    let chunk = |checksum| Chunk {
        checksum,
        ..Chunk::plain(&records)
    };
    assert_eq!(between(chunk(0).bytes()), (vec![5], vec![]));
    lost(chunk(77).bytes(), "its checksum is");
    assert_eq!(between(Chunk::plain(&[]).bytes()), (vec![], vec![]));
}

#[test]
fn records_with_short_bodies() {
    for opcode in 7..=14 {
        for body in [&[][..], &[1; 11]] {
            let (times, losses) = between(record(opcode, body));
            assert_eq!((times.len(), losses.len()), (0, 1), "{opcode}: {losses:?}");
        }
    }
    // Entries of a message index, as its count says, but no whole ones.
    let entries = [&[1, 0, 5, 0, 0, 0][..], &[0; 5]].concat();
    lost(record(7, &entries), "a field runs beyond its record");
    for opcode in 1..=6 {
        let chunk = record(opcode, &[]);
        assert_eq!(between(chunk).0, [0_u64; 0], "{opcode}");
    }
    let inside: Vec<u8> = (1..=14).flat_map(|opcode| record(opcode, &[9])).collect();
    assert_eq!(between(Chunk::plain(&inside).bytes()).0, [0_u64; 0]);
}

#[test]
fn channels_that_are_unknown_or_change_their_meaning() {
    let unknown = Chunk::plain(&message(3, 5)).bytes();
    lost(unknown, "1 message lost: channel 3");
    let (found, losses) = read(&file(&[
        good(&[1]),
        Chunk::plain(&[channel(1, "/other"), message(1, 5)].concat()).bytes(),
        good(&[9]),
        end(),
    ]))
    .unwrap();
    // Whatever is on it from there on could mean one thing or the other.
    assert_eq!(found.len(), 1);
    assert!(losses[0].to_string().contains("defined a second time"));
}

#[test]
fn what_follows_the_end() {
    let whole = file(&[good(&[1, 2]), end()]);
    for (more, said) in [
        (vec![0; 5000], "zeros"),
        (vec![0xA5; 5000], "no part of the log"),
    ] {
        let (found, losses) = read(&[whole.clone(), more].concat()).unwrap();
        assert_eq!(found.len(), 2);
        assert!(losses[0].to_string().contains(said), "{losses:?}");
    }
    // Another log: its messages are used, and what lies between the two is told.
    let (found, losses) = read(&[whole.clone(), whole].concat()).unwrap();
    assert_eq!((found.len(), losses.len()), (4, 1), "{losses:?}");
    let said = losses[0].to_string();
    assert!(said.contains("two were joined"), "{said}");
}

#[test]
fn a_footer_in_the_middle_ends_nothing() {
    let footer = &end()[13..];
    let (times, losses) = between(footer.to_vec());
    assert!(times.is_empty() && !losses.is_empty(), "{losses:?}");
}

#[test]
fn what_is_lost_is_told_with_its_place_in_time() {
    // By the messages before and behind it.
    let (_, losses) = between(claiming(9, 1 << 40, &[7; 50]));
    let said = "an attachment, between messages logged 0.000 s and 0.000 s after the first";
    assert!(losses[0].contains(said), "{losses:?}");
    // By the last one before it, where nothing follows.
    let second = 1_000_000_000;
    let mut cut = file(&[channel(1, "/a"), message(1, second), message(1, 3 * second)]);
    cut.extend(&message(1, 4 * second)[..20]);
    let (found, losses) = read(&cut).unwrap();
    assert_eq!(found.len(), 2);
    let said = losses[0].to_string();
    assert!(
        said.contains("the last message, behind a message logged 2.000 s"),
        "{said}"
    );
}

#[test]
fn zeros_in_and_behind_a_chunk() {
    let last = good(&[5, 6]);
    let mut bytes = file(&[good(&[1, 2]), last[..last.len() / 2].to_vec()]);
    bytes.resize(bytes.len() + 9000, 0);
    let (found, losses) = read(&bytes).unwrap();
    assert_eq!(found.len(), 2);
    let said: Vec<String> = losses.iter().map(ToString::to_string).collect();
    assert!(said[0].contains("a chunk with messages logged"), "{said:?}");
    assert!(
        said[1].contains("everything to the end of the file"),
        "{said:?}"
    );
    assert!(said[1].contains("filled with zeros"), "{said:?}");
    let lost: u64 = losses.iter().map(|loss| loss.bytes).sum();
    assert_eq!(lost + losses[0].offset, bytes.len() as u64, "{said:?}");
}

/// Messages outside of chunks under a checksum that one of them fails.
#[test]
fn what_no_checksum_vouches_for_is_used_only_when_asked_for() {
    let mut bytes = file(&[
        channel(1, "/a"),
        message(1, 5),
        message(1, 6),
        message(1, 7),
    ]);
    let sum = crc32fast::hash(&bytes);
    let place = bytes.len() - 5; // in the last message
    bytes.extend(record(15, &sum.to_le_bytes()));
    bytes.extend(&end()[13..]);
    assert_eq!(read(&bytes).unwrap().0.len(), 3);
    assert!(read(&bytes).unwrap().1.is_empty());
    bytes[place] ^= 1;
    let (found, losses) = read(&bytes).unwrap();
    assert!(found.is_empty());
    let said = losses[0].to_string();
    assert!(
        said.contains("3 messages lost") && said.contains("input.trust_unchecked"),
        "{said}"
    );
    let (found, losses) = read_with(&bytes, Unchecked::Used).unwrap();
    assert_eq!((found.len(), losses.len()), (3, 1), "{losses:?}");
    let said = losses[0].to_string();
    assert!(
        said.contains("any of them may be damaged. All are used"),
        "{said}"
    );
    assert!(!said.contains("messages lost"), "{said}");
}

#[test]
fn outside_of_chunks_in_any_order() {
    let records = [channel(1, "/a"), message(1, 9), message(1, 2), end()];
    let (found, losses) = read(&file(&records)).unwrap();
    assert_eq!(found.len(), 2);
    assert!(losses.is_empty(), "{losses:?}");
    let records = [message(1, 9), channel(1, "/a"), message(1, 2), end()];
    let (found, losses) = read(&file(&records)).unwrap();
    assert_eq!(found.len(), 1);
    assert!(
        losses[0].to_string().contains("1 message lost"),
        "{losses:?}"
    );
}

/// Kinds that no record outside of chunks has amid the data, and those whose fields it does not have: no more
/// than the message before is lost with it. A private record may hold anything: such a kind is told by the
/// checksum or the number of messages alone.
#[test]
fn a_message_of_another_kind_is_missed() {
    let whole = [
        channel(1, "/a"),
        message(1, 1),
        message(1, 2),
        message(1, 3),
        message(1, 4),
        message(1, 5),
    ];
    for opcode in [1, 4, 7, 8, 10, 11, 13, 14] {
        let mut records = whole.to_vec();
        records[2][0] = opcode;
        records.push(end());
        let (found, losses) = read(&file(&records)).unwrap();
        let times: Vec<u64> = found.iter().map(|(_, time, _)| *time).collect();
        assert!(
            times.ends_with(&[3, 4, 5]),
            "{opcode}: {times:?} {losses:?}"
        );
        assert!(!times.contains(&2), "{opcode}: {losses:?}");
        assert_eq!(losses.len(), 1, "{opcode}: {losses:?}");
    }
    // An attachment and a metadata record whose first bytes could be a message's.
    let attachment = record(9, &[vec![0; 24], vec![0; 8], vec![0; 4]].concat());
    let metadata = record(
        12,
        &[[1, 0, 0, 0, b'a', 21, 0, 0, 0].as_slice(), &[0; 21]].concat(),
    );
    for other in [attachment, metadata] {
        let mut records = vec![channel(0, "/b")];
        records.extend(whole.iter().cloned());
        records.insert(4, other);
        let (found, losses) = read(&file(&records)).unwrap();
        assert_eq!((found.len(), losses.len()), (5, 1), "{losses:?}");
    }
}
