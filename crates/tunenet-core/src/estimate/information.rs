//! Fisher information of the free parameters by its eigenvalues (Belsley, Kuh and Welsch 1980): how far each parameter is
//! determined, and which directions are not at all.

use nalgebra::{DMatrix, DVector};

use super::interval::ScaleEstimate;
use super::output_error::{Fit, Linearisation, Problem};

/// A parameter has no influence where its own share of the curvature, the recordings' nuisance parameters fitted, is below this share
/// of the whole ...
const DEAD_SHARE: f64 = 1e-9;
/// ... or so small that one noise standard deviation would move it by a million times its bounds.
const DEAD_CURVATURE: f64 = 1e-12;
/// A direction whose curvature is below this share of an average one is lost in the rounding of the derivatives: they are
/// forward differences with a relative error near 1e-6, and curvature is their square.
const NULL_CURVATURE: f64 = 1e-10;
/// A combination of parameters whose standard deviation exceeds this share of their bounds is as wide as an even draw from
/// them (1/√12).
const LOOSE_DIRECTION: f64 = 0.29;
/// A parameter takes part in a direction from this share on.
const TAKES_PART: f64 = 0.3;
/// ... and is untouched by one up to this share.
const UNTOUCHED: f64 = 1e-3;

/// A combination of parameters that the data do not determine.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Share of each free parameter, in units of its bounds; of length 1.
    pub axis: Vec<f64>,
    /// Whether nothing at all is known along it; otherwise it is only as wide as the bounds.
    pub null: bool,
}

impl Direction {
    /// Positions of the parameters that take part, the greatest share first.
    #[must_use]
    pub fn parts(&self) -> Vec<usize> {
        let mut parts: Vec<usize> = (0..self.axis.len()).filter(|&i| self.axis[i].abs() > TAKES_PART).collect();
        parts.sort_by(|a, b| self.axis[*b].abs().total_cmp(&self.axis[*a].abs()));
        parts
    }
}

/// What the data say of the free parameters, in their order.
#[derive(Debug, Clone)]
pub struct Information {
    /// Covariance for noise as stated, bounds ignored. Infinite on the diagonal, and 0 off it, for a parameter without
    /// influence or within a null direction; such a parameter leaves the others' entries as they would be without it.
    pub covariance: DMatrix<f64>,
    /// Directions of two parameters or more that the data leave open.
    pub directions: Vec<Direction>,
    /// Score of each free parameter (gradient of the log-likelihood) in its standard deviations: 0 in the interior; at a bound,
    /// positive or negative where the misfit falls beyond it.
    pub score: Vec<f64>,
}

impl Information {
    /// The information at `fit`.
    #[must_use]
    pub fn of(problem: &Problem, fit: &Fit, linear: &Linearisation, scale: &ScaleEstimate) -> Self {
        let (schur, score, whole) = problem.curvature(fit, linear);
        let n = problem.free.len();
        let spans: Vec<f64> = problem.free.iter().map(|&i| problem.simulator.parameters()[i].span()).collect();
        let live: Vec<usize> = (0..n)
            .filter(|&i| schur[(i, i)] > DEAD_SHARE * whole[i] && schur[(i, i)] * spans[i] * spans[i] > DEAD_CURVATURE)
            .collect();
        // In units of each parameter's own curvature, so that a sharp one does not drown the others in rounding.
        let unit: Vec<f64> = live.iter().map(|&i| schur[(i, i)].sqrt().recip()).collect();
        let scaled = DMatrix::from_fn(live.len(), live.len(), |a, b| schur[(live[a], live[b])] * unit[a] * unit[b]);
        let mut covariance: DMatrix<f64> = DMatrix::zeros(n, n);
        let mut null = Vec::new();
        if scaled.iter().all(|v| v.is_finite()) && !live.is_empty() {
            let eigen = scaled.symmetric_eigen();
            for (k, &curvature) in eigen.eigenvalues.iter().enumerate() {
                let axis = eigen.eigenvectors.column(k);
                if curvature < NULL_CURVATURE {
                    let step = (0..live.len()).map(|a| (live[a], axis[a] * unit[a] / spans[live[a]]));
                    let mut whole = DVector::zeros(n);
                    step.for_each(|(i, share)| whole[i] = share);
                    null.push(whole.normalize());
                    continue;
                }
                for (a, &i) in live.iter().enumerate() {
                    for (b, &j) in live.iter().enumerate() {
                        covariance[(i, j)] += axis[a] * axis[b] * unit[a] * unit[b] / curvature;
                    }
                }
            }
        }
        let sds = (0..n).map(|i| score[i] * (covariance[(i, i)] / (scale.variance * scale.inflation)).sqrt());
        let score = sds.map(|z: f64| if z.is_finite() { z } else { 0.0 }).collect();
        let mut directions = loose(&covariance, &spans, scale);
        let lost = |i: usize| !live.contains(&i) || null.iter().any(|axis| axis[i].abs() > UNTOUCHED);
        for i in (0..n).filter(|&i| lost(i)) {
            covariance.row_mut(i).fill(0.0);
            covariance.column_mut(i).fill(0.0);
            covariance[(i, i)] = f64::INFINITY;
        }
        directions.extend(plain(null).into_iter().map(|axis| Direction { axis, null: true }));
        directions.retain(|d| d.parts().len() > 1);
        Self { covariance, directions, score }
    }
}

/// The directions along which the bounds say as much as the data.
fn loose(covariance: &DMatrix<f64>, spans: &[f64], scale: &ScaleEstimate) -> Vec<Direction> {
    let n = spans.len();
    let scaled = DMatrix::from_fn(n, n, |i, j| covariance[(i, j)] / (spans[i] * spans[j]));
    if n < 2 || !scaled.iter().all(|v| v.is_finite()) {
        return Vec::new();
    }
    let eigen = scaled.symmetric_eigen();
    let wide = (0..n).filter(|&k| scale.sd(eigen.eigenvalues[k].max(0.0)) > LOOSE_DIRECTION);
    wide.map(|k| Direction { axis: eigen.eigenvectors.column(k).iter().copied().collect(), null: false }).collect()
}

/// The same space as `axes` span, by axes with as many zeros as elimination finds: two pairs of twins are two directions,
/// not two mixtures of them.
fn plain(mut axes: Vec<DVector<f64>>) -> Vec<Vec<f64>> {
    let count = axes.len();
    for k in 0..count {
        let pivot = axes[k].iamax();
        let lead = axes[k][pivot];
        if lead.abs() < UNTOUCHED {
            continue;
        }
        axes[k] /= lead;
        for other in (0..count).filter(|&o| o != k) {
            let share = axes[other][pivot];
            let less = &axes[k] * share;
            axes[other] -= less;
        }
    }
    let length = |axis: &DVector<f64>| axis.norm() > UNTOUCHED;
    axes.into_iter().filter(length).map(|axis| axis.normalize().iter().copied().collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixed_twins_come_apart() {
        // (1, −1, 0, 0) and (0, 0, 1, −1), turned by 30°.
        let (c, s) = (0.75f64.sqrt(), 0.5);
        let mixed = [[c, -c, s, -s], [-s, s, c, -c]].map(|a| DVector::from_row_slice(&a).normalize());
        let mut found = plain(mixed.to_vec());
        found.iter_mut().flatten().for_each(|v| *v = (*v * 1e9).round() / 1e9);
        for axis in &found {
            let direction = Direction { axis: axis.clone(), null: true };
            let mut parts = direction.parts();
            parts.sort_unstable();
            assert!(parts == [0, 1] || parts == [2, 3], "{axis:?}");
            assert_eq!(axis[parts[0]], -axis[parts[1]]);
        }
        assert_eq!(found.len(), 2);
    }
}
