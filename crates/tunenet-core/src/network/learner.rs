//! One step of a training: forward pass, loss, gradients by reverse-mode automatic differentiation, optimiser.
//!
//! All of it is candle's tensors, on whichever device they are.

use candle_core::{DType, Device, Tensor, Var};

use super::batches::Batch;
use super::optimiser::{GradientDescent, Schedule};
use super::preset::Loss;
use super::two_branch::TwoBranch;
use crate::Result;

/// A network that learns.
pub(super) struct Learner {
    network: TwoBranch,
    /// The weights of `network`, in the order of [`TwoBranch::NAMES`].
    weights: [Var; 8],
    descent: GradientDescent,
    loss: Loss,
}

impl Learner {
    /// Resumes from `network` and the optimiser state `descent`, on `device`.
    pub(super) fn new(network: &TwoBranch, descent: &GradientDescent, loss: Loss, device: &Device) -> Result<Self> {
        let (network, weights) = network.trainable(device)?;
        Ok(Self { network, weights, descent: descent.to_device(device)?, loss })
    }

    /// One step down the loss of `batch`; returns that loss.
    pub(super) fn learn(&mut self, batch: &Batch, at: Schedule) -> Result<f64> {
        let device = self.weights[0].device();
        let here = |tensor: &Tensor| tensor.to_device(device);
        let estimate = self.network.forward(&here(&batch.proposed)?, &here(&batch.target)?)?;
        let difference = here(&batch.difference)?;
        let loss = match self.loss {
            Loss::Squared => candle_nn::loss::mse(&estimate, &difference)?,
            Loss::Absolute => (estimate - difference)?.abs()?.mean_all()?,
        };
        self.descent.step(&self.weights, &loss.backward()?, at)?;
        Ok(loss.to_dtype(DType::F64)?.to_scalar()?)
    }

    /// The trained weights and the optimiser state, on the CPU. Good until the next step.
    pub(super) fn state(&self) -> Result<(TwoBranch, GradientDescent)> {
        Ok((self.network.detached(&Device::Cpu)?, self.descent.to_device(&Device::Cpu)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::preset::{Head, Optimiser};
    use crate::network::two_branch::Widths;

    fn batch() -> Batch {
        let tensor = |columns: usize, phase: f32| {
            let numbers: Vec<f32> = (0..20 * columns).map(|i| (phase + 0.7 * i as f32).sin()).collect();
            Tensor::from_vec(numbers, (20, columns), &Device::Cpu).unwrap()
        };
        Batch { proposed: tensor(9, 0.0), target: tensor(9, 1.0), difference: (tensor(2, 2.0) * 0.1).unwrap() }
    }

    #[test]
    fn a_step_follows_the_slope_of_the_loss() {
        let rate = 1e-3;
        let optimiser = Optimiser::Sgd { rate, decay: 1.0, decay_every: 1, l2: 0.0 };
        let widths = Widths { inputs: 9, features: 6, hidden: 5, outputs: 2 };
        let network = TwoBranch::new(widths, Head::Tanh, 3).unwrap();
        let descent = GradientDescent::new(optimiser, &network).unwrap();
        let mut learner = Learner::new(&network, &descent, Loss::Squared, &Device::Cpu).unwrap();
        let (before, _) = learner.state().unwrap();
        let before = before.weights().map(|weight| weight.copy().unwrap());
        let mut loss = |step| learner.learn(&batch(), Schedule { step, steps: 2, epoch: 0 }).unwrap();
        let losses = [loss(0), loss(1)];
        let (after, _) = learner.state().unwrap();
        let mut moved = 0.0;
        for (before, after) in before.iter().zip(after.weights()) {
            let square = (before - after).unwrap().sqr().unwrap().sum_all().unwrap();
            moved += f64::from(square.to_scalar::<f32>().unwrap());
        }
        // Two steps of length rate · |gradient|; the first lowers the loss by rate · |gradient|².
        let (fallen, expected) = (losses[0] - losses[1], moved / (4.0 * rate));
        assert!((fallen / expected - 1.0).abs() < 0.05, "{fallen:.3e} for {expected:.3e}");
    }

    /// The loss of `batch` in double precision, by a network whose weights are `flat`.
    fn loss(flat: &[Vec<f64>], shapes: &[Vec<usize>; 8], head: Head, kind: Loss) -> f64 {
        let tensor = |i: usize| Tensor::from_slice(&flat[i], shapes[i].as_slice(), &Device::Cpu).unwrap();
        let network = TwoBranch::from_weights(std::array::from_fn(tensor), head);
        let wide = |tensor: Tensor| tensor.to_dtype(DType::F64).unwrap();
        let Batch { proposed, target, difference } = batch();
        let error = (network.forward(&wide(proposed), &wide(target)).unwrap() - wide(difference)).unwrap();
        let errors = error.flatten_all().unwrap().to_vec1::<f64>().unwrap();
        let each = |e: &f64| if matches!(kind, Loss::Squared) { e * e } else { e.abs() };
        errors.iter().map(each).sum::<f64>() / errors.len() as f64
    }

    #[test]
    fn gradients_are_the_central_differences_of_the_loss() {
        let widths = Widths { inputs: 9, features: 6, hidden: 5, outputs: 2 };
        let numbers = |tensor: &Tensor| {
            let flat = tensor.flatten_all().unwrap().to_dtype(DType::F64).unwrap();
            flat.to_vec1::<f64>().unwrap()
        };
        for (head, kind) in [
            (Head::Tanh, Loss::Squared),
            (Head::Tanh, Loss::Absolute),
            (Head::Antisymmetric, Loss::Squared),
            (Head::Antisymmetric, Loss::Absolute),
        ] {
            let optimiser = Optimiser::Sgd { rate: 1.0, decay: 1.0, decay_every: 1, l2: 0.0 };
            let network = TwoBranch::new(widths, head, 3).unwrap();
            let descent = GradientDescent::new(optimiser, &network).unwrap();
            let mut learner = Learner::new(&network, &descent, kind, &Device::Cpu).unwrap();
            learner.learn(&batch(), Schedule { step: 0, steps: 1, epoch: 0 }).unwrap();
            let (after, _) = learner.state().unwrap();
            // A step of rate 1 is the gradient.
            let flat = network.weights().map(numbers);
            let gradient: Vec<Vec<f64>> = flat
                .iter()
                .zip(after.weights().map(numbers))
                .map(|(before, after)| before.iter().zip(after).map(|(b, a)| b - a).collect())
                .collect();
            let greatest = gradient.iter().flatten().fold(0.0, |most: f64, g| most.max(g.abs()));
            assert!(greatest > 1e-3, "{head:?}, {kind:?}: no gradient");
            let shapes = TwoBranch::shapes(widths);
            for (i, weights) in flat.iter().enumerate() {
                for k in 0..weights.len() {
                    let moved = |step: f64| {
                        let mut moved = flat.to_vec();
                        moved[i][k] += step;
                        loss(&moved, &shapes, head, kind)
                    };
                    let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                    let apart = (slope - gradient[i][k]).abs();
                    assert!(
                        apart < 1e-5 * greatest.max(0.1),
                        "{head:?}, {kind:?}, {i}, {k}: {slope} {}",
                        gradient[i][k]
                    );
                }
            }
        }
    }
}
