//! What stands where the data, or the file, ends.

use std::io::{Read, Seek};

use super::MAGIC;
use super::loss::{BEHIND, Loss, SUMMARY, Why};
use super::record::op;
use super::scan;
use super::walker::{Next, Walker};

impl<R: Read + Seek> Walker<'_, R> {
    /// The file's end, before the data section's.
    pub(super) fn end(&mut self, at: u64) -> Next {
        let length = self.source.length();
        if at < length {
            let bytes = length - at;
            let why = if self.is_zero(at, length)? {
                Why::Zeros
            } else {
                Why::Cut
            };
            self.losses.add(Loss::new(at, bytes, "a record", why));
        } else if !self.losses.reach(length) {
            self.losses
                .add(Loss::new(length, 0, "the end", Why::NoFooter));
        }
        Ok(None)
    }

    /// What follows the data section: the summary, and what should not be there.
    pub(super) fn close(&mut self, summary: u64) -> Next {
        let length = self.source.length();
        let rest = length.saturating_sub(summary);
        if self.tail.footer {
            if self.tail.damaged {
                self.losses
                    .add(Loss::new(summary, rest, SUMMARY, Why::Summary));
            }
            return Ok(None);
        }
        let mut at = summary;
        while let Some(prefix) = scan::prefix(&mut self.source, at)?
            && prefix.is_possible()
            && prefix.end(at) <= length
        {
            at = prefix.end(at);
            if prefix.opcode == op::FOOTER && self.source.peek(at)? == Some(MAGIC) {
                let end = at + MAGIC.len() as u64;
                let why = if self.is_zero(end, length)? {
                    Why::Zeros
                } else {
                    Why::Trailing
                };
                self.losses.add(Loss::new(end, length - end, BEHIND, why));
                return Ok(None);
            }
        }
        let why = if self.tail.magic {
            Why::Summary
        } else {
            Why::NoFooter
        };
        self.losses.add(Loss::new(summary, rest, SUMMARY, why));
        Ok(None)
    }
}
