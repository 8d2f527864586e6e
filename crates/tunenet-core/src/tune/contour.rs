//! Which pairs of values of two parameters the data allow together.

use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::fit::{Fit, Problem};
use super::interval::Spread;
use super::profile::{held, misfit};
use crate::Result;

/// Directions in which the edge is looked for.
const RAYS: u32 = 36;
/// Corrections along a ray; the root of the misfit is nearly straight, so that few are needed.
const CORRECTIONS: usize = 4;
/// How near to the level the edge has to be, as a share of its root.
const NEAR: f64 = 0.01;

/// The joint region of two parameters at one level, by profile likelihood: its edge seen from the best point.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    /// Positions of the two among the simulator's parameters.
    pub parameters: (usize, usize),
    /// The level: 0.95.
    pub level: f64,
    /// The best values.
    pub best: (f64, f64),
    /// The edge, once around; where a bound cuts the region it runs along the bound.
    pub edge: Vec<(f64, f64)>,
}

/// The joint region of the free parameters number `i` and `j` at `level` around `fit`, and the rollouts it took. `None`
/// where the data leave one of them, or a combination of both, without any curvature.
///
/// # Errors
/// Where the simulator refuses.
pub fn contour(problem: &Problem, fit: &Fit, (i, j): (usize, usize), level: f64) -> Result<Option<(Contour, usize)>> {
    let spread = Spread::of(problem, fit);
    let widening = spread.variance * spread.inflation;
    let of = |a: usize, b: usize| fit.covariance[(a, b)] * widening;
    // Directions that the covariance makes equally long (its Cholesky factor) find the edge in few steps.
    let first = of(i, i).sqrt();
    let across = of(i, j) / first;
    let second = (of(j, j) - across * across).sqrt();
    let Ok(fisher) = FisherSnedecor::new(2.0, spread.freedom) else { return Ok(None) };
    let reach = (2.0 * fisher.inverse_cdf(level)).sqrt();
    if ![first, across, second, reach].iter().all(|v| v.is_finite()) || first <= 0.0 || second <= 0.0 {
        return Ok(None);
    }
    let positions = [problem.free[i], problem.free[j]];
    let best = (fit.point.parameters[positions[0]], fit.point.parameters[positions[1]]);
    let bounds = positions.map(|p| &problem.simulator.parameters()[p]);
    let ray = |turn: u32| -> Result<((f64, f64), usize)> {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(turn) / f64::from(RAYS)).sin_cos();
        let direction = [first * cosine, across * cosine + second * sine];
        let room = [best.0, best.1]
            .into_iter()
            .zip(direction)
            .zip(bounds)
            .map(|((value, step), p)| if step > 0.0 { (p.max - value) / step } else { (p.min - value) / step });
        let most = room.filter(|r| r.is_finite()).fold(f64::INFINITY, f64::min).max(0.0);
        let (mut length, mut rollouts) = (reach.min(most), 0);
        let at = |length: f64| (best.0 + length * direction[0], best.1 + length * direction[1]);
        for _ in 0..CORRECTIONS {
            let (a, b) = at(length);
            let start = fit.point.with(&positions, &[a, b]);
            let there = held(problem, start, &positions, &spread)?;
            rollouts += there.rollouts;
            let root = misfit(&spread, there.cost - fit.cost).sqrt();
            let factor = (reach / root.max(f64::MIN_POSITIVE)).clamp(0.25, 4.0);
            if (factor - 1.0).abs() < NEAR || (length >= most && factor > 1.0) {
                break;
            }
            length = (length * factor).min(most);
        }
        Ok((at(length), rollouts))
    };
    let rays = (0..RAYS).into_par_iter().map(ray).collect::<Result<Vec<_>>>()?;
    let rollouts = rays.iter().map(|r| r.1).sum();
    let edge = rays.into_iter().map(|r| r.0).collect();
    Ok(Some((Contour { parameters: (positions[0], positions[1]), level, best, edge }, rollouts)))
}
