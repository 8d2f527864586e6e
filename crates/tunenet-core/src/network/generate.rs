//! Filling a dataset with rollouts.

use std::path::Path;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::dataset::{DatasetHeader, Pair};
use super::dataset_file::DatasetWriter;
use crate::simulator::Scale;
use crate::simulator::{Simulator, rollout};
use crate::{Error, Result};

/// Pairs rolled out before they are written. Bounds the memory; many times the number of cores, so that none waits long.
const BLOCK: u64 = 128;

/// What one pair is rolled out with.
#[derive(Debug, Clone, PartialEq)]
pub struct PairDraw {
    /// All parameters of the proposed model, in the simulator's order.
    pub proposed: Vec<f64>,
    /// All parameters of the target.
    pub target: Vec<f64>,
    /// Unknowns that both share.
    pub own: Vec<f64>,
    /// What makes both dimensionless, where the simulator has such a thing.
    pub scale: Option<Scale>,
}

/// Rolls out the pairs of a dataset into `out`, or those that an interrupted run left over.
///
/// `draw` is asked for pair 0, 1, … with a generator that depends on the header's seed and the pair's number alone, and
/// rollouts are spread over the cores: whatever the number of threads and however often the run was interrupted, the
/// bytes are the same. `progress` gets the number of pairs done and of all; where it answers `false`, the work stops and
/// can be resumed.
///
/// # Errors
/// [`Error::Simulator`] where a rollout fails, [`Error::Stopped`] on request, otherwise as [`DatasetWriter`].
pub fn generate(
    simulator: &dyn Simulator,
    header: &DatasetHeader,
    draw: &(dyn Fn(u64, &mut ChaCha8Rng) -> PairDraw + Sync),
    out: &Path,
    progress: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<()> {
    fill(header, &|number, random| roll_pair(simulator, header, draw(number, random)), out, progress)
}

/// Writes the pairs of a dataset into `out`, or those that an interrupted run left over: `make` is asked for pair 0, 1, …
/// with a generator that depends on the header's seed and the pair's number alone. What holds of [`generate`] holds here.
///
/// # Errors
/// What `make` refuses, [`Error::Stopped`] on request, otherwise as [`DatasetWriter`].
pub fn fill(
    header: &DatasetHeader,
    make: &(dyn Fn(u64, &mut ChaCha8Rng) -> Result<Pair> + Sync),
    out: &Path,
    progress: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<()> {
    let mut writer = DatasetWriter::open(out, header.clone())?;
    while writer.written() < header.pairs {
        if !progress(writer.written(), header.pairs) {
            return Err(Error::Stopped);
        }
        let block = writer.written()..(writer.written() + BLOCK).min(header.pairs);
        let pairs: Vec<Result<Pair>> =
            block.into_par_iter().map(|number| make(number, &mut stream(header.seed, number))).collect();
        for pair in pairs {
            writer.write(&pair?)?;
        }
    }
    progress(header.pairs, header.pairs);
    writer.finish()
}

/// What pair `number` of a dataset with this seed is drawn from.
#[must_use]
pub fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    random
}

fn roll_pair(simulator: &dyn Simulator, header: &DatasetHeader, draw: PairDraw) -> Result<Pair> {
    let PairDraw { proposed, target, own, scale } = draw;
    Ok(Pair {
        proposed: rollout(simulator, &proposed, &own, &header.clock)?,
        target: rollout(simulator, &target, &own, &header.clock)?,
        proposed_parameters: proposed,
        target_parameters: target,
        own,
        scale,
        clock: Vec::new(),
    })
}
