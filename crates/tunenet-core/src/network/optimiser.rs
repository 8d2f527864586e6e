//! Steps down the gradient, in place.
//!
//! A step on weights this small is mostly the cost of calling: candle's own optimisers make a dozen tensors for each
//! weight. Here one pass over the numbers does it all.

use candle_core::{CpuStorage, Device, InplaceOp2, InplaceOp3, Layout, Tensor};

use super::learner::Moment;
use super::numbers::{single, slice, slice_mut};
use super::preset::Optimiser;
use super::two_branch::TwoBranch;
use crate::Result;

/// An optimiser with its memory.
#[derive(Debug, Clone)]
pub(super) struct Descent {
    settings: Optimiser,
    /// Mean gradient and mean squared gradient of each weight; empty for SGD.
    pub(super) memory: Vec<(Tensor, Tensor)>,
}

impl Descent {
    /// A fresh optimiser for `network`.
    pub(super) fn new(settings: Optimiser, network: &TwoBranch) -> Result<Self> {
        let mut memory = Vec::new();
        if matches!(settings, Optimiser::AdamW { .. }) {
            for weight in network.weights() {
                let zeros = || Tensor::zeros(weight.shape(), weight.dtype(), &Device::Cpu);
                memory.push((zeros()?, zeros()?));
            }
        }
        Ok(Self { settings, memory })
    }

    /// One step down `gradients`, one for each weight.
    pub(super) fn step(&self, network: &TwoBranch, gradients: &[Tensor; 8], now: Moment) -> Result<()> {
        let step = self.at(now);
        for (i, (weight, gradient)) in network.weights().into_iter().zip(gradients).enumerate() {
            match step {
                Step::Sgd { rate, l2 } => {
                    weight.inplace_op2(gradient, &SgdStep { rate: single(rate), l2: single(l2) })?;
                }
                Step::AdamW { beta1, beta2, keep, rate, square_factor, epsilon } => {
                    let (mean, square) = &self.memory[i];
                    mean.inplace_op2(gradient, &Remember { beta: single(beta1), squared: false })?;
                    square.inplace_op2(gradient, &Remember { beta: single(beta2), squared: true })?;
                    let adam = AdamStep {
                        keep: single(keep),
                        rate: single(rate),
                        square_factor: single(square_factor),
                        epsilon: single(epsilon),
                    };
                    weight.inplace_op3(mean, square, &adam)?;
                }
            }
        }
        Ok(())
    }

    /// What the step at `now` does to every weight.
    pub(super) fn at(&self, Moment { step, steps, epoch }: Moment) -> Step {
        match self.settings {
            Optimiser::Sgd { rate, decay, decay_every, l2 } => {
                let decays = i32::try_from(epoch / decay_every).unwrap_or(i32::MAX);
                Step::Sgd { rate: rate * decay.powi(decays), l2 }
            }
            Optimiser::AdamW { rate, decay, beta1, beta2, epsilon } => {
                let rate = rate * 0.5 * (1.0 + (std::f64::consts::PI * step as f64 / steps as f64).cos());
                // Both memories start at zero; these factors undo that (arXiv 1412.6980, section 3).
                let count = (step + 1) as f64;
                Step::AdamW {
                    beta1,
                    beta2,
                    keep: 1.0 - rate * decay,
                    rate: rate / (1.0 - beta1.powf(count)),
                    square_factor: 1.0 / (1.0 - beta2.powf(count)),
                    epsilon,
                }
            }
        }
    }
}

/// One step with its numbers, the same wherever the weights `w` with gradient `g` are.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    /// `w ← w − rate (g + l2 w)`.
    Sgd { rate: f64, l2: f64 },
    /// `m ← β₁ m + (1 − β₁) g`, `v ← β₂ v + (1 − β₂) g²`, `w ← keep · w − rate · m / (√(v · square_factor) + ε)`.
    AdamW { beta1: f64, beta2: f64, keep: f64, rate: f64, square_factor: f64, epsilon: f64 },
}

/// `w ← w − rate (g + l2 w)`.
struct SgdStep {
    rate: f32,
    l2: f32,
}

impl InplaceOp2 for SgdStep {
    fn name(&self) -> &'static str {
        "sgd-step"
    }

    fn cpu_fwd(&self, w: &mut CpuStorage, wl: &Layout, g: &CpuStorage, gl: &Layout) -> candle_core::Result<()> {
        for (w, g) in slice_mut(w, wl)?.iter_mut().zip(slice(g, gl)?) {
            *w -= self.rate * (g + self.l2 * *w);
        }
        Ok(())
    }
}

/// `m ← β m + (1 − β) g`, or `g²`.
struct Remember {
    beta: f32,
    squared: bool,
}

impl InplaceOp2 for Remember {
    fn name(&self) -> &'static str {
        "remember"
    }

    fn cpu_fwd(&self, m: &mut CpuStorage, ml: &Layout, g: &CpuStorage, gl: &Layout) -> candle_core::Result<()> {
        for (m, g) in slice_mut(m, ml)?.iter_mut().zip(slice(g, gl)?) {
            *m = self.beta * *m + (1.0 - self.beta) * if self.squared { g * g } else { *g };
        }
        Ok(())
    }
}

/// `w ← keep · w − rate · m / (√(v · square_factor) + ε)`.
struct AdamStep {
    keep: f32,
    rate: f32,
    square_factor: f32,
    epsilon: f32,
}

impl InplaceOp3 for AdamStep {
    fn name(&self) -> &'static str {
        "adam-step"
    }

    fn cpu_fwd(
        &self,
        w: &mut CpuStorage,
        wl: &Layout,
        m: &CpuStorage,
        ml: &Layout,
        v: &CpuStorage,
        vl: &Layout,
    ) -> candle_core::Result<()> {
        for ((w, m), v) in slice_mut(w, wl)?.iter_mut().zip(slice(m, ml)?).zip(slice(v, vl)?) {
            *w = self.keep * *w - self.rate * m / ((v * self.square_factor).sqrt() + self.epsilon);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::preset::{Head, Preset};
    use crate::network::two_branch::Widths;

    /// One weight, gradient `2 w`, against the formulas done by hand.
    fn stepped(settings: Optimiser) -> (f32, f32) {
        let widths = Widths { inputs: 1, features: 1, hidden: 1, outputs: 1 };
        let network = TwoBranch::new(widths, Head::Tanh, 1).unwrap();
        let weight = || network.proposed.weight.to_vec2::<f32>().unwrap()[0][0];
        let before = weight();
        let gradients = network.weights().map(|weight| (weight * 2.0).unwrap());
        let now = Moment { step: 0, steps: 100, epoch: 5 };
        Descent::new(settings, &network).unwrap().step(&network, &gradients, now).unwrap();
        (before, weight())
    }

    #[test]
    fn sgd_by_hand() {
        let (w, after) = stepped(Preset::paper().optimiser);
        let rate = 1e-2 * 0.99;
        assert!((after - (w - rate * (2.0 * w + 1e-2 * w))).abs() < 1e-7);
    }

    #[test]
    fn the_first_step_of_adam_is_the_rate_down_the_sign() {
        let (w, after) = stepped(Preset::default().optimiser);
        assert!((after - (w - 3e-3 * w.signum())).abs() < 1e-6);
    }
}
