//! The clock of a video: its step, the frames that are missing, and stamps that a container has rounded.

use tunenet_core::statistics::{mean, median};

/// Steps below this many medians hold no missing frame.
const GAP: f64 = 1.5;
/// Rounding to whole milliseconds moves a stamp by no more than this, s.
const ROUNDING_S: f64 = 0.55e-3;
/// A stamp is a whole millisecond where it lies this near to one, s.
const WHOLE_S: f64 = 1e-7;

fn steps(times_s: &[f64]) -> Vec<f64> {
    times_s.windows(2).map(|w| w[1] - w[0]).collect()
}

/// From one frame to the next, s: the mean of the steps without a gap.
pub(crate) fn step_s(times_s: &[f64]) -> f64 {
    let steps = steps(times_s);
    let middle = median(steps.clone()).unwrap_or(1.0);
    let plain: Vec<f64> = steps.into_iter().filter(|s| *s < GAP * middle).collect();
    if plain.is_empty() { middle } else { mean(plain) }
}

/// How many frames are missing by the clock.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of frames, clamped")]
pub(crate) fn dropped(times_s: &[f64], step_s: f64) -> usize {
    steps(times_s).iter().map(|step| ((step / step_s).round() - 1.0).clamp(0.0, 1e6) as usize).sum()
}

/// Undoes the rounding of an even clock to whole milliseconds, which would shake a fast ball by millimetres. Other clocks
/// stay as they are.
pub(crate) fn even_out(times_s: &mut [f64]) {
    let whole = times_s.iter().all(|t| (t * 1e3 - (t * 1e3).round()).abs() < WHOLE_S * 1e3);
    if times_s.len() < 8 || !whole {
        return;
    }
    let step = step_s(times_s);
    let mut numbers = vec![0.0; times_s.len()];
    for i in 1..times_s.len() {
        numbers[i] = numbers[i - 1] + ((times_s[i] - times_s[i - 1]) / step).round().max(1.0);
    }
    let (mean_k, mean_t) = (mean(numbers.iter().copied()), mean(times_s.iter().copied()));
    let square: f64 = numbers.iter().map(|k| (k - mean_k).powi(2)).sum();
    let step = numbers.iter().zip(times_s.iter()).map(|(k, t)| (k - mean_k) * (t - mean_t)).sum::<f64>() / square;
    let even: Vec<f64> = numbers.iter().map(|k| mean_t + step * (k - mean_k)).collect();
    if even.iter().zip(times_s.iter()).all(|(a, b)| (a - b).abs() <= ROUNDING_S) {
        times_s.copy_from_slice(&even);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_stamps_become_even_and_gaps_stay() {
        let numbers: Vec<f64> = (0..60).filter(|k| *k != 20 && *k != 21).map(f64::from).collect();
        let mut times: Vec<f64> = numbers.iter().map(|k| (k * 1e3 / 30.0).round() / 1e3).collect();
        even_out(&mut times);
        assert!(numbers.iter().zip(&times).all(|(k, t)| (t - k / 30.0).abs() < 1e-4), "{times:?}");
        let step = step_s(&times);
        assert!((step - 1.0 / 30.0).abs() < 1e-6 && dropped(&times, step) == 2, "{step}");
    }

    #[test]
    fn clocks_of_other_kinds_stay_as_they_are() {
        let shaken: Vec<f64> =
            (0..40).map(|k| f64::from(k) / 30.0 + 1e-3 * f64::from(k % 7)).map(|t| (t * 1e3).round() / 1e3).collect();
        let mut same = shaken.clone();
        even_out(&mut same);
        assert_eq!(same, shaken);
    }
}
