//! Lack-of-fit test: the root mean square of residuals against the noise of their channel (Draper and Smith 1998, chapter 2).

use crate::observation::{Kind, Observation, lattice_step};
use crate::statistics::range;

/// A misfit below this share of the range of the data is negligible, even for exact recordings.
const PRACTICAL_SHARE: f64 = 1e-6;
/// How far the residual may exceed the noise: `1 + MARGIN + LUCK/√n`. The noise is itself estimated, from n samples with a
/// relative standard deviation near 1.9/√n (third differences) and more for short lists.
const MARGIN: f64 = 0.1;
const LUCK: f64 = 6.0;

/// How one recording's residual compares with its noise.
#[derive(Debug, Clone, Copy)]
pub struct Adequacy {
    /// Root mean square of the worst channel's residual over that channel's noise.
    pub ratio: f64,
    /// Which channel that is.
    pub worst: usize,
    /// The greatest ratio that noise alone explains.
    pub limit: f64,
    /// False where the recording is too short to know its own noise, so that nothing can be said.
    pub tested: bool,
}

impl Adequacy {
    /// Judges the weighted residuals (shape `[sample · channel]`) of `seen`, fitted with `fitted` numbers. Where real recordings never follow
    /// the simulation down to their noise (`discrepancy`), a channel of which less is left than a step of its sensor is adequate.
    #[must_use]
    pub fn of(seen: &Observation, noise: &[f64], residuals: &[f64], (fitted, discrepancy): (usize, bool)) -> Self {
        let width = noise.len();
        let samples = seen.len();
        let (mut worst, mut place) = (0.0, 0);
        for (channel, noise) in noise.iter().enumerate() {
            let column = || residuals.iter().skip(channel).step_by(width);
            let degrees_of_freedom = (samples as f64 - fitted as f64 / width as f64).max(1.0);
            let ratio = (column().map(|r| r * r).sum::<f64>() / degrees_of_freedom).sqrt();
            let resolved = || ratio <= 1.0 || !discrepancy || !is_below_step(seen, channel, ratio * noise);
            if ratio * noise > PRACTICAL_SHARE * range(seen.column(channel)) && ratio > worst && resolved() {
                (worst, place) = (ratio, channel);
            }
        }
        let (counted, tested) = match seen.kind() {
            Kind::EventTimes => (samples as f64 - 4.0, samples >= 7),
            _ => (samples as f64, samples >= 8),
        };
        Self { ratio: worst, worst: place, limit: 1.0 + MARGIN + LUCK / counted.max(1.0).sqrt(), tested }
    }

    /// Whether more is left than noise explains.
    #[must_use]
    pub fn poor(&self) -> bool {
        self.tested && self.ratio > self.limit
    }
}

/// Whether a residual, as a root mean square, is less than a step of the channel's sensor; not where the readings show no step.
pub(crate) fn is_below_step(seen: &Observation, channel: usize, rmse: f64) -> bool {
    let values: Vec<f64> = seen.column(channel).collect();
    lattice_step(&values).is_some_and(|step| rmse < step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Exact, Line};

    #[test]
    fn residuals_of_the_size_of_the_noise_are_adequate_and_twice_that_is_not() {
        let seen = Exact::new(Line).observe(&[("slope", 2.0)], &[0.5], 0.01, 7).unwrap();
        let residuals = |size: f64| (0..seen.len()).map(|i| if i % 2 == 0 { size } else { -size }).collect::<Vec<_>>();
        let fit = Adequacy::of(&seen, &[0.01], &residuals(1.0), (2, false));
        let n = seen.len() as f64;
        assert!((fit.ratio - (n / (n - 2.0)).sqrt()).abs() < 1e-12 && (fit.limit - 1.1 - 6.0 / n.sqrt()).abs() < 1e-12);
        assert!(fit.tested && !fit.poor());
        assert!(Adequacy::of(&seen, &[0.01], &residuals(2.0), (2, false)).poor());
    }

    #[test]
    fn less_than_a_step_of_the_sensor_is_adequate_where_no_simulation_follows_to_the_noise() {
        let exact = Exact::new(Line).observe(&[("slope", 2.0)], &[0.5], 0.02, 7).unwrap();
        let step = 0.01;
        let counts = exact.values().iter().map(|value| (value / step).round() * step).collect();
        let seen = Observation::new(Kind::Other, exact.channels().to_vec(), exact.clock().to_vec(), counts).unwrap();
        let of =
            |size: f64, discrepancy| Adequacy::of(&seen, &[0.002], &vec![size / 0.002; seen.len()], (2, discrepancy));
        assert!(of(0.009, false).poor() && !of(0.009, true).poor());
        assert!(of(0.011, true).poor());
    }

    #[test]
    fn a_recording_of_few_samples_is_not_tested() {
        let seen = Exact::new(Line).observe(&[("slope", 2.0)], &[0.5], 0.01, 7).unwrap().slice(0..7).unwrap();
        assert!(!Adequacy::of(&seen, &[0.01], &[9.0; 7], (2, false)).poor());
    }
}
