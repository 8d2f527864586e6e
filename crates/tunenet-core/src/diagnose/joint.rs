//! The joint fit: parameters and coefficients of all objects with every recording's own unknowns, by Levenberg–Marquardt.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::sets::Set;
use super::structure::Structure;
use crate::Result;
use crate::simulator::{Parameter, predict};
use crate::tune::arrow::{Arrow, Block};
use crate::tune::{huber_cost, huber_weight, robust_scale};

/// Forward-difference step of a parameter or own unknown, as a share of its bounds.
const DIFFERENCE_STEP: f64 = 1e-6;
/// ... and of a coefficient, as a share of a small visible one.
const COEFFICIENT_STEP: f64 = 1e-3;
const GREATEST_DAMPING: f64 = 1e8;
/// Nor are steps worth their rollouts that gain less than this share of the cost.
const TOLERANCE_SHARE: f64 = 5e-5;
/// How far a refused start is moved, as shares of the bounds.
const MOVES: [f64; 4] = [1e-4, 1e-3, 1e-2, 0.1];
/// A step of a parameter that would cross a bound goes so much of the way there.
const NEARER: f64 = 0.9;
/// A step that moves everything by less than this share of the bounds has arrived.
const STILL: f64 = 1e-11;

/// Where a fit stands.
#[derive(Debug, Clone)]
pub(super) struct Point {
    /// In the structure's order.
    pub globals: Vec<f64>,
    /// Shape `[recording][unknown]`.
    pub own: Vec<Vec<f64>>,
}

/// Derivatives of one recording's white residuals.
#[derive(Clone)]
pub(super) struct Columns {
    /// Which free numbers of the structure.
    pub places: Vec<usize>,
    /// A column for each of them.
    pub shared: Vec<Vec<f64>>,
    /// A column for each own unknown.
    pub own: Vec<Vec<f64>>,
}

/// What a fit ended with.
#[derive(Clone)]
pub(super) struct Outcome {
    pub point: Point,
    /// White residuals in units of the noise, shape `[recording][sample · channel]`.
    pub residuals: Vec<Vec<f64>>,
    /// Half the robust sum of squares with the pull of the guesses.
    pub cost: f64,
    /// The part of the cost that is the pull of the guesses.
    pub pull: f64,
    /// Covariance of the free numbers for noise as stated.
    pub covariance: DMatrix<f64>,
}

/// Recordings that share free numbers, and those numbers.
pub(super) struct Part {
    /// Positions among the recordings.
    pub sets: Vec<usize>,
    /// Positions among the structure's free numbers.
    pub places: Vec<usize>,
}

/// What the fit of a part ended with; of the point, only what belongs to the part has moved.
struct Fitted {
    point: Point,
    residuals: Vec<Vec<f64>>,
    covariance: DMatrix<f64>,
}

/// How far a fit goes.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    pub steps: usize,
    /// A step that gains less than this in cost ends it; a half of 1 is what the noise of one sample is worth.
    pub tolerance: f64,
    /// The share of each recording that is fitted.
    pub horizon: f64,
}

/// Which derivatives.
#[derive(Clone, Copy)]
pub(super) struct Which {
    /// Over this share of each recording.
    pub horizon: f64,
    /// By free numbers from this one on ...
    pub first: usize,
    /// ... and by the own unknowns.
    pub own: bool,
    /// By steps of a visible size.
    pub visibly: bool,
}

impl Which {
    pub const ALL: Self = Self { horizon: 1.0, first: 0, own: true, visibly: false };
}

/// A structure and the recordings that it is fitted to.
pub(super) struct Joint<'a> {
    pub structure: &'a Structure<'a>,
    pub sets: &'a [Set],
    /// Counts rollouts.
    pub rollouts: &'a AtomicUsize,
}

impl Joint<'_> {
    fn samples(&self, d: usize, horizon: f64) -> usize {
        let all = self.sets[d].clock().len();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
        let share = (all as f64 * horizon).ceil() as usize;
        share.clamp(crate::observation::FEWEST_SAMPLES.min(all), all)
    }

    /// Measured − predicted of one recording in its own unit, over its first `samples`.
    fn plain(&self, d: usize, globals: &[f64], own: &[f64], samples: usize) -> Result<Vec<f64>> {
        let set = &self.sets[d];
        self.rollouts.fetch_add(1, Ordering::Relaxed);
        let parameters = self.structure.parameters(set.object, globals);
        let simulator = self.structure.simulator(set.object);
        let mut values = predict(simulator, &set.prepared, &parameters, own, &set.clock()[..samples])?;
        values.iter_mut().zip(set.prepared.seen.values()).for_each(|(value, seen)| *value = seen - *value);
        Ok(values)
    }

    fn white(&self, d: usize, globals: &[f64], own: &[f64], samples: usize) -> Result<Vec<f64>> {
        let mut values = self.plain(d, globals, own, samples)?;
        self.sets[d].filter.apply(&mut values);
        Ok(values)
    }

    /// Measured − predicted in the channels' own units, shape `[recording][sample · channel]`.
    pub fn plain_residuals(&self, point: &Point) -> Result<Vec<Vec<f64>>> {
        let each = |d: usize| self.plain(d, &point.globals, &point.own[d], self.sets[d].clock().len());
        (0..self.sets.len()).into_par_iter().map(each).collect()
    }

    /// White residuals over the first share `horizon` of each recording.
    pub fn residuals(&self, point: &Point, horizon: f64) -> Result<Vec<Vec<f64>>> {
        (0..self.sets.len()).into_par_iter().map(|d| self.residual(d, point, horizon)).collect()
    }

    fn residual(&self, d: usize, point: &Point, horizon: f64) -> Result<Vec<f64>> {
        self.white(d, &point.globals, &point.own[d], self.samples(d, horizon))
    }

    /// Derivatives of the white residuals at `point`, where they are `residuals`, by free numbers from `first` on.
    ///
    /// With `visibly`, coefficients are moved as far as can be seen: some (the time a shutter is open) have no slope at all
    /// where they are absent.
    pub fn columns(&self, point: &Point, residuals: &[Vec<f64>], what: Which) -> Vec<Columns> {
        let all: Vec<usize> = (0..self.sets.len()).collect();
        self.columns_of(&all, point, residuals, what)
    }

    /// The same of the recordings `sets`, whose residuals are `residuals`.
    fn columns_of(&self, sets: &[usize], point: &Point, residuals: &[Vec<f64>], what: Which) -> Vec<Columns> {
        let Which { horizon, first, own, visibly } = what;
        let places: Vec<Vec<usize>> = sets
            .iter()
            .map(|&d| self.structure.places(self.sets[d].object).into_iter().filter(|&p| p >= first).collect())
            .collect();
        let own_count = |k: usize| if own { point.own[sets[k]].len() } else { 0 };
        let tasks: Vec<(usize, usize)> =
            (0..sets.len()).flat_map(|k| (0..places[k].len() + own_count(k)).map(move |c| (k, c))).collect();
        let column = |&(k, c): &(usize, usize)| -> Vec<f64> {
            let d = sets[k];
            let samples = self.samples(d, horizon);
            let rolled = |direction: f64| {
                let (mut globals, mut own) = (point.globals.clone(), point.own[d].clone());
                let step = if let Some(&place) = places[k].get(c) {
                    self.nudge_global(&mut globals, place, direction, visibly)
                } else {
                    let i = c - places[k].len();
                    let unknown = &self.sets[d].prepared.own[i];
                    nudge(&mut own[i], unknown, direction * DIFFERENCE_STEP * unknown.span())
                };
                self.white(d, &globals, &own, samples).map(|r| (r, step))
            };
            // On the edge of what can be simulated only one side exists, or none; then nothing is known of this direction.
            let Ok((mut moved, step)) = rolled(1.0).or_else(|_| rolled(-1.0)) else {
                return vec![0.0; residuals[k].len()];
            };
            moved.iter_mut().zip(&residuals[k]).for_each(|(m, r)| *m = (*m - r) / step);
            moved
        };
        let mut columns = tasks.par_iter().map(column).collect::<Vec<_>>().into_iter();
        let gather = |(k, places): (usize, Vec<usize>)| Columns {
            shared: columns.by_ref().take(places.len()).collect(),
            own: columns.by_ref().take(own_count(k)).collect(),
            places,
        };
        places.into_iter().enumerate().map(gather).collect()
    }

    fn nudge_global(&self, globals: &mut [f64], place: usize, direction: f64, visibly: bool) -> f64 {
        let global = &self.structure.globals[place];
        let step = match global.absent {
            Some((_, typical)) if visibly => typical,
            Some((_, typical)) => COEFFICIENT_STEP * typical,
            None => DIFFERENCE_STEP * global.parameter.span(),
        };
        nudge(&mut globals[place], &global.parameter, direction * step)
    }

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
        let taken = |own: &[f64]| self.plain(d, &start.globals, own, samples).is_ok();
        if taken(&start.own[d]) {
            return;
        }
        for share in MOVES {
            for (i, unknown) in self.sets[d].prepared.own.iter().enumerate() {
                for direction in [1.0, -1.0] {
                    let mut own = start.own[d].clone();
                    own[i] = (own[i] + direction * share * unknown.span()).clamp(unknown.min, unknown.max);
                    if taken(&own) {
                        start.own[d] = own;
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
                point.own[d].clone_from(&fitted.point.own[d]);
                residuals[d] = left;
            }
        }
        let pull = self.pull(&point, 0..self.sets.len());
        let cost = huber_cost(&residuals, spread(&residuals)) + pull;
        Outcome { point, residuals, cost, pull, covariance }
    }

    /// Recordings and free numbers that hang together. A number that all objects share joins all.
    pub fn parts(&self) -> Vec<Part> {
        let globals = &self.structure.globals;
        let objects = self.sets.iter().map(|s| s.object).max().map_or(0, |o| o + 1);
        if objects < 2 || globals.iter().any(|g| g.object.is_none()) {
            return vec![Part { sets: (0..self.sets.len()).collect(), places: (0..globals.len()).collect() }];
        }
        let part = |object: usize| Part {
            sets: (0..self.sets.len()).filter(|&d| self.sets[d].object == object).collect(),
            places: (0..globals.len()).filter(|&g| globals[g].object == Some(object)).collect(),
        };
        (0..objects).map(part).filter(|part| !part.sets.is_empty()).collect()
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
                let rolled: Result<Vec<Vec<f64>>> =
                    part.sets.par_iter().map(|&d| self.residual(d, &candidate, effort.horizon)).collect();
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
        let (shared, own) = equations.solve(damping);
        let own: f64 = equations.blocks.iter().zip(&own).map(|(b, step)| b.own_right.dot(step)).sum();
        shared.dot(&equations.right) + own
    }

    /// A weak pull of the own unknowns towards their guesses, so that a direction on which the data are silent stays put.
    fn pull(&self, point: &Point, sets: impl Iterator<Item = usize>) -> f64 {
        let each = sets.map(|d| (&self.sets[d], &point.own[d]));
        each.flat_map(|(s, own)| s.prepared.own.iter().zip(&s.pull).zip(own))
            .map(|((p, pull), v)| 0.5 * ((v - p.value) / pull).powi(2))
            .sum()
    }

    fn distance(&self, part: &Part, a: &Point, b: &Point) -> f64 {
        let shared = part.places.iter().map(|&g| {
            let span = self.structure.globals[g].parameter.span();
            (a.globals[g] - b.globals[g]).abs() / span
        });
        let own = part.sets.iter().flat_map(|&d| {
            let both = a.own[d].iter().zip(&b.own[d]);
            self.sets[d].prepared.own.iter().zip(both).map(|(p, (a, b))| (a - b).abs() / p.span())
        });
        shared.chain(own).fold(0.0, f64::max)
    }

    /// The normal equations of a part, its free numbers counted from 0.
    fn equations(&self, part: &Part, columns: &[Columns], residuals: &[Vec<f64>], point: &Point, scale: f64) -> Arrow {
        let mut arrow = Arrow::new(part.places.len(), columns.len());
        for ((&d, one), left) in part.sets.iter().zip(columns).zip(residuals) {
            let weights: Vec<f64> = left.iter().map(|r| huber_weight(*r, scale)).collect();
            let all: Vec<&Vec<f64>> = one.shared.iter().chain(&one.own).collect();
            let (shared, own) = (one.shared.len(), one.own.len());
            let mut normal = DMatrix::zeros(all.len(), all.len());
            let mut right = DVector::zeros(all.len());
            let mut weighted = vec![0.0; weights.len()];
            for i in 0..all.len() {
                weighted.iter_mut().zip(all[i].iter().zip(&weights)).for_each(|(w, (a, b))| *w = a * b);
                for j in 0..=i {
                    let product = dot(&weighted, all[j]);
                    normal[(i, j)] = product;
                    normal[(j, i)] = product;
                }
                right[i] = -dot(&weighted, left);
            }
            let within = |place: &usize| part.places.iter().position(|p| p == place);
            let places: Vec<usize> = one.places.iter().filter_map(within).collect();
            for (i, &row) in places.iter().enumerate() {
                arrow.right[row] += right[i];
                for (j, &column) in places.iter().enumerate() {
                    arrow.shared[(row, column)] += normal[(i, j)];
                }
            }
            let mut own_normal = normal.view((shared, shared), (own, own)).into_owned();
            let mut own_right = right.rows(shared, own).into_owned();
            let set = &self.sets[d];
            for (i, (p, pull)) in set.prepared.own.iter().zip(&set.pull).enumerate() {
                own_normal[(i, i)] += pull.powi(-2);
                own_right[i] -= (point.own[d][i] - p.value) / pull.powi(2);
            }
            let coupling = normal.view((0, shared), (shared, own)).into_owned();
            arrow.blocks.push(Block { places, coupling, own: own_normal, own_right });
        }
        // A coefficient on which the data are silent stays put.
        for (i, &place) in part.places.iter().enumerate() {
            let global = &self.structure.globals[place];
            if global.effect.is_some() {
                arrow.shared[(i, i)] += global.parameter.span().powi(-2);
            }
        }
        // A number on a bound that wants to leave it is held there.
        for (i, &place) in part.places.iter().enumerate() {
            let (p, value) = (&self.structure.globals[place].parameter, point.globals[place]);
            if arrow.right[i] < 0.0 && value <= p.min || arrow.right[i] > 0.0 && value >= p.max {
                arrow.hold(i);
            }
        }
        arrow
    }

    fn moved(&self, part: &Part, point: &Point, equations: &Arrow, damping: f64) -> Point {
        let (shared, own) = equations.solve(damping);
        let mut moved = point.clone();
        for (&place, step) in part.places.iter().zip(shared.iter()) {
            let global = &self.structure.globals[place];
            let (p, value) = (&global.parameter, &mut moved.globals[place]);
            let bound = (*value + step).clamp(p.min, p.max);
            // Where a ball loses nothing it bounces for ever, and a rollout takes as long.
            let short = global.effect.is_none() && bound != *value + step;
            *value += if short { NEARER * (bound - *value) } else { bound - *value };
        }
        for (&d, steps) in part.sets.iter().zip(own) {
            for ((value, step), p) in moved.own[d].iter_mut().zip(steps.iter()).zip(&self.sets[d].prepared.own) {
                *value = (*value + step).clamp(p.min, p.max);
            }
        }
        moved
    }
}

/// Moves `value` by `step`, inward where it would leave the bounds; returns the step taken.
fn nudge(value: &mut f64, parameter: &Parameter, step: f64) -> f64 {
    let before = *value;
    *value += if (parameter.min..=parameter.max).contains(&(before + step)) { step } else { -step };
    *value - before
}

/// The robust size of white residuals; those that do not count are 0 and say nothing of it.
pub(super) fn spread(residuals: &[Vec<f64>]) -> f64 {
    let counted: Vec<f64> = residuals.iter().flatten().copied().filter(|r| *r != 0.0).collect();
    if counted.is_empty() { 1.0 } else { robust_scale(&[counted]) }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
