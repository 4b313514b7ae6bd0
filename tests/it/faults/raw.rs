//! MCAP records by hand, right or wrong.

/// A file from its records.
pub fn file(records: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"\x89MCAP0\r\n".to_vec();
    bytes.extend(record(1, &[0; 8]));
    bytes.extend(records.concat());
    bytes
}

/// The data end and a footer without a summary.
pub fn end() -> Vec<u8> {
    let mut bytes = record(15, &[0; 4]);
    bytes.extend(record(2, &[0; 20]));
    bytes.extend(b"\x89MCAP0\r\n");
    bytes
}

/// A record, whose length is right.
pub fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    claiming(opcode, body.len() as u64, body)
}

/// A record that claims some length.
pub fn claiming(opcode: u8, length: u64, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &length.to_le_bytes(), body].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

/// A channel without a schema.
pub fn channel(id: u16, topic: &str) -> Vec<u8> {
    let id = id.to_le_bytes();
    let body = [&id[..], &[0; 2], &text(topic), &text("json"), &[0; 4]].concat();
    record(4, &body)
}

/// A message of a few bytes.
pub fn message(channel: u16, log_time: u64) -> Vec<u8> {
    let time = log_time.to_le_bytes();
    let body = [
        &channel.to_le_bytes()[..],
        &[0; 4],
        &time,
        &time,
        b"{\"range\":1}",
    ]
    .concat();
    record(5, &body)
}

/// A chunk with all that its header may say.
pub struct Chunk<'a> {
    pub records: &'a [u8],
    pub uncompressed: u64,
    pub checksum: u32,
    pub compression: &'a str,
}

impl<'a> Chunk<'a> {
    /// Uncompressed, with its checksum.
    pub fn plain(records: &'a [u8]) -> Self {
        Self {
            records,
            uncompressed: records.len() as u64,
            checksum: crc32fast::hash(records),
            compression: "",
        }
    }

    pub fn bytes(&self) -> Vec<u8> {
        let body = [
            &1_u64.to_le_bytes()[..],
            &9_u64.to_le_bytes(),
            &self.uncompressed.to_le_bytes(),
            &self.checksum.to_le_bytes(),
            &text(self.compression),
            &(self.records.len() as u64).to_le_bytes(),
            self.records,
        ];
        record(6, &body.concat())
    }
}

/// A chunk with a channel and messages on it, logged at these times.
pub fn good(times: &[u64]) -> Vec<u8> {
    let messages = times.iter().flat_map(|time| message(1, *time));
    let records: Vec<u8> = channel(1, "/range").into_iter().chain(messages).collect();
    Chunk::plain(&records).bytes()
}
