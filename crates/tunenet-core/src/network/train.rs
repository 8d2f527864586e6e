//! Training a network on a dataset.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::batches::{Batch, Batches};
use super::checkpoint::{self, Kept};
use super::dataset::{DatasetHeader, Pair};
use super::learner::{Learner, Moment, Place};
use super::library::Library;
use super::model::{self, About, MODEL_VERSION, Model, Target};
use super::optimiser::Descent;
use super::preset::Preset;
use super::train_device::TrainDevice;
use super::training_set::{Room, TrainingSet};
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
    /// Where to keep a checkpoint, if anywhere. It is found again by the same training after a kill, stays when training
    /// is done, and is the caller's to delete once the model is safe.
    pub checkpoint: Option<PathBuf>,
    /// Most bytes of encoded rollouts in memory. What is more waits in a temporary file beside the checkpoint, else in the
    /// system's folder for such files; what is learned is the same, bit for bit.
    pub memory_bytes: usize,
    /// Where the sums are done. A checkpoint goes on where it was made, or not at all.
    pub device: TrainDevice,
}

impl TrainOptions {
    /// [`memory_bytes`](Self::memory_bytes) where nobody says otherwise.
    pub const MEMORY_BYTES: usize = 256 << 20;

    /// Without a checkpoint, with the usual memory, on the CPU.
    #[must_use]
    pub fn new(preset: Preset, seed: u64) -> Self {
        Self { preset, seed, checkpoint: None, memory_bytes: Self::MEMORY_BYTES, device: TrainDevice::Cpu }
    }

    /// Where the temporary file belongs.
    fn folder(&self) -> PathBuf {
        let beside = self.checkpoint.as_deref().and_then(Path::parent);
        match beside {
            Some(folder) if folder.as_os_str().is_empty() => PathBuf::from("."),
            Some(folder) => folder.into(),
            None => std::env::temp_dir(),
        }
    }
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

/// Trains a network on `dataset`.
///
/// The dataset is read from its file once or twice, pair by pair, and may be larger than the memory.
/// The same dataset, preset and seed give the same weights, bit for bit on one kind of processor, whatever the number of
/// threads and however often the training was interrupted. On a GPU the same holds for one kind of GPU, as far as its own
/// libraries do. Where `progress` answers `false`, a checkpoint is written and
/// the training stops.
///
/// # Errors
/// [`Error::Setting`] for a preset out of range; [`Error::File`] and [`Error::Io`] where the dataset or the checkpoint
/// cannot be used; [`Error::Model`] where the dataset does not fit the preset; those of [`TrainDevice::check`]; [`Error::Stopped`] on request.
pub fn train(
    dataset: &Path,
    options: &TrainOptions,
    progress: &mut dyn FnMut(&TrainProgress) -> bool,
) -> Result<Model> {
    train_at(&options.device.place()?, dataset, options, progress)
}

/// As [`train`], wherever [`TrainOptions::device`] is.
pub(super) fn train_at(
    place: &Place,
    dataset: &Path,
    options: &TrainOptions,
    progress: &mut dyn FnMut(&TrainProgress) -> bool,
) -> Result<Model> {
    options.preset.check()?;
    let room = Room { memory_bytes: options.memory_bytes, folder: &options.folder() };
    let set = TrainingSet::read(dataset, &options.preset, room)?;
    let kept = options.checkpoint.as_deref().map(|checkpoint| (checkpoint, dataset));
    learn(place, &set, options, kept, progress)
}

/// As [`train`], on pairs at hand; [`TrainOptions::checkpoint`] is not used.
///
/// # Errors
/// As [`train`]; [`Error::Model`] for a pair that is not what `header` announces.
pub fn train_on(
    header: &DatasetHeader,
    pairs: &[Pair],
    options: &TrainOptions,
    progress: &mut dyn FnMut(&TrainProgress) -> bool,
) -> Result<Model> {
    options.preset.check()?;
    let room = Room { memory_bytes: options.memory_bytes, folder: &options.folder() };
    let set = TrainingSet::collect(header, pairs, &options.preset, room)?;
    learn(&options.device.place()?, &set, options, None, progress)
}

/// Trains on `set`; `kept` is where the state is kept and the file that the set was read from.
fn learn(
    place: &Place,
    set: &TrainingSet,
    options: &TrainOptions,
    kept: Option<(&Path, &Path)>,
    progress: &mut dyn FnMut(&TrainProgress) -> bool,
) -> Result<Model> {
    let preset = &options.preset;
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
    let mut descent = Descent::new(preset.optimiser.clone(), &network)?;
    let mut batches = Batches::new(set, preset, options.seed);
    let fingerprint = match kept {
        Some((_, dataset)) => checkpoint::fingerprint(dataset, &about)?,
        None => String::new(),
    };
    let kept = kept.map(|(path, _)| Kept { path, fingerprint: &fingerprint, place });
    let mut first = 0;
    if let Some(kept) = kept {
        first = checkpoint::load(kept, &about, &mut network, &mut descent)?.unwrap_or(0);
    }
    let mut learner = place.learner(network, descent, preset.loss)?;
    let save = |step: u64, learner: &dyn Learner| {
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
        let loss = learner.learn(&batch, Moment { step, steps, epoch: step / batches.in_epoch() })?;
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
                save(done, learner.as_ref())?;
                return Err(Error::Stopped);
            }
            if saved.elapsed() >= CHECKPOINT_EVERY || done == steps {
                save(done, learner.as_ref())?;
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
