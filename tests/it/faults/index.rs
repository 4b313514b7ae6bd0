//! An index of chunks that lies, in whole or in part.

use std::ops::Range;

use super::pristine::{Pristine, logs, read};
use crate::support::{rewrite, sample};

/// A chunk index record, and where it says that its chunk begins and how long it is: behind the
/// record's kind and length, and two times.
struct IndexEntry(Range<usize>);

impl IndexEntry {
    fn all(log: &Pristine) -> Vec<Self> {
        let entries = log.records.iter().filter(|(opcode, _)| *opcode == 8);
        entries.map(|(_, record)| Self(record.clone())).collect()
    }

    fn field(&self, place: usize) -> Range<usize> {
        let at = self.0.start + 9 + 16 + 8 * place;
        at..at + 8
    }

    /// The chunk's offset and length.
    fn says(&self, bytes: &[u8]) -> [u64; 2] {
        [0, 1].map(|place| u64::from_le_bytes(bytes[self.field(place)].try_into().unwrap()))
    }

    fn lie(&self, bytes: &mut [u8], lies: [u64; 2]) {
        for (place, lie) in lies.into_iter().enumerate() {
            bytes[self.field(place)].copy_from_slice(&lie.to_le_bytes());
        }
    }
}

/// Reads a log with its index changed under a checksum that is right, as a tool leaves it that changes
/// the data and forgets the index, or that writes a wrong one: no message is lost, nor said to be.
fn read_with_index(log: &Pristine, case: &str, change: impl FnOnce(&mut [u8])) {
    let (found, losses) = read(&index_changed(log, change)).unwrap();
    assert!(losses.is_empty(), "{}, {case}: {losses:?}", log.name);
    assert_eq!(found.len(), log.messages.len(), "{}, {case}", log.name);
}

fn index_changed(log: &Pristine, change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let mut bytes = log.bytes.clone();
    change(&mut bytes);
    // The checksum stands before the last magic bytes, and covers what is between it and the data
    // section.
    let (begin, checksum) = (log.records.iter())
        .find(|(opcode, _)| *opcode == 15)
        .map(|(_, end)| (end.end, bytes.len() - 8 - 4))
        .unwrap();
    let sum = crc32fast::hash(&bytes[begin..checksum]);
    bytes[checksum..checksum + 4].copy_from_slice(&sum.to_le_bytes());
    bytes
}

#[test]
fn an_index_that_lies_costs_no_message() {
    let with_index = |log: &Pristine| log.chunked && log.summary.is_some();
    for log in logs().into_iter().filter(with_index) {
        let entries = IndexEntry::all(&log);
        assert!(entries.len() > 5, "{}", log.name);
        for shift in [-8, 1, 100] {
            read_with_index(&log, &format!("all by {shift}"), |bytes| {
                for entry in &entries {
                    let [offset, length] = entry.says(bytes);
                    entry.lie(bytes, [offset.checked_add_signed(shift).unwrap(), length]);
                }
            });
        }
        let first = entries[0].says(&log.bytes);
        let end = log.bytes.len() as u64;
        for (number, entry) in entries.iter().enumerate() {
            let [offset, length] = entry.says(&log.bytes);
            // Elsewhere, at its message index, within another one, with another length.
            let lies = [
                [offset - 8, length],
                [offset + 1, length],
                [offset + length, length],
                [offset + length / 2, length],
                [first[0] + 40, length],
                [first[0], length],
                [0, length],
                [end, length],
                [u64::MAX, length],
            ];
            for lie in lies {
                let case = format!("chunk {number} at {lie:?}");
                read_with_index(&log, &case, |bytes| entry.lie(bytes, lie));
            }
            // A chunk of another length than the index has is another chunk.
            for lie in [length - 1, length + 50, u64::MAX, 0] {
                let bytes = index_changed(&log, |bytes| entry.lie(bytes, [offset, lie]));
                let (found, losses) = read(&bytes).unwrap();
                let chunk = offset as usize..(offset + length) as usize;
                let spared = log.messages.iter().filter(|p| p.record != chunk);
                let case = format!("{}, chunk {number} of {lie} bytes", log.name);
                assert_eq!(found.len(), spared.count(), "{case}: {losses:?}");
                assert!(losses[0].to_string().contains("is not the chunk"), "{case}");
            }
        }
    }
}

#[test]
fn an_index_of_which_one_entry_is_right_costs_no_message() {
    let mut logs = logs();
    logs.extend([None, Some(mcap::Compression::Lz4)].map(|compression| {
        let options = mcap::WriteOptions::new()
            .compression(compression)
            .calculate_chunk_crcs(false)
            .calculate_data_section_crc(false)
            .chunk_size(Some(1500));
        let bytes = rewrite(&sample("room_step.mcap"), options, |message| vec![message]);
        Pristine::new("no checksums", bytes, true)
    }));
    for log in logs
        .iter()
        .filter(|log| log.chunked && log.summary.is_some())
    {
        let entries = IndexEntry::all(log);
        for right in [0, 1, entries.len() / 2, entries.len() - 1] {
            read_with_index(log, &format!("all but {right}"), |bytes| {
                for (number, entry) in entries.iter().enumerate() {
                    let [offset, length] = entry.says(bytes);
                    if number != right {
                        entry.lie(bytes, [offset + (1 << 20), length]);
                    }
                }
            });
        }
    }
}
