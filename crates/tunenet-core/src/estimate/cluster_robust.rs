//! Cluster-robust covariance (Liang and Zeger 1986): uncertainty of a fit whose residuals are correlated over many samples.
//!
//! A model of an arm leaves much that is no noise: ripple, play, friction that changes with load. Such residuals are
//! correlated for seconds, and the curvature of their squares overstates the information. So the score of each block of
//! samples counts as one draw: the covariance is A⁻¹ (Σ s sᵀ) A⁻¹, A being the curvature and s the score of a block
//! (the sandwich estimator of Huber 1967 with blocks, as in Liang and Zeger 1986).

use nalgebra::{DMatrix, DVector};

use super::output_error::{Fit, Problem};
use crate::Result;
use crate::statistics::dot;

/// Blocks of each recording: long compared with the residual's correlation time, and enough of them for a variance.
const BLOCKS: usize = 15;

/// Cluster-robust scale of a fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blocks {
    /// By how much the variance of the worst parameter exceeds that of white residuals of this size; 1 or more.
    pub inflation: f64,
    /// Degrees of freedom: blocks less parameters.
    pub degrees_of_freedom: f64,
}

impl Problem<'_> {
    /// The cluster-robust scale at `fit`, whose white residuals have this `variance`; `None` where it does not apply: nothing
    /// drove the recordings, or nothing is free.
    ///
    /// # Errors
    /// Where the simulator refuses.
    pub(super) fn blocks(&self, fit: &Fit, variance: f64) -> Result<Option<Blocks>> {
        let n = self.free.len();
        if n == 0 || variance <= 0.0 || self.recordings.iter().any(|r| r.input.is_none() || !r.nuisances.is_empty()) {
            return Ok(None);
        }
        let (mut curvature, mut between) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        let mut cluster_count = 0;
        for ((one, residual), noise) in self.jacobian(fit)?.iter().zip(&fit.residuals).zip(self.noise) {
            let samples = residual.len() / noise.len();
            let blocks = BLOCKS.min(samples);
            for b in 0..blocks {
                let range = b * samples / blocks * noise.len()..(b + 1) * samples / blocks * noise.len();
                let score = DVector::from_fn(n, |i, _| dot(&one.shared[i][range.clone()], &residual[range.clone()]));
                between += &score * score.transpose();
                curvature +=
                    DMatrix::from_fn(n, n, |i, j| dot(&one.shared[i][range.clone()], &one.shared[j][range.clone()]));
            }
            cluster_count += blocks;
        }
        let degrees_of_freedom = cluster_count as f64 - n as f64;
        let Some(inverse) = curvature.try_inverse().filter(|_| degrees_of_freedom >= 1.0) else { return Ok(None) };
        let robust = &inverse * between * &inverse * (cluster_count as f64 / degrees_of_freedom);
        let ratio = |i: usize| robust[(i, i)] / (inverse[(i, i)] * variance);
        let inflation = (0..n).map(ratio).filter(|r| r.is_finite()).fold(1.0, f64::max);
        Ok(Some(Blocks { inflation, degrees_of_freedom }))
    }
}
