//! Contour of the profile likelihood of two parameters at one level (Venzon and Moolgavkar 1988).

use rayon::prelude::*;

use super::contour_ray::Ray;
use super::interval::ScaleEstimate;
use super::output_error::{Fit, Problem};

/// Directions in which the edge is looked for.
const RAYS: u32 = 36;

/// The joint region of two parameters at one level, by profile likelihood: its edge seen from the best point.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    /// Positions of the two among the simulator's parameters.
    pub parameters: (usize, usize),
    /// The level: 0.95.
    pub level: f64,
    /// The best values.
    pub best: (f64, f64),
    /// The edge, once around; where a bound, or what the simulator refuses, cuts the region it runs along that.
    pub edge: Vec<(f64, f64)>,
}

/// The joint region of the free parameters number `i` and `j` at `level` around `fit`, and the rollouts it took. `None`
/// where the data leave one of them, or a combination of both, without any curvature.
#[must_use]
pub fn contour(
    problem: &Problem,
    fit: &Fit,
    scale: &ScaleEstimate,
    (i, j): (usize, usize),
    level: f64,
) -> Option<(Contour, usize)> {
    let widening = scale.variance * scale.inflation;
    let of = |a: usize, b: usize| fit.covariance[(a, b)] * widening;
    // Directions that the covariance makes equally long (its Cholesky factor) find the edge in few steps.
    let first = of(i, i).sqrt();
    let across = of(i, j) / first;
    let second = (of(j, j) - across * across).sqrt();
    let quantile = scale.joint_quantile(2, level);
    let half_width = quantile.sqrt();
    if ![first, across, second, half_width].iter().all(|v| v.is_finite()) || first <= 0.0 || second <= 0.0 {
        return None;
    }
    let positions = [problem.free[i], problem.free[j]];
    let origin = positions.map(|p| fit.point.parameters[p]);
    let ray = |turn: u32| {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(turn) / f64::from(RAYS)).sin_cos();
        let direction = [first * cosine, across * cosine + second * sine].map(|step| half_width * step);
        Ray { problem, scale, positions, best: (&fit.point, fit.cost), origin, direction }.edge(quantile)
    };
    let rays = (0..RAYS).into_par_iter().map(ray).collect::<Vec<_>>();
    let rollouts = rays.iter().map(|r| r.1).sum();
    let edge = rays.into_iter().map(|r| r.0.into()).collect();
    Some((Contour { parameters: positions.into(), level, best: origin.into(), edge }, rollouts))
}
