//! The two-branch perceptron of `TuneNet` (arXiv 1907.11200, appendix): a forward pass and its weights.

use candle_core::{DType, Device, Tensor, Var};
use candle_nn::{Activation, Module};
use rand::Rng;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::preset::Head;
use super::product::{Left, product};
use crate::Result;

/// How many numbers go in, through and out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Widths {
    /// Numbers entering each branch.
    pub inputs: usize,
    /// Numbers leaving each branch.
    pub features: usize,
    /// Numbers in the layer behind both branches.
    pub hidden: usize,
    /// Tuned parameters.
    pub outputs: usize,
}

/// `y = x w + b` with `w` of shape `[in, out]` and `b` of shape `[out]`.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    pub(super) weight: Tensor,
    pub(super) bias: Tensor,
}

/// The paper's estimator (arXiv 1907.11200, appendix): the proposed model's and the target's observation each pass one layer
/// of their own; what comes out, side by side, passes a hidden layer and becomes the parameter difference
/// target − proposed, in units of each parameter's training span.
///
/// Field names are weight names: `proposed.weight` `[inputs, features]`, `proposed.bias` `[features]`, `target.*` alike,
/// `hidden.weight` `[2 features, hidden]`, `output.weight` `[hidden, outputs]`.
#[derive(Debug, Clone)]
pub(super) struct TwoBranch {
    pub(super) proposed: Linear,
    pub(super) target: Linear,
    pub(super) hidden: Linear,
    pub(super) output: Linear,
    pub(super) head: Head,
}

impl TwoBranch {
    /// Fresh weights, uniform in `±1/√in`, the default of the library that the paper used. candle's own generator
    /// cannot be seeded on a CPU, so the draws come from `ChaCha8`.
    pub(super) fn new(widths: Widths, head: Head, seed: u64) -> Result<Self> {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let mut linear = |inputs: usize, outputs: usize| -> Result<Linear> {
            let bound = 1.0 / (inputs as f32).sqrt();
            let mut uniform = |n: usize| (0..n).map(|_| draw.random_range(-bound..bound)).collect::<Vec<f32>>();
            Ok(Linear {
                weight: Tensor::from_vec(uniform(inputs * outputs), (inputs, outputs), &Device::Cpu)?,
                bias: Tensor::from_vec(uniform(outputs), outputs, &Device::Cpu)?,
            })
        };
        Ok(Self {
            proposed: linear(widths.inputs, widths.features)?,
            target: linear(widths.inputs, widths.features)?,
            hidden: linear(2 * widths.features, widths.hidden)?,
            output: linear(widths.hidden, widths.outputs)?,
            head,
        })
    }

    /// The names of the weights, in the order of [`TwoBranch::weights`].
    pub(super) const NAMES: [&'static str; 8] = [
        "proposed.weight",
        "proposed.bias",
        "target.weight",
        "target.bias",
        "hidden.weight",
        "hidden.bias",
        "output.weight",
        "output.bias",
    ];

    /// All weights.
    pub(super) fn weights(&self) -> [&Tensor; 8] {
        let (p, t, h, o) = (&self.proposed, &self.target, &self.hidden, &self.output);
        [&p.weight, &p.bias, &t.weight, &t.bias, &h.weight, &h.bias, &o.weight, &o.bias]
    }

    /// A network from its weights, in the order of [`TwoBranch::NAMES`].
    pub(super) fn from_weights(weights: [Tensor; 8], head: Head) -> Self {
        let [pw, pb, tw, tb, hw, hb, ow, ob] = weights;
        Self {
            proposed: Linear { weight: pw, bias: pb },
            target: Linear { weight: tw, bias: tb },
            hidden: Linear { weight: hw, bias: hb },
            output: Linear { weight: ow, bias: ob },
            head,
        }
    }

    /// The shape that each weight must have, in the order of [`TwoBranch::NAMES`].
    pub(super) fn shapes(widths: Widths) -> [Vec<usize>; 8] {
        let Widths { inputs, features, hidden, outputs } = widths;
        [
            vec![inputs, features],
            vec![features],
            vec![inputs, features],
            vec![features],
            vec![2 * features, hidden],
            vec![hidden],
            vec![hidden, outputs],
            vec![outputs],
        ]
    }

    /// The same network in double precision, for inference: training in single precision is exact enough, but the last
    /// updates of an iteration are smaller than single precision can distinguish.
    pub(super) fn widened(&self) -> Result<Self> {
        self.each(|weight| weight.detach().to_dtype(DType::F64))
    }

    /// The same weights on `device`, for inference.
    pub(super) fn detached(&self, device: &Device) -> Result<Self> {
        self.each(|weight| weight.detach().to_device(device))
    }

    /// A copy on `device` whose weights are variables, which gradients are taken by and steps change.
    pub(super) fn trainable(&self, device: &Device) -> Result<(Self, [Var; 8])> {
        let mut variables = Vec::with_capacity(8);
        for weight in self.weights() {
            variables.push(Var::from_tensor(&weight.to_device(device)?)?);
        }
        let Ok(variables) = <[Var; 8]>::try_from(variables) else { unreachable!("eight in, eight out") };
        Ok((Self::from_weights(variables.each_ref().map(|v| v.as_tensor().clone()), self.head), variables))
    }

    fn each(&self, made: impl Fn(&Tensor) -> candle_core::Result<Tensor>) -> Result<Self> {
        let mut weights = Vec::with_capacity(8);
        for weight in self.weights() {
            weights.push(made(weight)?);
        }
        let Ok(weights) = <[Tensor; 8]>::try_from(weights) else { unreachable!("eight in, eight out") };
        Ok(Self::from_weights(weights, self.head))
    }

    /// The estimated difference target − proposed in units of the training span, shape `[batch, outputs]`, from both
    /// observations, each `[batch, inputs]`.
    pub(super) fn forward(&self, proposed: &Tensor, target: &Tensor) -> Result<Tensor> {
        match self.head {
            Head::Tanh => Ok(self.one_way(proposed, target)?.tanh()?),
            // Two equal inputs take the same path twice and cancel to the last bit.
            Head::Antisymmetric => Ok(((self.one_way(proposed, target)? - self.one_way(target, proposed)?)? * 0.5)?),
        }
    }

    /// `h(a, b)`.
    fn one_way(&self, a: &Tensor, b: &Tensor) -> candle_core::Result<Tensor> {
        let rectified = |layer: candle_core::Result<Tensor>| layer.and_then(|values| Activation::Relu.forward(&values));
        let branches = [rectified(self.proposed.pass(a, Left::Data))?, rectified(self.target.pass(b, Left::Data))?];
        let hidden = rectified(self.hidden.pass(&Tensor::cat(&branches, 1)?, Left::Features))?;
        self.output.pass(&hidden, Left::Features)
    }
}

impl Linear {
    fn pass(&self, entering: &Tensor, left: Left) -> candle_core::Result<Tensor> {
        product(entering, &self.weight, left)?.broadcast_add(&self.bias)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTHS: Widths = Widths { inputs: 7, features: 4, hidden: 3, outputs: 2 };

    fn seen(seed: u64) -> Tensor {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let values: Vec<f32> = (0..21).map(|_| draw.random_range(-1.0..1.0)).collect();
        Tensor::from_vec(values, (3, 7), &Device::Cpu).unwrap()
    }

    #[test]
    fn same_seed_same_weights_within_the_bound() {
        let [one, two] = [0, 0].map(|seed| TwoBranch::new(WIDTHS, Head::Tanh, seed).unwrap());
        for ((a, b), shape) in one.weights().iter().zip(two.weights()).zip(TwoBranch::shapes(WIDTHS)) {
            assert_eq!(a.dims(), shape);
            let (a, b) = (a.flatten_all().unwrap().to_vec1::<f32>().unwrap(), b.flatten_all().unwrap());
            assert_eq!(a, b.to_vec1::<f32>().unwrap());
        }
        let first = one.proposed.weight.flatten_all().unwrap().to_vec1::<f32>().unwrap();
        assert!(first.iter().all(|w| w.abs() <= 1.0 / 7f32.sqrt()));
    }

    #[test]
    fn antisymmetric_is_zero_at_equality_and_flips_its_sign() {
        let network = TwoBranch::new(WIDTHS, Head::Antisymmetric, 3).unwrap();
        let zero = network.forward(&seen(1), &seen(1)).unwrap().to_vec2::<f32>().unwrap();
        assert_eq!(zero, vec![vec![0.0; 2]; 3]);
        let forth = network.forward(&seen(1), &seen(2)).unwrap();
        let back = network.forward(&seen(2), &seen(1)).unwrap().neg().unwrap();
        assert_eq!(forth.to_vec2::<f32>().unwrap(), back.to_vec2::<f32>().unwrap());
        assert!(forth.to_vec2::<f32>().unwrap()[0][0].abs() > 0.0);
    }

    #[test]
    fn another_width_is_refused() {
        let network = TwoBranch::new(Widths { inputs: 8, ..WIDTHS }, Head::Tanh, 5).unwrap();
        assert!(network.forward(&seen(1), &seen(2)).is_err());
    }
}
