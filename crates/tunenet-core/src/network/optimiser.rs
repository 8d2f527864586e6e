//! Gradient descent with L2 regularisation and a stepwise rate, and Adam with decoupled weight decay (`AdamW`, Loshchilov
//! and Hutter, arXiv 1711.05101) and a rate that falls along half a cosine.
//!
//! The moments stand in every checkpoint, so that a resumed training ends with the same bits. candle's own `AdamW` keeps
//! its moments to itself, and its SGD has no L2.

use candle_core::backprop::GradStore;
use candle_core::{Device, Tensor, Var};

use super::preset::Optimiser;
use super::two_branch::TwoBranch;
use crate::Result;

/// Where in the course of a training a step stands; rates depend on it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedule {
    /// Steps done.
    pub(super) step: u64,
    /// Steps in all.
    pub(super) steps: u64,
    /// From 0.
    pub(super) epoch: u64,
}

/// An optimiser with its memory.
#[derive(Debug, Clone)]
pub(super) struct GradientDescent {
    settings: Optimiser,
    /// First and second moment of each weight's gradient (arXiv 1412.6980, section 2); empty for SGD.
    pub(super) moments: Vec<(Tensor, Tensor)>,
}

impl GradientDescent {
    /// A fresh optimiser for `network`.
    pub(super) fn new(settings: Optimiser, network: &TwoBranch) -> Result<Self> {
        let mut moments = Vec::new();
        if matches!(settings, Optimiser::AdamW { .. }) {
            for weight in network.weights() {
                moments.push((weight.zeros_like()?, weight.zeros_like()?));
            }
        }
        Ok(Self { settings, moments })
    }

    /// The same on `device`.
    pub(super) fn to_device(&self, device: &Device) -> Result<Self> {
        let mut moments = Vec::with_capacity(self.moments.len());
        for (mean, square) in &self.moments {
            moments.push((mean.to_device(device)?, square.to_device(device)?));
        }
        Ok(Self { settings: self.settings.clone(), moments })
    }

    /// One step of `weights` down their gradients.
    pub(super) fn step(&mut self, weights: &[Var], gradients: &GradStore, at: Schedule) -> Result<()> {
        for (i, weight) in weights.iter().enumerate() {
            let none = || candle_core::Error::Msg("a weight without a gradient".into());
            let gradient = gradients.get(weight).ok_or_else(none)?;
            let before = weight.as_detached_tensor();
            let after = match self.settings {
                Optimiser::Sgd { rate, decay, decay_every, l2 } => {
                    let decays = i32::try_from(at.epoch / decay_every).unwrap_or(i32::MAX);
                    (&before - ((gradient + (&before * l2)?)? * (rate * decay.powi(decays)))?)?
                }
                Optimiser::AdamW { rate, decay, beta1, beta2, epsilon } => {
                    let rate = rate * 0.5 * (1.0 + (std::f64::consts::PI * at.step as f64 / at.steps as f64).cos());
                    // Both moments start at zero; these factors undo that (arXiv 1412.6980, section 3).
                    let count = (at.step + 1) as f64;
                    let (unbiased_rate, unbiased_square) =
                        (rate / (1.0 - beta1.powf(count)), 1.0 / (1.0 - beta2.powf(count)));
                    let (mean, square) = &mut self.moments[i];
                    *mean = ((&*mean * beta1)? + (gradient * (1.0 - beta1))?)?;
                    *square = ((&*square * beta2)? + (gradient.sqr()? * (1.0 - beta2))?)?;
                    let root = ((&*square * unbiased_square)?.sqrt()? + epsilon)?;
                    ((before * (1.0 - rate * decay))? - ((&*mean * unbiased_rate)? / root)?)?
                }
            };
            weight.set(&after)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::preset::Head;
    use crate::network::preset::Preset;
    use crate::network::two_branch::Widths;

    /// One weight with gradient `2 w`, before and after a step.
    fn stepped(settings: Optimiser) -> (f32, f32) {
        let widths = Widths { inputs: 1, features: 1, hidden: 1, outputs: 1 };
        let network = TwoBranch::new(widths, Head::Tanh, 1).unwrap();
        let (_, weights) = network.trainable(&Device::Cpu).unwrap();
        let mut squares = Tensor::zeros((), network.output.bias.dtype(), &Device::Cpu).unwrap();
        for weight in &weights {
            squares = (squares + weight.sqr().unwrap().sum_all().unwrap()).unwrap();
        }
        let gradients = squares.backward().unwrap();
        let weight = || weights[0].to_vec2::<f32>().unwrap()[0][0];
        let before = weight();
        let at = Schedule { step: 0, steps: 100, epoch: 5 };
        GradientDescent::new(settings, &network).unwrap().step(&weights, &gradients, at).unwrap();
        (before, weight())
    }

    #[test]
    fn sgd_follows_its_formula() {
        let (w, after) = stepped(Preset::paper().optimiser);
        let rate = 1e-2 * 0.99;
        assert!((after - (w - rate * (2.0 * w + 1e-2 * w))).abs() < 1e-7);
    }

    #[test]
    fn first_step_of_adam_is_the_rate_against_the_sign() {
        let (w, after) = stepped(Preset::default().optimiser);
        assert!((after - (w - 3e-3 * w.signum())).abs() < 1e-6);
    }
}
