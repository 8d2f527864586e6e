//! A dataset: pairs of rollouts in one MCAP file.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::dataset_stream::{Output, Source};
use crate::observation::Channel;
use crate::simulator::Scale;
use crate::{Error, Result};

/// Version of the dataset's format. Raised whenever an older program would misread a newer file.
pub const DATASET_VERSION: u32 = 1;

/// Pairs in a chunk. A kill loses at most the chunk being filled.
const PAIRS_IN_CHUNK: u64 = 16;

const DATASET_TOPIC: &str = "/dataset";
const PAIR_TOPIC: &str = "/pair";

const DATASET_DEFINITION: &str = "\
# What all pairs of this file share.
uint32 version
string preset
uint64 seed
uint64 pairs
string[] parameter_names
string[] parameter_units
float64[] parameter_min
float64[] parameter_max
bool[] parameter_tuned
string[] channel_names
string[] channel_units
# The instants of every rollout, s.
float64[] clock
# The scene, TOML.
string scene
";

const PAIR_DEFINITION: &str = "\
# Two rollouts that differ in their parameters alone.
float64[] proposed_parameters
float64[] target_parameters
# Unknowns that both share.
float64[] own
# Empty, or origin, length, start (s), time (s).
float64[] scale
# Row-major [sample, channel].
float64[] proposed
float64[] target
";

/// A parameter as the dataset covers it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoveredParameter {
    /// Its name: `restitution`.
    pub name: String,
    /// Its unit: `kg`; `1` where there is none.
    pub unit: String,
    /// The least value drawn.
    pub min: f64,
    /// The greatest value drawn.
    pub max: f64,
    /// Whether it is to be learned; the others are only recorded.
    pub tuned: bool,
}

impl CoveredParameter {
    /// The width of the range: what a difference of 1 means to the network.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.max - self.min
    }
}

/// What all pairs of a dataset share.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasetHeader {
    /// Name of the distribution that the pairs were drawn from.
    pub preset: String,
    /// What the draws started from.
    pub seed: u64,
    /// How many pairs the complete file holds.
    pub pairs: u64,
    /// All of the simulator's parameters, in its order.
    pub parameters: Vec<CoveredParameter>,
    /// What each rollout observes.
    pub channels: Vec<Channel>,
    /// The instants of every rollout, in s.
    pub clock: Vec<f64>,
    /// The scene, as the text of a simulation file; empty where there is none.
    pub scene: String,
}

/// One pair: two rollouts on the dataset's clock that differ in their parameters alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// All parameters of the proposed model, shape `[parameter]`.
    pub proposed_parameters: Vec<f64>,
    /// All parameters of the target, shape `[parameter]`.
    pub target_parameters: Vec<f64>,
    /// Unknowns that both share, such as a height of release.
    pub own: Vec<f64>,
    /// What makes both dimensionless, where the simulator has such a thing.
    #[serde(with = "scale_as_numbers")]
    pub scale: Option<Scale>,
    /// The proposed model's rollout, row-major `[sample, channel]`.
    pub proposed: Vec<f64>,
    /// The target's rollout, row-major `[sample, channel]`.
    pub target: Vec<f64>,
}

/// The header as it stands in the file; see [`DATASET_DEFINITION`].
#[derive(Debug, Default, Serialize, Deserialize)]
struct HeaderMessage {
    version: u32,
    preset: String,
    seed: u64,
    pairs: u64,
    parameter_names: Vec<String>,
    parameter_units: Vec<String>,
    parameter_min: Vec<f64>,
    parameter_max: Vec<f64>,
    parameter_tuned: Vec<bool>,
    channel_names: Vec<String>,
    channel_units: Vec<String>,
    clock: Vec<f64>,
    scene: String,
}

impl From<&DatasetHeader> for HeaderMessage {
    fn from(header: &DatasetHeader) -> Self {
        let mut message = Self {
            version: DATASET_VERSION,
            preset: header.preset.clone(),
            seed: header.seed,
            pairs: header.pairs,
            clock: header.clock.clone(),
            scene: header.scene.clone(),
            ..Self::default()
        };
        for parameter in &header.parameters {
            message.parameter_names.push(parameter.name.clone());
            message.parameter_units.push(parameter.unit.clone());
            message.parameter_min.push(parameter.min);
            message.parameter_max.push(parameter.max);
            message.parameter_tuned.push(parameter.tuned);
        }
        for channel in &header.channels {
            message.channel_names.push(channel.name.clone());
            message.channel_units.push(channel.unit.clone());
        }
        message
    }
}

impl HeaderMessage {
    fn header(self, path: &Path) -> Result<DatasetHeader> {
        if self.version != DATASET_VERSION {
            let text = format!("expected a dataset of version {DATASET_VERSION}, found version {}", self.version);
            return Err(Error::file(path, text, "write it again with this version of `tunenet gen`"));
        }
        let n = self.parameter_names.len();
        let whole = [
            self.parameter_units.len(),
            self.parameter_min.len(),
            self.parameter_max.len(),
            self.parameter_tuned.len(),
        ]
        .iter()
        .all(|&found| found == n)
            && self.channel_units.len() == self.channel_names.len();
        if !whole {
            return Err(Error::file(path, "expected lists of equal length in the dataset's header, found others", ""));
        }
        let parameters = (0..n).map(|i| CoveredParameter {
            name: self.parameter_names[i].clone(),
            unit: self.parameter_units[i].clone(),
            min: self.parameter_min[i],
            max: self.parameter_max[i],
            tuned: self.parameter_tuned[i],
        });
        Ok(DatasetHeader {
            preset: self.preset,
            seed: self.seed,
            pairs: self.pairs,
            parameters: parameters.collect(),
            channels: self.channel_names.into_iter().zip(self.channel_units).map(|(n, u)| Channel::new(n, u)).collect(),
            clock: self.clock,
            scene: self.scene,
        })
    }
}

/// `None` is written as an empty list.
mod scale_as_numbers {
    use super::Scale;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[expect(clippy::ref_option, reason = "the signature is serde's")]
    pub(super) fn serialize<S: Serializer>(scale: &Option<Scale>, to: S) -> Result<S::Ok, S::Error> {
        scale.map_or(vec![], |s| vec![s.origin, s.length, s.start_s, s.time_s]).serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Scale>, D::Error> {
        match Vec::<f64>::deserialize(from)?[..] {
            [] => Ok(None),
            [origin, length, start_s, time_s] => {
                Scale::new(origin, length, start_s, time_s).map(Some).map_err(D::Error::custom)
            }
            ref other => Err(D::Error::custom(format!("a scale of {} numbers", other.len()))),
        }
    }
}

impl DatasetHeader {
    /// Numbers in one rollout.
    fn rollout_len(&self) -> usize {
        self.clock.len() * self.channels.len()
    }

    /// Whether `pair` has the lengths that this header promises, and finite numbers.
    fn check(&self, pair: &Pair) -> std::result::Result<(), String> {
        let lengths = [
            ("parameters", self.parameters.len(), [&pair.proposed_parameters, &pair.target_parameters]),
            ("values", self.rollout_len(), [&pair.proposed, &pair.target]),
        ];
        for (what, expected, both) in lengths {
            for found in both {
                if found.len() != expected {
                    return Err(format!("expected {expected} {what}, found {}", found.len()));
                }
                if let Some(bad) = found.iter().find(|v| !v.is_finite()) {
                    return Err(format!("expected finite {what}, found {bad}"));
                }
            }
        }
        Ok(())
    }
}

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
        let Some(pair) = self.source.next::<Pair>(PAIR_TOPIC)? else {
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
        let topic = output.topic(PAIR_TOPIC, "tunenet_msgs/msg/Pair", PAIR_DEFINITION)?;
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
        self.output.write(self.topic, self.written, pair)?;
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
        let pair = self.source.as_mut()?.next::<Pair>(PAIR_TOPIC).ok()??;
        self.header.check(&pair).is_ok().then_some(pair)
    }
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
