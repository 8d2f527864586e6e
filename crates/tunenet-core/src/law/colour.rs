//! Lag-1 correlation of autocorrelated (AR(1)) noise by differences at two distances (Hall and Van Keilegom 2003, "Using difference-based
//! methods for inference in nonparametric regression with time series errors"), and how many independent values such noise leaves
//! (Bartlett 1946).

use crate::simulator::Prepared;
use crate::statistics::mad_sd;

/// Order of the differences: what a model lacks changes little from sample to sample, and all but cancels.
const ORDER: i32 = 5;
/// How many samples apart they are, and the others 1.
const APART: usize = 3;
/// Differences beyond so many robust standard deviations count as much as those there: impacts and outliers.
const LARGEST: f64 = 4.0;
/// Standard deviation of the logarithm of the ratio of both variances for n values of white noise, times √n: by 800 draws each of 150, 600
/// and 2,400 values.
const SPREAD: f64 = 2.65;
/// So many of them make noise autocorrelated (one case of a hundred), ...
const SIGNIFICANT: f64 = 2.326;
/// ... unless the correlation is smaller than matters.
const LEAST: f64 = 0.1;
/// The greatest correlation that the ratio still shows.
const GREATEST: f64 = 0.8;

/// Autocorrelated noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Colour {
    /// The correlation of neighbouring samples, 0 where it does not matter.
    correlation: f64,
}

impl Colour {
    /// Of white noise.
    pub const WHITE: Self = Self { correlation: 0.0 };

    /// Of what a model leaves of recordings, shape `[recording][sample · channel]`.
    pub fn of(recordings: &[Prepared], residuals: &[Vec<f64>]) -> Self {
        let (mut near, mut far, mut count) = (Vec::new(), Vec::new(), 0);
        for (recording, residual) in recordings.iter().zip(residuals) {
            let width = recording.seen.channels().len();
            for channel in 0..width {
                let values: Vec<f64> = residual.iter().skip(channel).step_by(width).copied().collect();
                near.extend(differences(&values, 1));
                far.extend(differences(&values, APART));
                count += values.len();
            }
        }
        let ratio = (robust_square(&near) / robust_square(&far)).ln();
        if !ratio.is_finite() || ratio > -SIGNIFICANT * SPREAD / (count as f64).sqrt() {
            return Self::WHITE;
        }
        let correlation = correlation(ratio);
        if correlation < LEAST { Self::WHITE } else { Self { correlation } }
    }

    /// Whether it matters.
    pub fn is_white(self) -> bool {
        self.correlation == 0.0
    }

    /// How many values hold as much of a slow change as one independent one.
    pub fn values_for_one(self) -> f64 {
        (1.0 + self.correlation) / (1.0 - self.correlation)
    }

    /// The noise of recordings as slow changes meet it, from that of white noise; third differences, by which noise is measured where it is
    /// not known, see less of autocorrelated noise.
    pub fn slow_noise(self, recordings: &[Prepared], noise: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let slow = self.values_for_one().sqrt();
        let measured = (difference_variance(0.0, 3) / difference_variance(self.correlation, 3)).sqrt();
        let one = |(recording, noise): (&Prepared, &Vec<f64>)| {
            let factor = if recording.noise.is_some() { slow } else { slow * measured };
            noise.iter().map(|sd| sd * factor).collect()
        };
        recordings.iter().zip(noise).map(one).collect()
    }
}

/// The mean square of values about 0, outliers limited.
fn robust_square(values: &[f64]) -> f64 {
    let most = LARGEST * mad_sd(values.iter().copied());
    values.iter().map(|v| v.abs().min(most).powi(2)).sum::<f64>() / values.len() as f64
}

/// Differences of values so many samples apart.
fn differences(values: &[f64], apart: usize) -> Vec<f64> {
    let mut all = values.to_vec();
    for _ in 0..ORDER {
        let next = (apart..all.len()).map(|i| all[i] - all[i - apart]).collect();
        all = next;
    }
    all
}

/// The variance of differences of unit noise: Σ (−1)ʲ C(2k, k + j) ρ^|j| over all whole j.
fn difference_variance(correlation: f64, order: i32) -> f64 {
    let choose = |k: i32| (0..k).fold(1.0, |product, i| product * f64::from(2 * order - i) / f64::from(i + 1));
    let one = |j: i32| if j % 2 == 0 { 1.0 } else { -1.0 } * choose(order + j) * correlation.powi(j);
    choose(order) + 2.0 * (1..=order).map(one).sum::<f64>()
}

/// The correlation at which the logarithm of the ratio of the variances of neighbouring differences and of others is this.
fn correlation(ratio: f64) -> f64 {
    let variance = |rho: f64| difference_variance(rho, ORDER);
    let of = |rho: f64| (variance(rho) / variance(rho.powf(APART as f64))).ln();
    let (mut low, mut high) = (0.0, GREATEST);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if of(middle) > ratio { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};

    use super::*;
    use crate::observation::{Channel, Kind, Observation};

    /// Noise on a slow residual ten times as large.
    fn drawn(rho: f64, seed: u64) -> (Vec<Prepared>, Vec<Vec<f64>>) {
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut last: f64 = draw.sample(rand_distr::StandardNormal);
        let values: Vec<f64> = (0..600)
            .map(|i| {
                let fresh: f64 = draw.sample(rand_distr::StandardNormal);
                last = rho * last + (1.0 - rho * rho).sqrt() * fresh;
                last + 10.0 * (f64::from(i) * 0.1).sin()
            })
            .collect();
        let clock = (0..600).map(|i| f64::from(i) * 0.01).collect();
        let seen = Observation::new(Kind::Other, vec![Channel::new("x", "m")], clock, values.clone()).unwrap();
        (vec![Prepared::whole(seen, 0)], vec![values])
    }

    #[test]
    fn the_variances_of_differences_have_their_closed_forms() {
        let wanted = 20.0 - 30.0 * 0.5 + 12.0 * 0.25 - 2.0 * 0.125;
        assert!((difference_variance(0.5, 3) - wanted).abs() < 1e-12);
        assert!((difference_variance(0.0, 5) - 252.0).abs() < 1e-9);
        let at = (difference_variance(0.6, 5) / difference_variance(0.216, 5)).ln();
        assert!((correlation(at) - 0.6).abs() < 1e-9, "{}", correlation(at));
    }

    #[test]
    fn the_correlation_of_noise_is_found_next_to_a_slow_residual() {
        let found: Vec<f64> =
            (0..20).map(|seed| drawn(0.6, seed)).map(|(r, v)| Colour::of(&r, &v).correlation).collect();
        let mean = found.iter().sum::<f64>() / 20.0;
        assert!((mean - 0.6).abs() < 0.1, "{found:?}");
        let white = (0..100).map(|seed| drawn(0.0, seed)).filter(|(r, v)| Colour::of(r, v).is_white()).count();
        assert!(white >= 97, "{white}");
    }

    /// Of a correlation of 0.6, four values are worth one; third differences see 0.54 of the noise, and slow changes meet twice as much.
    #[test]
    fn slow_changes_meet_more_noise_than_third_differences_see() {
        let (recordings, _) = drawn(0.6, 1);
        let colour = Colour { correlation: 0.6 };
        assert!((colour.values_for_one() - 4.0).abs() < 1e-12);
        let noise = colour.slow_noise(&recordings, &[vec![1.0]]);
        let seen = (difference_variance(0.6, 3) / 20.0).sqrt();
        assert!((noise[0][0] - 2.0 / seen).abs() < 1e-12 && (seen - 0.543).abs() < 1e-3, "{noise:?} {seen}");
        let known = Prepared { noise: Some(vec![1.0]), ..recordings[0].clone() };
        assert!((colour.slow_noise(&[known], &[vec![1.0]])[0][0] - 2.0).abs() < 1e-12);
    }
}
