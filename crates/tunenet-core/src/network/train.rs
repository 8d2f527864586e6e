//! Training a network on a dataset.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::batches::{Batch, Batches};
use super::checkpoint;
use super::dataset::{DatasetHeader, Pair};
use super::gradients::Gradients;
use super::library::Library;
use super::model::{self, About, MODEL_VERSION, Model, Target};
use super::optimiser::Descent;
use super::preset::Preset;
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
    /// Where to keep a checkpoint, if anywhere. It is found again by the same training after a kill, stays when training
    /// is done, and is the caller's to delete once the model is safe.
    pub checkpoint: Option<PathBuf>,
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
/// The same dataset, preset and seed give the same weights, bit for bit on one kind of processor, whatever the number of
/// threads and however often the training was interrupted. Where `progress` answers `false`, a checkpoint is written and
/// the training stops.
///
/// # Errors
/// [`Error::Setting`] for a preset out of range; [`Error::File`] and [`Error::Io`] where the dataset or the checkpoint
/// cannot be used; [`Error::Model`] where the dataset does not fit the preset; [`Error::Stopped`] on request.
pub fn train(
    dataset: &Path,
    options: &TrainOptions,
    progress: &mut dyn FnMut(&TrainProgress) -> bool,
) -> Result<Model> {
    options.preset.check()?;
    let set = TrainingSet::read(dataset, &options.preset)?;
    let kept = options.checkpoint.as_deref().map(|checkpoint| (checkpoint, dataset));
    learn(&set, options, kept, progress)
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
    learn(&TrainingSet::collect(header, pairs, &options.preset)?, options, None, progress)
}

/// Trains on `set`; `kept` is where the state is kept and the file that the set was read from.
fn learn(
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
    let gradients = Gradients::new(&network)?;
    let mut batches = Batches::new(set, preset, options.seed)?;
    let fingerprint = match kept {
        Some((_, dataset)) => checkpoint::fingerprint(dataset, &about)?,
        None => String::new(),
    };
    let mut first = 0;
    if let Some((path, _)) = kept {
        first = checkpoint::load(path, &fingerprint, &about, &mut network, &mut descent)?.unwrap_or(0);
    }
    let save = |step: u64, network: &TwoBranch, descent: &Descent| match kept {
        Some((path, _)) => checkpoint::save(path, &fingerprint, step, network, descent),
        None => Ok(()),
    };

    let steps = batches.steps();
    let held_back = batches.held_back()?;
    // Validation costs about as much as the steps between two of its twenty.
    let validate_every = (steps / 20).max(1);
    let mut validation = None;
    let (started, mut saved) = (Instant::now(), Instant::now());
    for step in first..steps {
        let batch = batches.draw(step)?;
        let loss = gradients.of(&network, &batch, preset.loss)?;
        descent.step(&network, gradients.each(), step, steps, step / batches.in_epoch())?;
        let done = step + 1;
        if let Some(pairs) = &held_back
            && (done % validate_every == 0 || validation.is_none())
        {
            validation = Some(mean_error(&network, pairs)?);
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
                save(done, &network, &descent)?;
                return Err(Error::Stopped);
            }
            if saved.elapsed() >= CHECKPOINT_EVERY || done == steps {
                save(done, &network, &descent)?;
                saved = Instant::now();
            }
        }
    }
    let library = Library::choose(set, preset.library);
    Model::new(about, set.header.clock.clone(), network, library)
}

fn named(channels: &[Channel]) -> Vec<(String, String)> {
    channels.iter().map(|c| (c.name.clone(), c.unit.clone())).collect()
}

fn mean_error(network: &TwoBranch, pairs: &Batch) -> Result<f64> {
    let error = (network.forward(&pairs.proposed, &pairs.target)? - &pairs.difference)?;
    Ok(f64::from(error.abs()?.mean_all()?.to_scalar::<f32>()?))
}
