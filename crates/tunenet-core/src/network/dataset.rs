//! A dataset's contents: what all pairs share, one pair, and how both stand in the file.

use std::fmt;
use std::path::Path;

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::shard::Shard;
use crate::observation::Channel;
use crate::simulator::Scale;
use crate::{Error, Result};

/// Newest version of the dataset's format. Raised whenever an older program would misread a newer file.
pub const DATASET_VERSION: u32 = FILMED;

/// One clock, in the header, for all pairs.
const ONE_CLOCK: u32 = 1;
/// An empty clock in the header, and one in every pair.
const CLOCKS_IN_PAIRS: u32 = 2;
/// One clock for all pairs, and targets that are observed on channels of their own.
const FILMED: u32 = 3;

pub(super) const DATASET_TOPIC: &str = "/dataset";
pub(super) const PAIR_TOPIC: &str = "/pair";

pub(super) const DATASET_DEFINITION: &str = "\
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
pub(super) const TARGET_DEFINITION: &str = "\
# What each target observes.
string[] target_channel_names
string[] target_channel_units
";

pub(super) const SHARD_TOPIC: &str = "/shard";

pub(super) const SHARD_DEFINITION: &str = "\
# Which share of the pairs of the dataset this file holds.
uint32 index
uint32 count
# The tunenet that wrote it.
string version
";

pub(super) const PAIR_DEFINITION: &str = "\
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
pub(super) const CLOCK_DEFINITION: &str = "\
# The instants of both rollouts, s.
float64[] clock
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
    /// What each target observes, where that is something else (pixels); empty where it is the same.
    pub target_channels: Vec<Channel>,
    /// The instants of every rollout, in s; empty where every pair brings its own.
    pub clock: Vec<f64>,
    /// The scene, as the text of a simulation file; empty where there is none.
    pub scene: String,
}

/// One pair: two rollouts on one clock that differ in their parameters alone, or a recording and a rollout from what was
/// made of its release.
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
    /// The instants of both, in s, where the header has none for all.
    #[serde(skip)]
    pub clock: Vec<f64>,
}

/// See [`SHARD_DEFINITION`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct ShardMessage {
    pub(super) index: u32,
    pub(super) count: u32,
    pub(super) version: String,
}

impl ShardMessage {
    pub(super) fn new(shard: Shard) -> Self {
        Self { index: shard.index(), count: shard.count(), version: env!("CARGO_PKG_VERSION").into() }
    }

    /// What it says, where that can be.
    pub(super) fn shard(&self, path: &Path) -> Result<Shard> {
        Shard::new(self.index, self.count).map_err(|_| {
            let text = format!("expected a shard below its count, found {}/{}", self.index, self.count);
            Error::file(path, text, "write it again with `tunenet gen`")
        })
    }
}

/// A pair with its own clock, as it stands in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ClockedPair {
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

/// The header as it stands in the file: [`DATASET_DEFINITION`], followed by [`TARGET_DEFINITION`] from version [`FILMED`] on.
#[derive(Debug, Default, Serialize)]
pub(super) struct HeaderMessage {
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
                let targets = if shared.version == FILMED {
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
                (false, _) => FILMED,
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
    pub(super) fn header(self, path: &Path) -> Result<DatasetHeader> {
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
        if shared.version == FILMED && targets.are_none() {
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
    /// Whether every pair brings its own clock.
    #[must_use]
    pub fn clocks_in_pairs(&self) -> bool {
        self.clock.is_empty()
    }

    /// The instants of a pair's rollouts.
    #[must_use]
    pub fn clock_of<'a>(&'a self, pair: &'a Pair) -> &'a [f64] {
        if self.clocks_in_pairs() { &pair.clock } else { &self.clock }
    }

    /// What each target observes.
    #[must_use]
    pub fn seen_channels(&self) -> &[Channel] {
        if self.target_channels.is_empty() { &self.channels } else { &self.target_channels }
    }

    /// Whether `pair` has the lengths that this header promises, and finite numbers.
    pub(super) fn check(&self, pair: &Pair) -> std::result::Result<(), String> {
        let clock = self.clock_of(pair);
        if clock.len() < 2 || clock.iter().any(|t| !t.is_finite()) || clock.windows(2).any(|w| w[1] <= w[0]) {
            return Err("expected a clock of at least 2 instants that rises, found another".into());
        }
        let parameters = self.parameters.len();
        let lengths = [
            ("parameters", parameters, &pair.proposed_parameters),
            ("parameters", parameters, &pair.target_parameters),
            ("values", clock.len() * self.channels.len(), &pair.proposed),
            ("values", clock.len() * self.seen_channels().len(), &pair.target),
        ];
        for (what, expected, found) in lengths {
            if found.len() != expected {
                return Err(format!("expected {expected} {what}, found {}", found.len()));
            }
            if let Some(bad) = found.iter().find(|v| !v.is_finite()) {
                return Err(format!("expected finite {what}, found {bad}"));
            }
        }
        Ok(())
    }
}
