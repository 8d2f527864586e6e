//! How the loss changes with every weight.
//!
//! Written out by hand: candle's own way back also differentiates by the observations, which nobody asks for, adds every
//! gradient to a zero of its size, and wakes a thread on every core to do so. The tests hold it against candle's.

use candle_core::{CpuStorage, Device, InplaceOp2, Layout, Tensor};

use super::batches::Batch;
use super::numbers::{slice, slice_mut};
use super::preset::{Head, Loss};
use super::product::{product, product_into};
use super::two_branch::{OneWay, TwoBranch};
use crate::Result;

/// The gradient of the loss by each of [`TwoBranch::weights`], in their order and shapes; made once, written by every step.
pub(super) struct Gradients {
    each: [Tensor; 8],
}

impl Gradients {
    pub(super) fn new(network: &TwoBranch) -> Result<Self> {
        let mut each = Vec::with_capacity(8);
        for weight in network.weights() {
            each.push(Tensor::zeros(weight.shape(), weight.dtype(), &Device::Cpu)?);
        }
        let Ok(each) = <[Tensor; 8]>::try_from(each) else { unreachable!("eight in, eight out") };
        Ok(Self { each })
    }

    /// Those of the last batch.
    pub(super) fn each(&self) -> &[Tensor; 8] {
        &self.each
    }

    /// Takes those of `batch`; returns its loss.
    pub(super) fn of(&self, network: &TwoBranch, batch: &Batch, loss: Loss) -> Result<f64> {
        let (proposed, target) = (&batch.proposed, &batch.target);
        let forth = network.one_way(proposed, target)?;
        match network.head {
            Head::Tanh => {
                let estimate = forth.output.tanh()?;
                let (loss, by_estimate) = by_estimate(&estimate, &batch.difference, loss)?;
                let by_output = (by_estimate * (1.0 - estimate.sqr()?)?)?;
                self.way_back(network, (proposed, target), &forth, &by_output, 0.0)?;
                Ok(loss)
            }
            Head::Antisymmetric => {
                let back = network.one_way(target, proposed)?;
                let estimate = ((&forth.output - &back.output)? * 0.5)?;
                let (loss, by_estimate) = by_estimate(&estimate, &batch.difference, loss)?;
                let half = (by_estimate * 0.5)?;
                self.way_back(network, (proposed, target), &forth, &half, 0.0)?;
                self.way_back(network, (target, proposed), &back, &half.neg()?, 1.0)?;
                Ok(loss)
            }
        }
    }

    /// Adds what one way through the network owes to each weight, `by_output` being what its output owes, to `keep` times
    /// what is there. `a` and `b` are the observations as they entered the branches.
    fn way_back(
        &self,
        network: &TwoBranch,
        (a, b): (&Tensor, &Tensor),
        way: &OneWay,
        by_output: &Tensor,
        keep: f32,
    ) -> Result<()> {
        let by_hidden = product(by_output, &network.output.weight.t()?)?;
        by_hidden.inplace_op2(&way.hidden, &Gate)?;
        let by_both = product(&by_hidden, &network.hidden.weight.t()?)?;
        by_both.inplace_op2(&way.both, &Gate)?;
        let features = by_both.dim(1)? / 2;
        let (by_a, by_b) = (by_both.narrow(1, 0, features)?, by_both.narrow(1, features, features)?);
        let layers = [(a, &by_a), (b, &by_b), (&way.both, &by_hidden), (&way.hidden, by_output)];
        for ((entered, by_left), gradients) in layers.into_iter().zip(self.each.chunks_exact(2)) {
            product_into(&gradients[0], &entered.t()?, by_left, keep)?;
            gradients[1].inplace_op2(&by_left.sum(0)?, &Sum { keep })?;
        }
        Ok(())
    }
}

/// The loss, a mean over the batch and the parameters, and its gradient by the estimate.
fn by_estimate(estimate: &Tensor, difference: &Tensor, loss: Loss) -> Result<(f64, Tensor)> {
    let error = (estimate - difference)?;
    let count = error.elem_count() as f64;
    let (mean, gradient) = match loss {
        Loss::Squared => (candle_nn::loss::mse(estimate, difference)?, (error * (2.0 / count))?),
        Loss::Absolute => (error.abs()?.mean_all()?, (error.sign()? / count)?),
    };
    Ok((f64::from(mean.to_scalar::<f32>()?), gradient))
}

/// What a rectifier passes back: nothing where it passed nothing on, `d ← d · [y > 0]`.
struct Gate;

impl InplaceOp2 for Gate {
    fn name(&self) -> &'static str {
        "gate"
    }

    fn cpu_fwd(&self, d: &mut CpuStorage, dl: &Layout, y: &CpuStorage, yl: &Layout) -> candle_core::Result<()> {
        for (d, y) in slice_mut(d, dl)?.iter_mut().zip(slice(y, yl)?) {
            if *y <= 0.0 {
                *d = 0.0;
            }
        }
        Ok(())
    }
}

/// `sum ← keep · sum + x`.
struct Sum {
    keep: f32,
}

impl InplaceOp2 for Sum {
    fn name(&self) -> &'static str {
        "sum"
    }

    fn cpu_fwd(&self, sum: &mut CpuStorage, sl: &Layout, x: &CpuStorage, xl: &Layout) -> candle_core::Result<()> {
        for (sum, x) in slice_mut(sum, sl)?.iter_mut().zip(slice(x, xl)?) {
            *sum = self.keep * *sum + x;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use candle_core::Var;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::network::two_branch::Widths;

    const WIDTHS: Widths = Widths { inputs: 11, features: 6, hidden: 5, outputs: 2 };

    fn drawn(draw: &mut ChaCha8Rng, rows: usize, columns: usize) -> Tensor {
        let numbers: Vec<f32> = (0..rows * columns).map(|_| draw.random_range(-1.0..1.0)).collect();
        Tensor::from_vec(numbers, (rows, columns), &Device::Cpu).unwrap()
    }

    /// The loss in candle's own operations, which candle can differentiate.
    fn differentiable(weights: &[Var], head: Head, batch: &Batch, loss: Loss) -> Tensor {
        let layer = |x: &Tensor, i: usize| x.matmul(&weights[i]).unwrap().broadcast_add(&weights[i + 1]).unwrap();
        let way = |a: &Tensor, b: &Tensor| {
            let branches = [layer(a, 0).relu().unwrap(), layer(b, 2).relu().unwrap()];
            layer(&layer(&Tensor::cat(&branches, 1).unwrap(), 4).relu().unwrap(), 6)
        };
        let (p, t) = (&batch.proposed, &batch.target);
        let estimate = match head {
            Head::Tanh => way(p, t).tanh().unwrap(),
            Head::Antisymmetric => ((way(p, t) - way(t, p)).unwrap() * 0.5).unwrap(),
        };
        match loss {
            Loss::Squared => (estimate - &batch.difference).unwrap().sqr().unwrap().mean_all().unwrap(),
            Loss::Absolute => (estimate - &batch.difference).unwrap().abs().unwrap().mean_all().unwrap(),
        }
    }

    #[test]
    fn they_are_those_that_candle_finds() {
        let mut draw = ChaCha8Rng::seed_from_u64(4);
        for head in [Head::Tanh, Head::Antisymmetric] {
            let network = TwoBranch::new(WIDTHS, head, 7).unwrap();
            let weights = network.weights().map(|weight| Var::from_tensor(weight).unwrap());
            let ours = Gradients::new(&network).unwrap();
            for loss in [Loss::Squared, Loss::Absolute] {
                let batch = Batch {
                    proposed: drawn(&mut draw, 9, WIDTHS.inputs),
                    target: drawn(&mut draw, 9, WIDTHS.inputs),
                    difference: drawn(&mut draw, 9, WIDTHS.outputs),
                };
                let theirs = differentiable(&weights, head, &batch, loss);
                let found = ours.of(&network, &batch, loss).unwrap();
                assert!((found - f64::from(theirs.to_scalar::<f32>().unwrap())).abs() < 1e-6);
                let theirs = theirs.backward().unwrap();
                for ((gradient, weight), name) in ours.each().iter().zip(&weights).zip(TwoBranch::NAMES) {
                    let flat = |x: &Tensor| x.flatten_all().unwrap().to_vec1::<f32>().unwrap();
                    let (found, expected) = (flat(gradient), flat(theirs.get(weight).unwrap()));
                    // The last bias cancels between the two ways of an antisymmetric head.
                    let cancels = head == Head::Antisymmetric && name == "output.bias";
                    assert!(cancels || expected.iter().any(|g| g.abs() > 1e-3), "{name} does nothing");
                    for (found, expected) in found.iter().zip(&expected) {
                        assert!((found - expected).abs() < 1e-6, "{name}, {head:?}, {loss:?}: {found} for {expected}");
                    }
                }
            }
        }
    }
}
