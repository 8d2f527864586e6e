//! The messages of an MCAP file, one by one.
//!
//! The file is read from start to end in small pieces, so its size does not matter and an index is not needed; a recording
//! that was cut off gives every message up to the cut.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, records::op};

use super::whole_chunks::{PIECE, WholeChunks};
use crate::ros::channel::{ChannelInfo, Decoders, RawMessage};
use crate::ros::decoder::{Described, MOST_DEFINITIONS};
use crate::ros::schema::Given;
use crate::shown::{counted, shell_word};
use crate::source::open;
use crate::{Action, Error, Result};

/// Longest record in bytes. An uncompressed 4K picture has 25 MB; a length beyond this is a broken file.
const LONGEST_RECORD: usize = 256 << 20;

/// Longest record of a small file, in bytes: a picture of one colour shrinks to nearly nothing.
const LONGEST_SMALL: usize = 32 << 20;

/// How much a file may grow as it is unpacked beyond that. Memory for a corrupted length is allocated before it is read.
const MOST_GROWTH: u64 = 64;

/// How many bytes of records are unpacked at most, whatever the size of the file: what a chunk of zeros unpacks to takes minutes.
const MOST_UNPACKED: u64 = 256 << 20;

/// Kind and length before every record, in bytes.
const RECORD_HEAD: u64 = 9;

/// The longest record that a file of `bytes` can plausibly hold, in bytes, and never more than `most`.
fn longest_record(bytes: u64, most: usize) -> usize {
    usize::try_from(bytes.saturating_mul(MOST_GROWTH)).unwrap_or(usize::MAX).max(LONGEST_SMALL).min(most)
}

/// The messages of a file in the order in which they stand there. Ends after the first error.
pub(crate) struct Messages {
    path: PathBuf,
    file: WholeChunks<File>,
    reader: LinearReader,
    /// The name, the language and the text of each schema.
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    /// Bytes of schemas that may still come.
    definitions_left: usize,
    /// How messages of each schema are read.
    decoders: BTreeMap<u16, Decoders>,
    /// Definitions of types that the file does not define.
    given: Vec<(String, String)>,
    channels: BTreeMap<u16, Arc<ChannelInfo>>,
    library: String,
    profile: String,
    count: u64,
    /// Bytes of records that may still be unpacked.
    left: u64,
    ended: bool,
}

/// Opens an MCAP file.
///
/// # Errors
/// [`Error::Io`] or [`Error::File`] where the file cannot be opened. The iterator returns [`Error::File`] once, as its
/// last item, where the file is cut off or broken, and says how many messages came before.
pub(crate) fn messages(path: impl AsRef<Path>) -> Result<Messages> {
    messages_up_to(path.as_ref(), LONGEST_RECORD)
}

/// As [`messages`], where a record may have up to `longest` bytes.
///
/// # Errors
/// As [`messages`].
pub(crate) fn messages_up_to(path: &Path, longest: usize) -> Result<Messages> {
    messages_within(path, longest, MOST_UNPACKED)
}

/// As [`messages_up_to`], where `unpacked` bytes of records are plausible whatever the size of the file.
fn messages_within(path: &Path, longest: usize, unpacked: u64) -> Result<Messages> {
    let file = open(path)?;
    let bytes = file.metadata().map_err(|e| Error::io(path, Action::Opening, e))?.len();
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(longest_record(bytes, longest));
    Ok(Messages {
        path: path.into(),
        file: WholeChunks::new(file),
        reader: LinearReader::new_with_options(options),
        schemas: BTreeMap::new(),
        definitions_left: MOST_DEFINITIONS,
        decoders: BTreeMap::new(),
        given: Vec::new(),
        channels: BTreeMap::new(),
        library: String::new(),
        profile: String::new(),
        count: 0,
        left: unpacked.max(bytes.saturating_mul(MOST_GROWTH)),
        ended: false,
    })
}

impl Messages {
    /// The same, with errors that name `path`: the messages stand in a copy.
    #[cfg(feature = "logs")]
    pub(crate) fn of(self, path: &Path) -> Self {
        Self { path: path.into(), ..self }
    }

    /// The same, where `given` defines types that the file does not.
    pub(crate) fn with_definitions(self, given: &Given) -> Self {
        Self { given: given.to_vec(), ..self }
    }

    /// The channels met so far, with or without messages.
    pub(crate) fn channels(&self) -> impl Iterator<Item = &Arc<ChannelInfo>> {
        self.channels.values()
    }

    /// Who wrote the file, as far as its header says: profile and library.
    pub(crate) fn writer(&self) -> (&str, &str) {
        (&self.profile, &self.library)
    }

    /// The next message, `None` at the end of the file. After a fault there is nothing more to ask for.
    pub(crate) fn advance(&mut self) -> std::result::Result<Option<RawMessage>, Fault> {
        loop {
            let record = match self.reader.next_event() {
                None => return Ok(None),
                Some(Err(McapError::UnexpectedEof)) if self.file.overrun() => return Err(Fault::Overrun),
                Some(event) => match event? {
                    LinearReadEvent::ReadRequest(need) => {
                        let read = self.file.read(self.reader.insert(need.clamp(1, PIECE))).map_err(Fault::Io)?;
                        self.reader.notify_read(read);
                        continue;
                    }
                    // What else there is, is not parsed: the crate's parser of attachments panics on short ones.
                    LinearReadEvent::Record { data, opcode } => {
                        let unpacked = data.len() as u64 + RECORD_HEAD;
                        self.left = self.left.checked_sub(unpacked).ok_or(Fault::Growth)?;
                        match opcode {
                            op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                                mcap::parse_record(opcode, data)?.into_owned()
                            }
                            _ => continue,
                        }
                    }
                },
            };
            if let Some(message) = self.take(record)? {
                return Ok(Some(message));
            }
        }
    }

    fn broken(&self, fault: Fault) -> Error {
        let hint = match &fault {
            Fault::Format(McapError::UnsupportedCompression(_)) => {
                "record with zstd, lz4 or uncompressed chunks".into()
            }
            Fault::Growth => "record again: such chunks hold next to nothing but zeros".to_owned(),
            Fault::Definitions => "record only the topics that are needed".to_owned(),
            _ if self.count == 0 => "copy the recording again".to_owned(),
            _ => format!(
                "try `mcap recover {} -o recovered.mcap`, which keeps what can be read; `mcap` is the command-line tool of \
                 https://mcap.dev",
                shell_word(&self.path.to_string_lossy())
            ),
        };
        let what = match fault {
            Fault::Io(error) => return Error::io(&self.path, Action::Reading, error),
            Fault::Overrun => "a record is longer than the chunk it stands in".to_owned(),
            Fault::Growth => {
                format!(
                    "its chunks unpack to more than {MOST_GROWTH} times its size and more than {MOST_UNPACKED} bytes"
                )
            }
            Fault::Definitions => {
                format!("expected at most {MOST_DEFINITIONS} bytes of message definitions, found more")
            }
            #[cfg(feature = "logs")]
            Fault::Packed(why) => format!("a message {why}"),
            Fault::Format(McapError::UnexpectedEof) => "the recording is cut off".to_owned(),
            Fault::Format(McapError::BadMagic) => "expected the mark of an MCAP file, found other bytes".to_owned(),
            Fault::Format(McapError::UnsupportedCompression(name)) => {
                format!("expected zstd or lz4 chunks, found `{name}`")
            }
            Fault::Format(McapError::Parse(_)) => "a record does not follow the MCAP format".to_owned(),
            Fault::Format(other) => {
                let text = other.to_string();
                let mut letters = text.chars();
                letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
            }
        };
        Error::file(&self.path, format!("{what}: {} could be read before", counted(self.count, "message")), hint)
    }

    /// A channel as its record and its schema describe it.
    fn channel(&mut self, record: &mcap::records::Channel) -> ChannelInfo {
        let schema = self.schemas.get(&record.schema_id);
        let (schema_name, schema_encoding, definition) =
            schema.map_or(("", "", &[][..]), |(name, encoding, text)| (name, encoding, text));
        let message_encoding = &record.message_encoding;
        let described = Described { message_encoding, schema_name, schema_encoding, definition };
        let known = self.decoders.entry(record.schema_id).or_default();
        ChannelInfo::new(record.id, record.topic.clone(), described, &self.given, known)
    }

    /// A message as it was before `rosbag2` compressed it by itself.
    #[cfg(feature = "logs")]
    fn whole(&mut self, data: Vec<u8>) -> std::result::Result<Vec<u8>, Fault> {
        if data.starts_with(crate::format::ZSTD) {
            let whole = crate::bag::unpacked_message(&data, LONGEST_RECORD).map_err(Fault::Packed)?;
            self.left = self.left.checked_sub(whole.len() as u64).ok_or(Fault::Growth)?;
            return Ok(whole);
        }
        Ok(data)
    }

    /// Takes in one record; returns it where it is a message.
    fn take(&mut self, record: Record<'static>) -> std::result::Result<Option<RawMessage>, Fault> {
        match record {
            Record::Header(header) => (self.profile, self.library) = (header.profile, header.library),
            Record::Schema { header, data } => {
                // The summary at the end repeats every schema, and the first one of a number counts.
                if let Entry::Vacant(new) = self.schemas.entry(header.id) {
                    let left = self.definitions_left.checked_sub(data.len() + header.name.len());
                    self.definitions_left = left.ok_or(Fault::Definitions)?;
                    new.insert((header.name, header.encoding, data.into_owned()));
                }
            }
            // The summary repeats every channel, too.
            Record::Channel(channel) if !self.channels.contains_key(&channel.id) => {
                let info = self.channel(&channel);
                self.channels.insert(channel.id, Arc::new(info));
            }
            Record::Message { header, data } => {
                let Some(channel) = self.channels.get(&header.channel_id) else {
                    return Err(McapError::UnknownChannel(header.sequence, header.channel_id).into());
                };
                let channel = Arc::clone(channel);
                #[cfg(feature = "logs")]
                let data = self.whole(data.into_owned())?;
                // A build that cannot unpack a message says so where it reads it.
                #[cfg(not(feature = "logs"))]
                let data = data.into_owned();
                self.count += 1;
                return Ok(Some(RawMessage { channel, log_time: header.log_time, data }));
            }
            _ => {}
        }
        Ok(None)
    }
}

/// Why there is no next message.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The file could not be read.
    Io(std::io::Error),
    /// A record runs past the end of its chunk.
    Overrun,
    /// The chunks unpack to implausibly many bytes.
    Growth,
    /// The definitions of its types are implausibly long.
    Definitions,
    /// A message that is compressed by itself is broken.
    #[cfg(feature = "logs")]
    Packed(String),
    /// Anything else that the format does not allow.
    Format(McapError),
}

impl From<McapError> for Fault {
    fn from(error: McapError) -> Self {
        Self::Format(error)
    }
}

impl Iterator for Messages {
    type Item = Result<RawMessage>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let next = self.advance();
        self.ended = !matches!(next, Ok(Some(_)));
        next.map_err(|fault| self.broken(fault)).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{bag, error_text, file, made};

    /// Five megabytes of zeros in a file of a few kilobytes.
    #[test]
    fn chunks_that_unpack_to_far_more_than_their_file_are_refused() {
        let zeros = made("/zeros", "std_msgs/msg/String", 5, |_, _| vec![0; 1_000_000]);
        let (_folder, path) = file("a.mcap", bag(Some(mcap::Compression::Zstd), &[zeros]));
        assert_eq!(messages(&path).unwrap().flatten().count(), 5);
        let refused = messages_within(&path, LONGEST_RECORD, 1 << 20).unwrap().find_map(Result::err).unwrap();
        let (message, hint) = error_text(&refused);
        assert!(message.starts_with("a.mcap: its chunks unpack to more than 64 times its size"), "{message}");
        assert!(hint.starts_with("record again"), "{hint}");
    }

    /// As `rosbag2` writes them with `--compression-mode message`.
    #[cfg(feature = "logs")]
    #[test]
    fn messages_that_are_compressed_one_by_one_are_unpacked() {
        let text = |i: i64| vec![0, 1, 0, 0, i.to_le_bytes()[0]];
        let read = |packed: &dyn Fn(Vec<u8>) -> Vec<u8>| {
            let topic = made("/a", "std_msgs/msg/String", 3, |ns, _| packed(text(ns)));
            let (_folder, path) = file("a.mcap", bag(None, &[topic]));
            let all: Result<Vec<Vec<u8>>> = messages(&path).unwrap().map(|one| Ok(one?.data)).collect();
            all
        };
        let pack = |data: Vec<u8>| zstd::encode_all(&data[..], 3).unwrap();
        assert_eq!(read(&pack).unwrap(), read(&|data| data).unwrap());
        let cut = read(&|data| pack(data)[..9].to_vec()).unwrap_err();
        let (message, _) = error_text(&cut);
        assert!(message.starts_with("a.mcap: a message cannot be unpacked with zstd"), "{message}");
    }

    /// Schemas of a megabyte each, which shrink to nearly nothing.
    #[test]
    fn definitions_of_implausible_length_are_refused() {
        let text = " ".repeat(1 << 20);
        let mut bytes = Vec::new();
        let options = mcap::WriteOptions::new().compression(Some(mcap::Compression::Zstd)).compression_threads(0);
        let mut writer = options.create(std::io::Cursor::new(&mut bytes)).unwrap();
        for number in 0..20 {
            let schema = writer.add_schema(&format!("a/{number}"), "ros2msg", text.as_bytes()).unwrap();
            let channel = writer.add_channel(schema, &format!("/{number}"), "cdr", &BTreeMap::new()).unwrap();
            let header =
                mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
            writer.write_to_known_channel(&header, &[0; 8]).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        let (_folder, path) = file("a.mcap", &bytes);
        let refused = messages(&path).unwrap().find_map(Result::err).unwrap();
        let (message, hint) = error_text(&refused);
        assert!(
            message.contains("expected at most 16777216 bytes of message definitions, found more: 15"),
            "{message}"
        );
        assert_eq!(hint, "record only the topics that are needed");
    }
}
