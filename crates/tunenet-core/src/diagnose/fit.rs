//! The joint fit: parameters and coefficients of all objects with every recording's nuisance parameters, by Levenberg–Marquardt.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::derivatives::{Columns, Which};
use super::joint::{Joint, Outcome, Part, Point, spread};
use crate::Result;
use crate::estimate::block_arrow::Arrow;
use crate::estimate::huber::huber_cost;
use crate::simulator::every;

const GREATEST_DAMPING: f64 = 1e8;
/// Nor are steps worth their rollouts that gain less than this share of the cost.
const TOLERANCE_SHARE: f64 = 5e-5;
/// How far a refused start is moved, as shares of the bounds.
const MOVES: [f64; 4] = [1e-4, 1e-3, 1e-2, 0.1];
/// A step of a parameter that would cross a bound goes so much of the way there.
const NEARER: f64 = 0.9;
/// A step that moves everything by less than this share of the bounds has arrived.
const STILL: f64 = 1e-11;

/// How far a fit goes.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    pub steps: usize,
    /// A step that gains less than this in cost ends it; a half of 1 is what the noise of one sample is worth.
    pub tolerance: f64,
    /// The share of each recording that is fitted.
    pub horizon: f64,
}

/// What the fit of a part ended with; of the point, only what belongs to the part has moved.
struct Fitted {
    point: Point,
    residuals: Vec<Vec<f64>>,
    covariance: DMatrix<f64>,
}

impl Joint<'_> {
    /// Fits from `start`; `first` are derivatives there, where they are known already.
    ///
    /// # Errors
    /// Where the simulator refuses the start; a refused step is only shortened.
    pub fn fit(&self, mut start: Point, effort: Effort, first: Option<Vec<Columns>>) -> Result<Outcome> {
        let residuals = self.residuals(&start, effort.horizon).or_else(|_| {
            (0..self.sets.len()).for_each(|d| self.admit(d, &mut start, effort.horizon));
            self.residuals(&start, effort.horizon)
        })?;
        Ok(self.fit_from(start, residuals, effort, first))
    }

    /// Where `point` stands, without a step.
    pub fn stand(&self, point: Point) -> Result<Outcome> {
        let residuals = self.residuals(&point, 1.0)?;
        Ok(self.fit_from(point, residuals, Effort { steps: 0, tolerance: 0.0, horizon: 1.0 }, None))
    }

    /// Moves the start of a recording that the simulator refuses (a ball inside a surface that tilts) to the nearest one
    /// that it takes, one unknown at a time.
    fn admit(&self, d: usize, start: &mut Point, horizon: f64) {
        let samples = self.samples(d, horizon);
        let taken = |nuisances: &[f64]| self.plain(d, &start.globals, nuisances, samples).is_ok();
        if taken(&start.nuisances[d]) {
            return;
        }
        for share in MOVES {
            for (i, unknown) in self.sets[d].prepared.nuisances.iter().enumerate() {
                for direction in [1.0, -1.0] {
                    let mut nuisances = start.nuisances[d].clone();
                    nuisances[i] = (nuisances[i] + direction * share * unknown.span()).clamp(unknown.min, unknown.max);
                    if taken(&nuisances) {
                        start.nuisances[d] = nuisances;
                        return;
                    }
                }
            }
        }
    }

    /// The same where the residuals at the start are known too.
    ///
    /// Objects that share no free number are fitted each on its own: a step that one of them refuses holds up no other,
    /// and costs no rollout of it.
    #[expect(clippy::needless_pass_by_value, reason = "what is given goes into the fit")]
    pub fn fit_from(
        &self,
        start: Point,
        residuals: Vec<Vec<f64>>,
        effort: Effort,
        first: Option<Vec<Columns>>,
    ) -> Outcome {
        let parts = self.parts();
        let one = |part: &Part| {
            let residuals = part.sets.iter().map(|&d| residuals[d].clone()).collect();
            let first = first.as_ref().map(|all| part.sets.iter().map(|&d| all[d].clone()).collect());
            self.fit_part(part, &start, residuals, effort, first)
        };
        let fitted: Vec<Fitted> = parts.par_iter().map(one).collect();
        let size = self.structure.globals.len();
        let mut covariance = DMatrix::from_diagonal_element(size, size, f64::INFINITY);
        let (mut point, mut residuals) = (start, residuals);
        for (part, fitted) in parts.iter().zip(fitted) {
            for (i, &row) in part.places.iter().enumerate() {
                point.globals[row] = fitted.point.globals[row];
                for (j, &column) in part.places.iter().enumerate() {
                    covariance[(row, column)] = fitted.covariance[(i, j)];
                }
            }
            for (&d, left) in part.sets.iter().zip(fitted.residuals) {
                point.nuisances[d].clone_from(&fitted.point.nuisances[d]);
                residuals[d] = left;
            }
        }
        let pull = self.pull(&point, 0..self.sets.len());
        let cost = huber_cost(&residuals, spread(&residuals)) + pull;
        Outcome { point, residuals, cost, pull, covariance }
    }

    /// One part alone; nothing outside of it is looked at.
    fn fit_part(
        &self,
        part: &Part,
        start: &Point,
        mut residuals: Vec<Vec<f64>>,
        effort: Effort,
        mut first: Option<Vec<Columns>>,
    ) -> Fitted {
        let mut point = start.clone();
        let sets = || part.sets.iter().copied();
        let derivatives = |point: &Point, residuals: &[Vec<f64>]| {
            self.columns_of(&part.sets, point, residuals, Which { horizon: effort.horizon, ..Which::ALL })
        };
        let mut damping = 1e-4;
        let mut equations = None;
        for _ in 0..effort.steps {
            let scale = spread(&residuals);
            let cost = huber_cost(&residuals, scale) + self.pull(&point, sets());
            let columns = first.take().unwrap_or_else(|| derivatives(&point, &residuals));
            let known = self.equations(part, &columns, &residuals, &point, scale);
            let mut improved = None;
            while damping < GREATEST_DAMPING {
                let candidate = self.moved(part, &point, &known, damping);
                let rolled = every(part.sets.par_iter().map(|&d| self.residual(d, &candidate, effort.horizon)));
                // A refused or worse step is a step too long.
                if let Ok(new) = rolled {
                    let gain = cost - huber_cost(&new, scale) - self.pull(&candidate, sets());
                    if gain >= 0.0 {
                        improved = Some((candidate, new, gain));
                        break;
                    }
                    // Nothing worth having is left in this direction.
                    if Self::promise(&known, damping) < effort.tolerance {
                        break;
                    }
                }
                damping *= 10.0;
            }
            equations = Some(known);
            let Some((candidate, new, gain)) = improved else { break };
            let still = self.distance(part, &point, &candidate) < STILL;
            (point, residuals) = (candidate, new);
            damping = (damping / 10.0).max(1e-10);
            if still || gain <= effort.tolerance.max(TOLERANCE_SHARE * cost) {
                break;
            }
        }
        let equations = equations.unwrap_or_else(|| {
            let columns = derivatives(&point, &residuals);
            self.equations(part, &columns, &residuals, &point, spread(&residuals))
        });
        Fitted { point, residuals, covariance: equations.covariance() }
    }

    /// What a linear model of this point promises to gain by the damped step.
    fn promise(equations: &Arrow, damping: f64) -> f64 {
        let (shared, nuisances) = equations.solve(damping);
        let nuisances: f64 = equations.blocks.iter().zip(&nuisances).map(|(b, step)| b.nuisance_right.dot(step)).sum();
        shared.dot(&equations.right) + nuisances
    }

    fn distance(&self, part: &Part, a: &Point, b: &Point) -> f64 {
        let shared = part.places.iter().map(|&g| {
            let span = self.structure.globals[g].parameter.span();
            (a.globals[g] - b.globals[g]).abs() / span
        });
        let nuisances = part.sets.iter().flat_map(|&d| {
            let both = a.nuisances[d].iter().zip(&b.nuisances[d]);
            self.sets[d].prepared.nuisances.iter().zip(both).map(|(p, (a, b))| (a - b).abs() / p.span())
        });
        shared.chain(nuisances).fold(0.0, f64::max)
    }

    fn moved(&self, part: &Part, point: &Point, equations: &Arrow, damping: f64) -> Point {
        let (shared, nuisances) = equations.solve(damping);
        let mut moved = point.clone();
        for (&place, step) in part.places.iter().zip(shared.iter()) {
            let global = &self.structure.globals[place];
            let (p, value) = (&global.parameter, &mut moved.globals[place]);
            let bound = (*value + step).clamp(p.min, p.max);
            // Where a ball loses nothing it bounces for ever, and a rollout takes as long.
            let short = global.effect.is_none() && bound != *value + step;
            *value += if short { NEARER * (bound - *value) } else { bound - *value };
        }
        for (&d, steps) in part.sets.iter().zip(nuisances) {
            for ((value, step), p) in
                moved.nuisances[d].iter_mut().zip(steps.iter()).zip(&self.sets[d].prepared.nuisances)
            {
                *value = (*value + step).clamp(p.min, p.max);
            }
        }
        moved
    }
}
