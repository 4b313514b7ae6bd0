//! Messages and records whose borders are in doubt, outside of chunks.

use std::io::{self, Read, Seek};

use super::OpenError;
use super::extent;
use super::loss::{Loss, Why};
use super::record::{self, Inner, PREFIX, op};
use super::scan::{self, LARGEST_DEFINITION, Prefix, Sought, next_record};
use super::source::Source;
use super::walker::{MESSAGE_HEADER, Walker};

/// Messages next to each other are logged within a day, nanoseconds.
const NEAR: u64 = 86_400_000_000_000;

impl<R: Read + Seek> Walker<'_, R> {
    /// Whether the record that is damaged `at` some place plainly begins there all the same, by its
    /// kind and what follows its length, or by its length alone: then the damage began there, and
    /// the message logged at `log_time` before it ended well.
    pub(super) fn keeps_a_trace(
        &mut self,
        at: u64,
        log_time: Option<u64>,
    ) -> Result<bool, OpenError> {
        let Some(prefix) = scan::prefix(&mut self.source, at)? else {
            return Ok(false);
        };
        let head = self.source.peek::<MESSAGE_HEADER>(at + PREFIX)?;
        let Some((id, time, _)) = head.as_ref().and_then(|head| record::message(head).ok()) else {
            return Ok(false);
        };
        let is_known = self.used.known().iter().any(|known| known.knows(id));
        let is_near = log_time.is_some_and(|logged| logged.abs_diff(time) < NEAR);
        let next = prefix.end(at);
        let is_usual =
            |next: Prefix| matches!(next.opcode, op::SCHEMA..=op::MESSAGE | op::DATA_END);
        let leads_on = scan::prefix(&mut self.source, next)?.is_some_and(is_usual)
            && self.could_begin(next)?;
        Ok(is_known && is_near && (prefix.opcode == op::MESSAGE || leads_on))
    }

    /// Whether a record of another kind was a message before it was damaged: one outside of chunks, of
    /// a known channel and logged near the last one.
    pub(super) fn was_message(&mut self, at: u64, prefix: Prefix) -> Result<bool, OpenError> {
        if self.chunked || self.used.messages == 0 || prefix.length < MESSAGE_HEADER as u64 {
            return Ok(false);
        }
        match prefix.opcode {
            // These stand beside chunks or behind the data, and it has not come to either.
            op::HEADER
            | op::MESSAGE_INDEX
            | op::CHUNK_INDEX
            | op::ATTACHMENT_INDEX
            | op::STATISTICS
            | op::METADATA_INDEX
            | op::SUMMARY_OFFSET => return Ok(true),
            op::ATTACHMENT | op::METADATA if self.fields_fill(at, prefix)? => return Ok(false),
            _ => {}
        }
        let head = self.source.peek::<MESSAGE_HEADER>(at + PREFIX)?;
        let message = head.as_ref().and_then(|head| record::message(head).ok());
        Ok(message.is_some_and(|(id, time, _)| {
            let is_known = self.used.known().iter().any(|known| known.knows(id));
            let is_near = |last: u64| last.abs_diff(time) < NEAR;
            is_known && self.used.last.is_some_and(is_near)
        }))
    }

    /// Whether the fields of a definition fill it.
    pub(super) fn fills(&mut self, at: u64, prefix: Prefix) -> Result<bool, OpenError> {
        Ok(prefix.length <= LARGEST_DEFINITION && self.fields_fill(at, prefix)?)
    }

    fn fields_fill(&mut self, at: u64, prefix: Prefix) -> Result<bool, OpenError> {
        let Prefix { opcode, length } = prefix;
        let fields = extent::of_fields(&mut self.source, opcode, at + PREFIX, length)?;
        Ok(fields == Some(length))
    }

    /// Whether a record of this length runs over others, as far as that is still looked for.
    pub(super) fn runs_over(&mut self, at: u64, end: u64) -> Result<bool, OpenError> {
        if self.looks == 0 {
            return Ok(false);
        }
        self.looks -= 1; // each look costs a pass over many records
        let sought = Sought {
            data_end: false,
            messages: Some(self.used.known()),
        };
        Ok(overlapped(&mut self.source, at, end, sought)?.is_some())
    }

    /// A definition outside of chunks whose length is wrong, and where it ends by its fields: other
    /// records stand there.
    fn by_fields(&mut self, at: u64) -> Result<Option<(Vec<u8>, u64)>, OpenError> {
        let Some(prefix) = scan::prefix(&mut self.source, at)? else {
            return Ok(None);
        };
        let is_definition = matches!(prefix.opcode, op::SCHEMA | op::CHANNEL);
        if self.chunked || !is_definition || self.looks == 0 || self.fills(at, prefix)? {
            return Ok(None);
        }
        self.looks -= 1; // each look costs as much as the largest definition
        let from = at + PREFIX;
        let most = LARGEST_DEFINITION;
        let fields = extent::of_fields(&mut self.source, prefix.opcode, from, most)?;
        let Some(length) = fields else {
            return Ok(None);
        };
        let end = from + length;
        if !scan::chain(&mut self.source, end, None)? {
            return Ok(None);
        }
        Ok(Some((self.source.get(from, length)?.to_vec(), end)))
    }

    /// Whether a definition with a wrong length stands there.
    pub(super) fn is_by_fields(&mut self, at: u64) -> Result<bool, OpenError> {
        Ok(self.by_fields(at)?.is_some())
    }

    /// Takes a definition with a wrong length, and tells where it ends.
    pub(super) fn behind_fields(
        &mut self,
        at: u64,
        prefix: Prefix,
    ) -> Result<Option<u64>, OpenError> {
        let Some((body, end)) = self.by_fields(at)? else {
            return Ok(None);
        };
        let opcode = prefix.opcode;
        let body = body.as_slice();
        let outcome = self.used.define(Inner { opcode, body });
        let why = outcome.err().unwrap_or(Why::Length);
        self.losses
            .add(Loss::new(at, end - at, "a definition", why));
        Ok(Some(end))
    }
}

/// The first record that a message with a wrong length runs over: its records, one after the other, pass
/// by where the message claims to end. Those in a message that carries records do not.
pub(super) fn overlapped<R: Read + Seek>(
    source: &mut Source<R>,
    at: u64,
    end: u64,
    sought: Sought<'_>,
) -> io::Result<Option<u64>> {
    /// So many places are looked at, and records from each on.
    const PLACES: usize = 8;
    const RECORDS: usize = 4096;
    let mut from = at + 1;
    for _ in 0..PLACES {
        let Some(candidate) = next_record(source, from, end, sought)? else {
            return Ok(None);
        };
        let mut reached = candidate;
        for _ in 0..RECORDS {
            match scan::prefix(source, reached)? {
                Some(prefix) if reached < end && prefix.is_possible() => {
                    reached = prefix.end(reached);
                }
                _ => break,
            }
        }
        if reached > end && reached <= source.length() {
            return Ok(Some(candidate));
        }
        from = candidate + 1;
    }
    Ok(None)
}
