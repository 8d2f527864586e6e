//! What a training asks of whoever does the sums.

use candle_core::Device;

use super::batches::Batch;
use super::gradients::Gradients;
use super::on_device::OnDevice;
use super::optimiser::Descent;
use super::preset::Loss;
use super::two_branch::TwoBranch;
use crate::Result;

/// Who does the sums.
#[derive(Debug, Clone)]
pub(super) enum Place {
    /// What is written out here, on the CPU.
    ByHand,
    /// candle's own operations, on a device of candle's. On its CPU they are what the tests hold against the rest.
    Candle(Device),
}

/// How far a training is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    /// Steps done.
    pub(super) step: u64,
    /// Steps in all.
    pub(super) steps: u64,
    /// From 0.
    pub(super) epoch: u64,
}

/// A network that learns.
pub(super) trait Learner {
    /// One step down the loss of `batch`; returns that loss.
    fn learn(&mut self, batch: &Batch, now: Moment) -> Result<f64>;

    /// What has been learned and what the optimiser remembers, on the CPU. Good until the next step.
    fn state(&self) -> Result<(TwoBranch, Descent)>;
}

impl Place {
    /// What a checkpoint and people call it.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::ByHand => "cpu",
            Self::Candle(Device::Cuda(_)) => "cuda",
            Self::Candle(_) => "candle",
        }
    }

    /// Goes on from `network` and what `descent` remembers.
    pub(super) fn learner(&self, network: TwoBranch, descent: Descent, loss: Loss) -> Result<Box<dyn Learner>> {
        Ok(match self {
            Self::ByHand => Box::new(ByHand { gradients: Gradients::new(&network)?, network, descent, loss }),
            Self::Candle(device) => Box::new(OnDevice::new(&network, descent, loss, device)?),
        })
    }
}

/// [`Place::ByHand`].
struct ByHand {
    network: TwoBranch,
    descent: Descent,
    gradients: Gradients,
    loss: Loss,
}

impl Learner for ByHand {
    fn learn(&mut self, batch: &Batch, now: Moment) -> Result<f64> {
        let loss = self.gradients.of(&self.network, batch, self.loss)?;
        self.descent.step(&self.network, self.gradients.each(), now)?;
        Ok(loss)
    }

    fn state(&self) -> Result<(TwoBranch, Descent)> {
        Ok((self.network.clone(), self.descent.clone()))
    }
}
