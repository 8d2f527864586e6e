//! What was measured.

use anyhow::Result;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::super::super::tuning::targets::DropTarget;
use super::BUDGETS;
use super::methods::{Method, Table2Tuners};
use crate::output::mean_and_sd;
use tunenet_core::statistics::mean;

/// Errors below are rounding, and no better than one another.
pub const ROUNDING: f64 = 1e-12;
/// A rival whose error is less than ours by this share at most is no better.
pub const TIED: f64 = 0.01;
/// Rollouts at which the figure has a point.
pub const POINTS: [usize; 12] = [0, 1, 2, 3, 4, 5, 7, 10, 20, 30, 50, 100];

/// Mean absolute errors of restitution over the targets of one seed, at each of [`POINTS`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SeedAccuracy {
    pub mean: Vec<f64>,
}

impl SeedAccuracy {
    pub fn measure(tuner: &Table2Tuners, method: Method, targets: &[DropTarget], seed: u64) -> Result<Self> {
        let one = |target: &DropTarget| -> Result<Vec<f64>> {
            let course = tuner.course(method, target, seed)?;
            Ok(POINTS.iter().map(|k| (course[*k] - target.restitution).abs()).collect())
        };
        let all = targets.par_iter().map(one).collect::<Result<Vec<_>>>()?;
        let over_targets = |k: usize| mean(all.iter().map(|errors| errors[k]));
        Ok(Self { mean: (0..POINTS.len()).map(over_targets).collect() })
    }
}

/// One method on one set.
#[derive(Debug, Clone)]
pub struct Table2Cell {
    pub set: &'static str,
    pub method: Method,
    pub seeds: Vec<SeedAccuracy>,
}

impl Table2Cell {
    /// The mean over the seeds at the point number `place` of [`POINTS`].
    pub fn at(&self, place: usize) -> f64 {
        mean(self.seeds.iter().map(|s| s.mean[place]))
    }

    /// The mean over the seeds after so many rollouts, one of [`BUDGETS`], and its spread over the seeds.
    pub fn after(&self, rollouts: usize) -> (f64, f64) {
        debug_assert!(BUDGETS.contains(&rollouts));
        let place = POINTS.iter().position(|k| *k == rollouts).unwrap_or(0);
        mean_and_sd(&self.seeds.iter().map(|s| s.mean[place]).collect::<Vec<_>>())
    }
}

/// The whole table.
#[derive(Debug, Clone)]
pub struct Table2Results {
    pub seed: u64,
    pub seeds: u64,
    pub targets: u64,
    pub quick: bool,
    pub cells: Vec<Table2Cell>,
}

impl Table2Results {
    /// The cells of one set, in the order of the methods.
    pub fn cells_of<'a>(&'a self, set: &'a str) -> impl Iterator<Item = &'a Table2Cell> {
        self.cells.iter().filter(move |c| c.set == set)
    }

    /// The method with the least error on a set after so many rollouts; preset `default` where nothing is better by more than
    /// rounding, or by [`TIED`].
    pub fn best(&self, set: &str, rollouts: usize) -> Option<Method> {
        let error = |c: &Table2Cell| c.after(rollouts).0;
        let least = self.cells_of(set).min_by(|a, b| error(a).total_cmp(&error(b)))?;
        let ours = self.cells_of(set).find(|c| c.method == Method::Default)?;
        let tied = error(ours) <= (1.0 + TIED) * error(least) + ROUNDING;
        Some(if tied { Method::Default } else { least.method })
    }
}
