//! What has been learned: the two-branch network, its data, its training.
//!
//! `TuneNet` (arXiv 1907.11200) looks at two observations, the proposed model's and the target's, and estimates the
//! *difference* of their parameters. Three steps lead there, each resumable after a kill and each the same, bit for bit,
//! for the same seed:
//!
//! 1. [`generate`] rolls out pairs that differ in their parameters alone and streams them into an MCAP file;
//!    several machines may each write a [`Shard`], and [`merge`] puts them together;
//! 2. [`train`] learns from that file, as a [`Preset`] says;
//! 3. [`Model::estimate`] compares two observations.
//!
//! What a branch sees is an [`Input`]; in units of a recording's own [`Scale`](crate::simulator::Scale), what was learned
//! at one height serves every other.

mod batches;
mod checkpoint;
mod dataset;
mod dataset_file;
mod dataset_merge;
mod dataset_stream;
mod generate;
mod gradients;
mod grid;
mod input;
mod learner;
mod library;
mod model;
mod numbers;
mod on_device;
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
mod weights_file;

pub use dataset::{CoveredParameter, DATASET_VERSION, DatasetHeader, Pair};
pub use dataset_file::{DatasetReader, DatasetWriter};
pub use dataset_merge::{merge, missing};
pub use generate::{PairDraw, fill, fill_shard, generate, generate_shard, stream};
pub use input::{Encoded, Input};
pub use model::{MODEL_VERSION, Model, Side};
pub use preset::{Course, Head, InputChoice, Loss, Optimiser, Preset};
pub use shard::Shard;
pub use train::{TrainOptions, TrainProgress, train, train_on};
pub use train_device::TrainDevice;
