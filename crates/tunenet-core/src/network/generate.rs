//! Filling a dataset with rollouts.

use std::path::Path;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::dataset::{DatasetHeader, Pair};
use super::dataset_file::DatasetWriter;
use super::shard::Shard;
use crate::simulator::Scale;
use crate::simulator::{Simulator, rollout};
use crate::{Error, Result};

/// Pairs rolled out before they are written. Bounds the memory; many times the number of cores, so that none waits long.
const BLOCK: u64 = 128;
/// Pairs on which each parameter is tried out before any is written.
const PROBES: u64 = 32;

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
/// can be resumed; that of the last call is asked before the file gets its name.
///
/// # Errors
/// [`Error::Setting`] where a parameter to be learned changes no rollout, since a network would learn to make it up;
/// [`Error::Simulator`] where a rollout fails, [`Error::Stopped`] on request, otherwise as [`DatasetWriter`].
pub fn generate(
    simulator: &dyn Simulator,
    header: &DatasetHeader,
    draw: &(dyn Fn(u64, &mut ChaCha8Rng) -> PairDraw + Sync),
    out: &Path,
    progress: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<()> {
    generate_shard(simulator, header, None, draw, out, progress)
}

/// As [`generate`], of one share of the pairs alone where `shard` says so: [`merge`](super::merge) puts shares together.
///
/// # Errors
/// As [`generate`].
pub fn generate_shard(
    simulator: &dyn Simulator,
    header: &DatasetHeader,
    shard: Option<Shard>,
    draw: &(dyn Fn(u64, &mut ChaCha8Rng) -> PairDraw + Sync),
    out: &Path,
    progress: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<()> {
    for i in (0..header.parameters.len()).filter(|&i| header.parameters[i].tuned) {
        if !matters(simulator, header, draw, i)? {
            return Err(Error::Setting {
                name: "parameters",
                expected: "parameters to learn that change what is observed".into(),
                found: format!("`{}`, which changes nothing", header.parameters[i].name),
            });
        }
    }
    let make = |number: u64, random: &mut ChaCha8Rng| roll_pair(simulator, header, draw(number, random));
    fill_shard(header, shard, &make, out, progress)
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
    fill_shard(header, None, make, out, progress)
}

/// As [`fill`], of one share of the pairs alone where `shard` says so.
///
/// # Errors
/// As [`fill`].
pub fn fill_shard(
    header: &DatasetHeader,
    shard: Option<Shard>,
    make: &(dyn Fn(u64, &mut ChaCha8Rng) -> Result<Pair> + Sync),
    out: &Path,
    progress: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<()> {
    let mut writer = match shard {
        Some(shard) => DatasetWriter::open_shard(out, header.clone(), shard)?,
        None => DatasetWriter::open(out, header.clone())?,
    };
    let first = shard.map_or(0, |shard| shard.block(header.pairs).start);
    let all = writer.end() - first;
    while writer.written() < writer.end() {
        if !progress(writer.written() - first, all) {
            return Err(Error::Stopped);
        }
        let block = writer.written()..(writer.written() + BLOCK).min(writer.end());
        let pairs: Vec<Result<Pair>> =
            block.into_par_iter().map(|number| make(number, &mut stream(header.seed, number))).collect();
        for pair in pairs {
            writer.write(&pair?)?;
        }
    }
    if !progress(all, all) {
        return Err(Error::Stopped);
    }
    writer.finish()
}

/// Whether parameter `i`, moved alone from the proposed model's value to the target's or to an end of its range, changes
/// any rollout.
fn matters(
    simulator: &dyn Simulator,
    header: &DatasetHeader,
    draw: &(dyn Fn(u64, &mut ChaCha8Rng) -> PairDraw + Sync),
    i: usize,
) -> Result<bool> {
    for number in 0..PROBES.min(header.pairs) {
        let drawn = draw(number, &mut stream(header.seed, number));
        let seen = rollout(simulator, &drawn.proposed, &drawn.own, &header.clock)?;
        let range = &header.parameters[i];
        for value in [drawn.target[i], range.min, range.max] {
            let mut moved = drawn.proposed.clone();
            moved[i] = value;
            // Values that cannot be simulated are no proof of either.
            if rollout(simulator, &moved, &drawn.own, &header.clock).is_ok_and(|other| other != seen) {
                return Ok(true);
            }
        }
    }
    Ok(header.pairs == 0)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::CoveredParameter;
    use crate::observation::Channel;
    use crate::simulator::Parameter;
    use rand::Rng;

    /// A line whose second parameter is forgotten.
    struct Line(Vec<Parameter>, Vec<Channel>);

    impl Simulator for Line {
        fn parameters(&self) -> &[Parameter] {
            &self.0
        }

        fn channels(&self) -> &[Channel] {
            &self.1
        }

        fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], out: &mut [f64]) -> std::result::Result<(), String> {
            clock.iter().zip(out).for_each(|(t, v)| *v = p[0] * t);
            Ok(())
        }
    }

    #[test]
    fn a_parameter_that_changes_nothing_is_refused_by_name() {
        let parameter = |name| Parameter::new(name, "1", 0.5, 0.0, 1.0).unwrap();
        let line = Line(vec![parameter("slope"), parameter("colour")], vec![Channel::new("y", "m")]);
        let header = |learned: [bool; 2]| DatasetHeader {
            preset: "line".into(),
            seed: 1,
            pairs: 4,
            parameters: ["slope", "colour"]
                .into_iter()
                .zip(learned)
                .map(|(name, tuned)| CoveredParameter {
                    name: name.into(),
                    unit: "1".into(),
                    min: 0.0,
                    max: 1.0,
                    tuned,
                })
                .collect(),
            channels: line.channels().to_vec(),
            target_channels: Vec::new(),
            clock: (0..20).map(f64::from).collect(),
            scene: String::new(),
        };
        let draw = |_: u64, random: &mut ChaCha8Rng| PairDraw {
            proposed: vec![random.random(), random.random()],
            target: vec![random.random(), random.random()],
            own: Vec::new(),
            scale: None,
        };
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("pairs.mcap");
        let error = generate(&line, &header([true, true]), &draw, &out, &mut |_, _| true).unwrap_err().to_string();
        assert!(error.contains("`colour`") && !error.contains("`slope`"), "{error}");
        assert!(!out.exists());
        generate(&line, &header([true, false]), &draw, &out, &mut |_, _| true).unwrap();
    }
}
