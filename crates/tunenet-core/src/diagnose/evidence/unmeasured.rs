//! Channels that were not measured, and nuisance parameters that only they would show.

use super::recording::PreparedRecording;
use crate::statistics::dot;

/// A nuisance parameter whose whole range moves nothing by more than this (in units of the noise) is held at its guess ...
pub(in crate::diagnose) const SILENT: f64 = 0.01;
/// ... by a prior with this share of its range as standard deviation.
const HELD_SHARE: f64 = 1e-6;

impl PreparedRecording {
    /// Channels of which nothing counts.
    pub(in crate::diagnose) fn unmeasured(&self) -> Vec<usize> {
        let width = self.width();
        (0..width).filter(|c| !self.keep.iter().skip(*c).step_by(width).any(|keep| *keep)).collect()
    }

    /// Holds the nuisance parameters with these derivatives of the white residuals where they move nothing.
    pub(in crate::diagnose) fn hold_silent(&mut self, columns: &[Vec<f64>]) {
        if self.unmeasured().is_empty() {
            return;
        }
        for (i, column) in columns.iter().enumerate() {
            if dot(column, column).sqrt() * self.prepared.nuisances[i].span() < SILENT {
                self.hold(i);
            }
        }
    }

    /// Holds nuisance parameter `i` at its guess.
    pub(in crate::diagnose) fn hold(&mut self, i: usize) {
        self.prior_sd[i] = self.held_sd(i);
    }

    fn held_sd(&self, i: usize) -> f64 {
        HELD_SHARE * self.prepared.nuisances[i].span()
    }

    /// Whether nuisance parameter `i` is not held.
    pub(in crate::diagnose) fn is_fitted(&self, i: usize) -> bool {
        self.prior_sd[i] > self.held_sd(i)
    }

    /// How many nuisance parameters are fitted: those that are held are not.
    pub(in crate::diagnose) fn fitted_nuisances(&self) -> usize {
        (0..self.prepared.nuisances.len()).filter(|&i| self.is_fitted(i)).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::Observation;
    use crate::simulator::{Parameter, Prepared};

    fn seen_along_x_and_z() -> PreparedRecording {
        let clock: Vec<f64> = (0..30).map(|k| f64::from(k) * 0.02).collect();
        let rows: Vec<[f64; 3]> = clock.iter().map(|t| [*t, 0.0, 1.0 - 4.905 * t * t]).collect();
        let mut prepared = Prepared::whole(Observation::positions(clock, &rows).unwrap(), 1);
        let nuisance = |name: &str| Parameter::new(name, "m/s", 1.0, -4.0, 4.0).unwrap();
        prepared.nuisances = vec![nuisance("initial.velocity_x"), nuisance("initial.velocity_y")];
        PreparedRecording::new(0, 0, false, prepared)
    }

    #[test]
    fn an_axis_that_stands_still_is_not_measured() {
        let recording = seen_along_x_and_z();
        assert_eq!((recording.unmeasured(), recording.values_per_sample()), (vec![1], 2.0));
    }

    /// What moves the recording stays as free as it was, what moves nothing is held at its guess.
    #[test]
    fn only_what_moves_nothing_is_held() {
        let mut recording = seen_along_x_and_z();
        let before = recording.prior_sd.clone();
        recording.hold_silent(&[vec![0.1; 90], vec![0.0; 90]]);
        assert_eq!((recording.prior_sd[0], recording.fitted_nuisances()), (before[0], 1));
        assert!(recording.prior_sd[1] < 1e-4 * before[1], "{:?}", recording.prior_sd);
    }
}
