//! Cluster-robust covariance (Liang and Zeger 1986): how sure a fit is where its residuals are correlated for long.
//!
//! A model of an arm leaves much that is no noise: ripple, play, friction that changes with load. Such residuals follow one
//! another for seconds, and the curvature of their squares then says far too much. So the pull of each stretch on the
//! parameters is taken as one draw: the covariance is A⁻¹ (Σ s sᵀ) A⁻¹, A being the curvature and s the pull of a stretch
//! (the sandwich of Huber 1967 with blocks, as Liang and Zeger 1986 have it).

use nalgebra::{DMatrix, DVector};

use super::output_error::{Fit, Problem};
use crate::Result;
use crate::statistics::dot;

/// Stretches of each recording: long against what the residual remembers, enough for a spread.
const BLOCKS: usize = 15;

/// What blocks say of a fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blocks {
    /// By how much the variance of the worst parameter exceeds that of white residuals of this size; 1 or more.
    pub inflation: f64,
    /// How many stretches are free to vary.
    pub freedom: f64,
}

impl Problem<'_> {
    /// The spread among stretches at `fit`, whose white residuals have this `variance`; `None` where it does not apply: nothing
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
        let mut stretches = 0;
        for ((one, residual), noise) in self.jacobian(fit)?.iter().zip(&fit.residuals).zip(self.noise) {
            let samples = residual.len() / noise.len();
            let blocks = BLOCKS.min(samples);
            for b in 0..blocks {
                let range = b * samples / blocks * noise.len()..(b + 1) * samples / blocks * noise.len();
                let pull = DVector::from_fn(n, |i, _| dot(&one.shared[i][range.clone()], &residual[range.clone()]));
                between += &pull * pull.transpose();
                curvature +=
                    DMatrix::from_fn(n, n, |i, j| dot(&one.shared[i][range.clone()], &one.shared[j][range.clone()]));
            }
            stretches += blocks;
        }
        let freedom = stretches as f64 - n as f64;
        let Some(inverse) = curvature.try_inverse().filter(|_| freedom >= 1.0) else { return Ok(None) };
        let robust = &inverse * between * &inverse * (stretches as f64 / freedom);
        let ratio = |i: usize| robust[(i, i)] / (inverse[(i, i)] * variance);
        let inflation = (0..n).map(ratio).filter(|r| r.is_finite()).fold(1.0, f64::max);
        Ok(Some(Blocks { inflation, freedom }))
    }
}
