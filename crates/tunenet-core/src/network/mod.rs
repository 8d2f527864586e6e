//! The two-branch network: its data, its training, its estimates.
//!
//! `TuneNet` (arXiv 1907.11200) looks at two observations, the proposed model's and the target's, and estimates the
//! *difference* of their parameters. Three steps lead there, each resumable after a kill and each the same, bit for bit,
//! for the same seed:
//!
//! 1. [`roll_pair`] rolls out pairs that differ in their parameters alone: a [`DataSet`]; several machines may each make a
//!    [`Shard`] of it;
//! 2. [`train()`] learns from it, as a [`Preset`] says;
//! 3. [`Model::estimate`] compares two observations.
//!
//! What a branch sees is an [`Input`]; in units of a recording's own [`Scale`](crate::simulator::Scale), what was learned
//! at one height serves every other.

mod batches;
mod checkpoint;
mod dataset;
mod generate;
mod grid;
mod input;
mod learner;
mod library;
mod model;
mod numbers;
mod optimiser;
mod preset;
mod product;
mod rows;
mod shard;
#[cfg(test)]
mod tests;
mod train;
mod train_device;
mod training_set;
mod two_branch;
mod weights;

pub use checkpoint::Checkpoint;
pub use dataset::{CoveredParameter, DataSet, DatasetHeader, Pair, PairsInMemory};
pub use generate::{Draw, PairDraw, check_learned, roll_pair, stream};
pub use input::{Encoded, Input};
pub use model::{MODEL_VERSION, Model, Side};
pub use preset::{Course, Head, InputChoice, Loss, Optimiser, Preset};
pub use rows::Overflow;
pub use shard::Shard;
pub use train::{Keeping, TrainOptions, TrainProgress, train, train_on};
pub use train_device::TrainDevice;
pub use weights::{Array, Numbers, Weights, WeightsFault};

impl From<candle_core::Error> for crate::Error {
    fn from(error: candle_core::Error) -> Self {
        Self::Network { message: error.to_string() }
    }
}
