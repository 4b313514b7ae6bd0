//! What could not be read, and why.

use std::fmt;

use super::MAX_CHUNK;
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
    /// A loss of which no more is known.
    pub fn new(offset: u64, bytes: u64, what: &'static str, why: Why) -> Self {
        Self {
            offset,
            bytes,
            what,
            span: None,
            messages: None,
            since: None,
            until: None,
            why,
            log_start: None,
        }
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
    /// Bytes were changed.
    #[error("its checksum is {found:08x} and should be {expected:08x}: bytes of it were changed")]
    Checksum {
        /// In the file.
        expected: u32,
        /// Of the bytes that are there.
        found: u32,
    },
    /// The data section's checksum covers it, and does not agree.
    #[error(
        "the checksum of the data section does not match, and no other covers these messages: any of \
         them may be damaged, so none is used. input.trust_unchecked = true uses them all the same"
    )]
    DataSection,
    /// As above; they are used because the configuration says so.
    #[error(
        "the checksum of the data section does not match, and no other covers these messages: any of \
         them may be damaged. All are used, as input.trust_unchecked says"
    )]
    Unchecked,
    /// The data section's checksum does not agree, and nothing else is wrong.
    #[error(
        "the checksum of the data section does not match, although that of every chunk does: \
         something between the chunks was changed, put in or taken out"
    )]
    BetweenChunks,
    /// A header that is none.
    #[error("its header is damaged")]
    Header,
    /// A length that does not fit, or a kind that does not exist.
    #[error("no record begins here: its kind or its length is damaged")]
    Prefix,
    /// No chunk of the length that the index has.
    #[error("the summary's index has a chunk of {0} bytes here, and no such record begins here")]
    NotIndexed(u64),
    /// A kind of record that does not stand there, or holds what a message does.
    #[error("its kind, {0:#04x}, is damaged")]
    Kind(u8),
    /// A length that does not fit, of a definition whose fields do.
    #[error("its length is damaged; its fields were read all the same")]
    Length,
    /// Nothing was written here.
    #[error("it is filled with zeros: nothing was written here, as after a power loss")]
    Zeros,
    /// A chunk beyond the limit.
    #[error("it is {0} bytes long; no more than {MAX_CHUNK} are read")]
    TooLarge(u64),
    /// Compressed data that is longer or shorter than it should be.
    #[error("it holds {} uncompressed and should hold {claimed}", counted(*found, "byte"))]
    Size {
        /// By its header.
        claimed: u64,
        /// Found.
        found: u64,
    },
    /// A file that unpacks to absurd lengths.
    #[error(
        "the chunks of this file, which has {0} bytes, unpack to more than is read of such a file"
    )]
    Bomb(u64),
    /// A compression that is not read.
    #[error("its compression, `{0}`, is not known; zstd, lz4 and none are")]
    Compression(String),
    /// Compressed data that cannot be decompressed.
    #[error("it cannot be decompressed: {0}")]
    Decompression(String),
    /// A schema that is defined twice.
    #[error("schema {0} is defined again, and otherwise: the first definition is kept")]
    SchemaConflict(u16),
    /// More definitions than are held.
    #[error("its message definitions, with those before it, are longer than is held of a file")]
    Definitions,
    /// A chunk whose records do not fit.
    #[error("a record in it runs beyond its end, or is none; what stands before it was used")]
    Overrun,
    /// The file ends within it.
    #[error(
        "the file ends within it. {} before the end {}",
        counted(*used, "message"),
        if *used == 1 { "was used; no checksum covers it" } else { "were used; no checksum covers them" }
    )]
    CutOff {
        /// Messages that were used.
        used: u64,
    },
    /// The file ends within it, and nothing of it is of use.
    #[error("the file ends within it")]
    Cut,
    /// The recorder did not finish.
    #[error("the file ends without a footer: its recorder did not finish")]
    NoFooter,
    /// Messages whose channel is nowhere defined.
    #[error("channel {0}, which they are on, is not defined before them or in the summary")]
    UnknownChannel(u16),
    /// A channel whose schema is nowhere defined.
    #[error("schema {0}, which it needs, is not defined before it or in the summary")]
    UnknownSchema(u16),
    /// A channel that is defined twice, differently.
    #[error(
        "channel {0} is defined a second time, otherwise; its messages from there on are not used"
    )]
    Conflict(u16),
    /// Records whose fields do not fit.
    #[error("a field runs beyond its record")]
    Malformed,
    /// A summary that does not hold together.
    #[error("it is damaged, and was not used; no message is lost by that alone")]
    Summary,
    /// The number of messages is not what the summary says.
    #[error("the summary counts {counted} messages; {read} were read")]
    Count {
        /// By the summary.
        counted: u64,
        /// Read.
        read: u64,
    },
    /// One log put behind another.
    #[error(
        "one log ends and another begins: two were joined. The messages of both are used, those of \
         channels that have other numbers in the second excepted"
    )]
    Joined,
    /// Bytes behind the log's end.
    #[error("it is no part of the log that ends before it, and was not read")]
    Trailing,
    /// The first bytes of the file.
    #[error("the magic bytes are damaged")]
    Magic,
    /// More losses than anyone reads.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_not_many() {
        let mut loss = Loss::new(7, 1, "a part", Why::CutOff { used: 1 });
        loss.messages = Some(1);
        let said = "at byte 7, 1 byte: a part, 1 message lost: the file ends within it. 1 message before the \
                    end was used; no checksum covers it";
        assert_eq!(loss.to_string(), said);
    }
}
