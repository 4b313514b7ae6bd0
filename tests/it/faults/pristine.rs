//! Whole logs to be damaged, and what stands where in them.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;
use std::ops::Range;
use std::path::PathBuf;

use mcap::records::Record;
use mcap::{Compression, WriteOptions};
use tmam_replay::io::log::container::{Loss, Unchecked, walk_in};

use crate::support::{rewrite, sample};

/// Topic, log time and bytes of a message.
pub type Message = (String, u64, Vec<u8>);

/// A message, the top-level record that it stands in, and those that its channel and its schema are
/// defined in.
pub struct Placed {
    pub message: Message,
    pub record: Range<usize>,
    pub definitions: [Range<usize>; 2],
}

/// A log and what is in it.
pub struct Pristine {
    pub name: String,
    pub bytes: Vec<u8>,
    pub chunked: bool,
    pub records: Vec<(u8, Range<usize>)>,
    pub messages: Vec<Placed>,
    pub set: BTreeSet<Message>,
    /// Where the data section ends.
    pub data_end: usize,
    /// Where the summary begins, if it names the channels.
    pub summary: Option<usize>,
}

impl Pristine {
    pub fn new(name: &str, bytes: Vec<u8>, has_summary: bool) -> Self {
        let mut records = Vec::new();
        let mut messages = Vec::new();
        let mut channels = BTreeMap::new();
        let mut schemas = BTreeMap::new();
        let mut at = 8;
        let mut data_end = bytes.len();
        while at < bytes.len() - 8 {
            let opcode = bytes[at];
            let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
            let range = at..at + 9 + length;
            let body = &bytes[at + 9..range.end];
            if at < data_end {
                let mut take = |record: Record<'_>| match record {
                    Record::Schema { header, .. } => {
                        schemas.insert(header.id, range.clone());
                    }
                    Record::Channel(channel) => {
                        let schema = schemas[&channel.schema_id].clone();
                        channels.insert(channel.id, (channel.topic, [schema, range.clone()]));
                    }
                    Record::Message { header, data } => {
                        let (topic, definitions) = &channels[&header.channel_id];
                        messages.push(Placed {
                            message: (topic.clone(), header.log_time, data.into_owned()),
                            record: range.clone(),
                            definitions: definitions.clone(),
                        });
                    }
                    _ => {}
                };
                match mcap::parse_record(opcode, body).unwrap() {
                    Record::Chunk { header, data } => {
                        let inside = mcap::read::ChunkReader::new(header, &data).unwrap();
                        inside.for_each(|record| take(record.unwrap()));
                    }
                    Record::DataEnd(_) => data_end = at,
                    record => take(record),
                }
            }
            records.push((opcode, range.clone()));
            at = range.end;
        }
        let set = messages.iter().map(|p| p.message.clone()).collect();
        Self {
            name: name.to_owned(),
            bytes,
            chunked: records.iter().any(|(opcode, _)| *opcode == 6),
            records,
            messages,
            set,
            data_end,
            summary: has_summary.then_some(data_end),
        }
    }
}

/// The beginning of a sample log, written in every way.
pub fn logs() -> Vec<Pristine> {
    let log: PathBuf = sample("room_step.mcap");
    let mut logs = Vec::new();
    let forms = [
        ("plain", Some(None)),
        ("zstd", Some(Some(Compression::Zstd))),
        ("lz4", Some(Some(Compression::Lz4))),
        ("unchunked", None),
    ];
    for (form, chunks) in forms {
        for summary in [true, false] {
            let mut options = WriteOptions::new()
                .use_chunks(chunks.is_some())
                .compression(chunks.flatten())
                .chunk_size(Some(1500));
            if !summary {
                options = options
                    .emit_summary_records(false)
                    .emit_summary_offsets(false);
            }
            let count = std::cell::Cell::new(0);
            let bytes = rewrite(&log, options, |message| {
                count.set(count.get() + 1);
                if count.get() <= 200 {
                    vec![message]
                } else {
                    Vec::new()
                }
            });
            let name = format!("{form}{}", if summary { "" } else { ", no summary" });
            logs.push(Pristine::new(&name, bytes, summary));
        }
    }
    logs
}

/// Reads a log; `None` for one that is refused.
pub fn read(bytes: &[u8]) -> Option<(Vec<Message>, Vec<Loss>)> {
    read_with(bytes, Unchecked::LeftOut)
}

/// As above, with or without what no checksum vouches for.
pub fn read_with(bytes: &[u8], unchecked: Unchecked) -> Option<(Vec<Message>, Vec<Loss>)> {
    let mut found = Vec::new();
    let losses = walk_in(Cursor::new(bytes), unchecked, &mut |channel, message| {
        found.push((
            channel.topic.clone(),
            message.log_time,
            message.data.to_vec(),
        ));
        assert!(found.len() < 1_000_000, "no end");
    });
    losses.ok().map(|losses| (found, losses))
}
