//! Noise of event times: robust quadratic regression of the logarithms of their intervals, and the median absolute deviation.

use crate::statistics::{mad_sd, median};

/// Timing noise assumed where a list is too short for an estimate, s: a microphone's click is found to about a third of a
/// millisecond.
const SHORT_LIST_SD_S: f64 = 3e-4;
/// No clock that hears impacts is worse than this share of the interval between them; a list that looks so is not noisy but
/// wrong, and must not pass for a good fit.
const WORST_SHARE: f64 = 0.015;
/// A list says something about its own noise from this many events on: one quadratic through the logarithms of the
/// intervals takes three degrees of freedom.
const FEWEST_FOR_NOISE: usize = 7;

/// Standard deviation of one event time, s.
///
/// The logarithm of the interval between impacts falls linearly with the count where each returns the same share of the speed,
/// and smoothly where that share depends on speed; what a quadratic in the count leaves over is timing noise and the scatter of the
/// impacts themselves. An error of one time moves the two adjacent intervals, hence √2. The median keeps a missed click from counting.
#[must_use]
pub fn event_time_sd(index: &[f64], time_s: &[f64]) -> f64 {
    if time_s.len() < FEWEST_FOR_NOISE {
        return SHORT_LIST_SD_S;
    }
    let even = |i: &usize| (index[i + 1] - index[*i] - 1.0).abs() < 0.5;
    let places: Vec<usize> = (0..time_s.len() - 1).filter(even).collect();
    let logs: Vec<(f64, f64, f64)> =
        places.iter().map(|&i| (index[i], (time_s[i + 1] - time_s[i]).ln(), time_s[i + 1] - time_s[i])).collect();
    let Some(fit) = robust_quadratic(&logs) else { return SHORT_LIST_SD_S };
    let left: Vec<f64> = logs.iter().map(|&(x, y, interval)| (y - quadratic(&fit, x)) * interval).collect();
    let correction = ((left.len() as f64) / (left.len() as f64 - 3.0)).sqrt();
    let mean_interval = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
    (mad_sd(left) * correction / 2f64.sqrt()).max(1e-6).min(WORST_SHARE * mean_interval)
}

fn quadratic(c: &nalgebra::Vector3<f64>, x: f64) -> f64 {
    c[0] + x * (c[1] + x * c[2])
}

/// A quadratic through `(x, y, interval)`, reweighted four times so that outliers fade (Cauchy weights at the median).
fn robust_quadratic(points: &[(f64, f64, f64)]) -> Option<nalgebra::Vector3<f64>> {
    let mut weights: Vec<f64> = points.iter().map(|p| p.2 * p.2).collect();
    let mut fit = None;
    for _ in 0..5 {
        let (mut normal, mut right) = (nalgebra::Matrix3::zeros(), nalgebra::Vector3::zeros());
        for (&(x, y, _), &w) in points.iter().zip(&weights) {
            let row = nalgebra::Vector3::new(1.0, x, x * x);
            normal += w * row * row.transpose();
            right += w * row * y;
        }
        let solution = normal.try_inverse()? * right;
        let left = |&(x, y, interval): &(f64, f64, f64)| ((y - quadratic(&solution, x)) * interval).abs();
        let median = median(points.iter().map(left)).unwrap_or(0.0).max(1e-9);
        for (w, p) in weights.iter_mut().zip(points) {
            *w = p.2 * p.2 / (1.0 + (left(p) / median).powi(2) / 4.0);
        }
        fit = Some(solution);
    }
    fit
}

#[cfg(test)]
mod tests {
    use super::event_time_sd;
    use rand::{Rng, SeedableRng};

    #[test]
    fn timing_noise_is_found_within_a_third() {
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut ratio = Vec::new();
        for _ in 0..200 {
            let index: Vec<f64> = (0..14).map(f64::from).collect();
            let exact = index.iter().map(|k| 0.5 * (1.0 - 0.9f64.powf(*k)) / 0.1);
            let noisy: Vec<f64> = exact.map(|t| t + 5e-4 * draw.sample::<f64, _>(rand_distr::StandardNormal)).collect();
            ratio.push(event_time_sd(&index, &noisy) / 5e-4);
        }
        ratio.sort_by(f64::total_cmp);
        assert!((ratio[100] - 1.0).abs() < 0.33, "median ratio {}", ratio[100]);
    }
}
