//! Heterogeneity of effects between recordings: Cochran's Q (Cochran 1954) of one-step estimates by their scores, less what noise
//! alone gives, as a share of the effects.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::judge::recording_scores::recording_scores;
use crate::estimate::cluster_robust::Score;

/// A share of the information below which a direction of the coefficients says nothing.
const SILENT: f64 = 1e-9;

/// How far each recording alone would move the coefficients of the effects of `model`, as a share of the coefficients
/// (root of the weighted mean square, less what noise alone moves). A cause that only resembles the effect is stronger in some
/// recordings than in others.
pub(in crate::diagnose) fn relative_heterogeneity(context: &Context<'_>, model: &Hypothesis) -> f64 {
    let shared = &model.structure.shared;
    let size = |index: usize| {
        let coefficient = shared[index].effect.is_some();
        coefficient.then(|| model.fit.point.parameters[index] - shared[index].absent.map_or(0.0, |a| a.0))
    };
    share_moved(&recording_scores(context, model), &size, context.effective_fraction().recip())
}

/// `size` of a shared parameter, `None` where it does not count; `by_noise` is what noise alone moves along each direction.
fn share_moved(scores: &[Score], size: &dyn Fn(usize) -> Option<f64>, by_noise: f64) -> f64 {
    let (mut moved, mut whole) = (0.0, 0.0);
    for score in scores {
        let (mine, sizes): (Vec<usize>, Vec<f64>) =
            score.indices.iter().enumerate().filter_map(|(i, &index)| Some((i, size(index)?))).unzip();
        if mine.is_empty() {
            continue;
        }
        let normal = DMatrix::from_fn(mine.len(), mine.len(), |i, j| score.normal[(mine[i], mine[j])]);
        let gradient = DVector::from_fn(mine.len(), |i, _| score.gradient[mine[i]]);
        let sizes = DVector::from_vec(sizes);
        whole += sizes.dot(&(&normal * &sizes));
        let eigen = normal.symmetric_eigen();
        let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        for (k, value) in eigen.eigenvalues.iter().enumerate().filter(|(_, v)| **v > SILENT * largest) {
            moved += eigen.eigenvectors.column(k).dot(&gradient).powi(2) / value - by_noise;
        }
    }
    if whole > 0.0 { (moved.max(0.0) / whole).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two recordings that know a coefficient of 2 to 1/√400 each; one asks for 0.2 more, the other for 0.2 less.
    #[test]
    fn the_share_is_the_scatter_over_the_size() {
        let score = |recording: usize, by: f64| Score {
            cluster: recording,
            indices: vec![7, 3],
            normal: DMatrix::from_row_slice(2, 2, &[400.0, 0.0, 0.0, 1.0]),
            gradient: DVector::from_row_slice(&[400.0 * by, 50.0]),
        };
        let scores = [score(0, 0.2), score(1, -0.2)];
        let size = |index: usize| (index == 7).then_some(2.0);
        assert!((share_moved(&scores, &size, 0.0) - 0.1).abs() < 1e-12);
        // What noise moves is taken off: 1 of the 16 of each.
        assert!((share_moved(&scores, &size, 1.0) - 0.1 * (15.0f64 / 16.0).sqrt()).abs() < 1e-12);
        assert_eq!(share_moved(&[score(0, 0.05)], &size, 1.0), 0.0);
        assert_eq!(share_moved(&scores, &|_| None, 1.0), 0.0);
    }
}
