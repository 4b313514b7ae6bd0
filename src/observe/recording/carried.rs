//! The results of a run in its recording: puts them there, and finds them, message by message.
//!
//! Rerun's own reader takes the frames and the heads of messages apart. It is not given the columns:
//! Arrow's reader panics on damaged ones, and takes the lengths in them at their word. Text lies in
//! them as it is and in one piece, so ours is found by how it begins, and ends where its JSON does.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use re_span::Span;
use rerun::external::re_log_encoding::external::lz4_flex::block::decompress_into;
use rerun::external::re_log_encoding::{
    CachingApplicationIdInjector, CodecError, Compression, Decodable as _, DecoderEntrypoint as _,
    MessageHeader, MessageKind, RRD_FOURCC, StreamFooter, StreamHeader, ToApplication as _,
    ToTransport,
};
use rerun::external::re_log_types::StoreSource;
use rerun::log::LogMsg;
use rerun::{StoreId, StoreKind, TextDocument};
use serde::de::IgnoredAny;

use super::canvas::Canvas;
use crate::io::schema::in_words;
use crate::observe::viewer::{Carried, CarriedError, Error};

const FEATURES: &str = "/run/features";
const LABELS: &str = "/run/labels";

/// A message whose columns are still bytes.
type PackedMessage = <LogMsg as ToTransport>::Output;

/// A longer message holds no results, bytes.
const LONGEST: u64 = 1 << 28;
/// LZ4 packs no tighter.
const TIGHTEST: u64 = 255;

/// Writes the results as documents, which no view shows.
pub fn put(carried: &Carried, canvas: &mut Canvas<'_>) -> Result<(), Error> {
    canvas.put(FEATURES, &TextDocument::new(carried.features.as_str()))?;
    match &carried.labels {
        Some(labels) => canvas.put(LABELS, &TextDocument::new(labels.as_str())),
        None => Ok(()),
    }
}

/// Reads the results of a recording.
///
/// # Errors
/// A file that is no whole recording of one run.
pub fn read_carried(path: &Path) -> Result<Carried, CarriedError> {
    // Opening a pipe would wait for a writer.
    if !std::fs::metadata(path)?.is_file() {
        return Err(CarriedError::NoFile);
    }
    let file = File::open(path)?;
    let len = file.metadata()?.len();
    find(BufReader::new(file), len)
}

/// The results in a recording of so many bytes.
fn find(mut file: impl Read + Seek, len: u64) -> Result<Carried, CarriedError> {
    let mut found = FoundResults::default();
    let mut at = 0;
    let head = piece(
        &mut file,
        &mut at,
        StreamHeader::ENCODED_SIZE_BYTES as u64,
        len,
    )?;
    StreamHeader::from_rrd_bytes(&head)
        .and_then(StreamHeader::to_version_and_options)
        .map_err(|source| codec(0, source))?;
    loop {
        let start = at;
        let head = piece(
            &mut file,
            &mut at,
            MessageHeader::ENCODED_SIZE_BYTES as u64,
            len,
        )?;
        let header = MessageHeader::from_rrd_bytes(&head).map_err(|source| codec(start, source))?;
        if header.len > len - at {
            return Err(CarriedError::CutOff { bytes: len });
        }
        if header.kind == MessageKind::End {
            const FOOTER: u64 = StreamFooter::ENCODED_SIZE_BYTES as u64;
            return match len - at - header.len {
                0 | FOOTER => found.carried(),
                rest if rest < FOOTER => Err(CarriedError::CutOff { bytes: len }),
                _ => {
                    at = file.seek(SeekFrom::Start(at + header.len + FOOTER))?;
                    let (end, bytes) = (at, len - at);
                    let next = piece(&mut file, &mut at, bytes.min(RRD_FOURCC.len() as u64), len)?;
                    if next == RRD_FOURCC {
                        return Err(CarriedError::Several);
                    }
                    Err(CarriedError::GoesOn { at: end, bytes })
                }
            };
        }
        if header.len > LONGEST {
            at += header.len;
            file.seek(SeekFrom::Start(at))?;
            continue;
        }
        let bytes = piece(&mut file, &mut at, header.len, len)?;
        found.take(header.kind, bytes, start)?;
    }
}

/// The next bytes of a file of a length.
fn piece(
    file: &mut impl Read,
    at: &mut u64,
    bytes: u64,
    len: u64,
) -> Result<Vec<u8>, CarriedError> {
    let mut piece = Vec::new();
    file.take(bytes).read_to_end(&mut piece)?;
    if piece.len() as u64 != bytes {
        return Err(CarriedError::CutOff { bytes: len });
    }
    *at += bytes;
    Ok(piece)
}

fn codec(at: u64, source: CodecError) -> CarriedError {
    let source = Box::new(source);
    CarriedError::Codec { at, source }
}

/// What the messages so far said.
#[derive(Default)]
struct FoundResults {
    ids: CachingApplicationIdInjector,
    writer: Option<(StoreId, StoreSource)>,
    features: Option<String>,
    labels: Option<String>,
}

impl FoundResults {
    fn take(&mut self, kind: MessageKind, bytes: Vec<u8>, at: u64) -> Result<(), CarriedError> {
        let span = Span {
            start: at,
            len: bytes.len() as u64,
        };
        let wrong = |source| codec(at, source);
        let message = PackedMessage::decode(bytes.into(), span, kind, &mut self.ids, None);
        match message.map_err(wrong)? {
            Some(message @ PackedMessage::SetStoreInfo(_)) => {
                let message = message.to_application((&mut self.ids, None));
                if let LogMsg::SetStoreInfo(store) = message.map_err(wrong)?
                    && store.info.store_id.kind() == StoreKind::Recording
                {
                    let store = store.info;
                    let (id, _) =
                        (self.writer).get_or_insert((store.store_id.clone(), store.store_source));
                    if *id != store.store_id {
                        return Err(CarriedError::Several);
                    }
                }
            }
            // Ours say of themselves that they hold at all times.
            Some(PackedMessage::ArrowMsg(columns)) if columns.is_static == Some(true) => {
                let compression = Compression::from(columns.compression());
                let columns = unpacked(&columns.payload, compression, columns.uncompressed_size);
                self.look_at(&columns.map_err(wrong)?)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn look_at(&mut self, columns: &[u8]) -> Result<(), CarriedError> {
        for (path, place) in [(FEATURES, &mut self.features), (LABELS, &mut self.labels)] {
            if position(columns, path).is_some()
                && let Some(text) = ours(columns)
                && place.replace(whole_json(text)?).is_some()
            {
                return Err(CarriedError::Several);
            }
        }
        Ok(())
    }

    fn carried(self) -> Result<Carried, CarriedError> {
        let Some(features) = self.features else {
            return Err(match self.writer.map(|(_, writer)| writer) {
                Some(StoreSource::Other(writer)) if writer.starts_with("tmam ") => {
                    CarriedError::Nothing { writer }
                }
                Some(StoreSource::Other(writer)) => CarriedError::Foreign { writer },
                Some(writer) => CarriedError::Foreign {
                    writer: writer.to_string(),
                },
                None => CarriedError::Foreign {
                    writer: "an unnamed program".to_owned(),
                },
            });
        };
        Ok(Carried {
            features,
            labels: self.labels,
        })
    }
}

/// The bytes of columns; nothing of columns that are too long for ours.
fn unpacked(packed: &[u8], compression: Compression, bytes: u64) -> Result<Vec<u8>, CodecError> {
    let possible = bytes <= LONGEST && bytes / TIGHTEST <= packed.len() as u64;
    match (compression, usize::try_from(bytes)) {
        (Compression::Off, _) => Ok(packed.to_vec()),
        (Compression::LZ4, Ok(bytes)) if possible => {
            let mut columns = vec![0; bytes];
            decompress_into(packed, &mut columns)?;
            Ok(columns)
        }
        (Compression::LZ4, _) => Ok(Vec::new()),
    }
}

/// Where a word first stands.
fn position(bytes: &[u8], word: &str) -> Option<usize> {
    let mut windows = bytes.windows(word.len());
    windows.position(|window| window == word.as_bytes())
}

/// From the beginning of our text on.
fn ours(columns: &[u8]) -> Option<&[u8]> {
    let (before, _) = columns.split_at_checked(position(columns, "\"schema\": \"tmam.")?)?;
    let begin = before.iter().rposition(|byte| *byte == b'{')?;
    columns.get(begin..)
}

/// The JSON value that the bytes begin with, and the line end after it.
fn whole_json(bytes: &[u8]) -> Result<String, CarriedError> {
    let damaged = |reason: String| CarriedError::Damaged { reason };
    let mut values = serde_json::Deserializer::from_slice(bytes).into_iter::<IgnoredAny>();
    if let Some(Err(error)) = values.next() {
        return Err(damaged(in_words(&error)));
    }
    let end = values.byte_offset();
    let end = end + usize::from(bytes.get(end) == Some(&b'\n'));
    let text = bytes.get(..end).unwrap_or_default().to_vec();
    String::from_utf8(text).map_err(|error| damaged(error.to_string()))
}

#[cfg(test)]
mod tests;
