//! How well anything could do on a drop of which nothing is known: the maximum of the likelihood of the same heights, by the
//! closed form alone.

use nalgebra::{DMatrix, DVector};

use super::closed_form::ClosedFormDrop;
use crate::scene::GRAVITY_M_S2;

/// Restitutions, evenly over `[0, 1]`, from which the other three parameters are fitted first.
const STARTS: u32 = 100;
/// Local minima in which all four are fitted then, the deepest first (multistart).
const MINIMA: usize = 6;
/// Steps of Levenberg and Marquardt's method at a start, and in a local minimum.
const FEW_STEPS: usize = 6;
const MANY_STEPS: usize = 60;
/// Forward differences, as a share of each parameter's size.
const DIFFERENCE: f64 = 1e-7;

/// What a record is explained by.
#[derive(Debug, Clone, Copy)]
pub struct DropParameters {
    pub drop: ClosedFormDrop,
    /// When the ball was released, on the record's clock, s.
    pub release_s: f64,
    /// Height of the lowest point on the floor, m.
    pub floor_m: f64,
}

impl DropParameters {
    fn heights(&self, clock: &[f64]) -> Vec<f64> {
        let clock: Vec<f64> = clock.iter().map(|t| t - self.release_s).collect();
        self.drop.heights(&clock).into_iter().map(|z| z + self.floor_m).collect()
    }

    /// Each parameter moved by its share of `steps`, in units of its size.
    fn moved(&self, steps: [f64; 4]) -> Self {
        let fall_s = (2.0 * self.drop.fall_m / GRAVITY_M_S2).sqrt();
        Self {
            drop: ClosedFormDrop {
                restitution: (self.drop.restitution + steps[0]).clamp(0.0, 1.0),
                fall_m: self.drop.fall_m * (1.0 + steps[1]).max(0.1),
            },
            release_s: self.release_s + steps[2] * fall_s,
            floor_m: self.floor_m + steps[3] * self.drop.fall_m,
        }
    }
}

/// The restitution under which white noise makes `heights_m` likeliest, everything else fitted too. `near` lends the first
/// guesses of height, release and floor, and is a start itself.
pub fn fit(near: DropParameters, clock: &[f64], heights_m: &[f64]) -> f64 {
    let record = HeightRecord { clock, heights_m };
    let at = |i: u32| ClosedFormDrop { restitution: f64::from(i) / f64::from(STARTS), ..near.drop };
    let first = |i| record.descend(DropParameters { drop: at(i), ..near }, true, FEW_STEPS);
    let mut starts: Vec<(f64, DropParameters)> = (0..=STARTS).map(first).collect();
    let deep = |i: usize| {
        let cost = |j: Option<usize>| j.and_then(|j| starts.get(j)).map_or(f64::INFINITY, |s| s.0);
        starts[i].0 <= cost(i.checked_sub(1)) && starts[i].0 <= cost(Some(i + 1))
    };
    let minima: Vec<usize> = (0..starts.len()).filter(|&i| deep(i)).collect();
    let mut minima: Vec<(f64, DropParameters)> = minima.into_iter().map(|i| starts[i]).collect();
    minima.sort_by(|a, b| a.0.total_cmp(&b.0));
    minima.truncate(MINIMA);
    minima.push((0.0, near));
    starts = minima.into_iter().map(|(_, start)| record.descend(start, false, MANY_STEPS)).collect();
    starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(near.drop.restitution, |s| s.1.drop.restitution)
}

struct HeightRecord<'a> {
    clock: &'a [f64],
    heights_m: &'a [f64],
}

impl HeightRecord<'_> {
    fn residual(&self, at: &DropParameters) -> DVector<f64> {
        let heights = at.heights(self.clock);
        DVector::from_iterator(heights.len(), heights.iter().zip(self.heights_m).map(|(z, seen)| seen - z))
    }

    /// Least squares from `start`, the restitution held or not: the sum of squares, and where.
    fn descend(&self, start: DropParameters, hold: bool, steps: usize) -> (f64, DropParameters) {
        let (mut at, mut residual) = (start, self.residual(&start));
        let mut damping = 1e-3;
        for _ in 0..steps {
            let cost = residual.norm_squared();
            let slopes = DMatrix::from_columns(&[0, 1, 2, 3].map(|k| self.slope(&at, &residual, k, hold)));
            let (normal, right) = (slopes.transpose() * &slopes, slopes.transpose() * &residual);
            let better = std::iter::successors(Some(damping), |d| Some(d * 10.0)).take(14).find_map(|damping| {
                let mut damped = normal.clone();
                (0..4).for_each(|i| damped[(i, i)] += damping * normal[(i, i)] + f64::MIN_POSITIVE.sqrt());
                let step = damped.cholesky()?.solve(&right);
                let there = at.moved([0, 1, 2, 3].map(|i| step[i]));
                let left = self.residual(&there);
                (left.norm_squared() < cost).then_some((there, left, damping))
            });
            let Some((there, left, used)) = better else { break };
            (at, residual, damping) = (there, left, (used / 10.0).max(1e-12));
            if cost - residual.norm_squared() < 1e-12 * cost {
                break;
            }
        }
        (residual.norm_squared(), at)
    }

    /// How the heights change with parameter number `k`.
    fn slope(&self, at: &DropParameters, residual: &DVector<f64>, k: usize, hold: bool) -> DVector<f64> {
        if hold && k == 0 {
            return DVector::zeros(residual.len());
        }
        let inward = if k == 0 && at.drop.restitution > 0.5 { -DIFFERENCE } else { DIFFERENCE };
        let mut steps = [0.0; 4];
        steps[k] = inward;
        (residual - self.residual(&at.moved(steps))) / inward
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_noise_the_restitution_comes_back_from_wrong_guesses() {
        let clock: Vec<f64> = (0..200).map(|i| f64::from(i) / 60.0).collect();
        for restitution in [0.05, 0.37, 0.9] {
            let truth =
                DropParameters { drop: ClosedFormDrop { fall_m: 2.0, restitution }, release_s: -0.1, floor_m: 0.3 };
            let seen = truth.heights(&clock);
            let wrong = DropParameters {
                drop: ClosedFormDrop { fall_m: 2.1, restitution: 0.6 },
                release_s: -0.12,
                floor_m: 0.2,
            };
            let found = fit(wrong, &clock, &seen);
            assert!((found - restitution).abs() < 1e-6, "{found} {restitution}");
        }
    }
}
