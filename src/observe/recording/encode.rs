//! Writes chunks as a Rerun file whose bytes depend on nothing but its content.
//!
//! The SDK's own encoder takes row and chunk ids from the clock and lists the stores in the
//! footer in hash-map order. Here ids count from the log's start and the footer has the recording
//! before the blueprint. Offsets and sizes for the footer are noted as the chunks go out, so
//! nothing but the footer's rows stays in memory.

use std::io::Write;

use rerun::external::arrow::datatypes::Schema;
use rerun::external::re_log_encoding::{
    Compression, CrateVersion, Encodable, EncodingOptions, MessageHeader, MessageKind, RRD_FOURCC,
    RawRrdManifest, RrdFooter, RrdManifestBuilder, Serializer, StreamFooter, StreamHeader,
    ToTransport,
};
use rerun::external::re_log_types::external::re_tuid::Tuid;
use rerun::external::re_log_types::{
    BlueprintActivationCommand, LogMsg, SetStoreInfo, StoreInfo, StoreSource,
};
use rerun::log::{Chunk, ChunkComponents, ChunkId, RowId, TimeColumn};
use rerun::{EntityPath, SerializedComponentColumn, StoreId, Timeline};

use super::Error;
use super::carried::this;
use super::live::{Live, LiveError};
use super::origin::Origin;

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
pub struct RrdWriter<W> {
    out: W,
    viewer: Option<Live>,
    lost: Option<LiveError>,
    // Whether messages go to the viewer alone.
    previewing: bool,
    origin: Origin,
    written: u64,
    scratch: Vec<u8>,
    ids: Ids,
    recording: Manifest,
    blueprint: Manifest,
}

/// Row and chunk ids: the log's start and a count.
struct Ids {
    start_ns: u64,
    count: u64,
}

impl Ids {
    fn next(&mut self) -> Tuid {
        self.count += 1;
        Tuid::from_nanos_and_inc(self.start_ns, self.count)
    }
}

impl<W: Write> RrdWriter<W> {
    /// Writes the head of the file: its two stores, still empty.
    pub fn new(
        out: W,
        viewer: Option<Live>,
        recording: StoreId,
        blueprint: StoreId,
        start_ns: i64,
        origin: Origin,
    ) -> Result<Self, Error> {
        let mut writer = Self {
            out,
            viewer,
            lost: None,
            previewing: false,
            origin,
            written: 0,
            scratch: Vec::new(),
            ids: Ids {
                start_ns: u64::try_from(start_ns).unwrap_or(0),
                count: 0,
            },
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
            writer.show(&message);
            writer.put(&message.to_transport(COMPRESSION)?)?;
        }
        Ok(writer)
    }

    /// What places are seen from.
    pub fn origin(&self) -> Origin {
        self.origin
    }

    /// Shows the viewer, where there is one, a blueprint to go by until the one at the end. The file
    /// is the same with it and without.
    pub fn preview(
        &mut self,
        blueprint: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        if self.viewer.is_none() {
            return Ok(());
        }
        let count = self.ids.count;
        self.previewing = true;
        let drawn = blueprint(self);
        self.previewing = false;
        self.ids.count = count;
        drawn?;
        let activate = self.activation();
        self.show(&activate);
        Ok(())
    }

    fn activation(&self) -> LogMsg {
        LogMsg::BlueprintActivationCommand(BlueprintActivationCommand {
            blueprint_id: self.blueprint.id.clone(),
            make_active: true,
            make_default: true,
        })
    }

    /// Takes the viewer's error, once it has gone away.
    pub fn lost(&mut self) -> Option<LiveError> {
        self.lost.take()
    }

    /// Sends a message to the viewer, while there is one.
    fn show(&mut self, message: &LogMsg) {
        let Some(viewer) = &mut self.viewer else {
            return;
        };
        if let Err(error) = viewer.send(message.clone()) {
            self.lost = Some(error);
            self.viewer = None;
        }
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
        self.show(&message);
        if self.previewing {
            return Ok(());
        }
        let message = message.to_transport(COMPRESSION)?;
        let uncompressed = message.byte_size_uncompressed();
        let header = MessageHeader::ENCODED_SIZE_BYTES as u64;
        let start = self.written + header;
        let len = self.put(&message)?.saturating_sub(header);
        self.manifest_mut(store).builder.append(
            &chunk.to_chunk_batch()?,
            re_span::Span { start, len },
            uncompressed,
        )?;
        Ok(())
    }

    /// Puts the blueprint in force, closes the file and gives the writer back, flushed; with the
    /// viewer's error, if it has gone away and [`lost`](Self::lost) has not said so.
    pub fn finish(mut self) -> Result<(W, Option<LiveError>), Error> {
        let activate = self.activation();
        self.show(&activate);
        self.put(&activate.to_transport(COMPRESSION)?)?;
        if let Some(Err(error)) = self.viewer.take().map(Live::close) {
            self.lost = Some(error);
        }

        let Self {
            lost,
            mut out,
            written,
            recording,
            blueprint,
            ..
        } = self;
        let mut footer = RrdFooter::default().to_transport(())?;
        for manifest in [recording, blueprint] {
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
        let at = written + end.len() as u64;
        end.extend_from_slice(&payload);
        StreamFooter::from_rrd_footer_bytes(at, &payload).to_rrd_bytes(&mut end)?;
        out.write_all(&end)?;
        out.flush()?;
        Ok((out, lost))
    }

    fn put(&mut self, what: &dyn Encodable) -> Result<u64, Error> {
        self.scratch.clear();
        what.to_rrd_bytes(&mut self.scratch)?;
        self.out.write_all(&self.scratch)?;
        let len = self.scratch.len() as u64;
        self.written += len;
        Ok(len)
    }

    fn manifest(&self, store: Store) -> &Manifest {
        match store {
            Store::Recording => &self.recording,
            Store::Blueprint => &self.blueprint,
        }
    }

    fn manifest_mut(&mut self, store: Store) -> &mut Manifest {
        match store {
            Store::Recording => &mut self.recording,
            Store::Blueprint => &mut self.blueprint,
        }
    }
}
