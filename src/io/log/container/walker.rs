//! One record after the other.
//!
//! What to do about a damaged one is in `recover`.

use std::io::{Read, Seek};

use super::chunk::Unpacker;
use super::loss::{Loss, Why};
use super::losses::Losses;
use super::place::{Places, is_chunk};
use super::record::{self, ChunkHeader, Inner, PREFIX, op};
use super::scan::{self, Prefix, is_data_end};
use super::source::Source;
use super::tail::{DATA_END, Tail};
use super::used::{Used, Visit};
use super::{MAGIC, MAX_CHUNK, OpenError, Unchecked};

/// Walks over a file.
pub struct Walker<'v, R> {
    pub(super) source: Source<R>,
    pub(super) tail: Tail,
    pub(super) places: Places,
    pub(super) unpacker: Unpacker,
    pub(super) used: Used<'v>,
    pub(super) losses: Losses,
    /// Whether the file has chunks.
    pub(super) chunked: bool,
    /// Behind the last chunk that was used or given up: no chunk before here is missing.
    pub(super) passed: u64,
    /// Whether the data section's checksum agrees, once that was asked.
    pub(super) section: Option<bool>,
    pub(super) unchecked: Unchecked,
    /// How many more times a second log is looked for.
    pub(super) joints: u8,
    /// How many more times records are looked for within a message whose length is in doubt.
    pub(super) looks: u16,
    /// What no checksum vouches for.
    pub(super) distrusted: Option<Loss>,
}

/// Bytes of a message before its content.
pub(super) const MESSAGE_HEADER: usize = 22;

/// Where to go on; `None` at the end.
pub(super) type Next = Result<Option<u64>, OpenError>;

impl<'v, R: Read + Seek> Walker<'v, R> {
    /// Opens a file: its magic bytes and its tail.
    pub fn new(
        input: R,
        unchecked: Unchecked,
        visit: &'v mut Visit<'v>,
    ) -> Result<Self, OpenError> {
        let mut source = Source::new(input)?;
        let mut tail = Tail::read(&mut source)?;
        let begins = source.peek(0)? == Some(MAGIC);
        if !(begins || tail.footer) {
            return Err(OpenError::NotMcap);
        }
        let mut losses = Losses::default();
        if !begins {
            let what = "the beginning of the file";
            losses.add(Loss::new(0, MAGIC.len() as u64, what, Why::Magic));
        }
        let mut places = Places::default();
        let mut fallback = None;
        if let Some(summary) = &mut tail.summary {
            places = Places::find(&mut source, summary)?;
            fallback = Some(std::mem::take(&mut summary.registry));
        }
        Ok(Self {
            unpacker: Unpacker::new(source.length()),
            chunked: places.any(),
            source,
            tail,
            places,
            used: Used::new(fallback.unwrap_or_default(), visit),
            losses,
            passed: MAGIC.len() as u64,
            section: None,
            unchecked,
            joints: 64,
            looks: 256,
            distrusted: None,
        })
    }

    /// Walks to the end.
    pub fn run(mut self) -> Result<Vec<Loss>, OpenError> {
        let mut at = MAGIC.len() as u64;
        loop {
            let next = self.step(at)?;
            self.losses.date(self.used.next.take(), self.used.last);
            match next {
                Some(next) => at = next,
                None => break,
            }
        }
        if let Some(loss) = self.distrusted.take() {
            self.losses.add(loss);
        }
        self.compare()?;
        let start = self.tail.summary.as_ref().and_then(|summary| summary.start);
        let start = self.used.start.into_iter().chain(start).min();
        Ok(self.losses.finish(start))
    }

    /// Where the data section ends at the latest.
    pub(super) fn limit(&self, at: u64) -> u64 {
        self.tail
            .limit
            .filter(|limit| *limit >= at)
            .unwrap_or(self.source.length())
    }

    fn step(&mut self, at: u64) -> Next {
        if self.tail.limit == Some(at) && self.tail.data_end != Some(at) {
            return self.close(at);
        }
        let length = self.source.length();
        if at >= length {
            return self.end(at);
        }
        let Some(prefix) = scan::prefix(&mut self.source, at)? else {
            return self.end(at);
        };
        let end = prefix.end(at);
        if !prefix.is_possible() || self.is_denied(at, prefix)? {
            return self.go_on(at, None);
        }
        match prefix.opcode {
            op::DATA_END if self.ends_data(at)? => return self.close(at + DATA_END),
            op::FOOTER if self.ends_file(prefix, end)? => return self.close(at),
            op::DATA_END | op::FOOTER => {
                return match self.behind_joint(at)? {
                    Some(next) => Ok(Some(next)),
                    None => self.go_on(at, None),
                };
            }
            _ => {}
        }
        if let Some(next) = self.behind_fields(at, prefix)? {
            return Ok(Some(next));
        }
        if end > length && !self.tail.magic {
            return self.cut_off(at, prefix);
        }
        if end > self.limit(at) {
            return self.go_on(at, None);
        }
        match prefix.opcode {
            op::CHUNK => self.chunk(at, prefix),
            // Outside of chunks, and behind damage, they are more likely the inside of a damaged one.
            op::SCHEMA | op::CHANNEL | op::MESSAGE if self.chunked && self.losses.any() => {
                self.go_on(at, None)
            }
            op::SCHEMA | op::CHANNEL => self.definition(at, prefix),
            op::MESSAGE => self.message(at, prefix),
            _ => self.pass_over(at, prefix),
        }
    }

    /// Whether a data end record stands where the data section ends.
    fn ends_data(&mut self, at: u64) -> Result<bool, OpenError> {
        Ok(match self.tail.data_end {
            Some(data_end) => data_end == at,
            None => is_data_end(&mut self.source, at)?,
        })
    }

    /// Whether a record is a footer that ends the file, or may do so where nothing else does.
    fn ends_file(&mut self, prefix: Prefix, end: u64) -> Result<bool, OpenError> {
        let is_footer = prefix.length == 20 && self.source.peek(end)? == Some(MAGIC);
        let is_last = end.saturating_add(MAGIC.len() as u64) == self.source.length();
        Ok(is_footer && (is_last || !self.tail.footer))
    }

    fn chunk(&mut self, at: u64, prefix: Prefix) -> Next {
        self.chunked = true;
        let end = prefix.end(at);
        let head = ChunkHeader::ROOM.min(prefix.length);
        let header = ChunkHeader::parse(self.source.get(at + PREFIX, head)?);
        let Some(header) = header.ok().filter(|header| header.fills(prefix.length)) else {
            return self.lose_chunk(at, end, None, Why::Header);
        };
        if header.checksum == 0 && header.compressed > 0 && !self.section_agrees()? {
            let count = self.indexed_messages(end)?;
            if self.distrust(at, end, Some(header.span), count) {
                return Ok(Some(end));
            }
        }
        let from = at + PREFIX + header.length;
        match self.unpacker.records(&mut self.source, from, &header)? {
            Err(why) => self.lose_chunk(at, end, Some(header.span), why),
            Ok(records) => {
                self.passed = end;
                let inside = self.used.records(records, false);
                if let Some(why) = inside.why {
                    let what = "a part of a chunk";
                    self.losses.add(Loss {
                        span: Some(header.span),
                        messages: (!inside.overrun).then_some(inside.lost),
                        ..Loss::new(at, end - at, what, why)
                    });
                }
                Ok(Some(end))
            }
        }
    }

    fn definition(&mut self, at: u64, prefix: Prefix) -> Next {
        let end = prefix.end(at);
        // A length that leads nowhere, or past other records, is wrong.
        if !self.chunked
            && !self.fills(at, prefix)?
            && (!self.could_begin(end)? || self.runs_over(at, end)?)
        {
            return self.go_on(at, Some(end));
        }
        let outcome = if prefix.length > MAX_CHUNK {
            Err(Why::TooLarge(prefix.length))
        } else {
            self.used.define(Inner {
                opcode: prefix.opcode,
                body: self.source.get(at + PREFIX, prefix.length)?,
            })
        };
        if let Err(why) = outcome {
            self.losses
                .add(Loss::new(at, end - at, "a definition", why));
        }
        Ok(Some(end))
    }

    /// A message outside of chunks.
    fn message(&mut self, at: u64, prefix: Prefix) -> Next {
        let end = prefix.end(at);
        let head = self.source.peek::<MESSAGE_HEADER>(at + PREFIX)?;
        let log_time = head.and_then(|head| Some(record::message(&head).ok()?.1));
        if !self.section_agrees()?
            && self.distrust(at, end, log_time.map(|time| (time, time)), Some(1))
        {
            return Ok(Some(end));
        }
        // What damaged the record behind it may have begun within it.
        if !self.could_begin(end)?
            && !self.keeps_a_trace(end, log_time)?
            && !self.is_by_fields(end)?
        {
            return self.go_on(at, Some(end));
        }
        let outcome = if prefix.length > MAX_CHUNK {
            Err(Why::TooLarge(prefix.length))
        } else {
            let body = self.source.get(at + PREFIX, prefix.length)?;
            self.used.message(body)
        };
        if let Err(why) = outcome {
            self.losses.add_message(at, end, log_time, why);
        }
        Ok(Some(end))
    }

    /// A record of which nothing is used.
    fn pass_over(&mut self, at: u64, prefix: Prefix) -> Next {
        let end = prefix.end(at);
        if self.was_message(at, prefix)? {
            if !self.could_begin(end)? {
                return self.go_on(at, None);
            }
            self.losses.add(Loss {
                messages: Some(1),
                ..Loss::new(at, end - at, "a message", Why::Kind(prefix.opcode))
            });
            return Ok(Some(end));
        }
        if is_chunk(&mut self.source, at + PREFIX, prefix.length)? {
            return self.lose_chunk(at, end, None, Why::Prefix);
        }
        // A length that leads nowhere may have led past something.
        if self.could_begin(end)? || self.is_by_fields(end)? {
            Ok(Some(end))
        } else {
            self.go_on(at, None)
        }
    }

    /// Whether a record could begin there, or the file ends.
    pub(super) fn could_begin(&mut self, at: u64) -> Result<bool, OpenError> {
        let length = self.source.length();
        Ok(scan::prefix(&mut self.source, at)?
            .is_none_or(|next| next.is_possible() && (next.end(at) <= length || !self.tail.magic)))
    }
}
