//! Fisher information and score of shared parameters in one recording (Ljung 1999, section 7.4).

use nalgebra::{DMatrix, DVector};

use super::response::inverse_root;
use crate::estimate::jacobian::Columns;

/// Residuals in units of what a law leaves.
pub(super) fn scaled(residuals: &[Vec<f64>], scale: f64) -> Vec<Vec<f64>> {
    residuals.iter().map(|all| all.iter().map(|r| r / scale).collect()).collect()
}

/// What a recording says of shared parameters, its own ones fitted: the information, and the slope.
pub(super) fn said(columns: &Columns, residual: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
    let rows = residual.len();
    let matrix = |of: &[Vec<f64>]| DMatrix::from_fn(rows, of.len(), |i, j| of[j][i]);
    let own = matrix(&columns.nuisances);
    let own = &own * inverse_root(&(own.transpose() * &own));
    let clean = |m: DMatrix<f64>| {
        let explained = &own * (own.transpose() * &m);
        m - explained
    };
    let (c, r) = (clean(matrix(&columns.shared)), clean(DMatrix::from_column_slice(rows, 1, residual)));
    (c.transpose() * &c, (c.transpose() * r).column(0).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line through the origin with an offset of each recording: the slope's information is the sum of squares about the mean.
    #[test]
    fn information_is_what_nuisances_leave() {
        let columns = Columns { indices: vec![0], shared: vec![vec![0.0, 1.0, 2.0]], nuisances: vec![vec![1.0; 3]] };
        let (information, score) = said(&columns, &[1.0, 1.0, 4.0]);
        assert!((information[(0, 0)] - 2.0).abs() < 1e-12 && (score[0] - 3.0).abs() < 1e-12, "{information} {score}");
    }
}
