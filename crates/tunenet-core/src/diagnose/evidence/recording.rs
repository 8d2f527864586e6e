//! Prepared recording: noise, weights, priors of its nuisance parameters, and samples that count.

use std::ops::Range;

use super::ar1_prewhitening::Filter;
use crate::estimate::{channel_noise, resolution};
use crate::observation::{Kind, Observation};
use crate::simulator::{Parameter, Prepared};
use crate::statistics::{mad_sd, median, range};

/// A model that explains a channel to better than this share of its range is as good as exact; it bounds the noise of data
/// without any from below.
const PRACTICAL_SHARE: f64 = 1e-5;
/// A channel that moves less than this share of the widest stands still and says nothing.
const STILL_SHARE: f64 = 1e-7;
/// A clock whose steps stray farther than this from their median is uneven.
const UNEVEN: f64 = 0.2;

/// A recording ready to be fitted: what its simulator made of it, its noise, and the samples that count.
#[derive(Clone)]
pub struct PreparedRecording {
    /// Its position among the recordings given.
    pub(in crate::diagnose) index: usize,
    pub(in crate::diagnose) object: usize,
    /// The first recording that shows the same motion, often itself.
    pub(in crate::diagnose) motion: usize,
    pub(in crate::diagnose) held_out: bool,
    pub(in crate::diagnose) prepared: Prepared,
    /// The standard deviation of the prior of each nuisance parameter, about its guess.
    pub(in crate::diagnose) prior_sd: Vec<f64>,
    /// Standard deviation of each channel.
    pub(in crate::diagnose) noise: Vec<f64>,
    /// The same as measured, before any model discrepancy counts as noise.
    pub(in crate::diagnose) measured_noise: Vec<f64>,
    /// Residuals beyond 4 times this many robust scales count by their absolute value (Huber 1964).
    pub(in crate::diagnose) loss_scale: f64,
    /// Whether a value counts, shape `[sample · channel]`.
    pub(in crate::diagnose) keep: Vec<bool>,
    /// How many samples follow its motion, and were cut off.
    pub(in crate::diagnose) resting: usize,
    /// From plain residuals to white ones in units of the noise.
    pub(in crate::diagnose) filter: Filter,
    /// When events are seen, s.
    pub(in crate::diagnose) events: Vec<f64>,
    /// Whether channels that stand still weigh, too.
    pub(in crate::diagnose) held_still: bool,
    /// How many of its last nuisance parameters are draws of a random effect, two to each event.
    pub(in crate::diagnose) random_draws: usize,
    /// Of which of its simulator's parameters its last nuisance parameter is a deviation.
    pub(in crate::diagnose) random_parameter: Option<usize>,
}

/// What a [strategy](crate::diagnose::Strategy) sees of a recording, and what it makes of it.
impl PreparedRecording {
    /// Its position among the recordings given.
    #[must_use]
    pub fn recording(&self) -> usize {
        self.index
    }

    /// The position of its object among the subjects.
    #[must_use]
    pub fn object(&self) -> usize {
        self.object
    }

    /// Whether it is only to judge by, not to fit to.
    #[must_use]
    pub fn held_out(&self) -> bool {
        self.held_out
    }

    /// What its simulator made of it.
    #[must_use]
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// When events are seen, in s on the clock of the recording; empty where its simulator knows none.
    #[must_use]
    pub fn events(&self) -> &[f64] {
        &self.events
    }

    /// Another preparation of the same recording: a part of it, or what it would have been otherwise. It belongs to the same
    /// object and motion, and is held out where this one is; noise and events are those of `prepared`.
    #[must_use]
    pub fn remade(&self, prepared: Prepared) -> Self {
        Self { motion: self.motion, ..Self::new(self.index, self.object, self.held_out, prepared) }
    }

    /// The same with these instants of its events, s.
    #[must_use]
    pub fn with_events(self, events: Vec<f64>) -> Self {
        Self { events, ..self }
    }

    /// The same with this white noise: the standard deviation of each channel in its unit, where it is greater than 0.
    #[must_use]
    pub fn with_noise(mut self, noise: &[f64]) -> Self {
        for (sd, known) in self.noise.iter_mut().zip(noise) {
            *sd = if *known > 0.0 { *known } else { *sd };
        }
        self.measured_noise.clone_from(&self.noise);
        self.prewhiten(0.0);
        self
    }
}

impl PreparedRecording {
    pub(in crate::diagnose) fn new(index: usize, object: usize, held_out: bool, mut prepared: Prepared) -> Self {
        let segmentation = prepared.segmentation.clone();
        let all = prepared.seen.len();
        if let Some(known) = &segmentation
            && let Ok(moving) = prepared.seen.slice(0..known.moving(&prepared.seen, &noise(&prepared.seen)))
        {
            prepared.seen = moving;
        }
        let seen = &prepared.seen;
        let resting = all - seen.len();
        let width = seen.channels().len();
        let ranges: Vec<f64> = (0..width).map(|c| range(seen.column(c))).collect();
        let widest = ranges.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let known = prepared.noise.clone().filter(|_| prepared.driven() || prepared.discrepancy);
        let noise: Vec<f64> =
            known.unwrap_or_else(|| noise(seen)).iter().map(|sd| sd.max(PRACTICAL_SHARE * widest)).collect();
        let keep: Vec<bool> =
            (0..seen.values().len()).map(|i| ranges[i % width] > STILL_SHARE * widest || width == 1).collect();
        let events = segmentation.map_or_else(Vec::new, |known| known.events(seen));
        let filter = Filter::new(seen.clock(), &noise, &keep, 0.0);
        let prior_sd = (0..prepared.nuisances.len()).map(|i| prepared.prior_sd(i)).collect();
        Self {
            index,
            object,
            motion: index,
            held_out,
            prepared,
            prior_sd,
            measured_noise: noise.clone(),
            noise,
            keep,
            resting,
            filter,
            events,
            held_still: false,
            loss_scale: 1.0,
            random_draws: 0,
            random_parameter: None,
        }
    }

    /// A piece of this recording as one of its own, with what is known of its noise.
    pub(in crate::diagnose) fn piece(&self, range: Range<usize>, prepared: Prepared) -> Self {
        let width = self.width();
        let keep = self.keep[range.start * width..range.end * width].to_vec();
        let filter = Filter::new(prepared.seen.clock(), &self.noise, &keep, 0.0);
        let prior_sd = (0..prepared.nuisances.len()).map(|i| prepared.prior_sd(i)).collect();
        let (noise, measured_noise) = (self.noise.clone(), self.measured_noise.clone());
        let mut piece =
            Self { prepared, prior_sd, noise, measured_noise, keep, resting: 0, filter, events: Vec::new(), ..*self };
        piece.hold_still();
        piece
    }

    /// Lets channels that stand still speak against whatever would move them; as they do not vary, their values are no
    /// evidence for anything else, and do not count.
    pub(in crate::diagnose) fn hold_still(&mut self) {
        self.held_still = true;
        self.prewhiten(0.0);
    }

    /// Which values weigh.
    fn weighed(&self) -> Vec<bool> {
        let width = self.width();
        let still = |c: usize| self.held_still && !(c..self.keep.len()).step_by(width).any(|i| self.keep[i]);
        let still: Vec<bool> = (0..width).map(still).collect();
        self.keep.iter().enumerate().map(|(i, keep)| *keep || still[i % width]).collect()
    }

    /// Adds its own deviation to `parameters`, within their bounds; the rest of `nuisances` is the simulator's.
    pub(in crate::diagnose) fn with_deviation<'b>(
        &self,
        parameters: &mut [f64],
        bounds: &[Parameter],
        nuisances: &'b [f64],
    ) -> &'b [f64] {
        match (self.random_parameter, nuisances) {
            (Some(position), [others @ .., deviation]) => {
                let Parameter { min, max, .. } = bounds[position];
                parameters[position] = (parameters[position] + deviation).clamp(min, max);
                others
            }
            _ => nuisances,
        }
    }

    pub(in crate::diagnose) fn width(&self) -> usize {
        self.noise.len()
    }

    /// What plain residuals of each channel are divided by before they are put together: 1 where all have one unit, else the noise as
    /// measured.
    pub(in crate::diagnose) fn yardsticks(&self) -> Vec<f64> {
        if self.prepared.seen.common_unit().is_some() { vec![1.0; self.width()] } else { self.measured_noise.clone() }
    }

    /// How many values are one sample of a root mean square: those of all measured channels as one distance where they have one unit.
    pub(in crate::diagnose) fn values_per_sample(&self) -> f64 {
        let measured = self.width() - self.unmeasured().len();
        if self.prepared.seen.common_unit().is_some() { measured.max(1) as f64 } else { 1.0 }
    }

    pub(in crate::diagnose) fn clock(&self) -> &[f64] {
        self.prepared.seen.clock()
    }

    /// Whether it is [driven](Prepared::driven).
    pub(in crate::diagnose) fn driven(&self) -> bool {
        self.prepared.driven()
    }

    /// How many samples have an outlier; a channel that does not count at all has none.
    pub(in crate::diagnose) fn outliers(&self) -> usize {
        let width = self.width();
        let counts: Vec<bool> = (0..width).map(|c| (c..self.keep.len()).step_by(width).any(|i| self.keep[i])).collect();
        self.keep.chunks(width).filter(|row| row.iter().zip(&counts).any(|(keep, counts)| *counts && !keep)).count()
    }

    /// How many values count.
    pub(in crate::diagnose) fn count(&self) -> usize {
        self.keep.iter().filter(|keep| **keep).count()
    }

    /// Takes this lag-one correlation of the noise for given.
    pub(in crate::diagnose) fn prewhiten(&mut self, rho: f64) {
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
    if seen.kind() == Kind::EventTimes || !uneven || seen.len() < 8 {
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
    let least = |c: usize| resolution(seen.kind(), &seen.column(c).collect::<Vec<f64>>());
    let allowed = |c: usize| Some(spread(c)).filter(|sd| *sd > 0.0).map(|sd| sd.min(plain[c]).max(least(c)));
    (0..plain.len()).map(|c| allowed(c).unwrap_or(plain[c])).collect()
}
