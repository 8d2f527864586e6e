//! Evidence of a residual force: Bayes factor of a Gaussian process of the acceleration against none (Rasmussen and Williams 2006, section
//! 5.4), averaged over its length and its variance (Kass and Raftery 1995). The average has odds of k to one with a probability of at most
//! 1/k by chance; the greatest value has not.

use nalgebra::{DMatrix, DVector};

use super::response::{Response, inverse_root, root};
use crate::estimate::jacobian::Columns;
use crate::statistics::mean;

/// Correlation lengths of the acceleration, as shares of a recording.
const LENGTHS: [f64; 3] = [0.04, 0.12, 0.4];
/// Its variance: values on a logarithmic grid, in units of what changes the record by its noise.
const VARIANCES: i32 = 33;
const DECADES: (f64, f64) = (-5.0, 3.0);

/// What is known of the shared parameters whose derivatives stand in the columns.
#[derive(Clone, Copy)]
pub(super) enum Shared<'a> {
    /// Nothing: what they explain does not count.
    Free,
    /// They were fitted to other recordings, with this covariance.
    Known(&'a DMatrix<f64>),
}

/// The logarithm of the odds, in nats and not below 0, for an acceleration that varies smoothly in time, about the residuals of a fit; what
/// its shared parameters may explain by their derivatives (`columns`) does not count.
pub(super) fn residual_force(response: &Response, residuals: &[Vec<f64>], columns: &[Columns], of: Shared) -> f64 {
    let n = response.dimension();
    let residual = response.coordinates(residuals);
    let shared = columns.first().map_or(0, |c| c.shared.len());
    let tangent = |j: usize| response.coordinates(&columns.iter().map(|c| c.shared[j].clone()).collect::<Vec<_>>());
    let tangents: Vec<DVector<f64>> = (0..shared).map(tangent).collect();
    let columns = DMatrix::from_fn(n, tangents.len(), |i, j| tangents[j][i]);
    // The inverse root of the residuals' covariance: directions of the parameters weigh less, or nothing.
    let (known, share) = match of {
        Shared::Free => {
            let known = &columns * inverse_root(&(columns.transpose() * &columns));
            let share = DVector::from_element(known.ncols(), 1.0);
            (known, share)
        }
        Shared::Known(covariance) => uncertain(&columns, covariance),
    };
    let project = |m: DMatrix<f64>| {
        let mut along = known.transpose() * &m;
        for (mut row, share) in along.row_iter_mut().zip(share.iter()) {
            row *= *share;
        }
        m - &known * along
    };
    let left = project(DMatrix::from_column_slice(n, 1, residual.as_slice()));
    let mut odds = Vec::new();
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
        // In these coordinates the process is tridiagonal; the mean of its eigenvalues makes the variance free of units.
        let (axes, diagonal, off_diagonal) = symmetric.symmetric_tridiagonalize().unpack();
        let along = axes.tr_mul(&left);
        let scale = (diagonal.sum() / n as f64).max(f64::MIN_POSITIVE);
        for k in 0..VARIANCES {
            let share = f64::from(k) / f64::from(VARIANCES - 1);
            let variance = 10.0_f64.powf(DECADES.0 + share * (DECADES.1 - DECADES.0)) / scale;
            odds.push(log_odds(diagonal.as_slice(), off_diagonal.as_slice(), along.as_slice(), variance));
        }
    }
    log_mean_exp(&odds).max(0.0)
}

/// The logarithm of the mean of these exponentials.
fn log_mean_exp(all: &[f64]) -> f64 {
    let greatest = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if greatest.is_finite() { greatest + mean(all.iter().map(|one| (one - greatest).exp())).ln() } else { greatest }
}

/// ½ zᵀz − ½ zᵀ A⁻¹ z − ½ ln det A with A = 1 + variance · T, where T is symmetric and tridiagonal with these numbers on its diagonal and
/// next to it: by A = L D Lᵀ (Golub and Van Loan 2013, section 4.3.6).
fn log_odds(diagonal: &[f64], off_diagonal: &[f64], z: &[f64], variance: f64) -> f64 {
    let (mut odds, mut pivot, mut solved) = (0.0, 1.0, 0.0);
    for (i, (&own, &z)) in diagonal.iter().zip(z).enumerate() {
        let coupling = if i == 0 { 0.0 } else { variance * off_diagonal[i - 1] };
        let factor = coupling / pivot;
        // T has no negative eigenvalues but those of rounding.
        pivot = (1.0 + variance * own - factor * coupling).max(f64::MIN_POSITIVE);
        solved = z - factor * solved;
        odds += 0.5 * (z * z - solved * solved / pivot - pivot.ln());
    }
    odds
}

/// Orthonormal directions U of `columns` · Σ · `columns`ᵀ and the shares by which (1 + that)^(−1/2) = 1 − U diag(share) Uᵀ.
fn uncertain(columns: &DMatrix<f64>, covariance: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let spread = columns * root(covariance);
    let eigen = (spread.transpose() * &spread).symmetric_eigen();
    let greatest = eigen.eigenvalues.iter().fold(0.0_f64, |most, v| most.max(*v));
    let kept: Vec<usize> = (0..eigen.eigenvalues.len()).filter(|&i| eigen.eigenvalues[i] > 1e-10 * greatest).collect();
    let right = DMatrix::from_fn(spread.ncols(), kept.len(), |i, j| {
        eigen.eigenvectors[(i, kept[j])] / eigen.eigenvalues[kept[j]].sqrt()
    });
    let share = DVector::from_fn(kept.len(), |i, _| 1.0 - (1.0 + eigen.eigenvalues[kept[i]]).sqrt().recip());
    (spread * right, share)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same by eigenvalues, of a positive matrix without structure.
    #[test]
    fn the_odds_are_those_of_the_eigenvalues() {
        let root = DMatrix::from_fn(6, 6, |i, j| (1.0 + i as f64 * 7.3 + j as f64 * 2.1).sin());
        let process = &root * root.transpose();
        let z = DVector::from_fn(6, |i, _| (1.7 * i as f64).cos());
        let eigen = process.clone().symmetric_eigen();
        let (axes, diagonal, off_diagonal) = process.symmetric_tridiagonalize().unpack();
        let turned = axes.tr_mul(&z);
        let along = eigen.eigenvectors.tr_mul(&z);
        for variance in [1e-5, 0.3, 1e3] {
            let each = eigen.eigenvalues.iter().zip(along.iter()).map(|(e, z)| {
                let more = 1.0 + variance * e;
                0.5 * z * z * (1.0 - more.recip()) - 0.5 * more.ln()
            });
            let wanted: f64 = each.sum();
            let found = log_odds(diagonal.as_slice(), off_diagonal.as_slice(), turned.as_slice(), variance);
            assert!((found - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{found} {wanted}");
        }
    }

    #[test]
    fn odds_are_averaged_and_not_their_logarithms() {
        let odds = [2.0_f64, 8.0, 0.5];
        assert!((log_mean_exp(&odds.map(f64::ln)) - 3.5_f64.ln()).abs() < 1e-12);
        assert_eq!(log_mean_exp(&[1_000.0, 1_000.0]), 1_000.0);
        assert_eq!(log_mean_exp(&[f64::INFINITY, 0.0]), f64::INFINITY);
    }

    /// Of one direction with variance s², (1 + s² u uᵀ)^(−1/2) = 1 − (1 − 1/√(1 + s²)) u uᵀ.
    #[test]
    fn an_uncertain_parameter_takes_the_share_of_its_closed_form() {
        let column = DMatrix::from_column_slice(3, 1, &[3.0, 0.0, 4.0]);
        let (directions, share) = uncertain(&column, &DMatrix::from_element(1, 1, 0.04));
        // |column| = 5 and sd 0.2: s = 1.
        assert!((share[0] - (1.0 - 0.5_f64.sqrt())).abs() < 1e-12, "{share}");
        assert!((directions[(0, 0)].abs() - 0.6).abs() < 1e-12 && (directions[(2, 0)].abs() - 0.8).abs() < 1e-12);
    }
}
