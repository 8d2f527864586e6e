//! Lag-1 correlation of autocorrelated (AR(1)) noise, from first differences of residuals.

use super::recording::Set;
use crate::statistics::median;

/// A lag-one correlation below this is not worth whitening ...
const LEAST: f64 = 0.06;
/// ... nor one below this many of its standard deviations.
const SIGNIFICANT: f64 = 2.0;
const GREATEST: f64 = 0.95;
/// Two samples are neighbours where their distance is this near to the usual one.
const EVEN: f64 = 0.2;

/// The lag-one correlation of the noise in `residuals` (units of the noise, not whitened), 0 where it does not matter.
///
/// From first differences, in which a smooth misfit all but cancels: for a first-order autoregressive process their own
/// lag-one correlation is −(1 − ρ)/2.
pub(in crate::diagnose) fn correlation(sets: &[Set], residuals: &[Vec<f64>]) -> f64 {
    let (mut product, mut square, mut count) = (0.0, 0.0, 0_usize);
    for (set, residual) in sets.iter().zip(residuals) {
        let (width, clock) = (set.width(), set.clock());
        let usual = median(clock.windows(2).map(|w| w[1] - w[0])).unwrap_or(0.0);
        let next = |k: usize| ((clock[k + 1] - clock[k]) / usual - 1.0).abs() < EVEN;
        for channel in 0..width {
            let at = |k: usize| k * width + channel;
            for k in 0..clock.len().saturating_sub(2) {
                let kept = set.keep[at(k)] && set.keep[at(k + 1)] && set.keep[at(k + 2)];
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
