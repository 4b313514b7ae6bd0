//! Messages and records whose borders are in doubt, outside of chunks.

use std::io::{self, Read, Seek};

use super::OpenError;
use super::record::{self, PREFIX, op};
use super::scan::{self, Prefix, Sought, next_record};
use super::source::Source;
use super::walker::{MESSAGE_HEADER, Walker};

impl<R: Read + Seek> Walker<'_, R> {
    /// Whether the record that is damaged `at` some place plainly begins there all the same, by its
    /// kind and what follows its length, or by its length alone: then the damage began there, and
    /// the message logged at `log_time` before it ended well.
    pub(super) fn keeps_a_trace(
        &mut self,
        at: u64,
        log_time: Option<u64>,
    ) -> Result<bool, OpenError> {
        /// Messages next to each other are logged within a day, nanoseconds.
        const NEAR: u64 = 86_400_000_000_000;
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
