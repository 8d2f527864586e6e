//! Noise of a segment, robust about a cubic (Huber 1964): what no smooth force leaves.
//!
//! A tracker's errors last for some samples, so the differences of neighbours show less of them than there is. But no force
//! moves a body fast: over one segment any of them leaves a path that a cubic follows. What strays from the best cubic is
//! noise, and no name is asked to explain it.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::evidence::recording::PreparedRecording;
use crate::statistics::mad_sd;

/// Numbers of a cubic.
const TERMS: usize = 4;
/// A segment has to have so many samples for each of them.
const SAMPLES_EACH: usize = 4;
/// Rounds of the robust fit, and where its loss changes over, in robust standard deviations.
const ROUNDS: usize = 8;
const CHANGES_OVER: f64 = 1.5;

impl PreparedRecording {
    /// This segment with the noise of each channel raised to what strays from its best cubic.
    #[must_use]
    pub fn with_raised_noise(mut self) -> Self {
        raise_noise(&mut self);
        self
    }
}

fn raise_noise(segment: &mut PreparedRecording) {
    let clock = segment.clock();
    let (begin, end) = (clock[0], clock[clock.len() - 1]);
    let scaled: Vec<f64> = clock.iter().map(|t| (2.0 * t - begin - end) / (end - begin)).collect();
    let width = segment.width();
    for channel in 0..width {
        let kept: Vec<usize> = (0..scaled.len()).filter(|k| segment.keep[k * width + channel]).collect();
        let values: Vec<f64> = kept.iter().map(|&k| segment.prepared.seen.row(k)[channel]).collect();
        let instants: Vec<f64> = kept.iter().map(|&k| scaled[k]).collect();
        if let Some(sd) = astray(&instants, &values) {
            segment.noise[channel] = segment.noise[channel].max(sd);
        }
    }
    segment.measured_noise.clone_from(&segment.noise);
    segment.prewhiten(0.0);
}

/// The standard deviation of `values` from their best cubic in `instants`, robust to outliers; `None` for too few.
fn astray(instants: &[f64], values: &[f64]) -> Option<f64> {
    if values.len() < TERMS * SAMPLES_EACH {
        return None;
    }
    let basis = DMatrix::from_fn(instants.len(), TERMS, |i, j| instants[i].powi(i32::try_from(j).unwrap_or(0)));
    let seen = DVector::from_column_slice(values);
    let mut weights = DVector::from_element(values.len(), 1.0);
    let mut left = seen.clone();
    for _ in 0..ROUNDS {
        let weighted = DMatrix::from_fn(instants.len(), TERMS, |i, j| weights[i] * basis[(i, j)]);
        let fit = (weighted.transpose() * &basis).try_inverse()? * (weighted.transpose() * &seen);
        left = &seen - &basis * fit;
        let spread = CHANGES_OVER * mad_sd(left.iter().copied());
        weights = left.map(|v| if v.abs() > spread { spread / v.abs() } else { 1.0 });
    }
    // Huber's loss counts an outlier by its distance, not by its square.
    let squares: f64 = left.iter().zip(weights.iter()).map(|(v, w)| w * v * v).sum();
    Some((squares / (values.len() - TERMS) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};

    use super::astray;

    /// Noise of 2 mm that lasts for three samples, about a bend of 1 m; then with a sample 1 m off.
    #[test]
    fn noise_that_lasts_is_seen_whole_and_motion_is_not() {
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let white: Vec<f64> = (0..302).map(|_| 0.002 * draw.sample::<f64, _>(rand_distr::StandardNormal)).collect();
        let instants: Vec<f64> = (0..300).map(|i| f64::from(i) / 150.0 - 1.0).collect();
        let lasting = |i: usize| white[i..i + 3].iter().sum::<f64>() / 3f64.sqrt();
        let mut values: Vec<f64> =
            instants.iter().enumerate().map(|(i, x)| x * x - 0.3 * x.powi(3) + lasting(i)).collect();
        let sd = astray(&instants, &values).unwrap();
        assert!((sd / 0.002 - 1.0).abs() < 0.15, "{sd}");
        values[40] += 1.0;
        let with_outlier = astray(&instants, &values).unwrap();
        // By its square it would raise the spread to 58 mm.
        assert!(with_outlier < 2.5 * sd, "{with_outlier} {sd}");
        assert!(astray(&instants[..15], &values[..15]).is_none());
    }
}
