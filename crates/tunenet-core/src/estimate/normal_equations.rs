//! Normal equations of Gauss and Newton with Huber's weights and the priors of nuisance parameters (Björck 1996, section 9.2).

use nalgebra::{DMatrix, DVector};

use super::block_arrow::{Arrow, Block};
use super::huber::huber_weight;
use super::jacobian::Columns;
use super::problem::{LeastSquares, Point};
use crate::statistics::dot;

/// The normal equations at `point`, whose residuals are `residuals`; bounds are ignored. Shared parameters are counted in the
/// order of [`LeastSquares::free`].
pub(crate) fn normal_equations(
    problem: &dyn LeastSquares,
    columns: &[Columns],
    residuals: &[Vec<f64>],
    point: &Point,
    scale: f64,
) -> Arrow {
    let free = problem.free();
    let mut arrow = Arrow::new(free.len(), columns.len());
    for ((&d, one), left) in problem.recordings().iter().zip(columns).zip(residuals) {
        let weights: Vec<f64> = left.iter().map(|r| huber_weight(*r, scale)).collect();
        let all: Vec<&Vec<f64>> = one.shared.iter().chain(&one.nuisances).collect();
        let (shared, nuisances) = (one.shared.len(), one.nuisances.len());
        let mut normal = DMatrix::zeros(all.len(), all.len());
        let mut right = DVector::zeros(all.len());
        let mut weighted = vec![0.0; left.len()];
        for i in 0..all.len() {
            weighted.iter_mut().zip(all[i]).zip(&weights).for_each(|((own, a), w)| *own = a * w);
            for j in 0..=i {
                normal[(i, j)] = dot(&weighted, all[j]);
                normal[(j, i)] = normal[(i, j)];
            }
            right[i] = -dot(&weighted, left);
        }
        let indices: Vec<usize> = one.indices.iter().filter_map(|p| free.iter().position(|f| f == p)).collect();
        for (i, &row) in indices.iter().enumerate() {
            arrow.right[row] += right[i];
            for (j, &column) in indices.iter().enumerate() {
                arrow.shared[(row, column)] += normal[(i, j)];
            }
        }
        let mut nuisance_normal = normal.view((shared, shared), (nuisances, nuisances)).into_owned();
        let mut nuisance_right = right.rows(shared, nuisances).into_owned();
        for (i, p) in problem.nuisances(d).iter().enumerate() {
            let sd = problem.prior_sd(d, i);
            nuisance_normal[(i, i)] += sd.powi(-2);
            nuisance_right[i] -= (point.nuisances[d][i] - p.value) / sd.powi(2);
        }
        let coupling = normal.view((0, shared), (shared, nuisances)).into_owned();
        arrow.blocks.push(Block { indices, coupling, nuisances: nuisance_normal, nuisance_right });
    }
    for (i, &index) in free.iter().enumerate() {
        arrow.shared[(i, i)] += problem.ridge(index);
    }
    arrow
}

/// Holds every free parameter that stands on a bound and wants to leave it (Bertsekas 1982).
pub(crate) fn hold_at_bounds(problem: &dyn LeastSquares, point: &Point, equations: &mut Arrow) {
    for (i, &index) in problem.free().iter().enumerate() {
        let (p, value) = (problem.parameter(index), point.parameters[index]);
        if equations.right[i] < 0.0 && value <= p.min || equations.right[i] > 0.0 && value >= p.max {
            equations.hold(i);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::jacobian::jacobian;
    use crate::estimate::problem::residuals;
    use crate::estimate::problem::tests::Lines;

    #[test]
    fn one_step_of_a_line_is_its_regression() {
        let lines = Lines::new(1.5, &[2.0, -1.0]);
        let point = lines.start();
        let left = residuals(&lines, &point).unwrap();
        let columns = jacobian(&lines, &point, &left).unwrap();
        let equations = normal_equations(&lines, &columns, &left, &point, 1e9);
        let (shared, nuisances) = equations.solve(0.0);
        assert!((shared[0] - 1.5).abs() < 1e-6, "{shared}");
        assert!((nuisances[0][0] - 2.0).abs() < 1e-6 && (nuisances[1][0] + 1.0).abs() < 1e-6, "{nuisances:?}");
        // Var b = σ²/Σ(t − mean)² = 1/5 for each recording.
        assert!((equations.covariance()[(0, 0)] - 0.1).abs() < 1e-6);
    }

    #[test]
    fn a_parameter_that_pushes_against_its_bound_is_held() {
        let lines = Lines::new(-12.0, &[0.0]);
        let point = lines.start().with(&[1], &[-10.0]);
        let left = residuals(&lines, &point).unwrap();
        let columns = jacobian(&lines, &point, &left).unwrap();
        let mut equations = normal_equations(&lines, &columns, &left, &point, 1e9);
        hold_at_bounds(&lines, &point, &mut equations);
        assert_eq!(equations.solve(0.0).0[0], 0.0);
    }
}
