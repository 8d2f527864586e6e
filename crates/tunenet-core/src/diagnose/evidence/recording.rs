//! Prepared recording: noise, weights, priors of its nuisance parameters, and samples that count.

use std::ops::Range;

use super::ar1_prewhitening::Filter;
use crate::estimate::channel_noise;
use crate::observation::{Kind, Observation};
use crate::simulator::{Parameter, Prepared};
use crate::statistics::{mad_sd, median};

/// A model that explains a channel to better than this share of its range is as good as exact; it bounds the noise of data
/// without any from below.
const PRACTICAL_SHARE: f64 = 1e-5;
/// A channel that moves less than this share of the widest stands still and says nothing.
const STILL_SHARE: f64 = 1e-7;
/// A clock whose steps stray farther than this from their median is uneven.
const UNEVEN: f64 = 0.2;

/// One recording, ready.
#[derive(Clone)]
pub(in crate::diagnose) struct Set {
    /// Its position among the recordings given.
    pub recording: usize,
    pub object: usize,
    /// The first recording that shows the same throw, often itself.
    pub throw: usize,
    pub held_out: bool,
    pub prepared: Prepared,
    /// How strongly each nuisance parameter is drawn to its guess: a standard deviation.
    pub pull: Vec<f64>,
    /// Standard deviation of each channel.
    pub noise: Vec<f64>,
    /// Whether a value counts, shape `[sample · channel]`.
    pub keep: Vec<bool>,
    /// From plain residuals to white ones in units of the noise.
    pub filter: Filter,
    /// When contacts are seen, s.
    pub contacts: Vec<f64>,
    /// Whether channels that stand still weigh, too.
    pub held_still: bool,
}

impl Set {
    pub fn new(recording: usize, object: usize, held_out: bool, mut prepared: Prepared) -> Self {
        let segmentation = prepared.segmentation.clone();
        if let Some(known) = &segmentation
            && let Ok(moving) = prepared.seen.slice(0..known.moving(&prepared.seen, &noise(&prepared.seen)))
        {
            prepared.seen = moving;
        }
        let seen = &prepared.seen;
        let width = seen.channels().len();
        let ranges: Vec<f64> = (0..width).map(|c| range(seen.column(c))).collect();
        let widest = ranges.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let noise: Vec<f64> = noise(seen).iter().map(|sd| sd.max(PRACTICAL_SHARE * widest)).collect();
        let keep: Vec<bool> =
            (0..seen.values().len()).map(|i| ranges[i % width] > STILL_SHARE * widest || width == 1).collect();
        let contacts = segmentation.map_or_else(Vec::new, |known| known.events(seen));
        let filter = Filter::new(seen.clock(), &noise, &keep, 0.0);
        let pull = prepared.nuisances.iter().map(Parameter::span).collect();
        Self {
            recording,
            object,
            throw: recording,
            held_out,
            prepared,
            pull,
            noise,
            keep,
            filter,
            contacts,
            held_still: false,
        }
    }

    /// A piece of this recording as one of its own, with what is known of its noise.
    pub fn piece(&self, range: Range<usize>, prepared: Prepared) -> Self {
        let width = self.width();
        let keep = self.keep[range.start * width..range.end * width].to_vec();
        let filter = Filter::new(prepared.seen.clock(), &self.noise, &keep, 0.0);
        let pull = prepared.nuisances.iter().map(Parameter::span).collect();
        let (noise, contacts) = (self.noise.clone(), Vec::new());
        let mut piece = Self { prepared, pull, noise, keep, filter, contacts, ..*self };
        piece.hold_still();
        piece
    }

    /// Lets channels that stand still speak against whatever would move them; as they do not vary, their values are no
    /// evidence for anything else, and do not count.
    pub fn hold_still(&mut self) {
        self.held_still = true;
        self.colour(0.0);
    }

    /// Which values weigh.
    fn weighed(&self) -> Vec<bool> {
        let width = self.width();
        let still = |c: usize| self.held_still && !(c..self.keep.len()).step_by(width).any(|i| self.keep[i]);
        let still: Vec<bool> = (0..width).map(still).collect();
        self.keep.iter().enumerate().map(|(i, keep)| *keep || still[i % width]).collect()
    }

    pub fn width(&self) -> usize {
        self.noise.len()
    }

    pub fn clock(&self) -> &[f64] {
        self.prepared.seen.clock()
    }

    /// How many values count.
    pub fn count(&self) -> usize {
        self.keep.iter().filter(|keep| **keep).count()
    }

    /// Takes this lag-one correlation of the noise for given.
    pub fn colour(&mut self, rho: f64) {
        self.filter = Filter::new(self.prepared.seen.clock(), &self.noise, &self.weighed(), rho);
    }
}

/// Noise of each channel. Third differences that allow for an uneven clock: weights that cancel any quadratic, of unit norm.
fn noise(seen: &Observation) -> Vec<f64> {
    let plain = channel_noise(seen);
    let clock = seen.clock();
    let steps: Vec<f64> = clock.windows(2).map(|w| w[1] - w[0]).collect();
    let usual = median(steps.iter().copied()).unwrap_or(0.0);
    let uneven = steps.iter().any(|step| (step / usual - 1.0).abs() > UNEVEN);
    if seen.kind() == Kind::BounceTimes || !uneven || seen.len() < 8 {
        return plain;
    }
    let spread = |channel: usize| {
        let values: Vec<f64> = seen.column(channel).collect();
        let differences = clock.windows(4).zip(values.windows(4)).map(|(t, v)| {
            let weight = |j: usize| (0..4).filter(|&k| k != j).map(|k| usual / (t[j] - t[k])).product::<f64>();
            let weights = [0, 1, 2, 3].map(weight);
            let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
            weights.iter().zip(v).map(|(w, v)| w * v).sum::<f64>() / norm
        });
        mad_sd(differences)
    };
    // A channel on a coarse grid may show no differences at all; then what the even clock would give stands.
    (0..plain.len()).map(|c| Some(spread(c)).filter(|sd| *sd > 0.0).map_or(plain[c], |sd| sd.min(plain[c]))).collect()
}

fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    high - low
}
