//! A dataset's file: reading it, writing it, and going on after a kill.

use std::path::{Path, PathBuf};

use tunenet_core::network::{DataSet, DatasetHeader, Pair, Shard};

use super::message::{
    CLOCK_DEFINITION, ClockedPair, DATASET_DEFINITION, DATASET_TOPIC, HeaderMessage, PAIR_DEFINITION, PAIR_TOPIC,
    PlainPair, SHARD_DEFINITION, SHARD_TOPIC, ShardMessage, TARGET_DEFINITION,
};
use super::stream::{Output, Source};
use crate::{Action, Error, Result};

/// Pairs in a chunk. A kill loses at most the chunk being filled.
const PAIRS_IN_CHUNK: u64 = 16;

/// Reads a dataset pair by pair, with the memory of one chunk.
pub struct DatasetReader {
    path: PathBuf,
    source: Source,
    header: DatasetHeader,
    shard: Option<ShardMessage>,
    /// How many pairs there have to be.
    expected: u64,
    read: u64,
    ended: bool,
}

impl DatasetReader {
    /// Opens a dataset and reads its header.
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::File`] where the file cannot be read, is not MCAP, holds no dataset, holds a shard of one,
    /// or is of another version.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self> {
        let reader = Self::open_either(path.into())?;
        match &reader.shard {
            None => Ok(reader),
            Some(shard) => {
                let text = format!("expected a whole dataset, found shard {}/{}", shard.index, shard.count);
                Err(Error::file(&reader.path, text, "`tunenet merge` puts shards together"))
            }
        }
    }

    /// Opens a shard of a dataset. Its header is the dataset's own; its pairs are those of [`shard`](Self::shard) alone.
    ///
    /// # Errors
    /// As [`open`](Self::open); [`Error::File`] for a whole dataset.
    pub fn open_shard(path: impl Into<PathBuf>) -> Result<Self> {
        let reader = Self::open_either(path.into())?;
        if reader.shard.is_some() {
            return Ok(reader);
        }
        let hint = "`tunenet gen --shard` writes shards; a whole dataset needs no merging";
        Err(Error::file(&reader.path, "expected a shard of a dataset, found a whole one", hint))
    }

    fn open_either(path: PathBuf) -> Result<Self> {
        let mut source = Source::open(&path)?;
        let Some((shard, message)) = begin(&mut source)? else {
            let text = format!("expected a dataset, found an MCAP file without a message on `{DATASET_TOPIC}`");
            return Err(Error::file(&path, text, "`tunenet gen` writes datasets"));
        };
        let header = message.header(&path)?;
        let block = shard.as_ref().map(|s| s.shard(&path)).transpose()?.map(|s| s.block(header.pairs));
        let expected = block.map_or(header.pairs, |block| block.end - block.start);
        Ok(Self { path, source, header, shard, expected, read: 0, ended: false })
    }

    /// Which share of the dataset this is; `None` for a whole one.
    #[must_use]
    pub fn shard(&self) -> Option<Shard> {
        self.shard.as_ref().and_then(|shard| shard.shard(&self.path).ok())
    }

    pub(crate) fn shard_message(&self) -> Option<&ShardMessage> {
        self.shard.as_ref()
    }

    /// Whether `path` is this shard of this dataset, written by this version and complete.
    #[must_use]
    pub fn holds(path: &Path, header: &DatasetHeader, shard: Shard) -> bool {
        let Ok(mut reader) = Self::open_shard(path) else { return false };
        reader.shard == Some(ShardMessage::new(shard)) && reader.header == *header && reader.all(|pair| pair.is_ok())
    }

    /// What all pairs share.
    #[must_use]
    pub fn header(&self) -> &DatasetHeader {
        &self.header
    }

    fn next_pair(&mut self) -> Result<Option<Pair>> {
        let expected = self.expected;
        let Some(pair) = next_pair(&mut self.source, &self.header)? else {
            if self.read == expected {
                return Ok(None);
            }
            let text = format!("expected {expected} pairs, found {}", self.read);
            return Err(Error::file(&self.path, text, "run `tunenet gen` again; it resumes"));
        };
        self.header
            .check(&pair)
            .map_err(|m| Error::file(&self.path, format!("pair {}: {m}", self.read), "write the dataset again"))?;
        self.read += 1;
        Ok(Some(pair))
    }
}

impl Iterator for DatasetReader {
    type Item = Result<Pair>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let next = self.next_pair().transpose();
        self.ended = !matches!(next, Some(Ok(_)));
        next
    }
}

/// A dataset's file, opened again for each pass over its pairs.
pub struct DatasetFile {
    path: PathBuf,
    header: DatasetHeader,
}

impl DatasetFile {
    /// Reads the header of the dataset at `path`.
    ///
    /// # Errors
    /// As [`DatasetReader::open`].
    pub fn open(path: impl Into<PathBuf>) -> Result<Self> {
        let path = path.into();
        let header = DatasetReader::open(&path)?.header;
        Ok(Self { path, header })
    }
}

impl DataSet for DatasetFile {
    fn header(&self) -> &DatasetHeader {
        &self.header
    }

    fn pairs(&self) -> tunenet_core::Result<Box<dyn Iterator<Item = tunenet_core::Result<Pair>> + '_>> {
        Ok(Box::new(DatasetReader::open(&self.path)?.map(|pair| Ok(pair?))))
    }
}

/// Writes a dataset, and resumes one that was interrupted.
///
/// Everything goes to `OUT.partial`; [`DatasetWriter::finish`] gives it its name. Whoever is killed and started again with
/// the same header finds the complete pairs and writes only the rest; the finished file is the same, byte for byte.
pub struct DatasetWriter {
    out: PathBuf,
    partial: PathBuf,
    output: Output,
    header: DatasetHeader,
    topic: u16,
    written: u64,
    end: u64,
}

impl DatasetWriter {
    /// Starts `out`, or resumes `out.partial`; where `shard` says so, for one share of the pairs.
    ///
    /// # Errors
    /// [`Error::Io`] where a file cannot be written; [`Error::File`] where `out.partial` belongs to another dataset.
    pub fn open(out: impl Into<PathBuf>, header: DatasetHeader, shard: Option<Shard>) -> Result<Self> {
        let out = out.into();
        if out.is_dir() {
            return Err(Error::io(&out, Action::Writing, std::io::ErrorKind::IsADirectory.into()));
        }
        let partial = with_suffix(&out, ".partial");
        if !partial.exists() {
            return Self::begin(out, &partial.clone(), partial, header, shard);
        }
        let mut earlier = Earlier::open(&partial, &header, shard)?;
        // Copied next to it first, so that a second kill finds one of the two whole.
        let copy = with_suffix(&out, ".partial.copy");
        let mut writer = Self::begin(out, &copy, partial.clone(), header, shard)?;
        while let Some(pair) = earlier.next() {
            writer.write(&pair)?;
        }
        std::fs::rename(&copy, &partial).map_err(|e| Error::io(&partial, Action::Renaming, e))?;
        Ok(writer)
    }

    fn begin(out: PathBuf, at: &Path, partial: PathBuf, header: DatasetHeader, shard: Option<Shard>) -> Result<Self> {
        let mut output = Output::create(at)?;
        if let Some(shard) = shard {
            let topic = output.topic(SHARD_TOPIC, "tunenet_msgs/msg/Shard", SHARD_DEFINITION)?;
            output.write(topic, 0, &ShardMessage::new(shard))?;
        }
        let targets = if header.target_channels.is_empty() { "" } else { TARGET_DEFINITION };
        let definition = format!("{DATASET_DEFINITION}{targets}");
        let dataset = output.topic(DATASET_TOPIC, "tunenet_msgs/msg/Dataset", &definition)?;
        let clock = if header.clocks_in_pairs() { CLOCK_DEFINITION } else { "" };
        let topic = output.topic(PAIR_TOPIC, "tunenet_msgs/msg/Pair", &format!("{PAIR_DEFINITION}{clock}"))?;
        output.write(dataset, 0, &HeaderMessage::from(&header))?;
        output.end_chunk()?;
        let pairs = shard.map_or(0..header.pairs, |shard| shard.block(header.pairs));
        Ok(Self { out, partial, output, header, topic, written: pairs.start, end: pairs.end })
    }

    /// The number, from 0, of the pair that is to be written next; of a whole dataset, how many are there already.
    #[must_use]
    pub fn written(&self) -> u64 {
        self.written
    }

    /// The number of the pair at which this file ends.
    #[must_use]
    pub fn end(&self) -> u64 {
        self.end
    }

    /// Writes the next pair.
    ///
    /// # Errors
    /// [`Error::Io`] where the disk refuses; [`Error::File`] where the pair does not fit the header or all are there.
    pub fn write(&mut self, pair: &Pair) -> Result<()> {
        let refuse = |text: String| Err(Error::file(&self.out, format!("pair {}: {text}", self.written), ""));
        if self.written == self.end {
            return refuse(format!("expected {} pairs, found more", self.end));
        }
        if let Err(text) = self.header.check(pair) {
            return refuse(text);
        }
        self.written += 1;
        if self.header.clocks_in_pairs() {
            self.output.write(self.topic, self.written, &ClockedPair::from(pair.clone()))?;
        } else {
            self.output.write(self.topic, self.written, &PlainPair(pair.clone()))?;
        }
        if self.written.is_multiple_of(PAIRS_IN_CHUNK) {
            self.output.end_chunk()?;
        }
        Ok(())
    }

    /// Forgets what an interrupted run left over of `out`, so that the next one begins again.
    ///
    /// # Errors
    /// [`Error::Io`] where it cannot be removed.
    pub fn forget(out: &Path) -> Result<()> {
        let partial = with_suffix(out, ".partial");
        match std::fs::remove_file(&partial) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::io(&partial, Action::Removing, error))
            }
            _ => Ok(()),
        }
    }

    /// Ends the file, waits for the disk and gives the file its name.
    ///
    /// # Errors
    /// [`Error::Io`] where the disk refuses; [`Error::File`] where pairs are missing.
    pub fn finish(self) -> Result<()> {
        if self.written != self.end {
            let text = format!("expected pairs up to {}, found {}", self.end, self.written);
            return Err(Error::file(&self.out, text, ""));
        }
        self.output.finish()?;
        std::fs::rename(&self.partial, &self.out).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => {
                let text = "expected it at the end, as this command wrote it, found none";
                Error::file(
                    &self.partial,
                    text,
                    "does another command write to the same --out? Run one after the other",
                )
            }
            _ => Error::io(&self.out, Action::Renaming, error),
        })
    }
}

/// The complete pairs of an interrupted file.
struct Earlier {
    source: Option<Source>,
    header: DatasetHeader,
}

impl Earlier {
    fn open(partial: &Path, expected: &DatasetHeader, shard: Option<Shard>) -> Result<Self> {
        let mut source = Source::open(partial)?;
        let refuse = |found: &str| {
            let text = format!("expected the beginning of this dataset, found {found}");
            let hint = "delete it, or write to another --out";
            Err(Error::file(partial, text, hint))
        };
        match begin(&mut source) {
            Ok(Some((share, message))) => {
                let found = message.header(partial)?;
                if found != *expected || share != shard.map(ShardMessage::new) {
                    return refuse("one with other settings");
                }
                Ok(Self { source: Some(source), header: found })
            }
            Ok(None) => refuse("an MCAP file that is no dataset"),
            Err(_) if begins_like_mcap(partial)? => Ok(Self { source: None, header: expected.clone() }),
            Err(_) => refuse("another kind of file"),
        }
    }

    /// The next complete pair; what is wrong after it is written again.
    fn next(&mut self) -> Option<Pair> {
        let pair = next_pair(self.source.as_mut()?, &self.header).ok()??;
        self.header.check(&pair).is_ok().then_some(pair)
    }
}

/// What a dataset begins with: which share of it this is, where it is one, and the header.
fn begin(source: &mut Source) -> Result<Option<(Option<ShardMessage>, HeaderMessage)>> {
    let mut shard = None;
    while let Some((topic, body)) = source.next_of(&[SHARD_TOPIC, DATASET_TOPIC])? {
        if topic == DATASET_TOPIC {
            return Ok(Some((shard, source.decode(DATASET_TOPIC, &body)?)));
        }
        shard = Some(source.decode(SHARD_TOPIC, &body)?);
    }
    Ok(None)
}

/// The next pair in the form that the header announces.
fn next_pair(source: &mut Source, header: &DatasetHeader) -> Result<Option<Pair>> {
    if header.clocks_in_pairs() {
        return Ok(source.next::<ClockedPair>(PAIR_TOPIC)?.map(Pair::from));
    }
    Ok(source.next::<PlainPair>(PAIR_TOPIC)?.map(|PlainPair(pair)| pair))
}

/// Whether what there is of the file could be the beginning of an MCAP file (killed before its first chunk was out).
fn begins_like_mcap(path: &Path) -> Result<bool> {
    use std::io::Read;
    let mut start = Vec::new();
    let file = std::fs::File::open(path).map_err(|e| Error::io(path, Action::Reading, e))?;
    file.take(mcap::MAGIC.len() as u64).read_to_end(&mut start).map_err(|e| Error::io(path, Action::Reading, e))?;
    Ok(mcap::MAGIC.starts_with(&start))
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}
