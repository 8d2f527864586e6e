//! Filling a data set's file with rollouts.

use std::path::Path;

use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use tunenet_core::network::{DatasetHeader, Draw, Pair, Shard, check_learned, roll_pair, stream};
use tunenet_core::simulator::Simulator;

use super::file::DatasetWriter;
use crate::Result;

/// Pairs rolled out before they are written. Bounds the memory; many times the number of cores, so that none waits long.
const BLOCK: u64 = 128;

/// Rolls out the pairs of a dataset into `out`, or those that an interrupted run left over; where `shard` says so, one share of
/// the pairs alone: [`merge`](crate::dataset::merge) puts shares together.
///
/// `draw` is asked for pair 0, 1, … with a generator that depends on the header's seed and the pair's number alone, and
/// rollouts are spread over the cores: for any number of threads and of interruptions, the
/// bytes are the same. `progress` gets the number of pairs done and of all; where it answers `false`, the work stops and
/// can be resumed; that of the last call is asked before the file gets its name.
///
/// # Errors
/// [`Setting`](tunenet_core::Error::Setting) where a parameter to be learned changes no rollout, since a network would
/// learn to make it up; [`Simulator`](tunenet_core::Error::Simulator) where a rollout fails,
/// [`Stopped`](tunenet_core::Error::Stopped) on request, otherwise as [`DatasetWriter`].
pub fn generate(
    simulator: &dyn Simulator,
    header: &DatasetHeader,
    shard: Option<Shard>,
    draw: &Draw<'_>,
    out: &Path,
    progress: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<()> {
    check_learned(simulator, header, draw)?;
    let make = |number: u64, random: &mut ChaCha8Rng| Ok(roll_pair(simulator, header, draw(number, random))?);
    fill(header, shard, &make, out, progress)
}

/// Writes the pairs of a dataset into `out`, or those that an interrupted run left over: `make` is asked for pair 0, 1, …
/// with a generator that depends on the header's seed and the pair's number alone. What holds of [`generate`] holds here.
///
/// # Errors
/// What `make` refuses, [`Stopped`](tunenet_core::Error::Stopped) on request, otherwise as [`DatasetWriter`].
pub fn fill(
    header: &DatasetHeader,
    shard: Option<Shard>,
    make: &(dyn Fn(u64, &mut ChaCha8Rng) -> Result<Pair> + Sync),
    out: &Path,
    progress: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<()> {
    let mut writer = DatasetWriter::open(out, header.clone(), shard)?;
    let first = shard.map_or(0, |shard| shard.block(header.pairs).start);
    let all = writer.end() - first;
    while writer.written() < writer.end() {
        if !progress(writer.written() - first, all) {
            return Err(tunenet_core::Error::Stopped.into());
        }
        let block = writer.written()..(writer.written() + BLOCK).min(writer.end());
        let pairs: Vec<Result<Pair>> =
            block.into_par_iter().map(|number| make(number, &mut stream(header.seed, number))).collect();
        for pair in pairs {
            writer.write(&pair?)?;
        }
    }
    if !progress(all, all) {
        return Err(tunenet_core::Error::Stopped.into());
    }
    writer.finish()
}
