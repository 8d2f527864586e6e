//! Evidence of a residual force: Bayes factor of a Gaussian process of the acceleration against none (Rasmussen and Williams 2006, section
//! 5.4), averaged over its length and its variance (Kass and Raftery 1995). The average has odds of k to one with a probability of at most
//! 1/k by chance; the greatest value has not.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::response::{Part, Response, inverse_root, root};
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
/// its shared parameters may explain by their derivatives (`columns`) does not count. Time in proportion to the number of recordings: the
/// process is one of its own in each of them, and the parameters follow by the matrix inversion lemma (Rasmussen and Williams 2006, A.3).
pub(super) fn residual_force(response: &Response, residuals: &[Vec<f64>], columns: &[Columns], of: Shared) -> f64 {
    let n = response.dimension();
    let residual = response.coordinates(residuals);
    let shared = columns.first().map_or(0, |c| c.shared.len());
    let tangent = |j: usize| response.coordinates(&columns.iter().map(|c| c.shared[j].clone()).collect::<Vec<_>>());
    let tangents: Vec<DVector<f64>> = (0..shared).map(tangent).collect();
    let columns = DMatrix::from_fn(n, tangents.len(), |i, j| tangents[j][i]);
    let known = match of {
        Shared::Free => {
            let directions = &columns * inverse_root(&(columns.transpose() * &columns));
            let precision = DVector::zeros(directions.ncols());
            Known { directions, precision }
        }
        Shared::Known(covariance) => uncertain(&columns, covariance),
    };
    let mut odds = Vec::new();
    for length in LENGTHS {
        let Some(process) = Process::of(response, length, &residual, &known) else { return f64::INFINITY };
        // The mean of its eigenvalues makes the variance free of units.
        let scale = (process.trace / n as f64).max(f64::MIN_POSITIVE);
        for k in 0..VARIANCES {
            let share = f64::from(k) / f64::from(VARIANCES - 1);
            let variance = 10.0_f64.powf(DECADES.0 + share * (DECADES.1 - DECADES.0)) / scale;
            odds.push(process.log_odds(variance, &known.precision));
        }
    }
    log_mean_exp(&odds).max(0.0)
}

/// What the shared parameters can change: orthonormal directions U, and along each the inverse of the variance that their uncertainty adds to
/// that of the noise, 0 where nothing is known of them.
struct Known {
    directions: DMatrix<f64>,
    precision: DVector<f64>,
}

/// The covariance of one recording in coordinates in which it is tridiagonal, and there the residuals and directions of parameters, shape
/// `[coordinate, 1 + direction]`.
struct Block {
    diagonal: Vec<f64>,
    off_diagonal: Vec<f64>,
    along: DMatrix<f64>,
}

/// The process of all recordings; with W the inverse root of what noise and parameters spread, without a process.
struct Process {
    blocks: Vec<Block>,
    /// The trace of W K W.
    trace: f64,
    /// |W r|².
    squares: f64,
}

impl Process {
    /// Of accelerations that are correlated over this share of a recording; `None` where a number is not finite.
    fn of(response: &Response, length: f64, residual: &DVector<f64>, known: &Known) -> Option<Self> {
        let mut first = Vec::new();
        let mut at = 0;
        for part in &response.parts {
            first.push(at);
            at += part.residual.len();
        }
        let used = |(_, part): &(&usize, &Part)| !part.residual.is_empty();
        let parts: Vec<(&usize, &Part)> = first.iter().zip(&response.parts).filter(used).collect();
        let one = |&(&at, part): &(&usize, &Part)| {
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
            let directions = known.directions.rows(at, rows);
            let along = DMatrix::from_fn(rows, 1 + directions.ncols(), |i, j| {
                if j == 0 { residual[at + i] } else { directions[(i, j - 1)] }
            });
            (block, along)
        };
        Self::new(&parts.par_iter().map(one).collect::<Vec<_>>(), &known.precision)
    }

    /// Of the covariance of each recording, and its residuals and directions as a [`Block`] has them.
    fn new(blocks: &[(DMatrix<f64>, DMatrix<f64>)], precision: &DVector<f64>) -> Option<Self> {
        let (mut trace, mut squares) = (0.0, 0.0);
        let mut along_residual = DVector::zeros(precision.len());
        for (block, along) in blocks {
            let (residual, directions) = (along.column(0), along.columns(1, precision.len()));
            trace += block.trace();
            squares += residual.norm_squared();
            along_residual += directions.tr_mul(&residual);
            for (direction, precision) in directions.column_iter().zip(precision.iter()) {
                trace -= direction.dot(&(block * direction)) / (1.0 + precision);
            }
        }
        for (along, precision) in along_residual.iter().zip(precision.iter()) {
            squares -= along * along / (1.0 + precision);
        }
        let tridiagonal = |(block, along): &(DMatrix<f64>, DMatrix<f64>)| {
            let symmetric = (block + block.transpose()) * 0.5;
            if symmetric.iter().chain(along.iter()).any(|v| !v.is_finite()) {
                return None;
            }
            let (axes, diagonal, off_diagonal) = symmetric.symmetric_tridiagonalize().unpack();
            let (diagonal, off_diagonal) = (diagonal.as_slice().to_vec(), off_diagonal.as_slice().to_vec());
            Some(Block { diagonal, off_diagonal, along: axes.tr_mul(along) })
        };
        let blocks: Option<Vec<Block>> = blocks.par_iter().map(tridiagonal).collect();
        Some(Self { blocks: blocks?, trace, squares })
    }

    /// ½ |W r|² − ½ rᵀ W (1 + variance · W K W)⁻¹ W r − ½ ln det(1 + variance · W K W): with A = 1 + variance · K, that is
    /// W (A + U Λ Uᵀ) W, where Λ is the inverse of `precision`.
    fn log_odds(&self, variance: f64, precision: &DVector<f64>) -> f64 {
        let parameters = precision.len();
        let mut products = DMatrix::zeros(1 + parameters, 1 + parameters);
        let mut log_det = 0.0;
        for block in &self.blocks {
            log_det += block.solve(variance, &mut products);
        }
        let mut quadratic = products[(0, 0)];
        if parameters > 0 {
            let mut inner = products.view((1, 1), (parameters, parameters)).into_owned();
            for (i, precision) in precision.iter().enumerate() {
                inner[(i, i)] += precision;
            }
            let Some(factor) = inner.cholesky() else { return f64::NEG_INFINITY };
            let along = products.view((1, 0), (parameters, 1)).into_owned();
            quadratic -= along.dot(&factor.solve(&along));
            log_det += 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
            log_det -= precision.iter().map(|precision| precision.ln_1p()).sum::<f64>();
        }
        0.5 * (self.squares - quadratic - log_det)
    }
}

impl Block {
    /// Adds Bᵀ A⁻¹ B to `products`, with B what stands in `along` and A = 1 + variance · T, where T is tridiagonal: by A = L D Lᵀ (Golub and
    /// Van Loan 2013, section 4.3.6). The logarithm of the determinant of A.
    fn solve(&self, variance: f64, products: &mut DMatrix<f64>) -> f64 {
        let mut solved = DVector::zeros(self.along.ncols());
        let (mut log_det, mut pivot) = (0.0, 1.0);
        for (i, (own, row)) in self.diagonal.iter().zip(self.along.row_iter()).enumerate() {
            let coupling = if i == 0 { 0.0 } else { variance * self.off_diagonal[i - 1] };
            let factor = coupling / pivot;
            // T has no negative eigenvalues but those of rounding.
            pivot = (1.0 + variance * own - factor * coupling).max(f64::MIN_POSITIVE);
            solved = row.transpose() - solved * factor;
            products.ger(1.0 / pivot, &solved, &solved, 1.0);
            log_det += pivot.ln();
        }
        log_det
    }
}

/// The logarithm of the mean of these exponentials.
fn log_mean_exp(all: &[f64]) -> f64 {
    let greatest = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if greatest.is_finite() { greatest + mean(all.iter().map(|one| (one - greatest).exp())).ln() } else { greatest }
}

/// What parameters with this covariance spread, whose derivatives are `columns`: `columns` · Σ · `columns`ᵀ = U Λ Uᵀ.
fn uncertain(columns: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Known {
    let spread = columns * root(covariance);
    let eigen = (spread.transpose() * &spread).symmetric_eigen();
    let greatest = eigen.eigenvalues.iter().fold(0.0_f64, |most, v| most.max(*v));
    let kept: Vec<usize> = (0..eigen.eigenvalues.len()).filter(|&i| eigen.eigenvalues[i] > 1e-10 * greatest).collect();
    let right = DMatrix::from_fn(spread.ncols(), kept.len(), |i, j| {
        eigen.eigenvectors[(i, kept[j])] / eigen.eigenvalues[kept[j]].sqrt()
    });
    let precision = DVector::from_fn(kept.len(), |i, _| eigen.eigenvalues[kept[i]].recip());
    Known { directions: spread * right, precision }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ½ zᵀz − ½ zᵀ (1 + variance · W K W)⁻¹ z − ½ ln det(1 + variance · W K W) of z = W r, with dense matrices.
    fn dense(process: &DMatrix<f64>, residual: &DVector<f64>, weight: &DMatrix<f64>, variance: f64) -> f64 {
        let n = residual.len();
        let spread = DMatrix::identity(n, n) + weight * process * weight * variance;
        let z = weight * residual;
        let factor = spread.cholesky().unwrap();
        let log_det = 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        0.5 * (z.norm_squared() - z.dot(&factor.solve(&z)) - log_det)
    }

    /// Two recordings of three coordinates, and two parameters of which nothing or much is known.
    #[test]
    fn the_odds_of_blocks_are_those_of_dense_matrices() {
        let root =
            DMatrix::from_fn(
                6,
                6,
                |i, j| {
                    if i / 3 == j / 3 { (1.0 + i as f64 * 7.3 + j as f64 * 2.1).sin() } else { 0.0 }
                },
            );
        let process = &root * root.transpose();
        let residual = DVector::from_fn(6, |i, _| (1.7 * i as f64).cos());
        let directions = DMatrix::from_fn(6, 2, |i, j| (0.3 + i as f64 * (1.0 + j as f64)).sin()).qr().q();
        for precision in [[0.0, 0.0], [0.5, 20.0]] {
            let precision = DVector::from_row_slice(&precision);
            let share = precision.map(|precision: f64| 1.0 - (precision / (1.0 + precision)).sqrt());
            let weight =
                DMatrix::identity(6, 6) - &directions * DMatrix::from_diagonal(&share) * directions.transpose();
            let block = |at: usize| {
                let along =
                    DMatrix::from_fn(3, 3, |i, j| if j == 0 { residual[at + i] } else { directions[(at + i, j - 1)] });
                (process.view((at, at), (3, 3)).into_owned(), along)
            };
            let found = Process::new(&[block(0), block(3)], &precision).unwrap();
            let trace = (&weight * &process * &weight).trace();
            assert!((found.trace - trace).abs() < 1e-9, "{} {trace}", found.trace);
            for variance in [1e-5, 0.3, 1e3] {
                let wanted = dense(&process, &residual, &weight, variance);
                let odds = found.log_odds(variance, &precision);
                assert!((odds - wanted).abs() < 1e-8 * wanted.abs().max(1.0), "{odds} {wanted}");
            }
        }
    }

    #[test]
    fn odds_are_averaged_and_not_their_logarithms() {
        let odds = [2.0_f64, 8.0, 0.5];
        assert!((log_mean_exp(&odds.map(f64::ln)) - 3.5_f64.ln()).abs() < 1e-12);
        assert_eq!(log_mean_exp(&[1_000.0, 1_000.0]), 1_000.0);
        assert_eq!(log_mean_exp(&[f64::INFINITY, 0.0]), f64::INFINITY);
    }

    /// Of one parameter, U is its derivative at length 1, and Λ the square of what its deviation changes.
    #[test]
    fn an_uncertain_parameter_spreads_what_its_deviation_changes() {
        let column = DMatrix::from_column_slice(3, 1, &[3.0, 0.0, 4.0]);
        let known = uncertain(&column, &DMatrix::from_element(1, 1, 0.09));
        // |column| = 5 and sd 0.3: 1.5.
        assert!((known.precision[0] - 1.0 / 2.25).abs() < 1e-12, "{}", known.precision);
        let directions = &known.directions;
        assert!((directions[(0, 0)].abs() - 0.6).abs() < 1e-12 && (directions[(2, 0)].abs() - 0.8).abs() < 1e-12);
    }
}
