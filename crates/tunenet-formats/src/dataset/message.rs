//! How a data set's header and its pairs stand in the file: CDR, with a ROS 2 message definition next to it.

use std::fmt;
use std::path::Path;

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use tunenet_core::network::{CoveredParameter, DatasetHeader, Pair, Shard};
use tunenet_core::observation::Channel;
use tunenet_core::simulator::Scale;

use crate::{Error, Result};

/// Newest version of the dataset's format. Raised whenever an older program would misread a newer file.
pub const DATASET_VERSION: u32 = TARGET_CHANNELS;

/// One clock, in the header, for all pairs.
const ONE_CLOCK: u32 = 1;
/// An empty clock in the header, and one in every pair.
const CLOCKS_IN_PAIRS: u32 = 2;
/// One clock for all pairs, and targets that are observed on channels of their own.
const TARGET_CHANNELS: u32 = 3;

pub(crate) const DATASET_TOPIC: &str = "/dataset";
pub(crate) const PAIR_TOPIC: &str = "/pair";

pub(crate) const DATASET_DEFINITION: &str = "\
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

/// What follows in the header where targets are observed otherwise than proposed rollouts.
pub(crate) const TARGET_DEFINITION: &str = "\
# What each target observes.
string[] target_channel_names
string[] target_channel_units
";

pub(crate) const SHARD_TOPIC: &str = "/shard";

pub(crate) const SHARD_DEFINITION: &str = "\
# Which share of the pairs of the dataset this file holds.
uint32 index
uint32 count
# The tunenet that wrote it.
string version
";

pub(crate) const PAIR_DEFINITION: &str = "\
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

/// What follows in a pair that has a clock of its own.
pub(crate) const CLOCK_DEFINITION: &str = "\
# The instants of both rollouts, s.
float64[] clock
";

/// See [`SHARD_DEFINITION`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ShardMessage {
    pub(crate) index: u32,
    pub(crate) count: u32,
    pub(crate) version: String,
}

impl ShardMessage {
    pub(crate) fn new(shard: Shard) -> Self {
        Self { index: shard.index(), count: shard.count(), version: env!("CARGO_PKG_VERSION").into() }
    }

    /// What it says, where that can be.
    pub(crate) fn shard(&self, path: &Path) -> Result<Shard> {
        Shard::new(self.index, self.count).map_err(|_| {
            let text = format!("expected a shard below its count, found {}/{}", self.index, self.count);
            Error::file(path, text, "write it again with `tunenet gen`")
        })
    }
}

/// See [`PAIR_DEFINITION`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Pair")]
struct PairFields {
    proposed_parameters: Vec<f64>,
    target_parameters: Vec<f64>,
    own: Vec<f64>,
    #[serde(with = "scale_as_numbers")]
    scale: Option<Scale>,
    proposed: Vec<f64>,
    target: Vec<f64>,
    #[serde(skip)]
    clock: Vec<f64>,
}

/// A pair as it stands in the file.
#[derive(Serialize, Deserialize)]
pub(crate) struct PlainPair(#[serde(with = "PairFields")] pub(crate) Pair);

/// A pair with its own clock, as it stands in the file.
#[derive(Serialize, Deserialize)]
pub(crate) struct ClockedPair {
    #[serde(with = "PairFields")]
    pair: Pair,
    clock: Vec<f64>,
}

impl From<Pair> for ClockedPair {
    fn from(mut pair: Pair) -> Self {
        Self { clock: std::mem::take(&mut pair.clock), pair }
    }
}

impl From<ClockedPair> for Pair {
    fn from(ClockedPair { pair, clock }: ClockedPair) -> Self {
        Self { clock, ..pair }
    }
}

/// The header as it stands in the file: [`DATASET_DEFINITION`], followed by [`TARGET_DEFINITION`] from version [`TARGET_CHANNELS`] on.
#[derive(Debug, Default, Serialize)]
pub(crate) struct HeaderMessage {
    shared: Shared,
    #[serde(skip_serializing_if = "Targets::are_none")]
    targets: Targets,
}

/// See [`DATASET_DEFINITION`].
#[derive(Debug, Default, Serialize, Deserialize)]
struct Shared {
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

/// See [`TARGET_DEFINITION`].
#[derive(Debug, Default, Serialize, Deserialize)]
struct Targets {
    channel_names: Vec<String>,
    channel_units: Vec<String>,
}

impl Targets {
    fn are_none(&self) -> bool {
        self.channel_names.is_empty()
    }
}

/// CDR names no fields and has no end mark, so the version decides what follows.
impl<'de> Deserialize<'de> for HeaderMessage {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        struct Parts;
        impl<'de> Visitor<'de> for Parts {
            type Value = HeaderMessage;

            fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
                to.write_str("the header of a dataset")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> std::result::Result<HeaderMessage, A::Error> {
                let shared: Shared = parts.next_element()?.ok_or_else(|| A::Error::invalid_length(0, &self))?;
                let targets = if shared.version == TARGET_CHANNELS {
                    parts.next_element()?.ok_or_else(|| A::Error::invalid_length(1, &self))?
                } else {
                    Targets::default()
                };
                Ok(HeaderMessage { shared, targets })
            }
        }
        from.deserialize_tuple(2, Parts)
    }
}

impl From<&DatasetHeader> for HeaderMessage {
    fn from(header: &DatasetHeader) -> Self {
        let parameters = || header.parameters.iter();
        let (channel_names, channel_units) = names_and_units(&header.channels);
        let shared = Shared {
            version: match (header.target_channels.is_empty(), header.clock.is_empty()) {
                (false, _) => TARGET_CHANNELS,
                (true, true) => CLOCKS_IN_PAIRS,
                (true, false) => ONE_CLOCK,
            },
            preset: header.preset.clone(),
            seed: header.seed,
            pairs: header.pairs,
            parameter_names: parameters().map(|p| p.name.clone()).collect(),
            parameter_units: parameters().map(|p| p.unit.clone()).collect(),
            parameter_min: parameters().map(|p| p.min).collect(),
            parameter_max: parameters().map(|p| p.max).collect(),
            parameter_tuned: parameters().map(|p| p.tuned).collect(),
            channel_names,
            channel_units,
            clock: header.clock.clone(),
            scene: header.scene.clone(),
        };
        let (channel_names, channel_units) = names_and_units(&header.target_channels);
        Self { shared, targets: Targets { channel_names, channel_units } }
    }
}

impl HeaderMessage {
    pub(crate) fn header(self, path: &Path) -> Result<DatasetHeader> {
        let Self { shared, targets } = self;
        if !(ONE_CLOCK..=DATASET_VERSION).contains(&shared.version) {
            let text =
                format!("expected a dataset of version 1 to {DATASET_VERSION}, found version {}", shared.version);
            return Err(Error::file(path, text, "write it again with this version of `tunenet gen`"));
        }
        let n = shared.parameter_names.len();
        let of_parameters = [
            shared.parameter_units.len(),
            shared.parameter_min.len(),
            shared.parameter_max.len(),
            shared.parameter_tuned.len(),
        ];
        if of_parameters.iter().any(|&found| found != n)
            || shared.channel_units.len() != shared.channel_names.len()
            || targets.channel_units.len() != targets.channel_names.len()
        {
            return Err(Error::file(path, "expected lists of equal length in the dataset's header, found others", ""));
        }
        if shared.version == TARGET_CHANNELS && targets.are_none() {
            return Err(Error::file(path, "expected what the targets observe in the dataset's header, found none", ""));
        }
        let parameters = (0..n).map(|i| CoveredParameter {
            name: shared.parameter_names[i].clone(),
            unit: shared.parameter_units[i].clone(),
            min: shared.parameter_min[i],
            max: shared.parameter_max[i],
            tuned: shared.parameter_tuned[i],
        });
        Ok(DatasetHeader {
            parameters: parameters.collect(),
            preset: shared.preset,
            seed: shared.seed,
            pairs: shared.pairs,
            channels: channels(shared.channel_names, shared.channel_units),
            target_channels: channels(targets.channel_names, targets.channel_units),
            clock: shared.clock,
            scene: shared.scene,
        })
    }
}

fn names_and_units(channels: &[Channel]) -> (Vec<String>, Vec<String>) {
    channels.iter().map(|c| (c.name.clone(), c.unit.clone())).unzip()
}

fn channels(names: Vec<String>, units: Vec<String>) -> Vec<Channel> {
    names.into_iter().zip(units).map(|(name, unit)| Channel::new(name, unit)).collect()
}

/// `None` is written as an empty list.
mod scale_as_numbers {
    use super::Scale;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[expect(clippy::ref_option, reason = "the signature is serde's")]
    pub(crate) fn serialize<S: Serializer>(scale: &Option<Scale>, to: S) -> Result<S::Ok, S::Error> {
        scale.map_or(vec![], |s| vec![s.origin, s.length, s.start_s, s.time_s]).serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Scale>, D::Error> {
        match Vec::<f64>::deserialize(from)?[..] {
            [] => Ok(None),
            [origin, length, start_s, time_s] => {
                Scale::new(origin, length, start_s, time_s).map(Some).map_err(D::Error::custom)
            }
            ref other => Err(D::Error::custom(format!("a scale of {} numbers", other.len()))),
        }
    }
}
