//! Levenberg–Marquardt through rollouts: the tuned parameters of all recordings together with each recording's own
//! unknowns, which are eliminated by a Schur complement.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::arrow::{Arrow, Block};
use super::residual::weighted;
use super::unknowns::Point;
use crate::Result;
use crate::simulator::{Parameter, Prepared, Simulator, every};
use crate::statistics::mad_sd;

/// Forward-difference step, as a share of an unknown's bounds: far above rounding (1e-14 of a trajectory), far below
/// anything that bends.
const DIFFERENCE_STEP: f64 = 1e-6;
/// Residuals beyond this many robust standard deviations pull with constant force (Huber 1964): at 4 the estimate of clean
/// normal data keeps 99.9 % of its efficiency.
const HUBER: f64 = 4.0;
const MOST_STEPS: usize = 40;

/// What a fit ended with.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The best point.
    pub point: Point,
    /// Weighted residuals there, shape `[recording][sample · channel]`.
    pub residuals: Vec<Vec<f64>>,
    /// Half the robust sum of squares.
    pub cost: f64,
    /// Covariance of the free parameters for noise as stated, the nuisance parameters marginalised; bounds ignored.
    pub covariance: DMatrix<f64>,
    /// How many rollouts it took.
    pub rollouts: usize,
    /// The free parameters after every accepted step with [`Problem::rmse`] there, the start first.
    pub trace: Vec<(Vec<f64>, f64)>,
}

/// What is fitted to what.
pub struct Problem<'a> {
    /// The simulator.
    pub simulator: &'a dyn Simulator,
    /// The recordings, prepared by it.
    pub recordings: &'a [Prepared],
    /// Noise of each recording's channels, shape `[recording][channel]`.
    pub noise: &'a [Vec<f64>],
    /// Positions of the free parameters.
    pub free: &'a [usize],
}

/// Derivatives of one recording: residuals at the point, and a column per free parameter and nuisance parameter.
pub(super) struct Linearised {
    pub residual: Vec<f64>,
    pub columns: Vec<Vec<f64>>,
}

impl Problem<'_> {
    fn parameter(&self, i: usize) -> &Parameter {
        &self.simulator.parameters()[self.free[i]]
    }

    fn samples(&self, recording: usize, horizon: f64) -> usize {
        let all = self.recordings[recording].seen.len();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
        let share = (all as f64 * horizon).ceil() as usize;
        share.clamp(crate::observation::FEWEST_SAMPLES.min(all), all)
    }

    /// Weighted residuals of every recording, over the first share `horizon` of each.
    ///
    /// # Errors
    /// Where the simulator refuses.
    pub fn residuals(&self, point: &Point, horizon: f64) -> Result<Vec<Vec<f64>>> {
        let each = |d: usize| {
            let recording = &self.recordings[d];
            weighted(
                self.simulator,
                recording,
                &self.noise[d],
                &point.parameters,
                &point.nuisances[d],
                self.samples(d, horizon),
            )
        };
        every((0..self.recordings.len()).into_par_iter().map(each))
    }

    /// Root mean square of measured − predicted in the channels' own unit, a sample of several channels counted once.
    #[must_use]
    pub fn rmse(&self, residuals: &[Vec<f64>]) -> f64 {
        let (mut squares, mut samples) = (0.0, 0);
        for (residual, noise) in residuals.iter().zip(self.noise) {
            squares += residual.iter().enumerate().map(|(i, r)| (r * noise[i % noise.len()]).powi(2)).sum::<f64>();
            samples += residual.len() / noise.len();
        }
        (squares / samples as f64).sqrt()
    }

    pub(super) fn linearise(&self, point: &Point, residuals: &[Vec<f64>], horizon: f64) -> Result<Vec<Linearised>> {
        let tasks: Vec<(usize, usize)> = (0..self.recordings.len())
            .flat_map(|d| (0..self.free.len() + point.nuisances[d].len()).map(move |column| (d, column)))
            .collect();
        let column = |&(d, column): &(usize, usize)| -> Result<Vec<f64>> {
            let samples = self.samples(d, horizon);
            let rolled = |direction: f64| {
                let (mut parameters, mut nuisances) = (point.parameters.clone(), point.nuisances[d].clone());
                let step = if column < self.free.len() {
                    nudge(&mut parameters[self.free[column]], self.parameter(column), direction)
                } else {
                    let nuisance_column = column - self.free.len();
                    nudge(&mut nuisances[nuisance_column], &self.recordings[d].nuisances[nuisance_column], direction)
                };
                weighted(self.simulator, &self.recordings[d], &self.noise[d], &parameters, &nuisances, samples)
                    .map(|r| (r, step))
            };
            // On the edge of what can be simulated (a body that touches the floor at its start) only one side exists.
            let (mut moved, step) = rolled(1.0).or_else(|_| rolled(-1.0))?;
            moved.iter_mut().zip(&residuals[d]).for_each(|(m, r)| *m = (*m - r) / step);
            Ok(moved)
        };
        let mut columns = every(tasks.par_iter().map(column))?.into_iter();
        let gather = |(d, residual): (usize, &Vec<f64>)| Linearised {
            residual: residual.clone(),
            columns: columns.by_ref().take(self.free.len() + point.nuisances[d].len()).collect(),
        };
        Ok(residuals.iter().enumerate().map(gather).collect())
    }

    /// Fits from `start` over the first share `horizon` of each recording.
    ///
    /// # Errors
    /// Where the simulator refuses the start; a refused step is only shortened.
    pub fn fit(&self, start: Point, horizon: f64) -> Result<Fit> {
        self.fit_until(start, horizon, 0.0)
    }

    /// As [`fit`](Problem::fit), but ends as well after two steps in a row that each gain no more than `enough` of the cost:
    /// a profile needs its cost, not the place in full precision.
    pub(super) fn fit_until(&self, start: Point, horizon: f64, enough: f64) -> Result<Fit> {
        let mut small_gains = 0;
        let mut point = start;
        let mut residuals = self.residuals(&point, horizon)?;
        let mut rollouts = self.recordings.len();
        let mut damping = 1e-3;
        let mut system = None;
        let mut trace = vec![(point.at(self.free), self.rmse(&residuals))];
        for _ in 0..MOST_STEPS {
            let scale = robust_scale(&residuals);
            let cost = huber_cost(&residuals, scale) + self.prior(&point);
            let linear = self.linearise(&point, &residuals, horizon)?;
            rollouts += linear.iter().map(|l| l.columns.len()).sum::<usize>();
            let equations = self.equations(&linear, &point, scale);
            let mut improved = None;
            while damping < 1e12 {
                let candidate = self.moved(&point, &equations, damping);
                rollouts += self.recordings.len();
                // A refused or worse step is a step too long.
                if let Ok(new) = self.residuals(&candidate, horizon) {
                    let new_cost = huber_cost(&new, scale) + self.prior(&candidate);
                    if new_cost <= cost {
                        improved = Some((candidate, new, cost - new_cost));
                        break;
                    }
                }
                damping *= 10.0;
            }
            system = Some(equations);
            let Some((candidate, new, gain)) = improved else { break };
            let still = self.distance(&point, &candidate) < 1e-12;
            (point, residuals) = (candidate, new);
            trace.push((point.at(self.free), self.rmse(&residuals)));
            damping = (damping / 10.0).max(1e-12);
            small_gains = if gain <= enough { small_gains + 1 } else { 0 };
            if still || gain <= 1e-12 * cost || small_gains == 2 {
                break;
            }
        }
        let covariance = system.map_or_else(|| DMatrix::zeros(0, 0), |s: Arrow| s.covariance());
        let cost = huber_cost(&residuals, robust_scale(&residuals)) + self.prior(&point);
        Ok(Fit { point, residuals, cost, covariance, rollouts, trace })
    }

    /// `point` as it stands, judged and linearised but not moved.
    ///
    /// # Errors
    /// Where the simulator refuses it.
    pub fn evaluate(&self, point: Point) -> Result<Fit> {
        let residuals = self.residuals(&point, 1.0)?;
        let linear = self.linearise(&point, &residuals, 1.0)?;
        let rollouts = self.recordings.len() + linear.iter().map(|l| l.columns.len()).sum::<usize>();
        let scale = robust_scale(&residuals);
        let covariance = self.equations(&linear, &point, scale).covariance();
        let cost = huber_cost(&residuals, scale) + self.prior(&point);
        let trace = vec![(point.at(self.free), self.rmse(&residuals))];
        Ok(Fit { point, residuals, cost, covariance, rollouts, trace })
    }

    /// Half the squared distance of the nuisance parameters from their guesses in units of their bounds: too weak to matter where
    /// the data speak, enough to keep a direction that they are silent on in place.
    fn prior(&self, point: &Point) -> f64 {
        let each = self.recordings.iter().zip(&point.nuisances);
        each.flat_map(|(r, nuisances)| r.nuisances.iter().zip(nuisances))
            .map(|(p, v)| 0.5 * ((v - p.value) / p.span()).powi(2))
            .sum()
    }

    fn distance(&self, a: &Point, b: &Point) -> f64 {
        let shared = self
            .free
            .iter()
            .map(|&i| (a.parameters[i] - b.parameters[i]).abs() / self.simulator.parameters()[i].span());
        let nuisances = self.recordings.iter().zip(a.nuisances.iter().zip(&b.nuisances));
        let nuisances = nuisances.flat_map(|(r, (a, b))| {
            r.nuisances.iter().zip(a.iter().zip(b)).map(|(p, (a, b))| (a - b).abs() / p.span())
        });
        shared.chain(nuisances).fold(0.0, f64::max)
    }

    /// What the data say of the free parameters at `fit`, each recording's nuisance parameters fitted: the Schur complement of the
    /// normal equations (the inverse of a covariance for noise as stated), the pull on each parameter (the slope of −cost),
    /// and the diagonal before the nuisance parameters took their share. Bounds are ignored.
    ///
    /// # Errors
    /// Where the simulator refuses.
    pub(super) fn curvature(&self, fit: &Fit) -> Result<(DMatrix<f64>, DVector<f64>, DVector<f64>)> {
        let linear = self.linearise(&fit.point, &fit.residuals, 1.0)?;
        let equations = self.normal_equations(&linear, &fit.point, robust_scale(&fit.residuals));
        let (schur, pull) = equations.reduced();
        Ok((schur, pull, equations.shared.diagonal()))
    }

    fn equations(&self, linear: &[Linearised], point: &Point, scale: f64) -> Arrow {
        let mut equations = self.normal_equations(linear, point, scale);
        // A parameter on a bound that wants to leave it is held there.
        for i in 0..self.free.len() {
            let (p, value) = (self.parameter(i), point.parameters[self.free[i]]);
            let outward = equations.right[i] < 0.0 && value <= p.min || equations.right[i] > 0.0 && value >= p.max;
            if outward {
                equations.hold(i);
            }
        }
        equations
    }

    fn normal_equations(&self, linear: &[Linearised], point: &Point, scale: f64) -> Arrow {
        let shared = self.free.len();
        let mut equations = Arrow::new(shared, linear.len());
        for (d, one) in linear.iter().enumerate() {
            let width = one.columns.len();
            let nuisances = width - shared;
            let weights: Vec<f64> = one.residual.iter().map(|r| huber_weight(*r, scale)).collect();
            let product =
                |a: &[f64], b: &[f64]| a.iter().zip(b).zip(&weights).map(|((a, b), w)| a * b * w).sum::<f64>();
            let normal =
                DMatrix::from_fn(
                    width,
                    width,
                    |i, j| {
                        if i <= j { product(&one.columns[i], &one.columns[j]) } else { 0.0 }
                    },
                );
            let normal = DMatrix::from_fn(width, width, |i, j| normal[(i.min(j), i.max(j))]);
            let right = DVector::from_fn(width, |i, _| -product(&one.columns[i], &one.residual));
            equations.shared += normal.view((0, 0), (shared, shared));
            equations.right += right.rows(0, shared);
            let mut nuisance_normal = normal.view((shared, shared), (nuisances, nuisances)).into_owned();
            let mut nuisance_right = right.rows(shared, nuisances).into_owned();
            for (i, p) in self.recordings[d].nuisances.iter().enumerate() {
                nuisance_normal[(i, i)] += p.span().powi(-2);
                nuisance_right[i] -= (point.nuisances[d][i] - p.value) / p.span().powi(2);
            }
            let coupling = normal.view((0, shared), (shared, nuisances)).into_owned();
            equations.blocks.push(Block {
                places: (0..shared).collect(),
                coupling,
                nuisances: nuisance_normal,
                nuisance_right,
            });
        }
        equations
    }

    fn moved(&self, point: &Point, equations: &Arrow, damping: f64) -> Point {
        let (shared, nuisances) = equations.solve(damping);
        let mut moved = point.clone();
        for (i, step) in shared.iter().enumerate() {
            let p = self.parameter(i);
            let value = &mut moved.parameters[self.free[i]];
            *value = (*value + step).clamp(p.min, p.max);
        }
        for ((values, steps), recording) in moved.nuisances.iter_mut().zip(nuisances).zip(self.recordings) {
            for ((value, step), p) in values.iter_mut().zip(steps.iter()).zip(&recording.nuisances) {
                *value = (*value + step).clamp(p.min, p.max);
            }
        }
        moved
    }
}

/// Moves `value` by the difference step in `direction`, inward where it stands on a bound; returns the step taken.
fn nudge(value: &mut f64, parameter: &Parameter, direction: f64) -> f64 {
    let wanted = direction * DIFFERENCE_STEP * parameter.span();
    let before = *value;
    *value += if (parameter.min..=parameter.max).contains(&(before + wanted)) { wanted } else { -wanted };
    *value - before
}

/// The residuals' own spread where it exceeds the stated noise, so that a misfit of the whole is not taken for outliers.
pub(crate) fn robust_scale(residuals: &[Vec<f64>]) -> f64 {
    mad_sd(residuals.iter().flatten().copied()).max(1.0)
}

pub(crate) fn huber_weight(residual: f64, scale: f64) -> f64 {
    (HUBER * scale / residual.abs()).min(1.0)
}

pub(crate) fn huber_cost(residuals: &[Vec<f64>], scale: f64) -> f64 {
    let limit = HUBER * scale;
    let each = |r: &f64| if r.abs() <= limit { 0.5 * r * r } else { limit * (r.abs() - 0.5 * limit) };
    residuals.iter().flatten().map(each).sum()
}
