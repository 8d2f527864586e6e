//! Noise of a channel by third differences and the median absolute deviation (von Neumann 1941; Rousseeuw and Croux 1993).

use crate::statistics::mad_sd;

/// Standard deviation of white noise on a smooth, nearly evenly sampled signal, from its third differences:
/// `1.4826 · median |Δ³x| / √20`.
///
/// Third differences cancel position, velocity and acceleration; 20 = 1 + 9 + 9 + 1 is the noise gain of the stencil, and
/// 1.4826 turns a median absolute deviation into a standard deviation of a normal distribution. The few differences that
/// straddle an impact are large, and the median ignores them.
///
/// A recording in steps of q (a file with few digits) cannot be known better than q/√12, so that is the least value
/// returned. Returns 0 for fewer than four samples.
#[must_use]
pub fn noise_sd(values: &[f64]) -> f64 {
    if values.len() < 4 {
        return 0.0;
    }
    let third = values.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]);
    let sd = mad_sd(third) / 20f64.sqrt();
    sd.max(step(values) / 12f64.sqrt())
}

/// The grid on which the values lie, 0 where they lie on none. Only powers of ten count, since only the digits of a file
/// make a grid; a parabola sampled evenly lies on one too, and is not rounded.
#[must_use]
pub fn step(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let least = sorted.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 1e-12).fold(f64::INFINITY, f64::min);
    let grid = 10f64.powf(least.log10().round());
    let on_grid = values.iter().all(|v| (v / grid - (v / grid).round()).abs() < 1e-3);
    if least.is_finite() && on_grid { grid } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::noise_sd;
    use rand::{Rng, SeedableRng};

    #[test]
    fn a_parabola_without_noise_has_none() {
        let fall: Vec<f64> = (0..100).map(|i| 5.0 - 4.905 * (f64::from(i) / 60.0).powi(2)).collect();
        assert!(noise_sd(&fall) < 1e-12, "{}", noise_sd(&fall));
    }

    #[test]
    fn white_noise_is_found_within_a_tenth() {
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let noisy: Vec<f64> = (0..4000)
            .map(|i| {
                let t = f64::from(i) / 60.0;
                let normal: f64 = draw.sample(rand_distr::StandardNormal);
                4.905 * t * t + 0.02 * normal
            })
            .collect();
        assert!((noise_sd(&noisy) / 0.02 - 1.0).abs() < 0.1, "{}", noise_sd(&noisy));
    }

    #[test]
    fn few_digits_bound_it_from_below() {
        let rounded: Vec<f64> = (0..50).map(|i| (f64::from(i) * 0.0137 * 1000.0).round() / 1000.0).collect();
        assert!(noise_sd(&rounded) >= 0.001 / 12f64.sqrt());
    }
}
