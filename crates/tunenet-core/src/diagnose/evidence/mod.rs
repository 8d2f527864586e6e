//! The evidence: prepared recordings and a model of their noise. A value: a step that learns more makes another.

pub(in crate::diagnose) mod ar1_correlation;
pub(in crate::diagnose) mod ar1_prewhitening;
pub(in crate::diagnose) mod copies;
pub(in crate::diagnose) mod outliers;
pub(in crate::diagnose) mod proposed;
pub(in crate::diagnose) mod recording;
pub(in crate::diagnose) mod sample;
pub(in crate::diagnose) mod segment_noise;
pub(in crate::diagnose) mod segments;
pub(in crate::diagnose) mod unmeasured;
pub(in crate::diagnose) mod validation_split;

use recording::PreparedRecording;

/// How the residuals of the true model are distributed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::diagnose) enum NoiseModel {
    /// Independent from sample to sample.
    White,
    /// First-order autoregressive, with this correlation of neighbours; residuals are prewhitened.
    Ar1 {
        /// The lag-1 correlation.
        rho: f64,
    },
    /// Model discrepancy is treated as noise: each channel's variance is inflated to that of the residual.
    Inflated {
        /// The share of the values that counts as independent.
        effective_fraction: f64,
    },
}

impl NoiseModel {
    /// The lag-1 correlation that is taken out of residuals.
    pub fn lag1(self) -> f64 {
        match self {
            Self::Ar1 { rho } => rho,
            Self::White | Self::Inflated { .. } => 0.0,
        }
    }

    /// The share of the values that counts as independent once residuals are white.
    pub fn effective_fraction(self) -> f64 {
        match self {
            Self::Inflated { effective_fraction } => effective_fraction,
            Self::White | Self::Ar1 { .. } => 1.0,
        }
    }
}

/// Recordings to fit, recordings to judge by, and the noise of both.
#[derive(Clone)]
pub(in crate::diagnose) struct Evidence {
    /// The recordings that are fitted.
    pub training: Vec<PreparedRecording>,
    /// The recordings that are held out to judge by.
    pub validation: Vec<PreparedRecording>,
    pub noise: NoiseModel,
}

impl Evidence {
    /// Splits prepared recordings into those to fit and those held out, their noise taken for white.
    pub fn new(recordings: Vec<PreparedRecording>) -> Self {
        let (validation, training) = recordings.into_iter().partition(|r| r.held_out);
        Self { training, validation, noise: NoiseModel::White }
    }

    /// The same with residuals prewhitened by this lag-1 correlation; 0 is white noise.
    pub fn prewhitened(mut self, rho: f64) -> Self {
        self.training.iter_mut().chain(&mut self.validation).for_each(|recording| recording.prewhiten(rho));
        self.noise = if rho == 0.0 { NoiseModel::White } else { NoiseModel::Ar1 { rho } };
        self
    }

    /// How many values are fitted.
    pub fn count(&self) -> usize {
        self.training.iter().map(PreparedRecording::count).sum()
    }

    /// Whether measured inputs drive all that is fitted, so that no start state of it is unknown.
    pub fn driven(&self) -> bool {
        !self.training.is_empty() && self.training.iter().all(PreparedRecording::driven)
    }

    /// Whether no recording is expected to be explained down to its noise.
    pub fn discrepancy(&self) -> bool {
        !self.training.is_empty() && self.training.iter().all(|recording| recording.prepared.discrepancy)
    }

    /// Whether all that is fitted, which no simulation explains down to its noise, has one setup: nothing that varies shows whether effects
    /// are what is left of it.
    pub fn discrepancy_in_one_setup(&self) -> bool {
        let setup = |recording: &PreparedRecording| recording.prepared.circumstances.as_ref().map(|known| known.setup);
        self.discrepancy() && self.training.iter().all(|recording| setup(recording) == setup(&self.training[0]))
    }

    /// The same of recordings of several channels. Effects that have a number for each channel then follow what is left of one of them.
    pub fn is_one_setup_of_several_channels(&self) -> bool {
        self.discrepancy_in_one_setup() && self.training[0].width() > 1
    }

    /// Whether all that is fitted shows one motion, however often. A driven recording is many: its input visits what a start
    /// state would have to choose.
    pub fn shows_one_motion(&self) -> bool {
        self.training.iter().all(|recording| !recording.driven() && recording.motion == self.training[0].motion)
    }

    /// Whether no object shows a second motion, against which the values of its nuisance parameters could be held.
    pub fn shows_one_motion_per_object(&self) -> bool {
        let one = |a: &PreparedRecording| self.training.iter().all(|b| a.object != b.object || a.motion == b.motion);
        self.training.iter().all(|recording| !recording.driven() && one(recording))
    }
}

/// Root mean square of plain residuals from the share `from` of each recording on, a sample of several channels counted
/// once, or where units differ of residuals over the noise of their channels; what is set aside does not count.
pub(in crate::diagnose) fn rmse(recordings: &[PreparedRecording], plain: &[Vec<f64>], from: f64) -> f64 {
    let (mut squares, mut samples) = (0.0, 0.0);
    for (recording, values) in recordings.iter().zip(plain) {
        let begin = from * values.len() as f64;
        let (yardsticks, width) = (recording.yardsticks(), recording.width());
        let kept = values.iter().enumerate().filter(|(i, _)| recording.keep[*i] && *i as f64 >= begin);
        let square = |i: usize, v: f64| (v / yardsticks[i % width]).powi(2);
        let (sum, count) = kept.fold((0.0, 0.0), |(sum, count), (i, v)| (sum + square(i, *v), count + 1.0));
        squares += sum;
        samples += count / recording.values_per_sample();
    }
    if samples > 0.0 { (squares / samples).sqrt() } else { 0.0 }
}
