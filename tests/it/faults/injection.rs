//! Fault injection: sample logs, written in every way, with one fault each.

use std::collections::BTreeSet;
use std::ops::Range;
use std::panic::catch_unwind;

use tmam_replay::io::log::container::Unchecked;

use super::damage::{Dice, Fault};
use super::pristine::{Message, Pristine, logs, read, read_with};

/// Random faults per log.
const FAULTS: u64 = 500;

/// What must hold of a log with a fault.
fn check(log: &Pristine, fault: &Fault) {
    let bytes = fault.apply(&log.bytes);
    let case = format!("{}: {fault:?}", log.name);
    let outcome = catch_unwind(|| read(&bytes)).unwrap_or_else(|_| panic!("panicked on {case}"));
    let Some((found, losses)) = outcome else {
        panic!("refused {case}");
    };
    let found: BTreeSet<Message> = found.into_iter().collect();
    let cut = matches!(fault, Fault::Truncate(_) | Fault::ZeroTail(_));
    let checked = log.chunked || cut || fault.spares(&(log.data_end..log.bytes.len()));
    // Outside of chunks a message has no checksum but that of the data section; where that is gone,
    // nobody can tell.
    if let Some(strange) = found.difference(&log.set).next()
        && checked
    {
        panic!(
            "made up ({}, {}) in {case}: {losses:?}",
            strange.0, strange.1
        );
    }
    assert!(
        found.len() == log.set.len() || !losses.is_empty(),
        "{} of {} messages, and not a word of the others, in {case}",
        found.len(),
        log.set.len()
    );
    // Outside of chunks only a cut leaves the messages before it beyond doubt.
    if !log.chunked && !matches!(fault, Fault::Truncate(_)) {
        return;
    }
    let end = log.bytes.len();
    let summary = log.summary.is_some_and(|at| fault.spares(&(at..end)));
    for placed in &log.messages {
        let defined = summary || placed.definitions.iter().all(|at| fault.spares(at));
        if defined && fault.spares(&placed.record) {
            let (topic, time, _) = &placed.message;
            assert!(
                found.contains(&placed.message),
                "lost ({topic}, {time}) of the record at {:?}, which is whole, in {case}: {losses:#?}",
                placed.record
            );
        }
    }
}

#[test]
fn a_whole_log_is_read_whole() {
    for log in logs() {
        let (found, losses) = read(&log.bytes).unwrap();
        let expected: Vec<Message> = log.messages.iter().map(|p| p.message.clone()).collect();
        assert!(losses.is_empty(), "{}: {losses:?}", log.name);
        assert!(found == expected, "{}", log.name);
        assert!(log.records.len() > 30, "{}", log.name);
    }
}

#[test]
fn a_log_cut_at_any_record() {
    for log in logs() {
        for (_, record) in &log.records {
            for at in [record.start, record.start + 5, record.end - 1] {
                check(&log, &Fault::Truncate(at));
            }
        }
    }
}

#[test]
fn a_record_taken_out_whole_or_there_twice() {
    for log in logs().iter().filter(|log| log.chunked) {
        for (opcode, record) in &log.records {
            if record.start > 8 {
                check(log, &Fault::Delete(record.clone()));
                check(log, &Fault::Duplicate(record.clone()));
            }
            if *opcode == 6 {
                let bytes = Fault::Delete(record.clone()).apply(&log.bytes);
                assert!(!read(&bytes).unwrap().1.is_empty(), "{}", log.name);
            }
        }
    }
}

#[test]
fn a_log_whose_tail_was_never_written() {
    for log in logs() {
        let mut dice = Dice(1);
        for (_, record) in &log.records {
            check(&log, &Fault::ZeroTail(record.start));
            let inside = record.start + dice.below(record.len());
            check(&log, &Fault::ZeroTail(inside));
        }
    }
}

#[test]
fn a_log_with_a_random_fault() {
    random_faults(0..FAULTS);
}

#[test]
#[ignore = "takes minutes"]
fn a_log_with_many_random_faults() {
    random_faults(FAULTS..40 * FAULTS);
}

fn random_faults(seeds: Range<u64>) {
    for log in logs() {
        for seed in seeds.clone() {
            let mut dice = Dice(seed << 8);
            check(&log, &Fault::random(&mut dice, log.bytes.len()));
        }
    }
}

#[test]
fn every_byte_of_a_small_log() {
    let logs = logs();
    let log = logs.iter().find(|log| log.name == "zstd").unwrap();
    // The first chunks, the borders between them, and the end.
    let end = log.bytes.len();
    for at in (8..3000).chain(end - 600..end) {
        check(log, &Fault::Flip(at, (at % 8) as u8));
    }
}

#[test]
fn the_messages_before_a_cut_within_a_chunk_are_used() {
    for log in logs().iter().filter(|log| log.name.starts_with("plain")) {
        let (_, last) = log
            .records
            .iter()
            .rfind(|(opcode, _)| *opcode == 6)
            .unwrap();
        let whole = log
            .messages
            .iter()
            .filter(|p| p.record.end < last.start)
            .count();
        let (found, losses) = read(&log.bytes[..last.end - 30]).unwrap();
        assert!(found.len() > whole + 5, "{} {whole}", found.len());
        assert!(
            losses[0]
                .to_string()
                .contains("messages before the end were used")
        );
    }
}

#[test]
fn a_damaged_kind_or_length_costs_its_message_and_no_more_than_the_one_before() {
    let logs = logs();
    for log in logs.iter().filter(|log| !log.chunked) {
        let mut dice = Dice(3);
        for (number, placed) in log.messages.iter().enumerate().take(60) {
            let at = placed.record.start + dice.below(9);
            let bytes = Fault::Flip(at, dice.below(8) as u8).apply(&log.bytes);
            let (found, losses) = read_with(&bytes, Unchecked::Used).unwrap();
            let found: BTreeSet<Message> = found.into_iter().collect();
            assert!(!losses.is_empty(), "{at}");
            assert!(found.is_subset(&log.set), "byte {at}: {losses:#?}");
            assert!(!found.contains(&placed.message), "byte {at}: {losses:#?}");
            let others = log.messages.iter().enumerate();
            let spared = others.filter(|(other, _)| *other != number && other + 1 != number);
            for (_, other) in spared {
                assert!(found.contains(&other.message), "byte {at}: {losses:#?}");
            }
        }
    }
}

#[test]
fn a_damaged_length_of_a_definition_costs_no_message() {
    for log in logs().iter().filter(|log| !log.chunked) {
        for definition in definitions(&log.bytes) {
            for bit in 0..64 {
                let at = definition + 1 + bit / 8;
                let bytes = Fault::Flip(at, (bit % 8) as u8).apply(&log.bytes);
                let (found, losses) = read_with(&bytes, Unchecked::Used).unwrap();
                let found: BTreeSet<Message> = found.into_iter().collect();
                assert!(!losses.is_empty(), "{at} {bit}");
                assert_eq!(
                    found.len(),
                    log.set.len(),
                    "byte {at}, bit {bit}: {losses:#?}"
                );
            }
        }
    }
}

/// Where the schemas and channels of the data section begin.
fn definitions(bytes: &[u8]) -> Vec<usize> {
    let mut at = 8;
    let mut places = Vec::new();
    while bytes[at] != 15 {
        if matches!(bytes[at], 3 | 4) {
            places.push(at);
        }
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        at += 9 + length as usize;
    }
    places
}
