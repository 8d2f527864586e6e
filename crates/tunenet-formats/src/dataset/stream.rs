//! MCAP in and out, one message at a time.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use byteorder::LittleEndian;
use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::mcap::reader::{Fault, Messages, messages_up_to};
use crate::ros::cdr::{LITTLE_ENDIAN, encode};
use crate::{Action, Error, Result};

/// Longest plausible record; a corrupted length would otherwise allocate all memory.
const LONGEST_RECORD: usize = 1 << 30;

/// A file being written.
pub(crate) struct Output {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
}

impl Output {
    /// A new file at `path`. Every setting that could differ between two machines is fixed: equal messages, equal bytes.
    pub(crate) fn create(path: &Path) -> Result<Self> {
        let file = File::create(path).map_err(|e| Error::io(path, Action::Creating, e))?;
        let writer = WriteOptions::new()
            .profile("ros2")
            .library(concat!("tunenet ", env!("CARGO_PKG_VERSION")))
            .compression(Some(mcap::Compression::Zstd))
            .compression_threads(0)
            // Chunks end where `end_chunk` says, so that they do not depend on how the writing was interrupted.
            .chunk_size(None)
            .create(BufWriter::new(file))
            .map_err(|e| mcap_error(path, Action::Writing, e))?;
        Ok(Self { path: path.to_owned(), writer })
    }

    /// A topic with its ROS 2 message definition; returns its number.
    pub(crate) fn topic(&mut self, topic: &str, message: &str, definition: &str) -> Result<u16> {
        let failed = |e| mcap_error(&self.path, Action::Writing, e);
        let schema = self.writer.add_schema(message, "ros2msg", definition.as_bytes()).map_err(failed)?;
        self.writer.add_channel(schema, topic, "cdr", &std::collections::BTreeMap::new()).map_err(failed)
    }

    /// One message. `number` is its place in the file; there is no clock time, so that equal runs write equal bytes.
    pub(crate) fn write(&mut self, topic: u16, number: u64, message: &impl Serialize) -> Result<()> {
        let bytes =
            encode(message).map_err(|e| Error::file(&self.path, format!("a message cannot be written: {e}"), ""))?;
        let header = MessageHeader {
            channel_id: topic,
            sequence: u32::try_from(number).unwrap_or(u32::MAX),
            log_time: number,
            publish_time: number,
        };
        self.writer.write_to_known_channel(&header, &bytes).map_err(|e| mcap_error(&self.path, Action::Writing, e))
    }

    /// Closes the chunk, so that what was written so far can be read back after a kill.
    pub(crate) fn end_chunk(&mut self) -> Result<()> {
        self.writer.flush().map_err(|e| mcap_error(&self.path, Action::Writing, e))
    }

    /// Ends the file and waits until the disk has it.
    pub(crate) fn finish(mut self) -> Result<()> {
        self.writer.finish().map_err(|e| mcap_error(&self.path, Action::Writing, e))?;
        let failed = |e| Error::io(&self.path, Action::Writing, e);
        let file = self.writer.into_inner().into_inner().map_err(|e| failed(e.into_error()))?;
        file.sync_all().map_err(failed)
    }
}

/// A file being read, front to back, with the memory of one chunk.
pub(crate) struct Source {
    path: PathBuf,
    messages: Messages,
}

impl Source {
    /// Opens `path`.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        Ok(Self { path: path.to_owned(), messages: messages_up_to(path, LONGEST_RECORD)? })
    }

    /// The next message on `topic`, `None` at the end of the file.
    pub(crate) fn next<M: DeserializeOwned>(&mut self, topic: &str) -> Result<Option<M>> {
        let Some((_, body)) = self.next_of(&[topic])? else { return Ok(None) };
        self.decode(topic, &body).map(Some)
    }

    /// The next message on any of these topics, with its topic, not decoded yet; `None` at the end of the file.
    pub(crate) fn next_of<'t>(&mut self, topics: &[&'t str]) -> Result<Option<(&'t str, Vec<u8>)>> {
        loop {
            let Some(message) = self.messages.advance().map_err(|fault| broken(&self.path, fault))? else {
                return Ok(None);
            };
            if let Some(topic) = topics.iter().find(|topic| **topic == message.channel.topic) {
                return Ok(Some((topic, message.data)));
            }
        }
    }

    /// What a message on `topic` says.
    pub(crate) fn decode<M: DeserializeOwned>(&self, topic: &str, body: &[u8]) -> Result<M> {
        let wrong = |found: String| {
            let text = format!("expected a message in little-endian CDR on `{topic}`, found {found}");
            Error::file(&self.path, text, "write the dataset again with `tunenet gen`")
        };
        let Some(body) = body.strip_prefix(&LITTLE_ENDIAN) else {
            return Err(wrong("another encapsulation".into()));
        };
        cdr_encoding::from_bytes::<M, LittleEndian>(body).map(|(read, _)| read).map_err(|e| wrong(e.to_string()))
    }
}

/// Why a dataset cannot be read on, in one sentence.
fn broken(path: &Path, fault: Fault) -> Error {
    match fault {
        Fault::Io(source) => Error::io(path, Action::Reading, source),
        Fault::Overrun => Error::file(
            path,
            "expected a sound MCAP file, found a record that is longer than its chunk",
            "write the file again",
        ),
        #[cfg(feature = "logs")]
        Fault::Packed(why) => Error::file(path, format!("a message {why}"), "write the file again"),
        Fault::Growth => Error::file(
            path,
            "expected a dataset, found chunks that unpack to implausibly many bytes",
            "write the file again",
        ),
        Fault::Definitions => Error::file(
            path,
            "expected a dataset, found message definitions of implausible length",
            "write the file again",
        ),
        Fault::Format(error) => mcap_error(path, Action::Reading, error),
    }
}

/// What went wrong with an MCAP file, in one sentence.
fn mcap_error(path: &Path, action: Action, error: McapError) -> Error {
    match error {
        McapError::Io(source) => Error::io(path, action, source),
        McapError::BadMagic => {
            Error::file(path, "expected an MCAP file, found another kind", "`tunenet gen` writes datasets")
        }
        McapError::UnexpectedEof | McapError::UnexpectedEoc => Error::file(
            path,
            "expected a complete MCAP file, found one that was cut short",
            "run the command that wrote it again",
        ),
        other => Error::file(path, format!("expected a sound MCAP file, found: {other}"), "write the file again"),
    }
}
