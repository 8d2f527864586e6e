//! A data set's contents: what all pairs share, and one pair.

use serde::{Deserialize, Serialize};

use crate::observation::Channel;
use crate::simulator::Scale;
use crate::{Error, Result};

/// A parameter as the dataset covers it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoveredParameter {
    /// Its name: `friction`.
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
/// made of its initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// All parameters of the proposed model, shape `[parameter]`.
    pub proposed_parameters: Vec<f64>,
    /// All parameters of the target, shape `[parameter]`.
    pub target_parameters: Vec<f64>,
    /// Nuisance parameters that both share, such as an initial height.
    pub own: Vec<f64>,
    /// What makes both dimensionless, where the simulator has such a thing.
    pub scale: Option<Scale>,
    /// The proposed model's rollout, row-major `[sample, channel]`.
    pub proposed: Vec<f64>,
    /// The target's rollout, row-major `[sample, channel]`.
    pub target: Vec<f64>,
    /// The instants of both, in s, where the header has none for all.
    pub clock: Vec<f64>,
}

/// The pairs of a data set, as often as they are asked for.
pub trait DataSet {
    /// What all pairs share.
    fn header(&self) -> &DatasetHeader;

    /// All pairs in their order, from the first one.
    ///
    /// # Errors
    /// Where they cannot be read.
    fn pairs(&self) -> Result<Box<dyn Iterator<Item = Result<Pair>> + '_>>;
}

/// A data set in memory.
#[derive(Debug, Clone, Copy)]
pub struct PairsInMemory<'a> {
    /// What all pairs share.
    pub header: &'a DatasetHeader,
    /// All of them.
    pub pairs: &'a [Pair],
}

impl DataSet for PairsInMemory<'_> {
    fn header(&self) -> &DatasetHeader {
        self.header
    }

    fn pairs(&self) -> Result<Box<dyn Iterator<Item = Result<Pair>> + '_>> {
        let refuse =
            |text: String| Error::Model { what: "training".into(), expected: "whole pairs".into(), found: text };
        let checked = move |pair: &Pair| self.header.check(pair).map_err(refuse).map(|()| pair.clone());
        Ok(Box::new(self.pairs.iter().map(checked)))
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
    ///
    /// # Errors
    /// The first thing that is wrong, in words.
    pub fn check(&self, pair: &Pair) -> std::result::Result<(), String> {
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
