//! Restricted likelihood of two variance components (Patterson and Thompson 1971): the error of each event's time alone, and the
//! scatter of each event that shifts all later ones.
//!
//! An event that leads to intervals longer by a share ε than the model's delays every later event by ε times the time between
//! the two. Least squares counts the residuals that this leaves as independent, and its interval is several times too narrow.
//! So the variance of its estimate is taken under C = I + λ S Sᵀ, averaged over the restricted likelihood of λ and an even
//! prior of its logarithm: a few events seldom determine λ, and its most likely value leaves intervals too narrow.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::output_error::{Fit, Linearisation, Problem};
use crate::observation::Kind;

/// Ratios λ of the second component to the first that are averaged over, evenly spaced in their logarithm; below the least, the
/// second does not matter.
const LEAST_RATIO: f64 = 1e-2;
const GREATEST_RATIO: f64 = 1e8;
const RATIOS: i32 = 31;
/// Singular values of the derivatives below this share of the largest belong to what the events do not determine.
const LEAST_SINGULAR: f64 = 1e-7;
/// Lists longer than this are thinned to about as many events: they determine the ratio well enough.
const MOST_EVENTS: usize = 60;

/// The events of one recording: their derivatives, residuals, and how the scatter of each shifts the others.
struct Events {
    /// Shape `[event, parameter]`, nuisance parameters of all recordings included.
    derivatives: DMatrix<f64>,
    residual: DVector<f64>,
    /// Covariance of the second component, of mean 1 on the diagonal.
    scatter: DMatrix<f64>,
}

impl Events {
    /// From the instants of the events, in any unit.
    fn new(derivatives: DMatrix<f64>, residual: DVector<f64>, instants: &[f64]) -> Self {
        let count = instants.len();
        let shift = DMatrix::from_fn(count, count, |n, j| (instants[n] - instants[j]).max(0.0));
        let scatter = &shift * shift.transpose();
        let mean = (scatter.trace() / count as f64).max(f64::MIN_POSITIVE);
        Self { derivatives, residual, scatter: scatter / mean }
    }
}

impl Problem<'_> {
    /// By how much the variance of the worst parameter exceeds that of independent residuals of this `variance`; `None` where
    /// the recordings are no event times, or nothing is free. 1 or more.
    pub(super) fn accumulated_inflation(&self, fit: &Fit, linear: &Linearisation, variance: f64) -> Option<f64> {
        let shared = self.free.len();
        if shared == 0 || variance <= 0.0 || self.recordings.iter().any(|r| r.seen.kind() != Kind::EventTimes) {
            return None;
        }
        let columns = &linear.columns;
        let width = shared + columns.iter().map(|c| c.nuisances.len()).sum::<usize>();
        let (mut events, mut first) = (Vec::new(), shared);
        for ((one, recording), residual) in columns.iter().zip(self.recordings).zip(&fit.residuals) {
            let kept: Vec<usize> = (0..residual.len()).step_by(residual.len().div_ceil(MOST_EVENTS).max(1)).collect();
            let mut derivatives = DMatrix::zeros(kept.len(), width);
            for (row, &n) in kept.iter().enumerate() {
                for (i, column) in one.shared.iter().enumerate() {
                    derivatives[(row, i)] = column[n];
                }
                for (i, column) in one.nuisances.iter().enumerate() {
                    derivatives[(row, first + i)] = column[n];
                }
            }
            first += one.nuisances.len();
            let instants: Vec<f64> = kept.iter().map(|&n| recording.seen.row(n)[0]).collect();
            events.push(Events::new(derivatives, DVector::from_fn(kept.len(), |k, _| residual[kept[k]]), &instants));
        }
        inflation(&events, shared).map(|ratio| (ratio / variance).max(1.0))
    }
}

/// The variance of the least-squares estimate of each of the first `shared` parameters under both components, in units of
/// its variance for independent residuals of variance 1: that of the worst. `None` where no residual is free.
fn inflation(events: &[Events], shared: usize) -> Option<f64> {
    let width = events.first()?.derivatives.ncols();
    let count: usize = events.iter().map(|e| e.residual.len()).sum();
    let mut derivatives = DMatrix::zeros(count, width);
    let mut first = 0;
    for one in events {
        derivatives.view_mut((first, 0), (one.residual.len(), width)).copy_from(&one.derivatives);
        first += one.residual.len();
    }
    // In units of each column, so that a coordinate's unit does not decide which direction counts.
    let unit: Vec<f64> =
        derivatives.column_iter().map(|c| c.norm()).map(|n| if n > 0.0 { 1.0 / n } else { 0.0 }).collect();
    derivatives.column_iter_mut().zip(&unit).for_each(|(mut column, unit)| column *= *unit);
    let svd = derivatives.svd(true, true);
    let (basis, turned) = (svd.u?, svd.v_t?);
    let rank: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > LEAST_SINGULAR * svd.singular_values[0])
        .collect();
    let degrees_of_freedom = count as f64 - rank.len() as f64;
    if degrees_of_freedom < 1.0 {
        return None;
    }
    let basis = DMatrix::from_fn(count, rank.len(), |n, k| basis[(n, rank[k])]);
    // The linear combination of the residuals that is the estimate of each shared parameter, in units of its column.
    let combination = |i: usize| -> DVector<f64> {
        let share = DVector::from_fn(rank.len(), |k, _| turned[(rank[k], i)] / svd.singular_values[rank[k]]);
        &basis * share
    };
    let combinations: Vec<DVector<f64>> = (0..shared).map(combination).filter(|c| c.norm() > 0.0).collect();
    let mut weighted = Vec::new();
    for step in 0..RATIOS {
        let share = f64::from(step) / f64::from(RATIOS - 1);
        let ratio = LEAST_RATIO * (GREATEST_RATIO / LEAST_RATIO).powf(share);
        let found = at_ratio(events, &basis, &combinations, degrees_of_freedom, if step == 0 { 0.0 } else { ratio })?;
        weighted.push(found);
    }
    let most = weighted.iter().map(|(log, _)| *log).fold(f64::NEG_INFINITY, f64::max);
    let weights = weighted.iter().map(|(log, _)| (log - most).exp());
    let sum: f64 = weights.clone().sum();
    Some(weights.zip(&weighted).map(|(weight, (_, variance))| weight * variance).sum::<f64>() / sum)
}

/// The logarithm of the restricted likelihood at this ratio, and the variance of the worst combination.
fn at_ratio(
    events: &[Events],
    basis: &DMatrix<f64>,
    combinations: &[DVector<f64>],
    degrees_of_freedom: f64,
    ratio: f64,
) -> Option<(f64, f64)> {
    let rank = basis.ncols();
    let (mut normal, mut right) = (DMatrix::zeros(rank, rank), DVector::zeros(rank));
    let (mut log_determinant, mut square, mut first) = (0.0, 0.0, 0);
    let mut variances = vec![0.0; combinations.len()];
    for one in events {
        let count = one.residual.len();
        let covariance = DMatrix::identity(count, count) + &one.scatter * ratio;
        for (sum, combination) in variances.iter_mut().zip(combinations) {
            let part = combination.rows(first, count);
            *sum += part.dot(&(&covariance * part));
        }
        let cholesky = Cholesky::new(covariance)?;
        let rows = basis.rows(first, count).into_owned();
        let (solved, residual) = (cholesky.solve(&rows), cholesky.solve(&one.residual));
        normal += rows.transpose() * solved;
        right += rows.transpose() * &residual;
        square += one.residual.dot(&residual);
        log_determinant += 2.0 * cholesky.l().diagonal().map(f64::ln).sum();
        first += count;
    }
    let cholesky = Cholesky::new(normal)?;
    let left = (square - right.dot(&cholesky.solve(&right))).max(f64::MIN_POSITIVE);
    log_determinant += 2.0 * cholesky.l().diagonal().map(f64::ln).sum();
    let log_likelihood = -0.5 * (log_determinant + degrees_of_freedom * left.ln());
    let size = left / degrees_of_freedom;
    let relative = variances.iter().zip(combinations).map(|(variance, c)| size * variance / c.norm_squared());
    Some((log_likelihood, relative.fold(0.0, f64::max)))
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_distr::StandardNormal;

    use super::*;
    use crate::statistics::student_quantile;

    /// Twelve events a second apart, with an unknown start and interval. The interval by least squares, and its 95 % interval,
    /// of 500 lists with these errors of each event and of all later ones, s: the share that holds the truth, and the
    /// mean half-width.
    fn coverage(own: f64, later: f64) -> (f64, f64) {
        let count = 12;
        let instants: Vec<f64> = (0..count).map(f64::from).collect();
        let derivatives = DMatrix::from_fn(12, 2, |n, i| if i == 0 { instants[n] } else { 1.0 });
        let pseudo = derivatives.clone().pseudo_inverse(1e-12).unwrap();
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(11);
        let (mut held, mut sum) = (0, 0.0);
        for _ in 0..500 {
            let shifts: Vec<f64> = (0..12).map(|_| later * draw.sample::<f64, _>(StandardNormal)).collect();
            let values = DVector::from_fn(12, |n, _| {
                let scatter: f64 = (0..n).map(|j| shifts[j] * (instants[n] - instants[j])).sum();
                scatter + own * draw.sample::<f64, _>(StandardNormal)
            });
            let estimate = &pseudo * &values;
            let residual = &values - &derivatives * &estimate;
            let events = Events::new(derivatives.clone(), residual, &instants);
            let variance = inflation(&[events], 1).unwrap() * pseudo.row(0).norm_squared();
            let half_width = student_quantile(0.975, 10.0) * variance.sqrt();
            held += i32::from(estimate[0].abs() <= half_width);
            sum += half_width / 500.0;
        }
        (f64::from(held) / 500.0, sum)
    }

    #[test]
    fn intervals_hold_whichever_component_prevails() {
        let (alone, narrow) = coverage(1e-3, 0.0);
        let (both, _) = coverage(1e-3, 1e-3);
        let (later, _) = coverage(1e-6, 1e-3);
        // Where the ratio is uncertain, the average over it is on the safe side.
        assert!((0.92..=0.98).contains(&later) && [alone, both].iter().all(|c| *c > 0.94), "{alone} {both} {later}");
        // The closed form for independent errors: t · 1e-3 / √Σ(n − n̄)².
        let closed = student_quantile(0.975, 10.0) * 1e-3 / 143f64.sqrt();
        // Twelve events cannot exclude that a little of their errors adds up.
        assert!((1.0..12.0).contains(&(narrow / closed)), "{narrow} instead of {closed}");
    }
}
