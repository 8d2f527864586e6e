//! Minibatch training of a network on a data set, with validation, progress and checkpoints.

use std::time::{Duration, Instant};

use super::batches::{Batch, Batches};
use super::checkpoint::{self, Checkpoint, Kept};
use super::dataset::{DataSet, DatasetHeader, Pair, PairsInMemory};
use super::learner::Learner;
use super::library::Library;
use super::model::{self, About, MODEL_VERSION, Model, Target};
use super::optimiser::{GradientDescent, Schedule};
use super::preset::Preset;
use super::rows::{Overflow, Room};
use super::train_device::TrainDevice;
use super::training_set::TrainingSet;
use super::two_branch::TwoBranch;
use crate::observation::Channel;
use crate::{Error, Result};

/// Steps between two reports: rare enough to cost nothing, often enough for a smooth bar and a prompt stop.
const REPORT_EVERY: u64 = 20;

/// A kill costs at most this much work.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(2);

/// How a network is to be trained.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainOptions {
    /// Every hyper-parameter.
    pub preset: Preset,
    /// What the initial weights and all draws start from.
    pub seed: u64,
    /// Most bytes of encoded rollouts in memory. What is more waits in [`Keeping::overflow`]; what is learned is the same, bit
    /// for bit.
    pub memory_bytes: usize,
    /// Device. A checkpoint resumes only on the device that wrote it.
    pub device: TrainDevice,
}

impl TrainOptions {
    /// [`memory_bytes`](Self::memory_bytes) by default.
    pub const MEMORY_BYTES: usize = 256 << 20;

    /// With the usual memory, on the CPU.
    #[must_use]
    pub fn new(preset: Preset, seed: u64) -> Self {
        Self { preset, seed, memory_bytes: Self::MEMORY_BYTES, device: TrainDevice::Cpu }
    }
}

/// What a training writes besides its model.
#[derive(Clone, Copy, Default)]
pub struct Keeping<'a> {
    /// Where its state is kept, if anywhere. It is found again by the same training after a kill, stays when training is
    /// done, and is the caller's to remove once the model is safe.
    pub checkpoint: Option<&'a dyn Checkpoint>,
    /// Where encoded rollouts beyond [`TrainOptions::memory_bytes`] wait; without one all stay in memory.
    pub overflow: Option<&'a Overflow<'a>>,
}

/// Where a training stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainProgress {
    /// Steps done.
    pub step: u64,
    /// Steps in all.
    pub steps: u64,
    /// Loss of the last batch, in units of the training span (squared where the preset says so).
    pub loss: f64,
    /// Mean absolute error on the pairs held back, noise-free, in units of the training span; `None` where none are held
    /// back.
    pub validation: Option<f64>,
    /// Time that is left at the present pace, in s.
    pub seconds_left: f64,
}

/// Trains a network on `data`, which is gone through once or twice, pair by pair, and may be larger than the memory.
///
/// The same data set, preset and seed give the same weights, bit for bit on one kind of processor, for any number of
/// threads and however often the training was interrupted. On a GPU the same holds for one kind of GPU, as far as its own
/// libraries do. Where `progress` answers `false`, a checkpoint is written and the training stops.
///
/// # Errors
/// [`Error::Setting`] for a preset out of range; [`Error::Dataset`] and [`Error::Model`] where the data set does not fit the
/// preset; [`Error::Weights`] for a checkpoint of another training; those of `data`, of `keeping` and of
/// [`TrainDevice::check`]; [`Error::Stopped`] on request.
pub fn train(
    data: &dyn DataSet,
    options: &TrainOptions,
    keeping: Keeping<'_>,
    progress: &mut dyn FnMut(&TrainProgress) -> bool,
) -> Result<Model> {
    options.preset.check()?;
    let room = Room { memory_bytes: options.memory_bytes, overflow: keeping.overflow };
    let set = TrainingSet::gather(data, &options.preset, room)?;
    learn(&set, options, keeping.checkpoint, progress)
}

/// As [`train`], on pairs in memory and without a checkpoint.
///
/// # Errors
/// As [`train`]; [`Error::Model`] for a pair that is not what `header` announces.
pub fn train_on(
    header: &DatasetHeader,
    pairs: &[Pair],
    options: &TrainOptions,
    progress: &mut dyn FnMut(&TrainProgress) -> bool,
) -> Result<Model> {
    train(&PairsInMemory { header, pairs }, options, Keeping::default(), progress)
}

/// Trains on `set`, with its state in `checkpoint`.
fn learn(
    set: &TrainingSet<'_>,
    options: &TrainOptions,
    checkpoint: Option<&dyn Checkpoint>,
    progress: &mut dyn FnMut(&TrainProgress) -> bool,
) -> Result<Model> {
    let (preset, device) = (&options.preset, options.device.device()?);
    let about = About {
        version: MODEL_VERSION,
        preset: preset.clone(),
        input: set.input.clone(),
        parameters: set.parameters.clone(),
        channels: named(&set.header.channels),
        target: set.target.clone().map(|input| Target { input, channels: named(&set.header.target_channels) }),
        seed: options.seed,
    };
    let mut network = TwoBranch::new(model::widths(&about), preset.head, options.seed)?;
    let mut descent = GradientDescent::new(preset.optimiser.clone(), &network)?;
    let mut batches = Batches::new(set, preset, options.seed);
    let fingerprint = checkpoint.map(|kept| checkpoint::fingerprint(kept, &about)).transpose()?.unwrap_or_default();
    let kept = checkpoint.map(|checkpoint| Kept { checkpoint, fingerprint: &fingerprint, device: options.device });
    let mut first = 0;
    if let Some(kept) = kept {
        first = checkpoint::load(kept, &about, &mut network, &mut descent)?.unwrap_or(0);
    }
    let mut learner = Learner::new(&network, &descent, preset.loss, &device)?;
    let save = |step: u64, learner: &Learner| {
        let Some(kept) = kept else { return Ok(()) };
        let (network, descent) = learner.state()?;
        checkpoint::save(kept, step, &network, &descent)
    };

    let steps = batches.steps();
    // Validation costs about as much as the steps between two of its twenty.
    let validate_every = (steps / 20).max(1);
    let mut validation = None;
    let (started, mut saved) = (Instant::now(), Instant::now());
    for step in first..steps {
        let batch = batches.draw(step)?;
        let loss = learner.learn(&batch, Schedule { step, steps, epoch: step / batches.in_epoch() })?;
        let done = step + 1;
        if done % validate_every == 0 || done == first + 1 {
            validation = mean_error(&learner.state()?.0, batches.held_back())?;
        }
        if done % REPORT_EVERY == 0 || done == steps {
            let pace = started.elapsed().as_secs_f64() / (done - first) as f64;
            if !loss.is_finite() {
                let (what, expected) = ("training".into(), "a finite loss".into());
                return Err(Error::Model { what, expected, found: format!("{loss} at step {done}") });
            }
            let report =
                TrainProgress { step: done, steps, loss, validation, seconds_left: pace * (steps - done) as f64 };
            if !progress(&report) && done < steps {
                save(done, &learner)?;
                return Err(Error::Stopped);
            }
            if saved.elapsed() >= CHECKPOINT_EVERY || done == steps {
                save(done, &learner)?;
                saved = Instant::now();
            }
        }
    }
    let library = Library::choose(set, preset.library)?;
    Model::new(about, set.header.clock.clone(), learner.state()?.0, library)
}

fn named(channels: &[Channel]) -> Vec<(String, String)> {
    channels.iter().map(|c| (c.name.clone(), c.unit.clone())).collect()
}

/// The mean absolute error on these pairs; `None` where there are none.
fn mean_error(network: &TwoBranch, pairs: impl Iterator<Item = Result<Batch>>) -> Result<Option<f64>> {
    let (mut sum, mut count) = (0.0, 0);
    for batch in pairs {
        let batch = batch?;
        let error = (network.forward(&batch.proposed, &batch.target)? - &batch.difference)?;
        sum += f64::from(error.abs()?.sum_all()?.to_scalar::<f32>()?);
        count += error.elem_count();
    }
    Ok((count > 0).then(|| sum / count as f64))
}
