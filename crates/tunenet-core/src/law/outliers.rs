//! Outliers of residuals: short runs far from all others by the median absolute deviation (Hampel 1974).

use crate::statistics::mad_sd;

/// Residuals beyond so many robust standard deviations of all are outliers where no more of them follow each other: tests of sums of squares
/// say nothing of noise with outliers. Longer runs of large residuals are no outliers, but something that a model lacks.
const LARGEST: f64 = 5.0;
const RUN: usize = 2;

/// Samples that are outliers, each with its neighbours in the same channel: positions in the residuals of a recording.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Outliers(Vec<Vec<(usize, Vec<usize>)>>);

impl Outliers {
    /// Those in residuals of so many channels, shape `[recording][sample · channel]`.
    pub fn of(residuals: &[Vec<f64>], width: usize) -> Self {
        let most = LARGEST * mad_sd(residuals.iter().flatten().copied());
        let one = |all: &Vec<f64>| {
            let is_large = |place: &usize| most > 0.0 && all[*place].abs() > most;
            let mut found = Vec::new();
            for channel in 0..width {
                let places: Vec<usize> = (channel..all.len()).step_by(width).collect();
                let mut end = 0;
                for run in places.chunk_by(|a, b| is_large(a) == is_large(b)) {
                    let first = end;
                    end += run.len();
                    if is_large(&run[0]) && run.len() <= RUN {
                        let before = first.checked_sub(1).map(|k| places[k]);
                        let near: Vec<usize> = before.into_iter().chain(places.get(end).copied()).collect();
                        found.extend(run.iter().map(|place| (*place, near.clone())));
                    }
                }
            }
            found
        };
        Self(residuals.iter().map(one).collect())
    }

    /// Residuals of the same recordings with the mean of the neighbours in the place of each outlier.
    pub fn replaced(&self, residuals: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut made = residuals.to_vec();
        for ((made, all), outliers) in made.iter_mut().zip(residuals).zip(&self.0) {
            for (place, near) in outliers {
                made[*place] = near.iter().map(|i| all[*i]).sum::<f64>() / near.len().max(1) as f64;
            }
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two channels, whose residuals are ±1: one of 50, or two after each other, are outliers, and three are none.
    #[test]
    fn a_short_run_of_large_residuals_is_an_outlier_and_a_longer_one_is_none() {
        let mut all: Vec<f64> = (0..100_u32).map(|i| if i % 4 < 2 { 1.0 } else { -1.0 }).collect();
        let large = [40, 61, 63, 80, 82, 84];
        for i in large {
            all[i] = 50.0;
        }
        let outliers = Outliers::of(&[all.clone()], 2);
        let found = outliers.replaced(&[all]);
        assert_eq!(large.map(|i| found[0][i]), [-1.0, 0.0, 0.0, 50.0, 50.0, 50.0]);
        assert_eq!(found[0][41], 1.0);
        // The same samples of another law's residuals.
        assert_eq!(outliers.replaced(&[vec![3.0; 100]]), [[3.0; 100]]);
        assert_eq!(Outliers::of(&[vec![0.0, 0.0, 3.0]], 1), Outliers(vec![vec![]]));
    }
}
