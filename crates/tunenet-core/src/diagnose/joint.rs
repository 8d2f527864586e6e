//! Rollouts of a structure beside its recordings, and what hangs together in them.

use nalgebra::DMatrix;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::evidence::recording::Set;
use super::hypothesis::structure::Structure;
use crate::Result;
use crate::estimate::problem::robust_scale;
use crate::simulator::{every, predict};

/// Where a fit stands.
#[derive(Debug, Clone)]
pub(super) struct Point {
    /// In the structure's order.
    pub globals: Vec<f64>,
    /// Shape `[recording][unknown]`.
    pub nuisances: Vec<Vec<f64>>,
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

/// A structure and the recordings that it is fitted to.
pub(super) struct Joint<'a> {
    pub structure: &'a Structure<'a>,
    pub sets: &'a [Set],
    /// Counts rollouts.
    pub rollouts: &'a AtomicUsize,
}

impl Joint<'_> {
    pub fn samples(&self, d: usize, horizon: f64) -> usize {
        let all = self.sets[d].clock().len();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
        let share = (all as f64 * horizon).ceil() as usize;
        share.clamp(crate::observation::FEWEST_SAMPLES.min(all), all)
    }

    /// Measured − predicted of one recording in its own unit, over its first `samples`.
    pub fn plain(&self, d: usize, globals: &[f64], nuisances: &[f64], samples: usize) -> Result<Vec<f64>> {
        let set = &self.sets[d];
        self.rollouts.fetch_add(1, Ordering::Relaxed);
        let parameters = self.structure.parameters(set.object, globals);
        let simulator = self.structure.simulator(set.object);
        let mut values = predict(simulator, &set.prepared, &parameters, nuisances, &set.clock()[..samples])?;
        values.iter_mut().zip(set.prepared.seen.values()).for_each(|(value, seen)| *value = seen - *value);
        Ok(values)
    }

    pub fn white(&self, d: usize, globals: &[f64], nuisances: &[f64], samples: usize) -> Result<Vec<f64>> {
        let mut values = self.plain(d, globals, nuisances, samples)?;
        self.sets[d].filter.apply(&mut values);
        Ok(values)
    }

    /// Measured − predicted in the channels' own units, shape `[recording][sample · channel]`.
    pub fn plain_residuals(&self, point: &Point) -> Result<Vec<Vec<f64>>> {
        let each = |d: usize| self.plain(d, &point.globals, &point.nuisances[d], self.sets[d].clock().len());
        every((0..self.sets.len()).into_par_iter().map(each))
    }

    /// White residuals over the first share `horizon` of each recording.
    pub fn residuals(&self, point: &Point, horizon: f64) -> Result<Vec<Vec<f64>>> {
        let each = |d: usize| self.residual(d, point, horizon);
        every((0..self.sets.len()).into_par_iter().map(each))
    }

    pub fn residual(&self, d: usize, point: &Point, horizon: f64) -> Result<Vec<f64>> {
        self.white(d, &point.globals, &point.nuisances[d], self.samples(d, horizon))
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

    /// A weak pull of the nuisance parameters towards their guesses, so that a direction on which the data are silent stays put.
    pub fn pull(&self, point: &Point, sets: impl Iterator<Item = usize>) -> f64 {
        let each = sets.map(|d| (&self.sets[d], &point.nuisances[d]));
        each.flat_map(|(s, nuisances)| s.prepared.nuisances.iter().zip(&s.pull).zip(nuisances))
            .map(|((p, pull), v)| 0.5 * ((v - p.value) / pull).powi(2))
            .sum()
    }
}

/// The robust size of white residuals; those that do not count are 0 and say nothing of it.
pub(super) fn spread(residuals: &[Vec<f64>]) -> f64 {
    let counted: Vec<f64> = residuals.iter().flatten().copied().filter(|r| *r != 0.0).collect();
    if counted.is_empty() { 1.0 } else { robust_scale(&[counted]) }
}
