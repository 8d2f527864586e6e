//! Cluster-robust intervals (Liang and Zeger 1986): where recordings differ by more than noise.
//!
//! The covariance of the fit knows the noise within recordings alone. Where they differ among themselves as well (another hidden
//! state, another surface), their scatter is what bounds the answer: each recording counts as one draw, by the covariance that is
//! robust to clusters (Liang and Zeger 1986), with Student's quantile for as many draws.

use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::judge::recording_scores::{recording_scores, stretch_scores};
use crate::estimate::cluster_robust::{ClusterRobust, Score};
use crate::statistics::{UPPER_95, student_quantile};

/// Half the 95 % interval of each shared parameter by the scatter between recordings; `None` where fewer than two bear on it.
pub(in crate::diagnose) fn cluster_robust_half_widths(context: &Context<'_>, model: &Hypothesis) -> Vec<Option<f64>> {
    half_widths(&recording_scores(context, model), model.structure.shared.len())
}

/// The same by the scatter between stretches of driven recordings: what a model of a mechanism leaves (ripple, play, friction
/// that changes with load) is correlated for seconds.
pub(in crate::diagnose) fn stretch_robust_half_widths(context: &Context<'_>, model: &Hypothesis) -> Vec<Option<f64>> {
    half_widths(&stretch_scores(context, model), model.structure.shared.len())
}

fn half_widths(scores: &[Score], size: usize) -> Vec<Option<f64>> {
    let ClusterRobust { covariance, clusters, .. } = ClusterRobust::new(scores, size);
    let half = |index: usize| {
        let draws = clusters[index] as f64;
        if draws < 1.5 {
            return None;
        }
        let quantile = student_quantile(UPPER_95, draws - 1.0);
        let variance: f64 = covariance[(index, index)] * draws / (draws - 1.0);
        (variance > 0.0 && variance.is_finite()).then(|| quantile * variance.sqrt())
    };
    (0..size).map(half).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// Ten equally sharp recordings whose own values are 0 to 9, the last of two pieces: the interval is that of the mean of
    /// ten numbers, however sharp each is.
    #[test]
    fn the_interval_is_that_of_a_mean_of_recordings() {
        let score = |recording: usize, normal: f64, by: f64| Score {
            cluster: recording,
            indices: vec![0],
            normal: DMatrix::from_element(1, 1, normal),
            gradient: DVector::from_element(1, normal * by),
        };
        let values: Vec<f64> = (0..10).map(f64::from).collect();
        let (mean, sharp) = (4.5, 1e4);
        let mut scores: Vec<Score> = (0..9).map(|k| score(k, sharp, values[k] - mean)).collect();
        scores.extend([score(9, 0.5 * sharp, 9.0 - mean), score(9, 0.5 * sharp, 9.0 - mean)]);
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 9.0 / 10.0;
        // Student's quantile of nine degrees of freedom, from a table.
        let expected = 2.262_157 * variance.sqrt();
        let found = half_widths(&scores, 2);
        assert!((found[0].unwrap() / expected - 1.0).abs() < 1e-6, "{found:?} {expected}");
        assert_eq!(found[1], None, "nothing bears on it");
        assert_eq!(half_widths(&scores[..1], 1), [None], "one recording has no scatter");
    }
}
