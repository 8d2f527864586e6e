//! What has been learned: the two-branch network, its data, its training.
//!
//! `TuneNet` (arXiv 1907.11200) looks at two observations, the proposed model's and the target's, and estimates the
//! *difference* of their parameters. Three steps lead there, each resumable after a kill and each the same, bit for bit,
//! for the same seed:
//!
//! 1. [`generate`] rolls out pairs that differ in their parameters alone and streams them into an MCAP file;
//! 2. [`train`] learns from that file, as a [`Preset`] says;
//! 3. [`Model::estimate`] compares two observations.
//!
//! What a branch sees is an [`Input`]; in units of a recording's own [`Scale`](crate::simulator::Scale), what was learned
//! at one height serves every other.

mod batches;
mod checkpoint;
mod dataset;
mod dataset_file;
mod dataset_stream;
mod generate;
mod input;
mod library;
mod model;
mod optimiser;
mod preset;
#[cfg(test)]
mod tests;
mod train;
mod training_set;
mod two_branch;
mod weights_file;

pub use dataset::{CoveredParameter, DATASET_VERSION, DatasetHeader, Pair};
pub use dataset_file::{DatasetReader, DatasetWriter};
pub use generate::{PairDraw, fill, generate, stream};
pub use input::{Encoded, Input};
pub use model::{MODEL_VERSION, Model, Side};
pub use preset::{Course, Head, InputChoice, Loss, Optimiser, Preset};
pub use train::{TrainOptions, TrainProgress, train, train_on};

/// Keeps matrix products on the thread that asks for them.
///
/// The largest product here is some 256 × 128 × 32: handing it to other threads costs more than it saves, takes cores
/// from the rollouts beside it, and would leave the order of work to the number of threads.
fn products_on_one_thread() {
    gemm::set_threading_threshold(usize::MAX);
}

/// In single precision, in which the network learns.
#[expect(clippy::cast_possible_truncation, reason = "losing digits is the point")]
fn single(number: f64) -> f32 {
    number as f32
}
