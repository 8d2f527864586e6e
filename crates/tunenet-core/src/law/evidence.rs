//! Evidence of a residual force: a Gaussian process of the acceleration against none (Rasmussen and Williams 2006, section 5.4).

use nalgebra::{DMatrix, DVector};

use super::response::{Response, inverse_root};
use crate::estimate::jacobian::Columns;

/// Correlation lengths of the acceleration, as shares of a recording.
const LENGTHS: [f64; 3] = [0.04, 0.12, 0.4];
/// Its variance: values on a logarithmic grid, in units of what changes the record by its noise.
const VARIANCES: i32 = 33;
const DECADES: (f64, f64) = (-5.0, 3.0);

/// The greatest logarithm of the odds, in nats, for an acceleration that varies smoothly in time, about the residuals of a fit; what its
/// shared parameters explain by their derivatives (`columns`) does not count.
pub(super) fn residual_force(response: &Response, residuals: &[Vec<f64>], columns: &[Columns]) -> f64 {
    let n = response.dimension();
    let residual = response.coordinates(residuals);
    let shared = columns.first().map_or(0, |c| c.shared.len());
    let tangent = |j: usize| response.coordinates(&columns.iter().map(|c| c.shared[j].clone()).collect::<Vec<_>>());
    let tangents: Vec<DVector<f64>> = (0..shared).map(tangent).collect();
    let columns = DMatrix::from_fn(n, tangents.len(), |i, j| tangents[j][i]);
    let known = &columns * inverse_root(&(columns.transpose() * &columns));
    let project = |m: DMatrix<f64>| {
        let explained = &known * (known.transpose() * &m);
        m - explained
    };
    let left = project(DMatrix::from_column_slice(n, 1, residual.as_slice()));
    let mut best = 0.0_f64;
    for length in LENGTHS {
        let mut process = DMatrix::zeros(n, n);
        let mut at = 0;
        for part in &response.parts {
            let pieces = part.visits.len();
            let length = length * pieces as f64;
            let kernel = DMatrix::from_fn(pieces, pieces, |i, j| {
                let apart = (i as f64 - j as f64) / length;
                (-0.5 * apart * apart).exp()
            });
            let rows = part.residual.len();
            let mut block = DMatrix::zeros(rows, rows);
            for axis in &part.axes {
                block += axis * &kernel * axis.transpose();
            }
            process.view_mut((at, at), (rows, rows)).copy_from(&block);
            at += rows;
        }
        let once = project(process).transpose();
        let process = project(once);
        let symmetric = (&process + process.transpose()) * 0.5;
        if symmetric.iter().any(|v| !v.is_finite()) {
            return f64::INFINITY;
        }
        let eigen = symmetric.symmetric_eigen();
        let along = eigen.eigenvectors.transpose() * &left;
        // The mean of the eigenvalues makes the variance free of units.
        let scale = (eigen.eigenvalues.iter().map(|e| e.max(0.0)).sum::<f64>() / n as f64).max(f64::MIN_POSITIVE);
        for k in 0..VARIANCES {
            let share = f64::from(k) / f64::from(VARIANCES - 1);
            let variance = 10.0_f64.powf(DECADES.0 + share * (DECADES.1 - DECADES.0)) / scale;
            let each = eigen.eigenvalues.iter().zip(along.iter()).map(|(e, z)| {
                let more = 1.0 + variance * e.max(0.0);
                0.5 * z * z * (1.0 - more.recip()) - 0.5 * more.ln()
            });
            best = best.max(each.sum());
        }
    }
    best
}
