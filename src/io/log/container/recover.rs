//! What follows damage: where to go on, and what was lost.

use std::io::{Read, Seek};

use super::loss::{Loss, Why};
use super::overlap::overlapped;
use super::record::{self, PREFIX, op};
use super::scan::{self, Sought, next_record};
use super::walker::{Next, Walker};
use super::{MAGIC, OpenError};

/// A chunk, and nothing else.
pub(super) const A_CHUNK: Sought<'static> = Sought {
    data_end: false,
    messages: None,
};

impl<R: Read + Seek> Walker<'_, R> {
    /// Reports a chunk that cannot be used, and goes on behind it. Its length may be wrong as well.
    pub(super) fn lose_chunk(
        &mut self,
        at: u64,
        end: u64,
        span: Option<(u64, u64)>,
        why: Why,
    ) -> Next {
        self.chunked = true;
        self.passed = at + 1;
        let trusted = match why {
            _ if self.places.at(at).is_some() => true,
            // Nothing speaks against the length of these.
            Why::Compression(_) | Why::TooLarge(_) | Why::Bomb(_) => true,
            _ => false,
        };
        let next = if trusted {
            end
        } else {
            self.behind_lost_chunk(at, end)?
        };
        let described = self.places.described(at).map(|index| index.span);
        let messages = if next < end {
            None
        } else {
            self.indexed_messages(end)?
        };
        self.losses.add(Loss {
            span: described.or(span),
            messages,
            ..Loss::new(at, next.min(end) - at, "a chunk", why)
        });
        // Behind a good length stand the chunk's message indexes, which nobody misses.
        if next > end && !self.could_begin(end)? {
            let why = if self.is_zero(end, next)? {
                Why::Zeros
            } else {
                Why::Prefix
            };
            let what = self.stretch(next);
            self.losses.add(Loss::new(end, next - end, what, why));
        }
        Ok(Some(next))
    }

    /// What an unreadable stretch up to some place is called.
    fn stretch(&self, to: u64) -> &'static str {
        if to == self.source.length() {
            "everything to the end of the file"
        } else {
            "a part"
        }
    }

    /// The next chunk behind one whose length may be wrong: within it, behind it, or wherever a scan
    /// finds one, since what stands at a wrong end may look like a record by chance.
    fn behind_lost_chunk(&mut self, at: u64, end: u64) -> Result<u64, OpenError> {
        if let Some(inside) = next_record(&mut self.source, at + 1, end, A_CHUNK)? {
            return Ok(inside);
        }
        let length = self.source.length();
        let mut follows = end;
        while let Some(prefix) = scan::prefix(&mut self.source, follows)?
            && prefix.is_message_index()
            && prefix.end(follows) <= length
        {
            follows = prefix.end(follows);
        }
        let limit = self.limit(at);
        let sought = Sought {
            data_end: true,
            ..A_CHUNK
        };
        if follows >= limit || scan::begins(&mut self.source, follows, sought)? {
            return Ok(end);
        }
        Ok(next_record(&mut self.source, end, limit, sought)?.unwrap_or(limit))
    }

    /// The messages that the message indexes from `at` on list.
    pub(super) fn indexed_messages(&mut self, mut at: u64) -> Result<Option<u64>, OpenError> {
        const HEAD: u64 = 6;
        const ENTRY: u64 = 16;
        let mut count = None;
        while let Some(prefix) = scan::prefix(&mut self.source, at)?
            && prefix.opcode == op::MESSAGE_INDEX
            && prefix.end(at) <= self.source.length()
        {
            let body = self.source.get(at + PREFIX, HEAD.min(prefix.length))?;
            // No more than the record has room for.
            let listed = record::indexed_messages(body)
                .unwrap_or_default()
                .min(prefix.length / ENTRY);
            count = Some(count.unwrap_or(0_u64).saturating_add(listed));
            at = prefix.end(at);
        }
        Ok(count)
    }

    /// Reports damage at some place, and finds the next one where reading can go on; behind
    /// `message`, where the damage may have begun within a message that ends there.
    pub(super) fn go_on(&mut self, at: u64, message: Option<u64>) -> Next {
        let length = self.source.length();
        if let Some(index) = self.places.at(at).copied() {
            let after = self.places.after(at).map_or(length, |next| next.offset);
            let next = index.end().min(after).min(length).max(at + 1);
            let messages = self.indexed_messages(next)?;
            self.losses.add(Loss {
                span: Some(index.span),
                messages,
                ..Loss::new(at, next - at, "a chunk", Why::NotIndexed(index.length))
            });
            return Ok(Some(next));
        }
        let searched = self
            .places
            .after(at)
            .map_or(self.limit(at), |next| next.offset);
        // A damaged length may have led past a chunk, to what looked like a record by chance.
        let missed = next_record(&mut self.source, self.passed.min(at), at, A_CHUNK)?;
        self.passed = self.passed.max(at + 1);
        if let Some(missed) = missed {
            self.losses
                .add(Loss::new(missed, 0, "what stands before", Why::Prefix));
            return Ok(Some(missed));
        }
        let sought = Sought {
            data_end: self.tail.limit.is_none(),
            messages: (!self.chunked).then(|| self.used.known()),
        };
        let overlapped = match message {
            Some(end) if self.looks > 0 => {
                self.looks -= 1; // each look costs a pass over many records
                overlapped(&mut self.source, at, end.min(searched), sought)?
            }
            _ => None,
        };
        let from = message.unwrap_or(at).saturating_add(1);
        let next = match overlapped {
            Some(record) => record,
            None => next_record(&mut self.source, from, searched, sought)?
                .unwrap_or(searched.max(at + 1).min(length)),
        };
        let why = if self.is_zero(message.unwrap_or(at), next)? {
            Why::Zeros
        } else if next == length && self.is_cut(at)? {
            Why::Cut
        } else {
            Why::Prefix
        };
        let what = match why {
            Why::Cut => self.cut_kind(at)?,
            Why::Prefix => self.kind(at)?.unwrap_or(self.stretch(next)),
            _ => self.stretch(next),
        };
        let loss = Loss::new(at, next - at, what, why);
        self.losses.add(match self.places.described(at) {
            Some(index) => Loss {
                what: "a chunk",
                span: Some(index.span),
                ..loss
            },
            None => loss,
        });
        Ok(Some(next))
    }

    /// Behind the magic bytes of a second log, where the first one ends here and the second follows.
    pub(super) fn behind_joint(&mut self, at: u64) -> Result<Option<u64>, OpenError> {
        let length = self.source.length();
        if self.joints == 0 {
            return Ok(None); // each look costs a pass over what follows
        }
        self.joints -= 1;
        let mut end = at;
        while let Some(prefix) = scan::prefix(&mut self.source, end)?
            && prefix.is_possible()
            && prefix.end(end) < length
        {
            end = prefix.end(end);
            if prefix.opcode == op::FOOTER {
                const MAGIC_LENGTH: u64 = MAGIC.len() as u64;
                let both = [end, end + MAGIC_LENGTH];
                for magic in both {
                    if self.source.peek(magic)? != Some(MAGIC) {
                        return Ok(None);
                    }
                }
                let next = end + 2 * MAGIC_LENGTH;
                let what = "the end of a log";
                self.losses.add(Loss::new(at, next - at, what, Why::Joined));
                return Ok(Some(next));
            }
        }
        Ok(None)
    }

    /// What a record is called that holds no message.
    fn kind(&mut self, at: u64) -> Result<Option<&'static str>, OpenError> {
        let prefix = scan::prefix(&mut self.source, at)?;
        Ok(match prefix.map(|prefix| prefix.opcode) {
            Some(op::ATTACHMENT) => Some("an attachment"),
            Some(op::METADATA) => Some("a metadata record"),
            Some(op::MESSAGE_INDEX) => Some("a message index"),
            _ => None,
        })
    }

    pub(super) fn is_zero(&mut self, from: u64, to: u64) -> Result<bool, OpenError> {
        const STRIDE: u64 = 64 << 10;
        let mut at = from;
        while at < to {
            let bytes = self.source.get(at, STRIDE.min(to - at))?;
            if bytes.iter().any(|byte| *byte != 0) {
                return Ok(false);
            }
            at += STRIDE;
        }
        Ok(from < to)
    }
}
