//! Cluster-robust covariance (Liang and Zeger 1986): uncertainty of a fit whose residuals are correlated within clusters.
//!
//! The curvature of the squares counts every sample as one draw. Recordings of a thing that changes from one to the next, or of
//! a mechanism whose model leaves ripple, play and friction under load for seconds, hold far fewer. So the score of each cluster
//! counts as one draw: the covariance is A⁻¹ (Σ s sᵀ) A⁻¹, A being the curvature and s the score of a cluster (the sandwich
//! estimator of Huber 1967 with clusters, as in Liang and Zeger 1986).

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::block_arrow::inverse;
use super::output_error::{Fit, Linearisation, Problem};
use crate::statistics::dot;

/// Stretches of a driven recording: long compared with the residual's correlation time, and enough of them for a variance.
const STRETCHES: usize = 15;

/// The normal equations of one recording or stretch, its nuisance parameters eliminated.
pub(crate) struct Score {
    /// The cluster that it belongs to; several pieces may share one.
    pub cluster: usize,
    /// Which shared parameters it touches.
    pub indices: Vec<usize>,
    /// What it knows of them, shape `[indices, indices]`.
    pub normal: DMatrix<f64>,
    /// Gradient of its log-likelihood by them, shape `[indices]`: 0 summed over all recordings where the fit has arrived.
    pub gradient: DVector<f64>,
}

impl Score {
    /// From derivatives of white residuals by the shared parameters at `indices`, and these residuals.
    pub fn new(cluster: usize, indices: &[usize], columns: &[&[f64]], residual: &[f64]) -> Self {
        let normal = DMatrix::from_fn(columns.len(), columns.len(), |i, j| dot(columns[i], columns[j]));
        let gradient = DVector::from_fn(columns.len(), |i, _| -dot(columns[i], residual));
        Self { cluster, indices: indices.to_vec(), normal, gradient }
    }
}

/// The values of a recording, shape `[sample · channel]`, in stretches of about the same length.
pub(crate) fn stretches(values: usize, width: usize) -> impl Iterator<Item = Range<usize>> {
    let samples = values / width;
    let count = STRETCHES.min(samples);
    (0..count).map(move |b| b * samples / count * width..(b + 1) * samples / count * width)
}

/// What the scatter between clusters says.
pub(crate) struct ClusterRobust {
    /// The covariance without the correction for the number of clusters.
    pub covariance: DMatrix<f64>,
    /// The covariance that white noise of variance 1 would leave.
    pub model_based: DMatrix<f64>,
    /// How many clusters bear on each parameter.
    pub clusters: Vec<usize>,
}

impl ClusterRobust {
    /// Of `size` shared parameters.
    pub fn new(scores: &[Score], size: usize) -> Self {
        let mut whole = DMatrix::zeros(size, size);
        let mut gradients: BTreeMap<usize, DVector<f64>> = BTreeMap::new();
        let mut bearing = vec![BTreeSet::new(); size];
        for score in scores {
            let gradient = gradients.entry(score.cluster).or_insert_with(|| DVector::zeros(size));
            for (i, &row) in score.indices.iter().enumerate() {
                gradient[row] += score.gradient[i];
                for (j, &column) in score.indices.iter().enumerate() {
                    whole[(row, column)] += score.normal[(i, j)];
                }
                if score.normal[(i, i)] > 0.0 {
                    bearing[row].insert(score.cluster);
                }
            }
        }
        let model_based = inverse(whole);
        let between = gradients
            .values()
            .fold(DMatrix::zeros(size, size), |sum: DMatrix<f64>, gradient| sum + gradient * gradient.transpose());
        let covariance = &model_based * between * &model_based;
        Self { covariance, model_based, clusters: bearing.iter().map(BTreeSet::len).collect() }
    }
}

/// Cluster-robust scale of a fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct RobustScale {
    /// By how much the variance of the worst parameter exceeds that of white residuals of this size; 1 or more.
    pub inflation: f64,
    /// Degrees of freedom: clusters less parameters.
    pub degrees_of_freedom: f64,
}

impl Problem<'_> {
    /// The scale by stretches of the recordings at `fit`, whose white residuals have this `variance`; `None` where it does not
    /// apply: nothing drove the recordings, or nothing is free.
    pub(super) fn robust_scale(&self, fit: &Fit, linear: &Linearisation, variance: f64) -> Option<RobustScale> {
        let n = self.free.len();
        if n == 0 || variance <= 0.0 || self.recordings.iter().any(|r| !r.driven()) {
            return None;
        }
        let indices: Vec<usize> = (0..n).collect();
        let mut scores = Vec::new();
        for ((one, residual), noise) in linear.columns.iter().zip(&fit.residuals).zip(self.noise) {
            for range in stretches(residual.len(), noise.len()) {
                let columns: Vec<&[f64]> = one.shared.iter().map(|column| &column[range.clone()]).collect();
                scores.push(Score::new(scores.len(), &indices, &columns, &residual[range]));
            }
        }
        let degrees_of_freedom = scores.len() as f64 - n as f64;
        if degrees_of_freedom < 1.0 {
            return None;
        }
        let ClusterRobust { covariance, model_based, .. } = ClusterRobust::new(&scores, n);
        let correction = scores.len() as f64 / degrees_of_freedom;
        let ratio = |i: usize| covariance[(i, i)] * correction / (model_based[(i, i)] * variance);
        let inflation = (0..n).map(ratio).filter(|r| r.is_finite()).fold(1.0, f64::max);
        Some(RobustScale { inflation, degrees_of_freedom })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three clusters of a mean, of 1, 4 and 9 equal values: A is the count, s the count times the distance from the mean.
    #[test]
    fn the_sandwich_of_a_mean_is_the_scatter_of_its_clusters() {
        let (counts, values) = ([1.0, 4.0, 9.0], [2.0, -1.0, 0.5]);
        let mean = counts.iter().zip(values).map(|(n, v)| n * v).sum::<f64>() / 14.0;
        let column = [1.0; 9];
        let score = |k: usize| {
            let residual = vec![mean - values[k]; [1, 4, 9][k]];
            Score::new(k, &[0], &[&column[..residual.len()]], &residual)
        };
        let found = ClusterRobust::new(&[score(0), score(1), score(2)], 1);
        let expected = counts.iter().zip(values).map(|(n, v)| (n * (v - mean)).powi(2)).sum::<f64>() / (14.0 * 14.0);
        assert!((found.covariance[(0, 0)] - expected).abs() < 1e-12 && found.clusters == [3]);
        assert!((found.model_based[(0, 0)] - 1.0 / 14.0).abs() < 1e-12);
    }

    #[test]
    fn stretches_cover_every_value_once() {
        let all: Vec<usize> = stretches(3 * 100, 3).flatten().collect();
        assert_eq!(all, (0..300).collect::<Vec<_>>());
        assert_eq!((stretches(300, 3).count(), stretches(4, 2).count()), (STRETCHES, 2));
    }
}
