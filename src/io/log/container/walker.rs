//! One record after the other, from the header to the end of the data.
//!
//! What follows a damaged one is in `recover`.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;

use super::border::{self, CHAIN, Prefix};
use super::channels::{Delivery, Visit};
use super::chunk::{self, Times, Unpacker};
use super::index::{Index, Listing};
use super::loss::{Loss, Losses, Why, wider};
use super::record::{
    self, DATA_END, Fields, INDEX_ENTRY, INDEX_HEADER, Inner, MAGIC, MAGIC_LENGTH, MAX_CHUNK,
    MESSAGE_HEADER, PREFIX, op,
};
use super::source::Source;
use super::tail::{Tail, data_agrees};

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
    NotMcap,
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
    // Opening a pipe would wait for a writer.
    let metadata = std::fs::metadata(path)?;
    let kind = metadata.file_type();
    if kind.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory).into());
    }
    if !kind.is_file() {
        return Err(OpenError::NoFile);
    }
    if metadata.len() == 0 {
        return Err(OpenError::Empty);
    }
    walk_in(File::open(path)?, unchecked, visit)
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
pub struct Walker<'v, R> {
    pub(super) source: Source<R>,
    pub(super) tail: Tail,
    pub(super) index: Index,
    pub(super) unpacker: Unpacker,
    pub(super) delivery: Delivery<'v>,
    pub(super) losses: Losses,
    /// Whether the file has chunks.
    pub(super) chunked: bool,
    /// Where the last record begins that only its own length and fields vouch for.
    pub(super) previous: u64,
    /// Whether the data section's checksum agrees, once that was asked.
    section: Option<bool>,
    unchecked: Unchecked,
    /// How many more times a second log is looked for.
    pub(super) joints: u8,
    /// What no checksum vouches for.
    distrusted: Option<Loss>,
}

/// Where to go on; `None` at the end.
pub(super) type Next = io::Result<Option<u64>>;

/// Where a record ends, and what says so.
#[derive(Clone, Copy)]
struct Border {
    end: u64,
    told_by: ToldBy,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ToldBy {
    Both,
    Length,
    Fields,
}

impl<'v, R: Read + Seek> Walker<'v, R> {
    fn new(input: R, unchecked: Unchecked, visit: &'v mut Visit<'v>) -> Result<Self, OpenError> {
        let mut source = Source::new(input)?;
        let mut tail = Tail::read(&mut source)?;
        let begins = source.peek(0)? == Some(MAGIC);
        if !(begins || tail.footer) {
            return Err(OpenError::NotMcap);
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
            joints: 64,
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
    pub(super) fn limit(&self, at: u64) -> u64 {
        let limit = self.tail.limit.filter(|limit| *limit >= at);
        limit.unwrap_or(self.source.length())
    }

    pub(super) fn leads_on(&mut self, at: u64, records: usize) -> io::Result<bool> {
        border::leads_on(&mut self.source, at, records, !self.tail.magic)
    }

    fn step(&mut self, at: u64) -> Next {
        if self.tail.limit == Some(at) && self.tail.data_end != Some(at) {
            return self.close(at);
        }
        let Some(prefix) = border::prefix(&mut self.source, at)? else {
            return self.end(at);
        };
        match prefix.opcode {
            op::DATA_END if self.ends_data(at)? => return self.close(at + DATA_END),
            op::FOOTER if self.ends_file(prefix, at)? => return self.close(at),
            op::DATA_END | op::FOOTER => {
                if let Some(next) = self.behind_joint(at)? {
                    return Ok(Some(next));
                }
            }
            _ => {}
        }
        let Some(border) = self.border(at, prefix)? else {
            return self.go_on(at, prefix);
        };
        self.previous = at;
        let end = border.end;
        if border.told_by == ToldBy::Length
            && border::end_of_fields(&mut self.source, at, op::CHUNK)? == Some(end)
        {
            return self.lose_chunk(at, end, None, Why::Kind(prefix.opcode));
        }
        if border.told_by == ToldBy::Fields && prefix.opcode != op::CHUNK {
            let what = kind(prefix.opcode);
            self.losses.add(Loss::new(at, end - at, what, Why::Length));
        }
        match prefix.opcode {
            op::CHUNK => return self.chunk(at, border),
            op::SCHEMA | op::CHANNEL => self.definition(at, end, prefix.opcode)?,
            op::MESSAGE => self.message(at, end)?,
            op::MESSAGE_INDEX if border.told_by == ToldBy::Both => {
                return Ok(Some(self.message_indexes(at, Some(Times::new()))?.0));
            }
            op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA
                if border.told_by != ToldBy::Length => {}
            op::PRIVATE.. => {}
            op::HEADER if self.source.peek(at - MAGIC_LENGTH)? == Some(MAGIC) => {}
            opcode => {
                let why = match opcode {
                    op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA => Why::Malformed,
                    _ => Why::Kind(opcode),
                };
                self.losses.add(Loss::new(at, end - at, kind(opcode), why));
            }
        }
        Ok(Some(end))
    }

    /// Where a record ends: where its length and its fields say, or the one of them that leads on.
    /// The fields come first, since a length that is too large may lead on behind other records.
    fn border(&mut self, at: u64, prefix: Prefix) -> io::Result<Option<Border>> {
        let limit = self.limit(at);
        let fields = border::end_of_fields(&mut self.source, at, prefix.opcode)?;
        let fields = fields.filter(|end| *end <= limit);
        let length = Some(prefix.end(at)).filter(|end| prefix.is_possible() && *end <= limit);
        let told = |end, told_by| Some(Border { end, told_by });
        match (fields, length) {
            (Some(fields), Some(length)) if fields == length => Ok(told(length, ToldBy::Both)),
            (Some(end), _) if self.leads_on(end, CHAIN)? => Ok(told(end, ToldBy::Fields)),
            (_, Some(end)) if self.leaves_a_trace(end)? => Ok(told(end, ToldBy::Length)),
            _ => Ok(None),
        }
    }

    /// Whether a record begins there, or one that is damaged: by its length, its fields or its channel.
    fn leaves_a_trace(&mut self, at: u64) -> io::Result<bool> {
        let Some(prefix) = border::prefix(&mut self.source, at)? else {
            return self.leads_on(at, 1);
        };
        let channel = self.source.peek(at + PREFIX)?.map(u16::from_le_bytes);
        if prefix.opcode == op::MESSAGE && channel.is_some_and(|id| self.delivery.knows(id)) {
            return Ok(true);
        }
        let fields = border::end_of_fields(&mut self.source, at, prefix.opcode)?;
        for end in [Some(prefix.end(at)), fields].into_iter().flatten() {
            if end < self.source.length() && self.leads_on(end, 1)? {
                return Ok(true);
            }
        }
        self.leads_on(at, 1)
    }

    fn ends_data(&mut self, at: u64) -> io::Result<bool> {
        match self.tail.data_end {
            Some(data_end) => Ok(data_end == at),
            None => border::ends_data(&mut self.source, at, !self.tail.magic),
        }
    }

    /// Whether a record is a footer that ends the file, or may do so where nothing else does.
    fn ends_file(&mut self, prefix: Prefix, at: u64) -> io::Result<bool> {
        let end = prefix.end(at);
        let is_footer = prefix.length == 20 && self.source.peek(end)? == Some(MAGIC);
        let is_last = end.saturating_add(MAGIC_LENGTH) == self.source.length();
        Ok(is_footer && (is_last || !self.tail.footer))
    }

    fn chunk(&mut self, at: u64, border: Border) -> Next {
        self.chunked = true;
        let Border { end, told_by } = border;
        let header = border::chunk_header(&mut self.source, at)?;
        let is_sure = |checksum| match told_by {
            ToldBy::Both => true,
            ToldBy::Fields => checksum != 0,
            ToldBy::Length => false,
        };
        let Some(header) = header.filter(|header| is_sure(header.checksum)) else {
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
        match self
            .index
            .meet(at, chunk::span(&times), header.uncompressed)
        {
            Listing::Listed => {}
            Listing::Unlisted => {
                let loss = Loss::new(at, end - at, "a chunk", Why::NotListed);
                self.losses.add(loss);
                return Ok(Some(self.message_indexes(end, None)?.0));
            }
            Listing::Other(entry) => {
                let is_used = entry.span == header.span || !self.index.binds(at);
                let (next, messages) = self.message_indexes(end, None)?;
                let why = if is_used {
                    Why::OtherTimes
                } else {
                    Why::OtherChunk
                };
                self.losses.add(Loss {
                    span: Some(entry.span),
                    messages: messages.filter(|_| !is_used),
                    ..Loss::new(at, end - at, "a chunk", why)
                });
                if !is_used {
                    return Ok(Some(next));
                }
            }
        }
        if told_by == ToldBy::Fields {
            self.losses
                .add(Loss::new(at, end - at, "a chunk", Why::Length));
        }
        let next = self.message_indexes(end, Some(times))?.0;
        let inside = self.delivery.records(self.unpacker.last(), false);
        if let Some(why) = inside.why {
            self.losses.add(Loss {
                span: Some(header.span),
                messages: (!inside.overrun).then_some(inside.lost),
                ..Loss::new(at, end - at, "a part of a chunk", why)
            });
        }
        Ok(Some(next))
    }

    /// A schema or channel outside of chunks.
    fn definition(&mut self, at: u64, end: u64, opcode: u8) -> io::Result<()> {
        let length = end - at - PREFIX;
        let outcome = if length > MAX_CHUNK {
            Err(Why::TooLarge(length))
        } else {
            let body = &self.source.get(at + PREFIX, length)?.to_vec();
            let record = Inner { opcode, body };
            let is_sure = self.delivery.fallback.repeats(record) || self.section_agrees()?;
            if !is_sure && self.distrust(at, end, None, None) {
                return Ok(());
            }
            self.delivery.define(record)
        };
        if let Err(why) = outcome {
            let what = kind(opcode);
            self.losses.add(Loss::new(at, end - at, what, why));
        }
        Ok(())
    }

    /// A message outside of chunks.
    fn message(&mut self, at: u64, end: u64) -> io::Result<()> {
        let head = self
            .source
            .peek::<{ MESSAGE_HEADER as usize }>(at + PREFIX)?;
        let log_time = head.and_then(|head| Some(record::message(&head).ok()?.1));
        if !self.section_agrees()?
            && self.distrust(at, end, log_time.map(|time| (time, time)), Some(1))
        {
            return Ok(());
        }
        let length = end - at - PREFIX;
        let outcome = if length > MAX_CHUNK {
            Err(Why::TooLarge(length))
        } else {
            let body = self.source.get(at + PREFIX, length)?;
            self.delivery.message(body)
        };
        if let Err(why) = outcome {
            self.losses.add_message(at, end, log_time, why);
        }
        Ok(())
    }

    /// Passes over the message indexes from `at` on, and reports the messages that they list and that
    /// are not `held` by the chunk before them. Of a chunk that is lost it counts the messages.
    pub(super) fn message_indexes(
        &mut self,
        mut at: u64,
        mut held: Option<Times>,
    ) -> io::Result<(u64, Option<u64>)> {
        let mut count = None;
        let mut channels = BTreeSet::new();
        let mut missing: Option<Loss> = None;
        while self.source.peek(at)? == Some([op::MESSAGE_INDEX])
            && let Some(end) = border::end_of_whole(&mut self.source, at)?
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
                let new = || Loss::new(at, 0, "message indexes", Why::NotHeld);
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
        let new = || Loss::new(at, 0, "all that has no checksum of its own", why);
        let loss = self.distrusted.get_or_insert_with(new);
        loss.bytes = end.saturating_sub(loss.offset);
        loss.span = wider(loss.span, span);
        if let Some(more) = messages.filter(|_| left_out) {
            loss.messages = Some(loss.messages.unwrap_or_default().saturating_add(more));
        }
        left_out
    }

    /// Reports what the walk has not shown: chunks of the index that are not there, a wrong number of
    /// messages, or else a wrong checksum over everything.
    fn compare(&mut self) -> io::Result<()> {
        if let Some(loss) = self.distrusted.take() {
            self.losses.add(loss);
        }
        let length = self.source.length();
        for entry in self.index.rest() {
            let offset = entry.offset.min(length);
            let bytes = entry.length.min(length - offset);
            self.losses.add(Loss {
                span: Some(entry.span),
                ..Loss::new(offset, bytes, "a chunk", Why::NotIndexed(entry.length))
            });
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
                self.losses.add(Loss {
                    messages: missing,
                    ..Loss::new(0, 0, what, Why::Count { counted, read })
                });
            }
        }
        if !self.losses.any() && !self.section_agrees()? {
            let (begin, end) = (self.index.begin(), self.limit(0));
            let what = "the data section";
            let loss = Loss::new(begin, end - begin, what, Why::BetweenChunks);
            self.losses.add(loss);
        }
        Ok(())
    }
}

/// What a record is called.
pub(super) fn kind(opcode: u8) -> &'static str {
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
