//! Derivatives that a fit goes on with: measured each, measured for several parameters by one rollout, or following the residuals from step
//! to step by a rank-one formula (Broyden 1965).

use super::jacobian::{Columns, grouped_jacobian, jacobian};
use super::problem::{LeastSquares, Point};
use crate::Result;

/// Where the derivatives of a step come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// They followed the steps, or are those of a point not far away.
    Followed,
    /// Several were measured by one rollout at the point.
    Grouped,
    /// Each was measured at the point.
    Measured,
}

impl Origin {
    /// Whether a fit may end with them.
    pub fn may_end(self, ends_measured: bool) -> bool {
        self == Self::Measured || self == Self::Grouped && !ends_measured
    }
}

/// Derivatives as they were measured, and how far the fit has gone since, in standard deviations of the estimate.
pub(super) struct Exact {
    pub columns: Option<Vec<Columns>>,
    pub moved_sds: f64,
}

impl Exact {
    /// None yet.
    pub fn none() -> Self {
        Self { columns: None, moved_sds: f64::INFINITY }
    }
}

/// How many rollouts the derivatives take.
pub(super) fn column_count(problem: &dyn LeastSquares) -> usize {
    let count = |&d: &usize| problem.touched(d).len() + problem.nuisances(d).len();
    problem.recordings().iter().map(count).sum()
}

/// The derivatives at a point; `rollouts` grows by those that they take.
///
/// # Errors
/// As [`jacobian`].
pub(super) fn derivatives(
    problem: &dyn LeastSquares,
    point: &Point,
    residuals: &[Vec<f64>],
    origin: Origin,
    rollouts: &mut usize,
) -> Result<Vec<Columns>> {
    if origin == Origin::Grouped {
        let (columns, count) = grouped_jacobian(problem, point, residuals)?;
        *rollouts += count;
        return Ok(columns);
    }
    let columns = jacobian(problem, point, residuals)?;
    *rollouts += columns.iter().map(Columns::count).sum::<usize>();
    Ok(columns)
}

/// Derivatives of which the last step's change of the residuals is true (Broyden 1965), steps measured in shares of the bounds.
pub(super) fn secant(
    problem: &dyn LeastSquares,
    mut columns: Vec<Columns>,
    (from, to): (&Point, &Point),
    (before, after): (&[Vec<f64>], &[Vec<f64>]),
) -> Vec<Columns> {
    for (k, (one, &d)) in columns.iter_mut().zip(problem.recordings()).enumerate() {
        let shared = one.indices.iter().map(|&i| (to.parameters[i] - from.parameters[i], problem.parameter(i).span()));
        let own = problem.nuisances(d).iter().enumerate();
        let own = own.map(|(i, p)| (to.nuisances[d][i] - from.nuisances[d][i], p.span()));
        let steps: Vec<(f64, f64)> = shared.chain(own).collect();
        let square: f64 = steps.iter().map(|(step, span)| (step / span).powi(2)).sum();
        if !square.is_normal() {
            continue;
        }
        let mut missing: Vec<f64> = after[k].iter().zip(&before[k]).map(|(after, before)| after - before).collect();
        for (column, (step, _)) in one.shared.iter().chain(&one.nuisances).zip(&steps) {
            missing.iter_mut().zip(column).for_each(|(missing, slope)| *missing -= slope * step);
        }
        for (column, (step, span)) in one.shared.iter_mut().chain(&mut one.nuisances).zip(&steps) {
            let share = step / span.powi(2) / square;
            column.iter_mut().zip(&missing).for_each(|(slope, missing)| *slope += share * missing);
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::problem::residuals as residuals_at;
    use crate::estimate::problem::tests::Lines;

    /// From derivatives that are wrong by a factor, those along the step become right, and those across it stay.
    #[test]
    fn secant_derivatives_repeat_the_last_step() {
        let lines = Lines::new(1.5, &[2.0]);
        let from = lines.start();
        let mut to = from.with(&[1], &[0.5]);
        to.nuisances[0][0] += 0.25;
        let (before, after) = (residuals_at(&lines, &from).unwrap(), residuals_at(&lines, &to).unwrap());
        let mut wrong = jacobian(&lines, &from, &before).unwrap();
        wrong[0].shared[0].iter_mut().for_each(|slope| *slope *= 3.0);
        let (step, level) = (to.parameters[1] - from.parameters[1], to.nuisances[0][0] - from.nuisances[0][0]);
        let spans = [lines.parameter(1).span(), lines.nuisances(0)[0].span()];
        // Across the step in shares of the bounds.
        let across = [-level / spans[1] * spans[0], step / spans[0] * spans[1]];
        let along = |columns: &[Columns], i: usize, [a, b]: [f64; 2]| {
            a * columns[0].shared[0][i] + b * columns[0].nuisances[0][i]
        };
        let right = secant(&lines, wrong.clone(), (&from, &to), (&before, &after));
        for i in 0..before[0].len() {
            assert!((along(&right, i, [step, level]) - (after[0][i] - before[0][i])).abs() < 1e-9);
            assert!((along(&right, i, across) - along(&wrong, i, across)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_fit_ends_with_derivatives_that_were_measured() {
        let may = |origin: Origin| [true, false].map(|ends_measured| origin.may_end(ends_measured));
        assert_eq!(
            [Origin::Followed, Origin::Grouped, Origin::Measured].map(may),
            [[false; 2], [false, true], [true; 2]]
        );
    }
}
