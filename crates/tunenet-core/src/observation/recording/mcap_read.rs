//! The messages of an MCAP file, one by one.
//!
//! The file is read from start to end in small pieces, so its size does not matter and an index is not needed; a recording
//! that was cut off gives every message up to the cut.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, records::op};

use super::open;
use super::whole_chunks::WholeChunks;
use crate::{Error, Result};

/// Longest record in bytes. An uncompressed 4K picture has 25 MB; a length beyond this is a broken file.
const LONGEST_RECORD: usize = 256 << 20;

/// Longest record of a small file, in bytes: a picture of one colour shrinks to nearly nothing.
const LONGEST_SMALL: usize = 32 << 20;

/// How much a file may grow as it is unpacked beyond that. What a broken length promises is set aside before it is read.
const MOST_GROWTH: u64 = 64;

/// How much is asked of the file at a time, in bytes, whatever a record promises.
pub(crate) const PIECE: usize = 64 << 10;

/// The longest record that a file of `bytes` is believed to hold, in bytes, and never more than `most`.
pub(crate) fn longest_record(bytes: u64, most: usize) -> usize {
    usize::try_from(bytes.saturating_mul(MOST_GROWTH)).unwrap_or(usize::MAX).max(LONGEST_SMALL).min(most)
}

/// A channel of an MCAP file, with its schema.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ChannelInfo {
    /// Its number in the file.
    pub id: u16,
    pub topic: String,
    /// `cdr`, `json`, …
    pub message_encoding: String,
    /// Empty where there is no schema.
    pub schema_name: String,
}

/// One message, not decoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RawMessage {
    pub channel: Arc<ChannelInfo>,
    /// When it was recorded, in ns.
    pub log_time: u64,
    pub data: Vec<u8>,
}

/// The messages of a file in the order in which they stand there. Ends after the first error.
pub(crate) struct Messages {
    path: PathBuf,
    file: WholeChunks<File>,
    reader: LinearReader,
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Arc<ChannelInfo>>,
    library: String,
    profile: String,
    count: u64,
    ended: bool,
}

/// Opens an MCAP file.
///
/// # Errors
/// [`Error::Io`] or [`Error::File`] where the file cannot be opened. The iterator returns [`Error::File`] once, as its
/// last item, where the file is cut off or broken, and says how many messages came before.
pub(crate) fn messages(path: impl AsRef<Path>) -> Result<Messages> {
    let path = path.as_ref();
    let file = open(path)?;
    let bytes = file.metadata().map_err(|e| Error::io(path, "opening", e))?.len();
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(longest_record(bytes, LONGEST_RECORD));
    Ok(Messages {
        path: path.into(),
        file: WholeChunks::new(file),
        reader: LinearReader::new_with_options(options),
        schemas: BTreeMap::new(),
        channels: BTreeMap::new(),
        library: String::new(),
        profile: String::new(),
        count: 0,
        ended: false,
    })
}

impl Messages {
    /// The channels met so far, with or without messages.
    pub(crate) fn channels(&self) -> impl Iterator<Item = &Arc<ChannelInfo>> {
        self.channels.values()
    }

    /// Who wrote the file, as far as its header says: profile and library.
    pub(crate) fn writer(&self) -> (&str, &str) {
        (&self.profile, &self.library)
    }

    fn broken(&self, error: &McapError) -> Error {
        let what = match error {
            McapError::UnexpectedEof if self.file.overrun() => {
                "a record is longer than the chunk it stands in".to_owned()
            }
            McapError::UnexpectedEof => "the recording is cut off".to_owned(),
            McapError::BadMagic => "expected the mark of an MCAP file, found other bytes".to_owned(),
            McapError::UnsupportedCompression(name) => format!("expected zstd or lz4 chunks, found `{name}`"),
            McapError::Parse(_) => "a record does not follow the MCAP format".to_owned(),
            other => {
                let text = other.to_string();
                let mut letters = text.chars();
                letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
            }
        };
        let messages = if self.count == 1 { "message" } else { "messages" };
        let hint = format!("try `mcap recover {} -o recovered.mcap`, which keeps them", self.path.display());
        Error::file(&self.path, format!("{what}: {} {messages} could be read before", self.count), hint)
    }

    /// Takes in one record; returns it where it is a message.
    fn take(&mut self, record: Record<'static>) -> std::result::Result<Option<RawMessage>, McapError> {
        match record {
            Record::Header(header) => (self.profile, self.library) = (header.profile, header.library),
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                // The summary at the end repeats every channel.
                let schema_name = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                self.channels.entry(channel.id).or_insert_with(|| {
                    Arc::new(ChannelInfo {
                        id: channel.id,
                        topic: channel.topic,
                        message_encoding: channel.message_encoding,
                        schema_name,
                    })
                });
            }
            Record::Message { header, data } => {
                let Some(channel) = self.channels.get(&header.channel_id) else {
                    return Err(McapError::UnknownChannel(header.sequence, header.channel_id));
                };
                self.count += 1;
                return Ok(Some(RawMessage {
                    channel: Arc::clone(channel),
                    log_time: header.log_time,
                    data: data.into_owned(),
                }));
            }
            _ => {}
        }
        Ok(None)
    }

    fn step(&mut self) -> Result<Step> {
        let record = match self.reader.next_event() {
            None => return Ok(Step::End),
            Some(Err(error)) => return Err(self.broken(&error)),
            Some(Ok(LinearReadEvent::ReadRequest(need))) => {
                let piece = self.reader.insert(need.clamp(1, PIECE));
                let read = self.file.read(piece).map_err(|e| Error::io(&self.path, "reading", e))?;
                self.reader.notify_read(read);
                return Ok(Step::Further);
            }
            Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                if !matches!(opcode, op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                    return Ok(Step::Further);
                }
                mcap::parse_record(opcode, data).map(Record::into_owned)
            }
        };
        let message = record.and_then(|record| self.take(record)).map_err(|error| self.broken(&error))?;
        Ok(message.map_or(Step::Further, Step::Message))
    }
}

enum Step {
    Message(RawMessage),
    Further,
    End,
}

impl Iterator for Messages {
    type Item = Result<RawMessage>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.ended {
            match self.step() {
                Ok(Step::Further) => {}
                Ok(Step::Message(message)) => return Some(Ok(message)),
                Ok(Step::End) => self.ended = true,
                Err(error) => {
                    self.ended = true;
                    return Some(Err(error));
                }
            }
        }
        None
    }
}
