//! Checkpoints: a training that was killed resumes and ends with the same bits.

use candle_core::DType;
use serde::{Deserialize, Serialize};

use super::model::{self, About};
use super::optimiser::GradientDescent;
use super::train_device::TrainDevice;
use super::two_branch::TwoBranch;
use super::weights::{Weights, WeightsFault};
use crate::{Error, Result};

/// What a checkpoint says besides its numbers.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mark {
    /// Of the dataset, the preset and the seed: a checkpoint resumes the same training or not at all.
    fingerprint: String,
    /// Steps done.
    step: u64,
    /// [`TrainDevice::name`].
    device: String,
}

/// Where the state of a training is kept, so that it can be killed.
pub trait Checkpoint {
    /// A digest of the data set, followed by `settings`: what makes a training this one.
    ///
    /// # Errors
    /// Where the data set cannot be read.
    fn fingerprint(&self, settings: &[u8]) -> Result<String>;

    /// What was kept last; `None` where nothing was.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn load(&self) -> Result<Option<Weights>>;

    /// Keeps `weights` in place of what was kept before: a kill leaves the one or the other, never half of it.
    ///
    /// # Errors
    /// Where they cannot be written.
    fn save(&self, weights: &Weights) -> Result<()>;
}

/// What makes a training this one: every byte of its data set, its preset and its seed.
pub(super) fn fingerprint(checkpoint: &dyn Checkpoint, about: &About) -> Result<String> {
    checkpoint.fingerprint(&serde_json::to_vec(about).map_err(|e| candle_core::Error::Msg(e.to_string()))?)
}

/// Which training, and where it runs.
///
/// A run ends on the device on which it began: mixing devices gives weights that no command reproduces.
#[derive(Clone, Copy)]
pub(super) struct Kept<'a> {
    pub(super) checkpoint: &'a dyn Checkpoint,
    /// See [`fingerprint`].
    pub(super) fingerprint: &'a str,
    pub(super) device: TrainDevice,
}

/// Writes where the training stands; a kill leaves the one before or this one, never half of it.
pub(super) fn save(kept: Kept<'_>, step: u64, network: &TwoBranch, descent: &GradientDescent) -> Result<()> {
    let mut tensors = model::named(network);
    for (name, (mean, square)) in TwoBranch::NAMES.iter().zip(&descent.moments) {
        tensors.push((format!("mean.{name}"), mean.clone()));
        tensors.push((format!("square.{name}"), square.clone()));
    }
    let mark = Mark { fingerprint: kept.fingerprint.to_owned(), step, device: kept.device.name().into() };
    let mark = serde_json::to_string(&mark).map_err(|e| candle_core::Error::Msg(e.to_string()))?;
    kept.checkpoint.save(&Weights::new(mark, &tensors)?)
}

/// Resumes from the checkpoint: sets the network and the optimiser, returns the steps done; `None` where there is none.
pub(super) fn load(
    Kept { checkpoint, fingerprint, device }: Kept<'_>,
    about: &About,
    network: &mut TwoBranch,
    descent: &mut GradientDescent,
) -> Result<Option<u64>> {
    let Some(mut stored) = checkpoint.load()? else { return Ok(None) };
    let refuse = |found: &str| Error::Weights {
        expected: "a checkpoint of this training".into(),
        found: found.into(),
        fault: WeightsFault::OtherTraining,
    };
    let mark: Mark = serde_json::from_str(&stored.about).map_err(|_| refuse("a model or another file"))?;
    if mark.fingerprint != fingerprint {
        return Err(refuse("one of another dataset, preset or seed"));
    }
    if mark.device != device.name() {
        return Err(Error::Weights {
            expected: format!("a checkpoint of a training on `{}`", device.name()),
            found: format!("one on `{}`", mark.device),
            fault: WeightsFault::OtherDevice(mark.device),
        });
    }
    *network = model::take_network(&mut stored, about)?;
    for (name, (mean, square)) in TwoBranch::NAMES.iter().zip(&mut descent.moments) {
        let (expected, number) = (mean.shape().clone(), DType::F32);
        *mean = stored.take(&format!("mean.{name}"), number, expected.dims())?;
        *square = stored.take(&format!("square.{name}"), number, expected.dims())?;
    }
    Ok(Some(mark.step))
}
