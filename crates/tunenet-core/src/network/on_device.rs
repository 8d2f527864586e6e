//! A training in candle's own operations, on whichever device candle has.
//!
//! What is written out by hand in [`gradients`](super::gradients) and [`optimiser`](super::optimiser) runs on a CPU alone.
//! The same network, loss and steps stand here as tensors: candle finds the gradients, and the device is a value. So the
//! tests run all of it on candle's CPU, and a GPU is only another value.

use candle_core::{Device, Tensor, Var};

use super::batches::Batch;
use super::learner::{Learner, Moment};
use super::optimiser::{Descent, Step};
use super::preset::{Head, Loss};
use super::two_branch::TwoBranch;
use crate::Result;

/// A network on a device.
pub(super) struct OnDevice {
    /// In the order of [`TwoBranch::NAMES`].
    weights: [Var; 8],
    head: Head,
    loss: Loss,
    /// Its memory is on the device too.
    descent: Descent,
}

impl OnDevice {
    /// Goes on from `network` and what `descent` remembers, wherever they are, on `device`.
    pub(super) fn new(network: &TwoBranch, mut descent: Descent, loss: Loss, device: &Device) -> Result<Self> {
        let mut weights = Vec::with_capacity(8);
        for weight in network.weights() {
            weights.push(Var::from_tensor(&weight.to_device(device)?)?);
        }
        let Ok(weights) = <[Var; 8]>::try_from(weights) else { unreachable!("eight in, eight out") };
        for (mean, square) in &mut descent.memory {
            (*mean, *square) = (mean.to_device(device)?, square.to_device(device)?);
        }
        Ok(Self { weights, head: network.head, loss, descent })
    }

    /// The loss of `batch` and its gradient by each weight.
    pub(super) fn gradients(&self, batch: &Batch) -> Result<(f64, Vec<Tensor>)> {
        let (device, numbers) = (self.weights[0].device(), self.weights[0].dtype());
        let here = |tensor: &Tensor| tensor.to_device(device)?.to_dtype(numbers);
        let estimate = self.forward(&here(&batch.proposed)?, &here(&batch.target)?)?;
        let error = (estimate - here(&batch.difference)?)?;
        let loss = match self.loss {
            Loss::Squared => error.sqr()?.mean_all()?,
            Loss::Absolute => error.abs()?.mean_all()?,
        };
        let found = loss.backward()?;
        let mut gradients = Vec::with_capacity(8);
        for weight in &self.weights {
            let none = || candle_core::Error::Msg("a weight without a gradient".into());
            let gradient = found.get(weight).ok_or_else(none)?;
            // It would drag along everything that it was made of.
            gradients.push(gradient.detach());
        }
        Ok((loss.to_dtype(candle_core::DType::F64)?.to_scalar()?, gradients))
    }

    /// As [`TwoBranch::forward`].
    fn forward(&self, proposed: &Tensor, target: &Tensor) -> candle_core::Result<Tensor> {
        match self.head {
            Head::Tanh => self.one_way(proposed, target)?.tanh(),
            // Both ways are one batch, to ask the device half as often.
            Head::Antisymmetric => {
                let pairs = proposed.dim(0)?;
                let (a, b) = (Tensor::cat(&[proposed, target], 0)?, Tensor::cat(&[target, proposed], 0)?);
                let both = self.one_way(&a, &b)?;
                (both.narrow(0, 0, pairs)? - both.narrow(0, pairs, pairs)?)? * 0.5
            }
        }
    }

    fn one_way(&self, a: &Tensor, b: &Tensor) -> candle_core::Result<Tensor> {
        let pass =
            |x: &Tensor, layer: usize| x.matmul(&self.weights[2 * layer])?.broadcast_add(&self.weights[2 * layer + 1]);
        let branches = [pass(a, 0)?.relu()?, pass(b, 1)?.relu()?];
        pass(&pass(&Tensor::cat(&branches, 1)?, 2)?.relu()?, 3)
    }

    /// As [`Descent::step`].
    fn step(&mut self, gradients: &[Tensor], now: Moment) -> Result<()> {
        let step = self.descent.at(now);
        for (i, (weight, gradient)) in self.weights.iter().zip(gradients).enumerate() {
            let before = weight.as_detached_tensor();
            let after = match step {
                Step::Sgd { rate, l2 } => (&before - ((gradient + (&before * l2)?)? * rate)?)?,
                Step::AdamW { beta1, beta2, keep, rate, square_factor, epsilon } => {
                    let (mean, square) = &mut self.descent.memory[i];
                    *mean = ((&*mean * beta1)? + (gradient * (1.0 - beta1))?)?;
                    *square = ((&*square * beta2)? + (gradient.sqr()? * (1.0 - beta2))?)?;
                    let root = ((&*square * square_factor)?.sqrt()? + epsilon)?;
                    ((before * keep)? - ((&*mean * rate)? / root)?)?
                }
            };
            weight.set(&after)?;
        }
        Ok(())
    }
}

impl Learner for OnDevice {
    fn learn(&mut self, batch: &Batch, now: Moment) -> Result<f64> {
        let (loss, gradients) = self.gradients(batch)?;
        self.step(&gradients, now)?;
        Ok(loss)
    }

    fn state(&self) -> Result<(TwoBranch, Descent)> {
        let mut weights = Vec::with_capacity(8);
        for weight in &self.weights {
            weights.push(weight.as_detached_tensor().to_device(&Device::Cpu)?);
        }
        let Ok(weights) = <[Tensor; 8]>::try_from(weights) else { unreachable!("eight in, eight out") };
        let mut descent = self.descent.clone();
        for (mean, square) in &mut descent.memory {
            (*mean, *square) = (mean.to_device(&Device::Cpu)?, square.to_device(&Device::Cpu)?);
        }
        Ok((TwoBranch::from_weights(weights, self.head), descent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::preset::Preset;
    use crate::network::two_branch::Widths;

    /// The same gradients, so that nothing but the step itself is compared.
    #[test]
    fn steps_are_those_written_out_by_hand() {
        let widths = Widths { inputs: 9, features: 5, hidden: 4, outputs: 2 };
        for optimiser in [Preset::paper().optimiser, Preset::default().optimiser] {
            let network = TwoBranch::new(widths, Head::Tanh, 3).unwrap();
            let other = TwoBranch::new(widths, Head::Tanh, 4).unwrap();
            let descent = Descent::new(optimiser, &network).unwrap();
            let mut device = OnDevice::new(&network, descent.clone(), Loss::Squared, &Device::Cpu).unwrap();
            for (memory, fresh) in device.descent.memory.iter_mut().zip(&descent.memory) {
                // Steps by hand write in place.
                *memory = (fresh.0.copy().unwrap(), fresh.1.copy().unwrap());
            }
            for step in 0..50 {
                let gradients = other.weights().map(|w| (w * f64::cos(step as f64)).unwrap());
                let now = Moment { step, steps: 60, epoch: step / 7 };
                descent.step(&network, &gradients, now).unwrap();
                device.step(&gradients, now).unwrap();
            }
            for (ours, theirs) in network.weights().into_iter().zip(device.state().unwrap().0.weights()) {
                let off = (ours - theirs).unwrap().abs().unwrap().flatten_all().unwrap().max(0).unwrap();
                let off = off.to_scalar::<f32>().unwrap();
                // A dozen roundings of weights below 1 at 6e-8.
                assert!(off < 1e-6, "{off:.1e}");
            }
        }
    }
}
