//! Minibatches: the pairs of each step, shuffled by epochs or drawn afresh with noise and cuts (data augmentation).

use std::ops::Range;

use candle_core::{Device, Tensor};
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::preset::{Course, Preset};
use super::rows::Rollout;
use super::training_set::{self, TrainingSet};
use crate::Result;

/// Validation pairs that pass the network together.
const VALIDATION_BATCH: usize = 1024;

/// Proposed `[batch, width]`, target `[batch, width]` and difference `[batch, parameter]`.
pub(super) struct Batch {
    pub(super) proposed: Tensor,
    pub(super) target: Tensor,
    pub(super) difference: Tensor,
}

/// Draws batches. Each depends on the seed and the step alone, so that a resumed training sees what it would have seen.
pub(super) struct Batches<'a> {
    set: &'a TrainingSet<'a>,
    preset: &'a Preset,
    seed: u64,
    /// Pairs that are trained on; those behind them are held back.
    pairs: usize,
    /// Of a training in epochs: the present one, and the order of its pairs.
    epoch: Option<(u64, Vec<u32>)>,
}

impl<'a> Batches<'a> {
    pub(super) fn new(set: &'a TrainingSet<'a>, preset: &'a Preset, seed: u64) -> Self {
        let held_back = (set.pairs() as f64 * preset.held_back).floor();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most half the pairs")]
        let pairs = set.pairs() - held_back as usize;
        let epoch = match preset.course {
            Course::Epochs { .. } => Some((u64::MAX, Vec::new())),
            Course::Remixed { .. } => None,
        };
        Self { set, preset, seed, pairs, epoch }
    }

    /// Steps in an epoch: batches that show every pair once.
    pub(super) fn in_epoch(&self) -> u64 {
        self.pairs.div_ceil(self.preset.batch) as u64
    }

    /// Steps in the whole training.
    pub(super) fn steps(&self) -> u64 {
        match self.preset.course {
            Course::Epochs { epochs } => epochs * self.in_epoch(),
            Course::Remixed { steps, .. } => steps,
        }
    }

    /// The validation pairs in blocks, so that memory does not depend on their number.
    pub(super) fn held_back(&self) -> impl Iterator<Item = Result<Batch>> + '_ {
        let (first, end) = (self.pairs, self.set.pairs());
        let block = move |start: usize| plain(self.set, start..(start + VALIDATION_BATCH).min(end));
        (first..end).step_by(VALIDATION_BATCH).map(block)
    }

    /// The pairs of step `step`, from 0.
    pub(super) fn draw(&mut self, step: u64) -> Result<Batch> {
        let in_epoch = self.in_epoch();
        let Some((epoch, order)) = &mut self.epoch else { return self.mix(step) };
        if *epoch != step / in_epoch {
            *epoch = step / in_epoch;
            *order = (0..).take(self.pairs).collect();
            order.shuffle(&mut stream(self.seed, *epoch));
        }
        #[expect(clippy::cast_possible_truncation, reason = "below the number of pairs")]
        let first = (step % in_epoch) as usize * self.preset.batch;
        let chosen = &order[first..(first + self.preset.batch).min(order.len())];
        plain(self.set, chosen.iter().map(|pair| *pair as usize))
    }

    fn mix(&self, step: u64) -> Result<Batch> {
        let (noise, cut) = match self.preset.course {
            Course::Remixed { noise, cut, .. } => (super::numbers::single(noise), cut),
            Course::Epochs { .. } => (0.0, 0.0),
        };
        let mut draw = stream(self.seed, step);
        let mut build = Builder::new(self.set, self.preset.batch);
        for _ in 0..self.preset.batch {
            let (a, b) = if self.set.mixable {
                (draw.random_range(0..2 * self.pairs), draw.random_range(0..2 * self.pairs))
            } else {
                let pair = 2 * draw.random_range(0..self.pairs);
                if draw.random() { (pair, pair + 1) } else { (pair + 1, pair) }
            };
            build.read(a, b)?;
            let mut seen = build.common();
            if cut > 0.0 && draw.random_bool(cut) {
                seen.end = seen.start + draw.random_range(0..=seen.len());
            }
            build.push(&seen);
            let share: f32 = draw.random();
            let sd = noise * share * share;
            if sd > 0.0 {
                for value in build.last_target(&seen) {
                    *value += sd * draw.sample::<f32, _>(StandardNormal);
                }
            }
        }
        build.batch()
    }
}

/// Streams 1, 2, … of the seed; the initial weights took stream 0.
fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    draw.set_stream(number + 1);
    draw
}

/// The dataset's own pairs, as they are.
fn plain(set: &TrainingSet<'_>, pairs: impl ExactSizeIterator<Item = usize>) -> Result<Batch> {
    let mut build = Builder::new(set, pairs.len());
    for pair in pairs {
        build.read(2 * pair, 2 * pair + 1)?;
        build.push(&build.common());
    }
    build.batch()
}

struct Builder<'a> {
    set: &'a TrainingSet<'a>,
    /// The two rollouts that were read last.
    read: [Rollout; 2],
    proposed: Vec<f32>,
    target: Vec<f32>,
    difference: Vec<f32>,
}

impl<'a> Builder<'a> {
    fn new(set: &'a TrainingSet<'a>, pairs: usize) -> Self {
        let width = set.input.width();
        Self {
            set,
            read: Default::default(),
            proposed: Vec::with_capacity(pairs * width),
            target: Vec::with_capacity(pairs * width),
            difference: Vec::with_capacity(pairs * set.parameters.len()),
        }
    }

    /// Takes up two rollouts.
    fn read(&mut self, a: usize, b: usize) -> Result<()> {
        let [one, two] = &mut self.read;
        self.set.rollouts.read(a, one)?;
        self.set.rollouts.read(b, two)
    }

    /// What both that were read cover.
    fn common(&self) -> Range<usize> {
        training_set::common(&self.read[0], &self.read[1])
    }

    /// Appends them as a pair, blank in both outside `seen`; see [`Encoded::pair`](super::input::Encoded::pair).
    fn push(&mut self, seen: &Range<usize>) {
        let [a, b] = &self.read;
        for (side, Rollout { row, .. }) in [(&mut self.proposed, a), (&mut self.target, b)] {
            let start = side.len();
            side.resize(start + row.len(), 0.0);
            side[start + seen.start..start + seen.end].copy_from_slice(&row[seen.clone()]);
        }
        self.difference.extend(b.normalised.iter().zip(&a.normalised).map(|(b, a)| super::numbers::single(b - a)));
    }

    /// The target of the last pair within `seen`.
    fn last_target(&mut self, seen: &Range<usize>) -> &mut [f32] {
        let start = self.target.len() - self.set.input.width();
        &mut self.target[start + seen.start..start + seen.end]
    }

    fn batch(self) -> Result<Batch> {
        let width = self.set.input.width();
        let pairs = self.proposed.len() / width;
        Ok(Batch {
            proposed: Tensor::from_vec(self.proposed, (pairs, width), &Device::Cpu)?,
            target: Tensor::from_vec(self.target, (pairs, width), &Device::Cpu)?,
            difference: Tensor::from_vec(self.difference, (pairs, self.set.parameters.len()), &Device::Cpu)?,
        })
    }
}
