//! Direct prediction: a network with one branch that sees the target alone, two hidden layers of 32 as in the paper's
//! two-branch one, and is asked once.

use anyhow::{Context, Result, ensure};
use candle_core::{DType, Device, Tensor, Var};
use candle_nn::{AdamW, Optimizer, ParamsAdamW};
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const HIDDEN: usize = 32;
const BATCH: usize = 50;
const RATE: f64 = 1e-3;

/// One thing to learn from: what was seen, and the parameter behind it.
pub struct Example {
    pub seen: Vec<f64>,
    pub parameter: f64,
}

/// A trained network, with the scales that it was trained at.
pub struct Direct {
    layers: Vec<(Tensor, Tensor)>,
    seen: (f64, f64),
    parameter: (f64, f64),
}

impl Direct {
    /// Learns from `examples`, all of one length. The same seed gives the same network.
    pub fn train(examples: &[Example], epochs: usize, seed: u64) -> Result<Self> {
        let width = examples.first().context("nothing to learn from")?.seen.len();
        ensure!(examples.iter().all(|e| e.seen.len() == width), "examples of different lengths");
        let seen = range(examples.iter().flat_map(|e| e.seen.iter().copied()));
        let parameter = range(examples.iter().map(|e| e.parameter));
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let variables = [(HIDDEN, width), (HIDDEN, HIDDEN), (1, HIDDEN)]
            .iter()
            .map(|(out, into)| layer(*out, *into, &mut random))
            .collect::<Result<Vec<_>>>()?;
        let layers: Vec<(Tensor, Tensor)> =
            variables.iter().map(|(w, b)| (w.as_tensor().clone(), b.as_tensor().clone())).collect();
        let all: Vec<Var> = variables.into_iter().flat_map(|(w, b)| [w, b]).collect();
        let mut optimiser = AdamW::new(all, ParamsAdamW { lr: RATE, weight_decay: 0.0, ..ParamsAdamW::default() })?;
        let network = Self { layers, seen, parameter };
        let mut order: Vec<usize> = (0..examples.len()).collect();
        for epoch in 0..epochs {
            // Down to nothing along a cosine, so that the last epochs only settle.
            optimiser
                .set_learning_rate(0.5 * RATE * (1.0 + (std::f64::consts::PI * epoch as f64 / epochs as f64).cos()));
            order.shuffle(&mut random);
            for batch in order.chunks(BATCH) {
                let rows: Vec<f32> = batch.iter().flat_map(|i| network.scaled(&examples[*i].seen)).collect();
                let wanted: Vec<f32> = batch.iter().map(|i| unit(examples[*i].parameter, parameter)).collect();
                let rows = Tensor::from_vec(rows, (batch.len(), width), &Device::Cpu)?;
                let wanted = Tensor::from_vec(wanted, (batch.len(), 1), &Device::Cpu)?;
                let loss = (network.forward(&rows)? - wanted)?.sqr()?.mean_all()?;
                optimiser.backward_step(&loss)?;
            }
        }
        Ok(network)
    }

    /// The parameter behind `seen`.
    pub fn estimate(&self, seen: &[f64]) -> Result<f64> {
        let row = Tensor::from_vec(self.scaled(seen), (1, seen.len()), &Device::Cpu)?;
        let out = f64::from(self.forward(&row)?.to_vec2::<f32>()?[0][0]);
        let (low, high) = self.parameter;
        Ok(low + (high - low) * out)
    }

    fn forward(&self, rows: &Tensor) -> candle_core::Result<Tensor> {
        let mut x = rows.clone();
        for (i, (weight, bias)) in self.layers.iter().enumerate() {
            x = x.matmul(&weight.t()?)?.broadcast_add(bias)?;
            if i + 1 < self.layers.len() {
                x = x.relu()?;
            }
        }
        Ok(x)
    }

    fn scaled(&self, seen: &[f64]) -> Vec<f32> {
        seen.iter().map(|v| unit(*v, self.seen)).collect()
    }
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// `range` brought to 0 and 1.
#[expect(clippy::cast_possible_truncation, reason = "networks compute in single precision")]
fn unit(value: f64, (low, high): (f64, f64)) -> f32 {
    ((value - low) / (high - low).max(f64::MIN_POSITIVE)) as f32
}

/// Weights and offsets, uniform within one over the root of the inputs.
fn layer(out: usize, into: usize, random: &mut ChaCha8Rng) -> Result<(Var, Var)> {
    #[expect(clippy::cast_precision_loss, reason = "a few hundred inputs")]
    let bound = (into as f32).sqrt().recip();
    let mut draw = |n: usize| -> Vec<f32> { (0..n).map(|_| random.random_range(-bound..=bound)).collect() };
    let weight = Tensor::from_vec(draw(out * into), (out, into), &Device::Cpu)?.to_dtype(DType::F32)?;
    let bias = Tensor::from_vec(draw(out), out, &Device::Cpu)?;
    Ok((Var::from_tensor(&weight)?, Var::from_tensor(&bias)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_learns_a_slope_and_its_seed_decides() {
        let line = |slope: f64| -> Vec<f64> { (0..8).map(|i| slope * f64::from(i)).collect() };
        let example = |i: u32| {
            let parameter = f64::from(i) / 100.0;
            Example { seen: line(parameter), parameter }
        };
        let examples: Vec<Example> = (0..=100).map(example).collect();
        let [one, two, other] = [1, 1, 2].map(|seed| Direct::train(&examples, 300, seed).unwrap());
        let found = one.estimate(&line(0.345)).unwrap();
        assert!((found - 0.345).abs() < 0.01, "{found}");
        assert_eq!(found.to_bits(), two.estimate(&line(0.345)).unwrap().to_bits());
        assert_ne!(found.to_bits(), other.estimate(&line(0.345)).unwrap().to_bits());
    }
}
