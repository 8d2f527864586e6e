//! Lag-1 correlation of autocorrelated (AR(1)) noise, from first differences of residuals.

use super::recording::PreparedRecording;
use crate::statistics::{mad_sd, median};

/// A lag-one correlation below this is not worth whitening ...
const LEAST: f64 = 0.06;
/// ... nor one below this many of its standard deviations.
const SIGNIFICANT: f64 = 2.0;
const GREATEST: f64 = 0.95;
/// Two samples are neighbours where their distance is this near to the usual one.
const EVEN: f64 = 0.2;

/// The lag-one correlation up to which what is left of things that are not expected to be explained down to their noise is noise: joints
/// are read a hundred times a second and faster, so that a filter of 0.1 s leaves as much. What their simulations leave out is correlated
/// by 0.95 and more.
pub(in crate::diagnose) const LONGEST_OF_DISCREPANCY: f64 = 0.9;
/// Residuals beyond so many robust standard deviations count as much as those there.
const LARGEST: f64 = 4.0;

/// The same as [`correlation`], from the residuals themselves where they are no longer correlated than noise may be: differences know it
/// three times less exactly.
pub(in crate::diagnose) fn whole_correlation(recordings: &[PreparedRecording], residuals: &[Vec<f64>]) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    for (recording, residual) in recordings.iter().zip(residuals) {
        let width = recording.width();
        for channel in 0..width {
            let kept = (channel..residual.len()).step_by(width).filter(|&i| recording.keep[i]);
            let values: Vec<f64> = kept.map(|i| residual[i]).collect();
            let most = LARGEST * mad_sd(values.iter().copied());
            let limited: Vec<f64> = values.iter().map(|v| v.clamp(-most, most)).collect();
            product += limited.windows(2).map(|w| w[0] * w[1]).sum::<f64>();
            square += limited.iter().map(|v| v * v).sum::<f64>();
        }
    }
    let whole = product / square;
    if whole.is_finite() && whole <= LONGEST_OF_DISCREPANCY { whole } else { correlation(recordings, residuals) }
}

/// The lag-one correlation of the noise in `residuals` (units of the noise, not whitened), 0 where it does not matter.
///
/// From first differences, in which a smooth misfit all but cancels: for a first-order autoregressive process their own
/// lag-one correlation is −(1 − ρ)/2.
pub(in crate::diagnose) fn correlation(recordings: &[PreparedRecording], residuals: &[Vec<f64>]) -> f64 {
    let (mut product, mut square, mut count) = (0.0, 0.0, 0_usize);
    for (recording, residual) in recordings.iter().zip(residuals) {
        let (width, clock) = (recording.width(), recording.clock());
        let usual = median(clock.windows(2).map(|w| w[1] - w[0])).unwrap_or(0.0);
        let next = |k: usize| ((clock[k + 1] - clock[k]) / usual - 1.0).abs() < EVEN;
        for channel in 0..width {
            let at = |k: usize| k * width + channel;
            for k in 0..clock.len().saturating_sub(2) {
                let kept = recording.keep[at(k)] && recording.keep[at(k + 1)] && recording.keep[at(k + 2)];
                if kept && next(k) && next(k + 1) {
                    let (first, second) =
                        (residual[at(k + 1)] - residual[at(k)], residual[at(k + 2)] - residual[at(k + 1)]);
                    product += first * second;
                    square += 0.5 * (first * first + second * second);
                    count += 1;
                }
            }
        }
    }
    if square <= 0.0 || count < 20 {
        return 0.0;
    }
    let rho = 1.0 + 2.0 * product / square;
    // Bartlett: the lag-one correlation of the differences of white noise has variance 1/(2n).
    let sd = 2.0 / (2.0 * count as f64).sqrt();
    if rho.abs() > LEAST.max(SIGNIFICANT * sd) { rho.clamp(-0.5, GREATEST) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::in_swings;

    /// Noise with a correlation of 0.7 by a recurrence; a slow misfit is left to the differences.
    #[test]
    fn residuals_state_a_short_correlation_and_differences_a_long_one() {
        in_swings(&[], 3, 0, |context| {
            let mut state = 1_u64;
            let mut draw = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / 9_007_199_254_740_992.0 - 0.5
            };
            let mut last = 0.0;
            let mut noise = |count: usize| -> Vec<f64> {
                (0..count)
                    .map(|_| {
                        last = 0.7 * last + draw();
                        last
                    })
                    .collect()
            };
            let short: Vec<Vec<f64>> =
                context.recordings().iter().map(|recording| noise(recording.keep.len())).collect();
            let found = whole_correlation(context.recordings(), &short);
            let by_differences = correlation(context.recordings(), &short);
            assert!((found - 0.7).abs() < 0.12 && found != by_differences, "{found} {by_differences}");
            let slow = short
                .iter()
                .map(|one| one.iter().enumerate().map(|(i, v)| v + 20.0 * (0.05 * i as f64).sin()).collect());
            let slow: Vec<Vec<f64>> = slow.collect();
            assert_eq!(whole_correlation(context.recordings(), &slow), correlation(context.recordings(), &slow));
        });
    }
}
