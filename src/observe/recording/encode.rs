//! Writes chunks as a Rerun file whose bytes depend on nothing but its content.
//!
//! The SDK's own encoder takes row and chunk ids from the clock and lists the stores in the
//! footer in hash-map order. Here ids count from a digest of what is recorded and the footer has the recording
//! before the blueprint. Offsets and sizes for the footer are noted as the chunks go out, so
//! nothing but the footer's rows stays in memory.

use std::io::Write;

use rerun::external::arrow::datatypes::Schema;
use rerun::external::re_log_encoding::{
    CodecError, Compression, CrateVersion, Encodable, EncodingOptions, MessageHeader, MessageKind,
    RRD_FOURCC, RawRrdManifest, RrdFooter, RrdManifestBuilder, Serializer, StreamFooter,
    StreamHeader, ToTransport,
};
use rerun::external::re_log_types::external::re_tuid::Tuid;
use rerun::external::re_log_types::{
    BlueprintActivationCommand, LogMsg, SetStoreInfo, StoreInfo, StoreSource,
};
use rerun::log::{Chunk, ChunkComponents, ChunkError, ChunkId, RowId, TimeColumn};
use rerun::{
    ApplicationId, EntityPath, SerializationError, SerializedComponentColumn, StoreId, StoreKind,
    Timeline,
};

use super::live::Live;
use crate::core::observer::Setting;
use crate::observe::drawing::Overlay;
use crate::observe::viewer::{Error, this};

const COMPRESSION: Compression = Compression::LZ4;

/// Which of the file's two stores a chunk belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Store {
    /// What was seen and decided.
    Recording,
    /// How it is laid out on the screen.
    Blueprint,
}

/// One store: its name and what the footer will say of its chunks.
struct Manifest {
    id: StoreId,
    builder: RrdManifestBuilder,
}

impl Manifest {
    fn new(id: StoreId) -> Self {
        Self {
            id,
            builder: RrdManifestBuilder::default(),
        }
    }

    fn build(self) -> Result<RawRrdManifest, Error> {
        let mut manifest = self.builder.build(self.id)?;
        // The builder lists the columns in hash-map order.
        let schema = std::mem::replace(&mut manifest.sorbet_schema, Schema::empty());
        let mut fields: Vec<_> = schema.fields().iter().cloned().collect();
        fields.sort_by(|a, b| a.name().cmp(b.name()));
        manifest.sorbet_schema = Schema::new_with_metadata(fields, schema.metadata);
        Ok(manifest)
    }
}

/// A Rerun file being written, and sent to an open viewer where there is one.
pub struct RrdWriter<'a> {
    // `None` where the viewer alone is shown it: then it is an error when that goes away.
    out: Option<&'a mut (dyn Write + Send)>,
    viewer: Option<Live>,
    // Why the viewer was not shown everything.
    lost: Option<Error>,
    // The count of ids before a blueprint that goes to the viewer alone.
    previewing: Option<u64>,
    written: u64,
    scratch: Vec<u8>,
    ids: Ids,
    recording: Manifest,
    blueprint: Manifest,
}

/// Row and chunk ids: the digest of the recording and a count.
struct Ids {
    digest: u64,
    count: u64,
}

impl Ids {
    fn next(&mut self) -> Tuid {
        self.count += 1;
        Tuid::from_nanos_and_inc(self.digest, self.count)
    }
}

impl<'a> RrdWriter<'a> {
    /// Writes the head of the file: its two stores, still empty.
    pub fn new(
        out: Option<&'a mut (dyn Write + Send)>,
        viewer: Option<Live>,
        [recording, blueprint]: [StoreId; 2],
        digest: u64,
    ) -> Result<Self, Error> {
        let mut writer = Self {
            out,
            viewer,
            lost: None,
            previewing: None,
            written: 0,
            scratch: Vec::new(),
            ids: Ids { digest, count: 0 },
            recording: Manifest::new(recording),
            blueprint: Manifest::new(blueprint),
        };
        writer.put(&StreamHeader {
            fourcc: RRD_FOURCC,
            version: CrateVersion::LOCAL.to_bytes(),
            options: EncodingOptions {
                compression: COMPRESSION,
                serializer: Serializer::Protobuf,
            },
        })?;
        for store in [Store::Recording, Store::Blueprint] {
            let message = LogMsg::SetStoreInfo(SetStoreInfo {
                row_id: writer.ids.next(),
                info: StoreInfo::new(
                    writer.manifest(store).id.clone(),
                    StoreSource::Other(this()),
                ),
            });
            writer.show(&message)?;
            writer.put(&message.to_transport(COMPRESSION)?)?;
        }
        Ok(writer)
    }

    /// From here on messages go to the viewer alone, where there is one; ids do not count.
    pub fn begin_preview(&mut self) -> bool {
        self.previewing = self.viewer.is_some().then_some(self.ids.count);
        self.previewing.is_some()
    }

    /// Puts the previewed blueprint in force. The file is the same with it and without.
    pub fn end_preview(&mut self) -> Result<(), Error> {
        if let Some(count) = self.previewing.take() {
            self.ids.count = count;
        }
        self.show(&self.activation())
    }

    fn activation(&self) -> LogMsg {
        LogMsg::BlueprintActivationCommand(BlueprintActivationCommand {
            blueprint_id: self.blueprint.id.clone(),
            make_active: true,
            make_default: true,
        })
    }

    /// Sends a message to the viewer, while there is one.
    fn show(&mut self, message: &LogMsg) -> Result<(), Error> {
        let Some(viewer) = &mut self.viewer else {
            return Ok(());
        };
        match viewer.send(message.clone()) {
            Ok(()) => Ok(()),
            Err(error) => self.lose(error),
        }
    }

    fn lose(&mut self, error: Error) -> Result<(), Error> {
        self.viewer = None;
        if self.out.is_none() {
            return Err(error);
        }
        self.lost = Some(error);
        Ok(())
    }

    /// Writes rows of one entity; `times` has one column per timeline, none for static data.
    pub fn chunk(
        &mut self,
        store: Store,
        entity: &EntityPath,
        rows: usize,
        times: Vec<(Timeline, Vec<i64>)>,
        columns: impl IntoIterator<Item = SerializedComponentColumn>,
    ) -> Result<(), Error> {
        let id = ChunkId::from_tuid(self.ids.next());
        let row_ids: Vec<RowId> = (0..rows)
            .map(|_| RowId::from_tuid(self.ids.next()))
            .collect();
        let chunk = Chunk::from_native_row_ids(
            id,
            entity.clone(),
            Some(true),
            &row_ids,
            times
                .into_iter()
                .map(|(line, at)| (*line.name(), TimeColumn::new(None, line, at.into())))
                .collect(),
            columns.into_iter().collect::<ChunkComponents>(),
        )?;
        let store_id = self.manifest(store).id.clone();
        let message = LogMsg::ArrowMsg(store_id, chunk.to_arrow_msg()?);
        self.show(&message)?;
        if self.previewing.is_some() {
            return Ok(());
        }
        let message = message.to_transport(COMPRESSION)?;
        let uncompressed = message.byte_size_uncompressed();
        let header = MessageHeader::ENCODED_SIZE_BYTES as u64;
        let start = self.written + header;
        let len = self.put(&message)?.saturating_sub(header);
        self.manifest(store).builder.append(
            &chunk.to_chunk_batch()?,
            re_span::Span { start, len },
            uncompressed,
        )?;
        Ok(())
    }

    /// Puts the blueprint in force and closes the file; with why the viewer was not shown everything.
    pub fn finish(mut self) -> Result<Option<Error>, Error> {
        let activate = self.activation();
        self.show(&activate)?;
        self.put(&activate.to_transport(COMPRESSION)?)?;
        if let Some(Err(error)) = self.viewer.take().map(Live::close) {
            self.lose(error)?;
        }
        let Some(out) = self.out else {
            return Ok(self.lost);
        };
        let mut footer = RrdFooter::default().to_transport(())?;
        for manifest in [self.recording, self.blueprint] {
            footer.manifests.push(manifest.build()?.to_transport(())?);
        }
        let mut payload = Vec::new();
        footer.to_rrd_bytes(&mut payload)?;
        let mut end = Vec::new();
        MessageHeader {
            kind: MessageKind::End,
            len: payload.len() as u64,
        }
        .to_rrd_bytes(&mut end)?;
        let at = self.written + end.len() as u64;
        end.extend_from_slice(&payload);
        StreamFooter::from_rrd_footer_bytes(at, &payload).to_rrd_bytes(&mut end)?;
        out.write_all(&end)?;
        out.flush()?;
        Ok(self.lost)
    }

    fn put(&mut self, what: &dyn Encodable) -> Result<u64, Error> {
        self.scratch.clear();
        what.to_rrd_bytes(&mut self.scratch)?;
        if let Some(out) = &mut self.out {
            out.write_all(&self.scratch)?;
        }
        let len = self.scratch.len() as u64;
        self.written += len;
        Ok(len)
    }

    fn manifest(&mut self, store: Store) -> &mut Manifest {
        match store {
            Store::Recording => &mut self.recording,
            Store::Blueprint => &mut self.blueprint,
        }
    }
}

impl From<CodecError> for Error {
    fn from(error: CodecError) -> Self {
        Self::Form(Box::new(error))
    }
}

impl From<ChunkError> for Error {
    fn from(error: ChunkError) -> Self {
        Self::Form(Box::new(error))
    }
}

impl From<SerializationError> for Error {
    fn from(error: SerializationError) -> Self {
        Self::Form(Box::new(error))
    }
}

/// How much of a file's name goes into the name of its recordings' application.
const MAX_STEM: usize = 100;

/// Names for the recording and its blueprint, and what its ids count from: a digest of the log's events, the
/// configuration, the version, and what is drawn over the run.
///
/// The viewer keeps a blueprint per application, and bounds that fit one log do not fit another:
/// so each log is its own application. Two configurations over one log are two recordings of it. A catalog
/// takes chunks of equal ids for one chunk.
pub fn identity(setting: &Setting<'_>, overlay: &Overlay) -> ([StoreId; 2], u64) {
    let source = setting.source;
    let content = serde_json::to_string(&(source, setting.config)).unwrap_or_default();
    let (events, this) = (setting.events_sha256, this());
    let digest = fnv1a(format!("{this} {events} {content} {overlay:?}").as_bytes());
    let recording = format!("{}-{digest:016x}", source.start_ns);
    (named_ids("tmam", &source.file, recording), digest)
}

/// Names for a recording of a kind of a log.
pub fn named_ids(kind: &str, file: &str, recording: String) -> [StoreId; 2] {
    // Other characters are not allowed in an application's name.
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let stem: String = stem
        .chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() || c == '_' {
                c
            } else {
                '-'
            }
        })
        .take(MAX_STEM)
        .collect();
    let application = ApplicationId::new_or_unknown(format!("{kind}-{stem}"));
    let blueprint = format!("{recording}-blueprint");
    [
        StoreId::new(StoreKind::Recording, application.clone(), recording),
        StoreId::new(StoreKind::Blueprint, application, blueprint),
    ]
}

/// A hash that is the same everywhere.
pub fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
