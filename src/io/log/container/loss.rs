//! The losses of a file: what could not be read, where, and why.

use std::fmt;

use super::record::MAX_CHUNK;
use crate::core::wording::counted;

/// Something that could not be read from the file, or cannot be trusted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Loss {
    /// Where in the file, bytes from its start.
    pub offset: u64,
    /// How many bytes.
    pub bytes: u64,
    /// What stands there, for a person: `a chunk`, ...
    pub what: &'static str,
    /// Log times of the first and last message of it, where they are known.
    pub span: Option<(u64, u64)>,
    /// Messages lost, where that is known.
    pub messages: Option<u64>,
    /// Log time of the last message used before it.
    pub since: Option<u64>,
    /// Log time of the first message used behind it.
    pub until: Option<u64>,
    /// Why it was not used.
    pub why: Why,
    /// Log time of the first message of the log, which times are told from.
    pub log_start: Option<u64>,
}

impl Loss {
    /// A loss of which no more is known, of the bytes `from..to`.
    pub fn new(from: u64, to: u64, what: &'static str, why: Why) -> Self {
        Self {
            offset: from,
            bytes: to.saturating_sub(from),
            what,
            span: None,
            messages: None,
            since: None,
            until: None,
            why,
            log_start: None,
        }
    }

    /// With the log times of its first and last message, if they are known.
    pub fn spanning(self, span: Option<(u64, u64)>) -> Self {
        Self { span, ..self }
    }

    /// With the number of its messages, if it is known.
    pub fn losing(self, messages: Option<u64>) -> Self {
        Self { messages, ..self }
    }

    /// Whether messages may have gone with it whose times nothing tells.
    fn is_undated(&self) -> bool {
        let may_hold_messages = matches!(
            self.why,
            Why::Header
                | Why::Prefix
                | Why::NotIndexed(_)
                | Why::Kind(_)
                | Why::Zeros
                | Why::Cut
                | Why::TooLarge(_)
                | Why::Malformed
                | Why::NoFooter
        );
        may_hold_messages && self.span.is_none() && self.what != SUMMARY && self.what != BEHIND
    }
}

/// What a loss is called that holds no message.
pub const SUMMARY: &str = "the summary";
/// What a loss is called that lies behind the log's end.
pub const BEHIND: &str = "what follows the log";

/// Why a part of the file was not used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Why {
    #[error("its checksum is {found:08x} and should be {expected:08x}: bytes of it were changed")]
    Checksum { expected: u32, found: u32 },
    #[error(
        "the checksum of the data section does not match, and no other covers these records: any of \
         them may be damaged, so none is used. input.trust_unchecked = true uses them all the same"
    )]
    DataSection,
    #[error(
        "the checksum of the data section does not match, and no other covers these records: any of \
         them may be damaged. All are used, as input.trust_unchecked says"
    )]
    Unchecked,
    #[error(
        "the checksum of the data section does not match, although that of every chunk does: \
         something between the chunks was changed, put in or taken out"
    )]
    BetweenChunks,
    #[error("its header is damaged")]
    Header,
    #[error("no record begins here: its kind or its length is damaged")]
    Prefix,
    #[error("the summary's index has a chunk of {0} bytes here, and no such record begins here")]
    NotIndexed(u64),
    #[error("its kind, {0:#04x}, is none that stands here")]
    Kind(u8),
    #[error("its length is damaged; its fields were read all the same")]
    Length,
    #[error("it is not the chunk that the summary's index has here, nor any other of the index")]
    OtherChunk,
    #[error("the summary's index has it with other times than its messages have")]
    OtherTimes,
    #[error("the summary's index does not list it: it is no part of this log, and was not used")]
    NotListed,
    #[error("they list messages that no chunk before them holds")]
    NotHeld,
    #[error("it is filled with zeros: nothing was written here, as after a power loss")]
    Zeros,
    #[error("it is {0} bytes long; no more than {MAX_CHUNK} are read")]
    TooLarge(u64),
    #[error("it holds {} uncompressed and should hold {claimed}", counted(*found, "byte"))]
    Size { claimed: u64, found: u64 },
    #[error(
        "the chunks of this file, which has {0} bytes, unpack to more than is read of such a file"
    )]
    Bomb(u64),
    #[error("its compression, `{0}`, is not known; zstd, lz4 and none are")]
    Compression(String),
    #[error("it cannot be decompressed: {0}")]
    Decompression(String),
    #[error("schema {0} is defined again, and otherwise: the first definition is kept")]
    SchemaConflict(u16),
    #[error("the summary, which a checksum vouches for, has it otherwise: that is used")]
    Contradicted,
    #[error("its message definitions, with those before it, are longer than is held of a file")]
    Definitions,
    #[error("a record in it runs beyond its end, or is none; what stands before it was used")]
    Overrun,
    #[error(
        "the file ends within it. {} before the end {}",
        counted(*used, "message"),
        if *used == 1 { "was used; no checksum covers it" } else { "were used; no checksum covers them" }
    )]
    CutOff { used: u64 },
    #[error("the file ends within it")]
    Cut,
    #[error("the file ends without a footer: its recorder did not finish")]
    NoFooter,
    #[error("channel {0}, which they are on, is not defined before them or in the summary")]
    UnknownChannel(u16),
    #[error("schema {0}, which it needs, is not defined before it or in the summary")]
    UnknownSchema(u16),
    #[error(
        "channel {0} is defined a second time, otherwise; its messages from there on are not used"
    )]
    Conflict(u16),
    #[error("a field runs beyond its record")]
    Malformed,
    #[error("it is damaged, and was not used; no message is lost by that alone")]
    Summary,
    #[error("the summary counts {counted} messages; {read} were read")]
    Count { counted: u64, read: u64 },
    #[error(
        "a log ends here and more follows, as where two were joined: both are used as far as they agree"
    )]
    Joined,
    #[error("it is no part of the log that ends before it, and was not read")]
    Trailing,
    #[error("the magic bytes are damaged")]
    Magic,
    #[error("there are {0} more such places")]
    More(u64),
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at byte {}", self.offset)?;
        if self.bytes > 0 {
            write!(f, ", {}", counted(self.bytes, "byte"))?;
        }
        write!(f, ": {}", self.what)?;
        // A chunk without messages has none.
        if let Some((from, to)) = self.span.filter(|span| *span != (0, 0)) {
            f.write_str(" with messages logged from ")?;
            // A header that is damaged itself may claim any time.
            if self
                .log_start
                .is_some_and(|start| start <= from && from <= to)
            {
                let (from, to) = (self.seconds(from), self.seconds(to));
                write!(f, "{from:.3} s to {to:.3} s after the first, ")?;
            }
            let (from, to) = (from as f64 * 1e-9, to as f64 * 1e-9);
            write!(f, "{from:.3} s to {to:.3} s by the clock")?;
        }
        match (self.since, self.until) {
            _ if !self.is_undated() => {}
            (Some(since), Some(until)) => write!(
                f,
                ", between messages logged {:.3} s and {:.3} s after the first",
                self.seconds(since),
                self.seconds(until)
            )?,
            (Some(since), None) => write!(
                f,
                ", behind a message logged {:.3} s after the first, the last one used",
                self.seconds(since)
            )?,
            (None, Some(_)) => f.write_str(", before the first message used")?,
            (None, None) => {}
        }
        if let Some(count) = self.messages {
            write!(f, ", {} lost", counted(count, "message"))?;
        }
        write!(f, ": {}", self.why)
    }
}

impl Loss {
    /// Seconds from the first message of the log to a log time.
    fn seconds(&self, time: u64) -> f64 {
        let start = self.log_start.unwrap_or_default();
        (i128::from(time) - i128::from(start)) as f64 * 1e-9
    }
}

/// The span that holds both.
pub fn wider(one: Option<(u64, u64)>, other: Option<(u64, u64)>) -> Option<(u64, u64)> {
    match (one, other) {
        (Some((a, b)), Some((c, d))) => Some((a.min(c), b.max(d))),
        (one, other) => one.or(other),
    }
}

/// More losses than this are only counted.
const MOST: usize = 200;

/// Every loss of a file.
#[derive(Debug, Default)]
pub struct Losses {
    list: Vec<Loss>,
    more: u64,
    /// From here on, what lies behind a loss is not yet known.
    open: usize,
    /// From here on, nor is what lies before it.
    new: usize,
}

impl Losses {
    /// Whether there is any.
    pub fn any(&self) -> bool {
        !self.list.is_empty()
    }

    /// Messages that are known to be lost.
    pub fn messages(&self) -> u64 {
        let known = self.list.iter().filter_map(|loss| loss.messages);
        known.fold(0, u64::saturating_add)
    }

    /// Adds one.
    pub fn add(&mut self, loss: Loss) {
        if self.list.len() < MOST {
            self.list.push(loss);
        } else {
            self.more += 1;
        }
    }

    /// Dates the losses by the messages used in one step: those from before it by the `first`, its
    /// own by the `last` of all so far.
    pub fn date(&mut self, first: Option<u64>, last: Option<u64>) {
        if let Some(first) = first {
            for loss in self.list.get_mut(self.open..self.new).unwrap_or_default() {
                loss.until = Some(first);
            }
            self.open = self.new;
        }
        for loss in self.list.get_mut(self.new..).unwrap_or_default() {
            loss.since = last;
        }
        self.new = self.list.len();
    }

    /// Adds a message outside of chunks: one loss for all that follow each other for one reason.
    pub fn add_message(&mut self, at: u64, end: u64, span: Option<(u64, u64)>, why: Why) {
        const WHAT: &str = "messages";
        match self.list.last_mut() {
            Some(last) if last.why == why && last.what == WHAT => {
                last.bytes = end.saturating_sub(last.offset);
                last.messages = last.messages.map(|count| count + 1);
                last.span = wider(last.span, span);
            }
            _ => self.add(Loss::new(at, end, WHAT, why).spanning(span).losing(Some(1))),
        }
    }

    /// Whether the last loss reaches to some place.
    pub fn reach(&self, end: u64) -> bool {
        let last = self.list.last();
        last.is_some_and(|loss| loss.offset.saturating_add(loss.bytes) == end)
    }

    /// All of them, by offset, with times told from the first message on.
    pub fn finish(mut self, log_start: Option<u64>) -> Vec<Loss> {
        self.list.sort_by_key(|loss| loss.offset);
        if self.more > 0 {
            let why = Why::More(self.more);
            self.list.push(Loss::new(0, 0, "the list ends here", why));
        }
        for loss in &mut self.list {
            loss.log_start = log_start;
        }
        self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_not_many() {
        let loss = Loss::new(7, 8, "a part", Why::CutOff { used: 1 }).losing(Some(1));
        let said = "at byte 7, 1 byte: a part, 1 message lost: the file ends within it. 1 message before the \
                    end was used; no checksum covers it";
        assert_eq!(loss.to_string(), said);
    }
}
