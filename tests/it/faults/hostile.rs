//! Logs that carry what is not theirs, or from which something was taken with all sums made right.

use std::borrow::Cow;
use std::io::Cursor;

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use tmam_replay::io::log::container::{Loss, Unchecked};

use super::pristine::{Message, Pristine, read, read_with};
use super::raw::{Chunk, channel, end, file, message, record};

/// Chunks of the log, and messages in each.
const CHUNKS: u64 = 12;
const IN_EACH: u64 = 9;

fn options() -> WriteOptions {
    WriteOptions::new().compression(None).chunk_size(None)
}

/// A log of equal chunks on two channels, from some time on. `between` writes something behind the
/// fourth chunk.
fn write(
    options: WriteOptions,
    start: u64,
    between: impl Fn(&mut mcap::Writer<Cursor<Vec<u8>>>),
) -> Vec<u8> {
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema("t/T", "ros2msg", b"int8 a").unwrap();
    for chunk in 0..CHUNKS {
        for number in 0..IN_EACH {
            let topic = ["/a", "/b"][(number % 2) as usize];
            let channel_id = writer
                .add_channel(schema, topic, "cdr", &Default::default())
                .unwrap();
            let log_time = start + 1000 * chunk + number;
            let header = MessageHeader {
                channel_id,
                sequence: 0,
                log_time,
                publish_time: log_time,
            };
            let data = log_time.to_le_bytes();
            writer.write_to_known_channel(&header, &data).unwrap();
        }
        writer.flush().unwrap();
        if chunk == 3 {
            between(&mut writer);
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

fn plain(options: WriteOptions) -> Pristine {
    Pristine::new("plain", write(options, 1 << 40, |_| {}), true)
}

fn without_summary() -> WriteOptions {
    options()
        .emit_summary_records(false)
        .emit_summary_offsets(false)
}

/// Puts the right checksum over the summary, and over the data where there is one.
fn set_sums(bytes: &mut [u8], data_end: usize) {
    if bytes[data_end + 9..data_end + 13] != [0; 4] {
        let sum = crc32fast::hash(&bytes[..data_end]);
        bytes[data_end + 9..data_end + 13].copy_from_slice(&sum.to_le_bytes());
    }
    let at = bytes.len() - 12;
    let sum = crc32fast::hash(&bytes[data_end + 13..at]);
    bytes[at..at + 4].copy_from_slice(&sum.to_le_bytes());
}

fn chunks(log: &Pristine) -> Vec<std::ops::Range<usize>> {
    let chunks = log.records.iter().filter(|(opcode, _)| *opcode == 6);
    chunks.map(|(_, range)| range.clone()).collect()
}

fn said(losses: &[Loss]) -> String {
    losses.iter().map(|loss| format!("{loss}\n")).collect()
}

/// What is read must be the log's own, whole and in order.
fn holds(bytes: &[u8], own: &[Message], case: &str) -> String {
    let (found, losses) = read(bytes).unwrap();
    assert!(
        found == own,
        "{case}: {} of {}: {losses:#?}",
        found.len(),
        own.len()
    );
    said(&losses)
}

fn own(log: &Pristine) -> Vec<Message> {
    log.messages
        .iter()
        .map(|placed| placed.message.clone())
        .collect()
}

#[test]
fn no_message_of_a_log_inside_an_attachment() {
    let inner = write(options(), 1 << 20, |_| {});
    let attach = |writer: &mut mcap::Writer<_>| {
        let attachment = mcap::Attachment {
            log_time: 1,
            create_time: 1,
            name: "previous.mcap".to_owned(),
            media_type: "application/octet-stream".to_owned(),
            data: Cow::Borrowed(&inner),
        };
        writer.attach(&attachment).unwrap();
    };
    for (form, options) in [("index", options()), ("no index", without_summary())] {
        let whole = Pristine::new(form, write(options, 1 << 40, attach), true);
        let own = own(&whole);
        assert_eq!(holds(&whole.bytes, &own, form), "");
        let (_, attachment) = whole
            .records
            .iter()
            .find(|(opcode, _)| *opcode == 9)
            .unwrap();
        let at = attachment.start + 1;
        let length = (attachment.len() - 9) as u64;
        // Records of the inner log begin at these places of the attachment.
        let inner_at = (length - 4 - inner.len() as u64) as usize + 9;
        let within = |place: usize| (inner_at + place - 9) as u64;
        let inner_records = Pristine::new("inner", inner.clone(), true).records;
        let mut lengths = vec![length + 1, length - 1, length + 40, 7, 0, u64::MAX, 1 << 40];
        lengths.extend(inner_records.iter().map(|(_, record)| within(record.start)));
        for lie in lengths {
            let mut bytes = whole.bytes.clone();
            bytes[at..at + 8].copy_from_slice(&lie.to_le_bytes());
            let case = format!("{form}: {lie} for {length}");
            let said = holds(&bytes, &own, &case);
            assert!(
                said.contains("an attachment: its length is damaged"),
                "{case}: {said}"
            );
        }
        // Both of its lengths, and its kind: with an index nothing of it is used all the same.
        if form == "index" {
            for place in [0, 1, 2, 9 + 16 + 4 + 13 + 4 + 24] {
                for value in [0x00, 0x05, 0x06, 0x86, 0xff] {
                    let mut bytes = whole.bytes.clone();
                    bytes[attachment.start + place] = value;
                    bytes[at] ^= 3;
                    let case = format!("byte {place} is {value}");
                    let said = holds(&bytes, &own, &case);
                    assert!(!said.is_empty(), "{case}");
                }
            }
        }
    }
}

#[test]
fn no_message_of_a_log_inside_a_message() {
    let inner = write(options(), 1 << 20, |_| {});
    for (form, options) in [("index", options()), ("no index", without_summary())] {
        let carry = |writer: &mut mcap::Writer<Cursor<Vec<u8>>>| {
            let schema = writer.add_schema("t/T", "ros2msg", b"int8 a").unwrap();
            let id = writer
                .add_channel(schema, "/bag", "cdr", &Default::default())
                .unwrap();
            let header = MessageHeader {
                channel_id: id,
                sequence: 0,
                log_time: 1 << 41,
                publish_time: 1 << 41,
            };
            writer.write_to_known_channel(&header, &inner).unwrap();
            writer.flush().unwrap();
        };
        let whole = Pristine::new(form, write(options, 1 << 40, carry), true);
        let all = own(&whole);
        let others: Vec<Message> = all.iter().filter(|m| m.0 != "/bag").cloned().collect();
        assert_eq!(all.len(), others.len() + 1);
        assert_eq!(holds(&whole.bytes, &all, form), "");
        // Its chunk is the one that is longer than the inner log; a byte of it is changed.
        let carrier = chunks(&whole)
            .into_iter()
            .find(|c| c.len() > inner.len())
            .unwrap();
        for place in [60, 200, carrier.len() / 2, carrier.len() - 1] {
            let mut bytes = whole.bytes.clone();
            bytes[carrier.start + place] ^= 4;
            let said = holds(&bytes, &others, &format!("{form}: {place}"));
            assert!(said.contains("1 message lost: its checksum is"), "{said}");
        }
    }
}

/// A log that ends within a record that carries another log, or that other log with a damaged head.
#[test]
fn no_message_of_a_log_inside_a_record_that_is_cut_off() {
    let inner = write(options(), 1 << 20, |_| {});
    let mut headless = inner.clone();
    headless[..30].fill(0xA5);
    for carried in [
        &inner,
        &headless,
        &write(without_summary(), 1 << 20, |_| {}),
    ] {
        let attachment = |writer: &mut mcap::Writer<_>| {
            let attachment = mcap::Attachment {
                log_time: 1,
                create_time: 1,
                name: "previous.mcap".to_owned(),
                media_type: "application/octet-stream".to_owned(),
                data: Cow::Borrowed(carried),
            };
            writer.attach(&attachment).unwrap();
        };
        let whole = Pristine::new("", write(without_summary(), 1 << 40, attachment), true);
        let (_, record) = whole.records.iter().find(|(kind, _)| *kind == 9).unwrap();
        let before = |p: &&super::pristine::Placed| p.record.end <= record.start;
        let own: Vec<Message> = (whole.messages.iter().filter(before))
            .map(|placed| placed.message.clone())
            .collect();
        assert_eq!(own.len() as u64, 4 * IN_EACH);
        // The payload ends four bytes before the record; at its end stands the other log's own end.
        let (from, payload) = (record.start, record.end - 4);
        let places = [from + 90, from + 400, payload - 2000, payload - 1, payload];
        let attached = places.map(|end| whole.bytes[..end].to_vec());
        // The same in a metadata record, whose fields are a name and bytes.
        let length = (4 + 1 + 4 + carried.len() + 100) as u64;
        let head = [&[12][..], &length.to_le_bytes(), &[1, 0, 0, 0, b'm']].concat();
        let count = (carried.len() as u32 + 100).to_le_bytes();
        let metadata = [&whole.bytes[..from], &head, &count, carried].concat();
        for bytes in attached.into_iter().chain([metadata]) {
            let case = format!("{} of {} bytes", bytes.len(), carried.len());
            let said = holds(&bytes, &own, &case);
            assert!(said.contains("the file ends within it"), "{case}: {said}");
        }
    }
}

/// Outside of chunks, in a message that is whole, before one that is damaged.
#[test]
fn no_message_of_a_log_inside_the_message_before_a_damaged_one() {
    let inner: Vec<u8> = (0..5).flat_map(|time| message(1, time)).collect();
    let body = [&[1, 0][..], &[0; 4], &[9; 16], &inner].concat();
    let mut damaged = message(1, 77);
    damaged[0] = 0;
    let records = [channel(1, "/a"), message(1, 70), record(5, &body), damaged];
    let after = [message(1, 80), message(1, 81), message(1, 82), end()];
    let (found, losses) = read(&file(&[&records[..], &after].concat())).unwrap();
    assert!(found.iter().all(|m| m.1 >= 70), "{found:?}: {losses:?}");
    assert_eq!((found.len(), losses.len()), (5, 1), "{losses:?}");
}

#[test]
fn a_chunk_of_another_length_in_the_place_of_another_is_not_used() {
    let log = plain(options());
    let chunk = &chunks(&log)[4];
    // The same messages with another payload, packed: times, size and count are those of the index.
    let body = &log.bytes[chunk.start + 9..chunk.end];
    let mut records = body[40..].to_vec();
    *records.last_mut().unwrap() ^= 1;
    let packed = lz4_of(&records);
    let length = (packed.len() as u64).to_le_bytes();
    let sum = crc32fast::hash(&records).to_le_bytes();
    let forged = [&body[..24], &sum, &[3, 0, 0, 0], b"lz4", &length, &packed].concat();
    let forged = record(6, &forged);
    // What is left is filled with a private record, so that everything behind stays where it is.
    let filler = record(0x90, &vec![0; chunk.len() - forged.len() - 9]);
    let mut bytes = log.bytes.clone();
    bytes[chunk.clone()].copy_from_slice(&[forged, filler].concat());
    set_sums(&mut bytes, log.data_end);
    let is_left = |m: &Message| (m.1 - (1 << 40)) / 1000 != 4;
    let left: Vec<Message> = own(&log).into_iter().filter(is_left).collect();
    let said = holds(&bytes, &left, "another length");
    assert!(said.contains("it is not the chunk"), "{said}");
}

fn lz4_of(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
    std::io::Write::write_all(&mut encoder, bytes).unwrap();
    encoder.finish().0
}

/// A definition outside of chunks that the summary has otherwise, where only the summary has a checksum.
#[test]
fn a_definition_that_the_summary_contradicts_is_not_used() {
    let options = options()
        .use_chunks(false)
        .calculate_data_section_crc(false);
    let log = Pristine::new("unchunked", write(options, 1 << 40, |_| {}), true);
    for (kind, word) in [(3, &b"int8 a"[..]), (4, b"/a")] {
        let (_, record) = (log.records.iter())
            .find(|(opcode, _)| *opcode == kind)
            .unwrap();
        let mut definition = log.bytes[record.clone()].windows(word.len());
        let at = record.start + definition.position(|w| w == word).unwrap();
        let mut bytes = log.bytes.clone();
        bytes[at + word.len() - 1] = b'x';
        let said = holds(&bytes, &own(&log), &format!("kind {kind}"));
        let expected = "the summary, which a checksum vouches for";
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn a_chunk_that_the_index_does_not_list_is_not_used() {
    let log = plain(options());
    let foreign = Pristine::new("foreign", write(options(), 1 << 20, |_| {}), true);
    let own = own(&log);
    for chunk in &chunks(&log)[1..] {
        for strange in [
            &foreign.bytes[chunks(&foreign)[2].clone()],
            &log.bytes[chunk.clone()],
        ] {
            // A verified index binds wherever the bytes behind have gone.
            let mut bytes = log.bytes.clone();
            bytes.splice(chunk.start..chunk.start, strange.iter().copied());
            let said = holds(&bytes, &own, &format!("at {}", chunk.start));
            assert!(said.contains("index does not list it"), "{said}");
        }
    }
}

#[test]
fn a_chunk_in_the_place_of_another_is_not_used() {
    let indexed = |log: &Pristine, copied: usize, over: usize| {
        let chunks = chunks(log);
        let mut bytes = log.bytes.clone();
        let copy = bytes[chunks[copied].clone()].to_vec();
        assert_eq!(copy.len(), chunks[over].len());
        bytes[chunks[over].clone()].copy_from_slice(&copy);
        bytes
    };
    let log = plain(options());
    let without = plain(without_summary());
    for (copied, over) in [(3, 7), (7, 3), (4, 5), (11, 1)] {
        let lost = |message: &Message| (message.1 - (1 << 40)) / 1000 == over as u64;
        for sums in [false, true] {
            let mut bytes = indexed(&log, copied, over);
            if sums {
                set_sums(&mut bytes, log.data_end);
            }
            let left: Vec<Message> = own(&log).into_iter().filter(|m| !lost(m)).collect();
            let said = holds(&bytes, &left, &format!("{copied} over {over}"));
            assert!(
                said.contains(&format!(", {IN_EACH} messages lost: it is not the chunk")),
                "{said}"
            );
        }
        // Without an index the message indexes tell.
        let bytes = indexed(&without, copied, over);
        let (_, losses) = read(&bytes).unwrap();
        let said = said(&losses);
        assert!(
            said.contains(&format!(", {IN_EACH} messages lost: they list")),
            "{said}"
        );
    }
}

#[test]
fn the_index_of_the_second_of_two_logs_does_not_bind_the_first() {
    let first = plain(options());
    for second in [write(options(), 1 << 41, |_| {}), first.bytes.clone()] {
        let second = Pristine::new("second", second, true);
        let both = [own(&first), own(&second)].concat();
        let bytes = [&first.bytes[..], &second.bytes].concat();
        let said = holds(&bytes, &both, "two logs");
        assert!(said.contains("two were joined"), "{said}");
    }
}

#[test]
fn message_indexes_without_their_chunk_are_told() {
    let log = plain(without_summary());
    let left_of = |gone: u64| -> Vec<Message> {
        let is_left = |m: &Message| (m.1 - (1 << 40)) / 1000 != gone;
        own(&log).into_iter().filter(is_left).collect()
    };
    for (gone, chunk) in chunks(&log).into_iter().enumerate() {
        if gone == 0 {
            continue; // its definitions are gone with it
        }
        let mut bytes = log.bytes.clone();
        let sum = log.data_end + 9;
        bytes[sum..sum + 4].fill(0);
        bytes.drain(chunk);
        let said = holds(&bytes, &left_of(gone as u64), &format!("chunk {gone}"));
        assert!(
            said.contains(&format!(", {IN_EACH} messages lost: they list")),
            "{said}"
        );
    }
}

#[test]
fn kinds_that_do_not_stand_among_the_data_are_told() {
    let records = [channel(1, "/a"), message(1, 5)].concat();
    let good = Chunk::plain(&records).bytes();
    for opcode in [1, 8, 10, 11, 13, 14] {
        let bytes = file(&[good.clone(), record(opcode, &[0; 20]), good.clone(), end()]);
        let (found, losses) = read(&bytes).unwrap();
        assert_eq!(found.len(), 2, "{opcode}: {losses:?}");
        let said = said(&losses);
        assert!(
            said.contains(&format!("its kind, {opcode:#04x}, is none")),
            "{said}"
        );
        // And inside a chunk.
        let strange = [records.clone(), record(opcode, &[0; 20])].concat();
        let bytes = file(&[Chunk::plain(&strange).bytes(), end()]);
        let (found, losses) = read(&bytes).unwrap();
        assert_eq!((found.len(), losses.len()), (1, 1), "{opcode}: {losses:?}");
    }
}

#[test]
fn no_message_of_a_log_inside_a_record_of_no_known_kind() {
    let good = Chunk::plain(&[channel(1, "/a"), message(1, 5)].concat()).bytes();
    let inner = file(&[
        Chunk::plain(&[channel(1, "/b"), message(1, 6)].concat()).bytes(),
        end(),
    ]);
    for opcode in [0, 0x20, 0x90] {
        let bytes = file(&[good.clone(), record(opcode, &inner), good.clone(), end()]);
        let (found, losses) = read(&bytes).unwrap();
        assert_eq!(found.len(), 2, "{opcode}: {losses:?}");
        assert_eq!(losses.len(), usize::from(opcode < 0x80), "{losses:?}");
    }
}

#[test]
fn definitions_that_no_checksum_vouches_for_are_not_used() {
    let definition = channel(1, "/odom");
    let chunk = Chunk::plain(&message(1, 5)).bytes();
    let mut bytes = file(&[definition, chunk]);
    let sum = crc32fast::hash(&bytes);
    bytes.extend(record(15, &sum.to_le_bytes()));
    bytes.extend(&end()[13..]);
    assert_eq!(
        read(&bytes).map(|(found, losses)| (found.len(), losses.len())),
        Some((1, 0))
    );
    let name = bytes
        .windows(5)
        .position(|window| window == b"/odom")
        .unwrap();
    bytes[name + 1] = b'a';
    let (found, losses) = read(&bytes).unwrap();
    assert!(found.is_empty());
    let told = said(&losses);
    assert!(
        told.contains("checksum of the data section") && told.contains("trust_unchecked"),
        "{told}"
    );
    let (found, losses) = read_with(&bytes, Unchecked::Used).unwrap();
    assert_eq!(found.len(), 1);
    assert!(
        said(&losses).contains("the checksum of the data section"),
        "{losses:?}"
    );
}

#[test]
fn a_changed_byte_that_costs_no_message_is_told() {
    // A name in metadata, a time in a message index: every message and their number are right.
    let metadata = |writer: &mut mcap::Writer<Cursor<Vec<u8>>>| {
        let metadata = mcap::records::Metadata {
            name: "robot".to_owned(),
            metadata: Default::default(),
        };
        writer.write_metadata(&metadata).unwrap();
    };
    let log = Pristine::new("metadata", write(options(), 1 << 40, metadata), true);
    for (opcode, place) in [(12, 14), (7, 16)] {
        let (_, record) = log
            .records
            .iter()
            .find(|(kind, _)| *kind == opcode)
            .unwrap();
        let mut bytes = log.bytes.clone();
        bytes[record.start + place] ^= 1;
        let said = holds(&bytes, &own(&log), &format!("kind {opcode}"));
        assert!(!said.is_empty(), "kind {opcode}");
    }
}
