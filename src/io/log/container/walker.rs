//! One record after the other, from the header to the end of the data; and where to go on behind damage.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;

use super::channels::{Delivery, Visit};
use super::chunk::{self, Times, Unpacker};
use super::folder::parts;
use super::loss::{BEHIND, Loss, Losses, SUMMARY, Why, wider};
use super::packed::unpacked;
use super::record::{
    self, Channel, ChunkHeader, ChunkIndex, DATA_END, Fields, INDEX_ENTRY, INDEX_HEADER, Identity,
    Inner, MAGIC, MAGIC_LENGTH, MAX_CHUNK, MESSAGE_HEADER, PREFIX, op,
};
use super::source::{CHAIN, Prefix, Source};
use super::summary::{Index, Listing, Tail, data_agrees};
use crate::io::text_file::LFS_POINTER;

/// What is done with records that only the data section's checksum covers, where that does not
/// agree: any of them may be damaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unchecked {
    /// None is used.
    LeftOut,
    /// All are.
    Used,
}

/// Why nothing at all can be read of a file.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The end of a log is read first.
    #[error("it is a pipe or a device, which cannot be read from any place")]
    NoFile,
    #[error("it is empty: 0 bytes")]
    Empty,
    #[error("it neither begins nor ends with the MCAP magic bytes")]
    NotMcap(&'static str),
    /// A folder.
    #[error("it is a folder without a .mcap file")]
    NoParts,
}

/// What files are that are given for logs, by their first bytes.
const OTHERS: [(&[u8], &str); 5] = [
    (
        b"#ROSBAG",
        "it is a ROS 1 bag: `mcap convert` makes a log of it",
    ),
    (
        b"SQLite format 3",
        "it is a .db3 file of a rosbag2 folder: `ros2 bag convert` makes a log of it",
    ),
    LFS_POINTER,
    (
        b"RRF",
        "it is a recording for the Rerun viewer: `rerun` opens it, and `tmam diff` compares it; the log that it was made of is wanted",
    ),
    (
        b"{",
        "it is JSON, as features and golden files are, which `tmam diff` compares; the log that it was made of is wanted",
    ),
];

/// What a file is, and what to do about it.
fn what_it_is<R: Read + Seek>(source: &mut Source<R>) -> io::Result<&'static str> {
    let begin = source.get(0, 32)?;
    let found = OTHERS.iter().find(|(magic, _)| begin.starts_with(magic));
    Ok(found.map_or("", |(_, what)| what))
}

/// Calls `visit` with every message of the file that can be trusted, in file order.
///
/// # Errors
/// A file that cannot be opened or is not an MCAP file. Everything else is a [`Loss`].
pub fn walk(
    path: &Path,
    unchecked: Unchecked,
    visit: &mut Visit<'_>,
) -> Result<Vec<Loss>, OpenError> {
    walk_with(path, unchecked, false, visit)
}

/// The same; with `ahead`, the next chunk is unpacked on a thread while `visit` sees the messages of the one before.
///
/// # Errors
/// As [`walk`].
pub fn walk_with(
    path: &Path,
    unchecked: Unchecked,
    ahead: bool,
    visit: &mut Visit<'_>,
) -> Result<Vec<Loss>, OpenError> {
    // Opening a pipe would wait for a writer.
    let metadata = std::fs::metadata(path)?;
    match metadata.file_type() {
        kind if kind.is_dir() => walk_folder(path, unchecked, ahead, visit),
        kind if !kind.is_file() => Err(OpenError::NoFile),
        _ if metadata.len() == 0 => Err(OpenError::Empty),
        _ => {
            let mut walker = Walker::new(unpacked(File::open(path)?)?, unchecked, visit)?;
            walker.ahead = ahead;
            Ok(walker.run()?)
        }
    }
}

/// Walks over the parts of a recording that `ros2 bag` split, which lie in one folder, in the order of their
/// numbers. Channels that are the same in several parts are one.
fn walk_folder(
    folder: &Path,
    unchecked: Unchecked,
    ahead: bool,
    visit: &mut Visit<'_>,
) -> Result<Vec<Loss>, OpenError> {
    let parts = parts(folder)?;
    if parts.is_empty() {
        return Err(OpenError::NoParts);
    }
    let mut channels: Vec<Channel> = Vec::new();
    let mut losses = Vec::new();
    for part in parts {
        // By its number in the part, the number in the whole.
        let mut numbers = BTreeMap::new();
        let lost = walk_with(&part, unchecked, ahead, &mut |channel, message| {
            let place = *numbers.entry(channel.id).or_insert_with(|| {
                let is_it = |known: &Channel| {
                    known.topic == channel.topic
                        && known.encoding == channel.encoding
                        && known.schema == channel.schema
                };
                let place = channels.iter().position(is_it).unwrap_or(channels.len());
                if let (true, Ok(id)) = (place == channels.len(), u16::try_from(place)) {
                    channels.push(Channel {
                        id,
                        ..channel.clone()
                    });
                }
                place
            });
            if let Some(channel) = channels.get(place) {
                visit(channel, message);
            }
        });
        losses.extend(lost?);
    }
    Ok(losses)
}

/// [`walk`] over anything that can be read from any place.
///
/// # Errors
/// Input that cannot be read or is not an MCAP file.
pub fn walk_in<R: Read + Seek>(
    input: R,
    unchecked: Unchecked,
    visit: &mut Visit<'_>,
) -> Result<Vec<Loss>, OpenError> {
    Ok(Walker::new(input, unchecked, visit)?.run()?)
}

/// Walks over a file.
struct Walker<'v, R> {
    source: Source<R>,
    tail: Tail,
    index: Index,
    unpacker: Unpacker,
    delivery: Delivery<'v>,
    losses: Losses,
    /// Whether the file has chunks.
    chunked: bool,
    /// Where the last record begins that only its own length and fields vouch for.
    previous: u64,
    /// Whether the data section's checksum agrees, once that was asked.
    section: Option<bool>,
    unchecked: Unchecked,
    /// Whether the next chunk is unpacked while the last one is used.
    ahead: bool,
    /// What no checksum vouches for.
    distrusted: Option<Loss>,
}

/// Where to go on; `None` at the end.
type Next = io::Result<Option<u64>>;

impl<'v, R: Read + Seek> Walker<'v, R> {
    fn new(input: R, unchecked: Unchecked, visit: &'v mut Visit<'v>) -> Result<Self, OpenError> {
        let mut source = Source::new(input)?;
        let mut tail = Tail::read(&mut source)?;
        let begins = source.peek(0)? == Some(MAGIC);
        if !(begins || tail.footer) {
            return Err(OpenError::NotMcap(what_it_is(&mut source)?));
        }
        let mut losses = Losses::default();
        if !begins {
            let what = "the beginning of the file";
            losses.add(Loss::new(0, MAGIC_LENGTH, what, Why::Magic));
        }
        let (mut index, mut fallback) = Default::default();
        if let Some(summary) = &mut tail.summary {
            index = Index::find(&mut source, summary)?;
            fallback = std::mem::take(&mut summary.registry);
        }
        Ok(Self {
            unpacker: Unpacker::new(source.length()),
            chunked: !index.is_empty(),
            previous: MAGIC_LENGTH,
            source,
            tail,
            index,
            delivery: Delivery::new(fallback, visit),
            losses,
            section: None,
            unchecked,
            ahead: false,
            distrusted: None,
        })
    }

    fn run(mut self) -> io::Result<Vec<Loss>> {
        let mut at = MAGIC_LENGTH;
        loop {
            let next = self.step(at)?;
            self.losses
                .date(self.delivery.next.take(), self.delivery.last);
            match next {
                Some(next) => at = next,
                None => break,
            }
        }
        self.compare()?;
        let start = self.tail.summary.as_ref().and_then(|summary| summary.start);
        let start = self.delivery.start.into_iter().chain(start).min();
        Ok(self.losses.finish(start))
    }

    /// Where the data section ends at the latest.
    fn limit(&self, at: u64) -> u64 {
        let limit = self.tail.limit.filter(|limit| *limit >= at);
        limit.unwrap_or(self.source.length())
    }

    fn leads_on(&mut self, at: u64, records: usize) -> io::Result<bool> {
        self.source.leads_on(at, records, !self.tail.magic)
    }

    fn step(&mut self, at: u64) -> Next {
        if self.tail.limit == Some(at) && self.tail.data_end != Some(at) {
            return self.close(at);
        }
        let Some(prefix) = self.source.prefix(at)? else {
            return self.end(at);
        };
        match prefix.opcode {
            op::DATA_END if self.ends_data(at)? => return self.close(at + DATA_END),
            op::FOOTER if self.ends_file(prefix, at)? => return self.close(at),
            op::DATA_END | op::FOOTER => return self.go_on(at, prefix),
            _ => {}
        }
        let Some((end, flaw)) = self.border(at, prefix)? else {
            return self.go_on(at, prefix);
        };
        self.previous = at;
        if prefix.opcode == op::CHUNK {
            return self.chunk(at, end, flaw);
        }
        let is_malformed = flaw == Some(Why::Malformed);
        let why = match prefix.opcode {
            op::SCHEMA | op::CHANNEL if !is_malformed => {
                self.definition(at, end, prefix.opcode)?.or(flaw)
            }
            op::MESSAGE => return self.message(at, end),
            op::MESSAGE_INDEX if flaw.is_none() => {
                return Ok(Some(self.message_indexes(at, Some(Times::new()))?.0));
            }
            op::SCHEMA..=op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA | op::PRIVATE.. => flaw,
            op::HEADER if self.source.peek(at - MAGIC_LENGTH)? == Some(MAGIC) => flaw,
            opcode => Some(Why::Kind(opcode)),
        };
        if let Some(why) = why {
            self.losses
                .add(Loss::new(at, end, kind(prefix.opcode), why));
        }
        Ok(Some(end))
    }

    /// Where a record ends, and what is wrong with it where its length and its fields do not say the same:
    /// then it is the one of them that leads on. The fields come first, since a length that is too large may
    /// lead on behind other records.
    fn border(&mut self, at: u64, prefix: Prefix) -> io::Result<Option<(u64, Option<Why>)>> {
        let limit = self.limit(at);
        let length = Some(prefix.end(at)).filter(|end| prefix.is_possible() && *end <= limit);
        let fields = self.source.end_of_fields(at, prefix.opcode)?;
        let is_index = prefix.opcode == op::MESSAGE_INDEX;
        let is_odd = is_index && prefix.length % INDEX_ENTRY != INDEX_HEADER;
        Ok(match (fields, length) {
            (Some(fields), Some(length)) if fields == length && !is_odd => Some((length, None)),
            (Some(end), _) if end <= limit && self.leads_on(end, CHAIN)? => {
                Some((end, Some(if is_odd { Why::Malformed } else { Why::Length })))
            }
            (Some(_), Some(end)) if self.leads_on(end, CHAIN)? => Some((end, Some(Why::Malformed))),
            (None, Some(end)) if self.leaves_a_trace(end)? => Some((end, None)),
            // A log inside a record of no known kind is no part of this one either.
            (None, None) if !prefix.is_possible() && self.holds_log(at)? => {
                let end = Some(prefix.end(at)).filter(|end| *end <= limit);
                match end {
                    Some(end) if self.leads_on(end, CHAIN)? => Some((end, None)),
                    _ => None,
                }
            }
            _ => None,
        })
    }

    /// Whether what a record holds begins as a log does.
    fn holds_log(&mut self, at: u64) -> io::Result<bool> {
        Ok(self.source.peek(at.saturating_add(PREFIX))? == Some(MAGIC))
    }

    /// Whether a record begins there, or one of which the length or the fields are damaged.
    fn leaves_a_trace(&mut self, at: u64) -> io::Result<bool> {
        if let Some(prefix) = self.source.prefix(at)? {
            let fields = self.source.end_of_fields(at, prefix.opcode)?;
            for end in [Some(prefix.end(at)), fields].into_iter().flatten() {
                if end < self.source.length() && self.leads_on(end, 1)? {
                    return Ok(true);
                }
            }
        }
        self.leads_on(at, 1)
    }

    fn ends_data(&mut self, at: u64) -> io::Result<bool> {
        match self.tail.data_end {
            Some(data_end) => Ok(data_end == at),
            None => self.source.ends_data(at, !self.tail.magic),
        }
    }

    /// Whether a record is a footer that ends the file, or may do so where nothing else does.
    fn ends_file(&mut self, prefix: Prefix, at: u64) -> io::Result<bool> {
        let end = prefix.end(at);
        let is_footer = prefix.length == 20 && self.source.peek(end)? == Some(MAGIC);
        let is_last = end.saturating_add(MAGIC_LENGTH) == self.source.length();
        Ok(is_footer && (is_last || !self.tail.footer))
    }

    fn chunk(&mut self, at: u64, end: u64, flaw: Option<Why>) -> Next {
        self.chunked = true;
        // Of one with a damaged length its checksum must tell that it is one.
        let header = self.source.chunk_header(at)?.filter(|header| match flaw {
            None => true,
            Some(Why::Length) => header.checksum != 0,
            Some(_) => false,
        });
        let Some(header) = header else {
            return self.lose_chunk(at, end, None, Why::Header);
        };
        if header.checksum == 0 && header.compressed > 0 && !self.section_agrees()? {
            let (next, messages) = self.message_indexes(end, None)?;
            if self.distrust(at, end, Some(header.span), messages) {
                self.index.lose(at);
                return Ok(Some(next));
            }
        }
        let from = at + PREFIX + header.length;
        let times = match self.unpacker.records(&mut self.source, from, &header)? {
            Ok(records) => chunk::times(records),
            Err(why) => return self.lose_chunk(at, end, Some(header.span), why),
        };
        let said = header.identity();
        let span = chunk::span(&times).unwrap_or(said.span);
        let (is_used, listed, why) = match self.index.meet(at, Identity { span, ..said }) {
            Listing::Listed => (true, None, flaw),
            Listing::Unlisted => (false, None, Some(Why::NotListed)),
            Listing::Other(entry) if entry.chunk == said || !self.index.binds(at) => {
                (true, Some(entry.chunk.span), Some(Why::OtherTimes))
            }
            Listing::Other(entry) => (false, Some(entry.chunk.span), Some(Why::OtherChunk)),
        };
        let (next, messages) = self.message_indexes(end, is_used.then_some(times))?;
        if let Some(why) = why {
            let messages = messages.filter(|_| listed.is_some());
            let loss = Loss::new(at, end, "a chunk", why);
            self.losses.add(loss.spanning(listed).losing(messages));
        }
        if is_used {
            if self.ahead {
                self.begin(next)?;
            }
            let inside = self.delivery.records(self.unpacker.last(), false);
            if let Some(why) = inside.why {
                let lost = (!inside.overrun).then_some(inside.lost);
                let loss = Loss::new(at, end, "a part of a chunk", why);
                self.losses
                    .add(loss.spanning(Some(header.span)).losing(lost));
            }
        }
        Ok(Some(next))
    }

    /// Begins to unpack what comes next, if that is a chunk.
    fn begin(&mut self, at: u64) -> io::Result<()> {
        let Some(prefix) = self.source.prefix(at)? else {
            return Ok(());
        };
        if prefix.opcode == op::CHUNK
            && prefix.end(at) <= self.limit(at)
            && let Some(header) = self.sound_header(at, prefix)?
        {
            let from = at + PREFIX + header.length;
            self.unpacker.begin(&mut self.source, from, header)?;
        }
        Ok(())
    }

    /// Takes a schema or channel outside of chunks, or says why not.
    fn definition(&mut self, at: u64, end: u64, opcode: u8) -> io::Result<Option<Why>> {
        let length = end - at - PREFIX;
        if length > MAX_CHUNK {
            return Ok(Some(Why::TooLarge(length)));
        }
        let body = &self.source.get(at + PREFIX, length)?.to_vec();
        let record = Inner { opcode, body };
        let repeats = self.delivery.fallback.repeats(record);
        let is_sure = repeats == Some(true) || self.section_agrees()?;
        if !is_sure && self.distrust(at, end, None, None) {
            return Ok(None);
        }
        if repeats == Some(false) && self.index.binds(at) {
            return Ok(Some(Why::Contradicted));
        }
        Ok(self.delivery.define(record).err())
    }

    /// A message outside of chunks.
    fn message(&mut self, at: u64, end: u64) -> Next {
        let head = self
            .source
            .peek::<{ MESSAGE_HEADER as usize }>(at + PREFIX)?;
        let log_time = head.and_then(|head| Some(record::message(&head).ok()?.1));
        let span = log_time.map(|time| (time, time));
        if !self.section_agrees()? && self.distrust(at, end, span, Some(1)) {
            return Ok(Some(end));
        }
        let length = end - at - PREFIX;
        let outcome = if length > MAX_CHUNK {
            Err(Why::TooLarge(length))
        } else {
            let body = self.source.get(at + PREFIX, length)?;
            self.delivery.message(body)
        };
        if let Err(why) = outcome {
            self.losses.add_message(at, end, span, why);
        }
        Ok(Some(end))
    }

    /// Passes over the message indexes from `at` on, and reports the messages that they list and that
    /// are not `held` by the chunk before them. Of a chunk that is lost it counts the messages.
    fn message_indexes(
        &mut self,
        mut at: u64,
        mut held: Option<Times>,
    ) -> io::Result<(u64, Option<u64>)> {
        let mut count = None;
        let mut channels = BTreeSet::new();
        let mut missing: Option<Loss> = None;
        while self.source.peek(at)? == Some([op::MESSAGE_INDEX])
            && let Some(end) = self.source.end_of_whole(at)?
            && end <= self.limit(at)
        {
            let (channel, listed) = self.listed(at, end)?;
            let absent = match &mut held {
                // A second index of one channel is another chunk's, which is not there.
                _ if !channels.insert(channel) => listed,
                Some(held) => absent(listed, held.remove(&channel).unwrap_or_default()),
                None => {
                    *count.get_or_insert(0) += listed.len() as u64;
                    Vec::new()
                }
            };
            if let (Some(first), Some(last)) = (absent.first(), absent.last()) {
                let new = || Loss::new(at, at, "message indexes", Why::NotHeld);
                let loss = missing.get_or_insert_with(new);
                loss.bytes = end - loss.offset;
                loss.span = wider(loss.span, Some((*first, *last)));
                *loss.messages.get_or_insert(0) += absent.len() as u64;
            }
            self.previous = at;
            at = end;
        }
        if let Some(loss) = missing {
            self.losses.add(loss);
        }
        Ok((at, count))
    }

    /// The channel of a message index, and the log times that it lists, sorted.
    fn listed(&mut self, at: u64, end: u64) -> io::Result<(u16, Vec<u64>)> {
        /// No chunk has room for more messages.
        const MOST: u64 = MAX_CHUNK / (PREFIX + MESSAGE_HEADER);
        const PIECE: u64 = 4096 * INDEX_ENTRY;
        let channel = self.source.peek(at + PREFIX)?.map_or(0, u16::from_le_bytes);
        let begin = at + PREFIX + INDEX_HEADER;
        let end = end.min(begin + MOST * INDEX_ENTRY);
        let mut times = Vec::new();
        for from in (begin..end).step_by(PIECE as usize) {
            let entries = self.source.get(from, PIECE.min(end - from))?;
            let entries = entries.chunks_exact(INDEX_ENTRY as usize);
            times.extend(entries.filter_map(|entry| Fields(entry).u64().ok()));
        }
        times.sort_unstable();
        Ok((channel, times))
    }

    /// Whether the data section's checksum does not speak against what only it covers.
    fn section_agrees(&mut self) -> io::Result<bool> {
        if let Some(agrees) = self.section {
            return Ok(agrees);
        }
        let agrees = match self.tail.data_end {
            Some(data_end) => data_agrees(&mut self.source, self.index.begin(), data_end)?,
            None => true,
        };
        self.section = Some(agrees);
        Ok(agrees)
    }

    /// Reports what the data section's checksum speaks against; whether it is to be left out.
    fn distrust(
        &mut self,
        at: u64,
        end: u64,
        span: Option<(u64, u64)>,
        messages: Option<u64>,
    ) -> bool {
        let (why, left_out) = match self.unchecked {
            Unchecked::LeftOut => (Why::DataSection, true),
            Unchecked::Used => (Why::Unchecked, false),
        };
        let new = || Loss::new(at, at, "all that has no checksum of its own", why);
        let loss = self.distrusted.get_or_insert_with(new);
        loss.bytes = end.saturating_sub(loss.offset);
        loss.span = wider(loss.span, span);
        if let Some(more) = messages.filter(|_| left_out) {
            *loss.messages.get_or_insert(0) += more;
        }
        left_out
    }

    /// Reports a chunk that cannot be used, and goes on behind it, or within it where another record
    /// proves that it ends earlier than it says.
    fn lose_chunk(&mut self, at: u64, end: u64, span: Option<(u64, u64)>, why: Why) -> Next {
        self.chunked = true;
        let next = match why {
            // Nothing speaks against the length of these.
            Why::Compression(_) | Why::TooLarge(_) | Why::Bomb(_) => end,
            _ if self.leads_on(end, CHAIN)? => end,
            _ => self.search(at + 1, end, end)?.unwrap_or(end),
        };
        let (behind, messages) = if next == end {
            self.message_indexes(end, None)?
        } else {
            (next, None)
        };
        let entry = self.index.lose(at);
        let span = entry.map(|entry| entry.chunk.span).or(span);
        let loss = Loss::new(at, next, "a chunk", why);
        self.losses.add(loss.spanning(span).losing(messages));
        Ok(Some(behind))
    }

    /// Reports damage where a record should begin, and goes on at the next one that proves itself.
    fn go_on(&mut self, at: u64, prefix: Prefix) -> Next {
        let length = self.source.length();
        if let Some(entry) = self.index.at(at) {
            let end = at.saturating_add(entry.chunk.length);
            if end <= self.limit(at) && self.leads_on(end, CHAIN)? {
                return self.lose_chunk(at, end, None, Why::NotIndexed(entry.chunk.length));
            }
        }
        if self.runs_beyond_the_file(at, prefix)? {
            self.cut_off(at, prefix)?;
            return Ok(Some(length));
        }
        // The record before may have lost bytes, and run over this one's beginning.
        let limit = self.limit(at + 1);
        let previous = std::mem::replace(&mut self.previous, at);
        let next = self.search(previous + 1, limit, at)?.unwrap_or(limit);
        let from = if next < at { previous } else { at };
        let why = match prefix.opcode {
            _ if self.source.is_zero(from, next)? => Why::Zeros,
            op::DATA_END | op::FOOTER => Why::Joined,
            _ => Why::Prefix,
        };
        let entry = self.index.lose(at);
        let what = match prefix.opcode {
            _ if entry.is_some() => "a chunk",
            op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA => kind(prefix.opcode),
            _ if next == length => "everything to the end of the file",
            _ => "a part",
        };
        let loss = Loss::new(from, next, what, why);
        self.losses
            .add(loss.spanning(entry.map(|entry| entry.chunk.span)));
        Ok(Some(next))
    }

    /// Whether a record announces more bytes than the file has, so that all that follows is its own,
    /// whatever that looks like. Where the file ends as it should, that may be the end of a log in it.
    fn runs_beyond_the_file(&mut self, at: u64, prefix: Prefix) -> io::Result<bool> {
        /// No record is as long.
        const ABSURD: u64 = 1 << 40;
        if self.index.binds(at) || !prefix.is_possible() {
            return Ok(false);
        }
        let length = Some(prefix.end(at));
        let fields = self.source.end_of_fields(at, prefix.opcode)?;
        let is_beyond = |end: &u64| *end > self.source.length() && *end - at < ABSURD;
        let [length, fields] = [length, fields].map(|end| end.filter(is_beyond));
        let holds_anything = matches!(prefix.opcode, op::ATTACHMENT | op::METADATA);
        Ok(match self.tail.magic {
            true => holds_anything && length.is_some() && length == fields,
            false => length.or(fields).is_some(),
        })
    }

    /// The first record in `from..to` that proves itself. Of what lies in the bytes up to `within` only what
    /// runs over their end does.
    fn search(&mut self, from: u64, to: u64, within: u64) -> io::Result<Option<u64>> {
        let indexed = self.index.next(from).filter(|place| *place < to);
        let stop = indexed.unwrap_or(to);
        let mut at = from;
        while let Some(candidate) = self.source.next_candidate(at, stop)? {
            if self.proves_itself(candidate, within)? {
                return Ok(Some(candidate));
            }
            at = candidate + 1;
        }
        Ok(indexed)
    }

    fn proves_itself(&mut self, at: u64, within: u64) -> io::Result<bool> {
        let prefix = self.source.prefix(at)?;
        let Some(prefix) = prefix.filter(|prefix| prefix.end(at) > within) else {
            return Ok(false);
        };
        match prefix.opcode {
            op::CHUNK => self.chunk_proves_itself(at, prefix),
            op::DATA_END if self.tail.data_end.is_none() => {
                self.source.ends_data(at, !self.tail.magic)
            }
            // A damaged chunk may hold what looks like these.
            op::SCHEMA | op::CHANNEL if !self.chunked => self.leads_on(at, CHAIN),
            op::MESSAGE if !self.chunked => {
                let id = self.source.peek(at + PREFIX)?.map(u16::from_le_bytes);
                Ok(id.is_some_and(|id| self.delivery.knows(id)) && self.leads_on(at, CHAIN)?)
            }
            _ => Ok(false),
        }
    }

    /// A chunk proves itself by the index, where there is one that binds, or else by its checksum, or
    /// without one by what follows.
    fn chunk_proves_itself(&mut self, at: u64, prefix: Prefix) -> io::Result<bool> {
        let Some(header) = self.sound_header(at, prefix)? else {
            return Ok(false);
        };
        let end = prefix.end(at);
        if self.index.binds(at) {
            return Ok(self.index.lists(at, header.identity()));
        }
        if end > self.source.length() {
            return Ok(!self.tail.magic); // the last one, which was cut off
        }
        if header.checksum == 0 {
            return self.leads_on(end, CHAIN);
        }
        let from = at + PREFIX + header.length;
        self.unpacker.proves(&mut self.source, from, &header)
    }

    /// The header of what may be a chunk, if it says the same of its length as the record does.
    fn sound_header(&mut self, at: u64, prefix: Prefix) -> io::Result<Option<ChunkHeader>> {
        let header = self.source.chunk_header(at)?;
        Ok(header.filter(|header| {
            header.length.checked_add(header.compressed) == Some(prefix.length)
                && header.uncompressed.max(header.compressed) <= MAX_CHUNK
                && matches!(header.compression.as_str(), "" | "zstd" | "lz4")
        }))
    }

    /// Reports a record that the file ends within, and uses what there is of a chunk.
    fn cut_off(&mut self, at: u64, prefix: Prefix) -> io::Result<()> {
        let length = self.source.length();
        let what = match prefix.opcode {
            op::CHUNK => "the last chunk",
            op::MESSAGE => "the last message",
            opcode => kind(opcode),
        };
        let loss = |why| Loss::new(at, length, what, why);
        let header = match prefix.opcode {
            op::CHUNK => self.sound_header(at, prefix)?,
            _ => None,
        };
        let Some(header) = header else {
            self.losses.add(loss(Why::Cut));
            return Ok(());
        };
        self.chunked = true;
        let before = self.delivery.messages;
        let from = at + PREFIX + header.length;
        let present = ChunkHeader {
            compressed: length.saturating_sub(from),
            ..header
        };
        let why = match self.unpacker.beginning(&mut self.source, from, &present)? {
            Err(why) => why,
            Ok(records) => {
                self.delivery.records(records, true);
                match self.delivery.messages - before {
                    0 => Why::Cut,
                    used => Why::CutOff { used },
                }
            }
        };
        self.losses.add(loss(why).spanning(Some(present.span)));
        Ok(())
    }

    /// The file's end, before the data section's.
    fn end(&mut self, at: u64) -> Next {
        let length = self.source.length();
        if at < length {
            let why = match self.source.is_zero(at, length)? {
                true => Why::Zeros,
                false => Why::Cut,
            };
            self.losses.add(Loss::new(at, length, "a record", why));
        } else if !self.losses.reach(length) {
            let loss = Loss::new(length, length, "the end", Why::NoFooter);
            self.losses.add(loss);
        }
        Ok(None)
    }

    /// What follows the data section: the summary, and what should not be there.
    fn close(&mut self, summary: u64) -> Next {
        let length = self.source.length();
        if self.tail.footer {
            if self.tail.damaged {
                let loss = Loss::new(summary, length, SUMMARY, Why::Summary);
                self.losses.add(loss);
            }
            return Ok(None);
        }
        let mut at = summary;
        while let Some(prefix) = self.source.prefix(at)?
            && prefix.is_possible()
            && prefix.end(at) <= length
        {
            at = prefix.end(at);
            if prefix.opcode == op::FOOTER && self.source.peek(at)? == Some(MAGIC) {
                let end = at + MAGIC_LENGTH;
                let why = match self.source.is_zero(end, length)? {
                    true => Why::Zeros,
                    false => Why::Trailing,
                };
                self.losses.add(Loss::new(end, length, BEHIND, why));
                return Ok(None);
            }
        }
        let why = match self.tail.magic {
            true => Why::Summary,
            false => Why::NoFooter,
        };
        self.losses.add(Loss::new(summary, length, SUMMARY, why));
        Ok(None)
    }

    /// Reports what the walk has not shown: chunks of the index that are not there, a wrong number of
    /// messages, or else a wrong checksum over everything.
    fn compare(&mut self) -> io::Result<()> {
        if let Some(loss) = self.distrusted.take() {
            self.losses.add(loss);
        }
        let length = self.source.length();
        for ChunkIndex { chunk, offset } in self.index.rest() {
            let from = offset.min(length);
            let to = from.saturating_add(chunk.length).min(length);
            let loss = Loss::new(from, to, "a chunk", Why::NotIndexed(chunk.length));
            self.losses.add(loss.spanning(Some(chunk.span)));
        }
        let summary = self.tail.summary.as_ref();
        let counted = summary.and_then(|summary| summary.messages);
        let read = self.delivery.messages;
        if let Some(counted) = counted.filter(|counted| *counted != read) {
            // What the losses do not say of how much is missing.
            let missing = counted.checked_sub(read);
            let known = self.losses.any().then(|| self.losses.messages());
            if known.is_none_or(|known| missing.is_some_and(|missing| missing > known)) {
                let what = match known {
                    Some(_) => "the file as a whole",
                    None => "the number of messages is wrong",
                };
                let loss = Loss::new(0, 0, what, Why::Count { counted, read });
                self.losses.add(loss.losing(missing));
            }
        }
        if !self.losses.any() && !self.section_agrees()? {
            let (begin, end) = (self.index.begin(), self.limit(0));
            let what = "the data section";
            let loss = Loss::new(begin, end, what, Why::BetweenChunks);
            self.losses.add(loss);
        }
        Ok(())
    }
}

/// What a record is called.
fn kind(opcode: u8) -> &'static str {
    match opcode {
        op::SCHEMA | op::CHANNEL => "a definition",
        op::MESSAGE_INDEX => "a message index",
        op::ATTACHMENT => "an attachment",
        op::METADATA => "a metadata record",
        _ => "a record",
    }
}

/// The times listed, one by one, that are not among those held.
fn absent(listed: Vec<u64>, mut held: Vec<u64>) -> Vec<u64> {
    held.sort_unstable();
    let mut held = held.into_iter().peekable();
    let is_absent = |time: &u64| {
        while held.next_if(|held| held < time).is_some() {}
        held.next_if_eq(time).is_none()
    };
    listed.into_iter().filter(is_absent).collect()
}
