//! How the loss changes with every weight.
//!
//! Written out by hand: candle's own way back also differentiates by the observations, which nobody asks for, adds every
//! gradient to a zero of its size, and wakes a thread on every core to do so. Training does this in single precision; the tests
//! hold it against candle's in double precision too.

use candle_core::{CpuStorage, DType, Device, InplaceOp2, Layout, Tensor};
use nalgebra::RealField;

use super::batches::Batch;
use super::numbers::range;
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
    Ok((mean.to_dtype(DType::F64)?.to_scalar()?, gradient))
}

/// What a rectifier passes back: nothing where it passed nothing on, `d ← d · [y > 0]`.
struct Gate;

impl InplaceOp2 for Gate {
    fn name(&self) -> &'static str {
        "gate"
    }

    fn cpu_fwd(&self, d: &mut CpuStorage, dl: &Layout, y: &CpuStorage, yl: &Layout) -> candle_core::Result<()> {
        match (d, y) {
            (CpuStorage::F32(d), CpuStorage::F32(y)) => gate(&mut d[range(dl)?], &y[range(yl)?]),
            (CpuStorage::F64(d), CpuStorage::F64(y)) => gate(&mut d[range(dl)?], &y[range(yl)?]),
            _ => candle_core::bail!("a gate for numbers of one precision, single or double"),
        }
        Ok(())
    }
}

fn gate<T: RealField + Copy>(d: &mut [T], y: &[T]) {
    for (d, y) in d.iter_mut().zip(y) {
        if *y <= T::zero() {
            *d = T::zero();
        }
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
        match (sum, x) {
            (CpuStorage::F32(sum), CpuStorage::F32(x)) => add(&mut sum[range(sl)?], &x[range(xl)?], self.keep),
            (CpuStorage::F64(sum), CpuStorage::F64(x)) => add(&mut sum[range(sl)?], &x[range(xl)?], self.keep.into()),
            _ => candle_core::bail!("a sum of numbers of one precision, single or double"),
        }
        Ok(())
    }
}

fn add<T: RealField + Copy>(sum: &mut [T], x: &[T], keep: T) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum = keep * *sum + *x;
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::network::on_device::OnDevice;
    use crate::network::optimiser::Descent;
    use crate::network::preset::Preset;
    use crate::network::two_branch::Widths;

    const WIDTHS: Widths = Widths { inputs: 11, features: 6, hidden: 5, outputs: 2 };

    fn drawn(draw: &mut ChaCha8Rng, numbers: DType, rows: usize, columns: usize) -> Tensor {
        let values: Vec<f64> = (0..rows * columns).map(|_| draw.random_range(-1.0..1.0)).collect();
        Tensor::from_vec(values, (rows, columns), &Device::Cpu).unwrap().to_dtype(numbers).unwrap()
    }

    /// Largest difference from candle's gradients, over the largest gradient of the same weight.
    fn off(network: &TwoBranch, batch: &Batch, loss: Loss) -> f64 {
        let ours = Gradients::new(network).unwrap();
        let found = ours.of(network, batch, loss).unwrap();
        let descent = Descent::new(Preset::paper().optimiser, network).unwrap();
        let theirs = OnDevice::new(network, descent, loss, &Device::Cpu).unwrap();
        let (expected, theirs) = theirs.gradients(batch).unwrap();
        let mut worst = (found / expected - 1.0).abs();
        for ((found, expected), name) in ours.each().iter().zip(&theirs).zip(TwoBranch::NAMES) {
            let numbers = |x: &Tensor| x.flatten_all().unwrap().to_dtype(DType::F64).unwrap().to_vec1::<f64>().unwrap();
            let (found, expected) = (numbers(found), numbers(expected));
            let largest = expected.iter().fold(0.0f64, |most, g| most.max(g.abs()));
            // The last bias cancels between the two ways of an antisymmetric head.
            let cancels = network.head == Head::Antisymmetric && name == "output.bias";
            assert!(cancels || largest > 1e-3, "{name} does nothing");
            let scale = if cancels { 1.0 } else { largest };
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(&expected) {
                worst = worst.max((found - expected).abs() / scale);
            }
        }
        worst
    }

    #[test]
    fn they_are_those_that_candle_finds() {
        let mut draw = ChaCha8Rng::seed_from_u64(4);
        for (numbers, tolerance) in [(DType::F32, 1e-5), (DType::F64, 1e-13)] {
            for head in [Head::Tanh, Head::Antisymmetric] {
                let network = TwoBranch::new(WIDTHS, head, 7).unwrap();
                let network = if numbers == DType::F64 { network.widened().unwrap() } else { network };
                for loss in [Loss::Squared, Loss::Absolute] {
                    // One pair alone has shapes of its own.
                    for pairs in [9, 1] {
                        let batch = Batch {
                            proposed: drawn(&mut draw, numbers, pairs, WIDTHS.inputs),
                            target: drawn(&mut draw, numbers, pairs, WIDTHS.inputs),
                            difference: drawn(&mut draw, numbers, pairs, WIDTHS.outputs),
                        };
                        let off = off(&network, &batch, loss);
                        assert!(off < tolerance, "{numbers:?}, {head:?}, {loss:?}, {pairs}: {off:.1e}");
                    }
                }
            }
        }
    }
}
