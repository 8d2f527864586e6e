//! A dataset's file: reading it, writing it, and going on after a kill.

use std::path::{Path, PathBuf};

use super::dataset::{
    CLOCK_DEFINITION, ClockedPair, DATASET_DEFINITION, DATASET_TOPIC, DatasetHeader, HeaderMessage, PAIR_DEFINITION,
    PAIR_TOPIC, Pair,
};
use super::dataset_stream::{Output, Source};
use crate::{Error, Result};

/// Pairs in a chunk. A kill loses at most the chunk being filled.
const PAIRS_IN_CHUNK: u64 = 16;

/// Reads a dataset pair by pair, with the memory of one chunk.
pub struct DatasetReader {
    path: PathBuf,
    source: Source,
    header: DatasetHeader,
    read: u64,
    ended: bool,
}

impl DatasetReader {
    /// Opens a dataset and reads its header.
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::File`] where the file cannot be read, is not MCAP, holds no dataset, or is of another
    /// version.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self> {
        let path = path.into();
        let mut source = Source::open(&path)?;
        let Some(message) = source.next::<HeaderMessage>(DATASET_TOPIC)? else {
            let text = format!("expected a dataset, found an MCAP file without a message on `{DATASET_TOPIC}`");
            return Err(Error::file(&path, text, "`tunenet gen` writes datasets"));
        };
        let header = message.header(&path)?;
        Ok(Self { path, source, header, read: 0, ended: false })
    }

    /// What all pairs share.
    #[must_use]
    pub fn header(&self) -> &DatasetHeader {
        &self.header
    }

    fn next_pair(&mut self) -> Result<Option<Pair>> {
        let expected = self.header.pairs;
        let Some(pair) = next_pair(&mut self.source, &self.header)? else {
            if self.read == expected {
                return Ok(None);
            }
            let text = format!("expected {expected} pairs, found {}", self.read);
            return Err(Error::file(&self.path, text, "run `tunenet gen` again; it goes on where it stopped"));
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

/// Writes a dataset, and goes on with one that was interrupted.
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
}

impl DatasetWriter {
    /// Starts `out`, or goes on with `out.partial`.
    ///
    /// # Errors
    /// [`Error::Io`] where a file cannot be written; [`Error::File`] where `out.partial` belongs to another dataset.
    pub fn open(out: impl Into<PathBuf>, header: DatasetHeader) -> Result<Self> {
        let out = out.into();
        if out.is_dir() {
            return Err(Error::io(&out, "writing", std::io::ErrorKind::IsADirectory.into()));
        }
        let partial = with_suffix(&out, ".partial");
        if !partial.exists() {
            return Self::begin(out, &partial.clone(), partial, header);
        }
        let mut earlier = Earlier::open(&partial, &header)?;
        // Copied beside it first, so that a second kill finds one of the two whole.
        let copy = with_suffix(&out, ".partial.copy");
        let mut writer = Self::begin(out, &copy, partial.clone(), header)?;
        while let Some(pair) = earlier.next() {
            writer.write(&pair)?;
        }
        std::fs::rename(&copy, &partial).map_err(|e| Error::io(&partial, "renaming", e))?;
        Ok(writer)
    }

    fn begin(out: PathBuf, at: &Path, partial: PathBuf, header: DatasetHeader) -> Result<Self> {
        let mut output = Output::create(at)?;
        let dataset = output.topic(DATASET_TOPIC, "tunenet_msgs/msg/Dataset", DATASET_DEFINITION)?;
        let clock = if header.clocks_in_pairs() { CLOCK_DEFINITION } else { "" };
        let topic = output.topic(PAIR_TOPIC, "tunenet_msgs/msg/Pair", &format!("{PAIR_DEFINITION}{clock}"))?;
        output.write(dataset, 0, &HeaderMessage::from(&header))?;
        output.end_chunk()?;
        Ok(Self { out, partial, output, header, topic, written: 0 })
    }

    /// How many pairs are there already; the number, from 0, of the pair that is to be written next.
    #[must_use]
    pub fn written(&self) -> u64 {
        self.written
    }

    /// Writes the next pair.
    ///
    /// # Errors
    /// [`Error::Io`] where the disk refuses; [`Error::File`] where the pair does not fit the header or all are there.
    pub fn write(&mut self, pair: &Pair) -> Result<()> {
        let refuse = |text: String| Err(Error::file(&self.out, format!("pair {}: {text}", self.written), ""));
        if self.written == self.header.pairs {
            return refuse(format!("expected {} pairs, found more", self.header.pairs));
        }
        if let Err(text) = self.header.check(pair) {
            return refuse(text);
        }
        self.written += 1;
        if self.header.clocks_in_pairs() {
            self.output.write(self.topic, self.written, &ClockedPair::from(pair.clone()))?;
        } else {
            self.output.write(self.topic, self.written, pair)?;
        }
        if self.written.is_multiple_of(PAIRS_IN_CHUNK) {
            self.output.end_chunk()?;
        }
        Ok(())
    }

    /// Ends the file, waits for the disk and gives the file its name.
    ///
    /// # Errors
    /// [`Error::Io`] where the disk refuses; [`Error::File`] where pairs are missing.
    pub fn finish(self) -> Result<()> {
        if self.written != self.header.pairs {
            let text = format!("expected {} pairs, found {}", self.header.pairs, self.written);
            return Err(Error::file(&self.out, text, ""));
        }
        self.output.finish()?;
        std::fs::rename(&self.partial, &self.out).map_err(|e| Error::io(&self.out, "renaming", e))
    }
}

/// The complete pairs of an interrupted file.
struct Earlier {
    source: Option<Source>,
    header: DatasetHeader,
}

impl Earlier {
    fn open(partial: &Path, expected: &DatasetHeader) -> Result<Self> {
        let mut source = Source::open(partial)?;
        let refuse = |found: &str| {
            let text = format!("expected the beginning of this dataset, found {found}");
            let hint = "delete it, or write to another --out";
            Err(Error::file(partial, text, hint))
        };
        match source.next::<HeaderMessage>(DATASET_TOPIC) {
            Ok(Some(message)) => {
                let found = message.header(partial)?;
                if found != *expected {
                    return refuse("one with other settings");
                }
                Ok(Self { source: Some(source), header: found })
            }
            Ok(None) => refuse("an MCAP file that is no dataset"),
            Err(_) if begins_like_mcap(partial)? => Ok(Self { source: None, header: expected.clone() }),
            Err(_) => refuse("another kind of file"),
        }
    }

    /// The next complete pair; whatever is wrong after it is written anew.
    fn next(&mut self) -> Option<Pair> {
        let pair = next_pair(self.source.as_mut()?, &self.header).ok()??;
        self.header.check(&pair).is_ok().then_some(pair)
    }
}

/// The next pair in the form that the header announces.
fn next_pair(source: &mut Source, header: &DatasetHeader) -> Result<Option<Pair>> {
    if header.clocks_in_pairs() {
        return Ok(source.next::<ClockedPair>(PAIR_TOPIC)?.map(Pair::from));
    }
    source.next::<Pair>(PAIR_TOPIC)
}

/// Whether what there is of the file could be the beginning of an MCAP file (killed before its first chunk was out).
fn begins_like_mcap(path: &Path) -> Result<bool> {
    use std::io::Read;
    let mut start = Vec::new();
    let file = std::fs::File::open(path).map_err(|e| Error::io(path, "reading", e))?;
    file.take(mcap::MAGIC.len() as u64).read_to_end(&mut start).map_err(|e| Error::io(path, "reading", e))?;
    Ok(mcap::MAGIC.starts_with(&start))
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}
