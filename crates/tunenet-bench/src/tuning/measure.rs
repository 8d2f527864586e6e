//! One cell after the other: a row's targets under one way of tuning.

use anyhow::Result;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tunenet_core::network::Model;

use super::super::search::{Course, brent, nearest};
use super::likelihood;
use super::ours;
use super::rivals::{self, Stored};
use super::rows::{BUDGETS, Conditions, MOST};
use super::targets::{DropTarget, Simulation, mean_distance};
use crate::output::mean_and_median;

/// A way of tuning that has no training.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rival {
    Apex,
    Nearest,
    Brent,
}

impl Rival {
    pub const ALL: [Self; 3] = [Self::Apex, Self::Nearest, Self::Brent];

    pub fn name(self) -> &'static str {
        match self {
            Self::Apex => "apex",
            Self::Nearest => "nearest",
            Self::Brent => "brent",
        }
    }

    /// In words.
    pub fn title(self) -> &'static str {
        match self {
            Self::Apex => "apex-height loop",
            Self::Nearest => "nearest of 201 stored rollouts, then secant Gauss–Newton",
            Self::Brent => "bounded Brent on the squared error",
        }
    }
}

/// Who tunes.
pub enum BenchTuner<'a> {
    Network(&'a Model),
    Rival(Rival, &'a Stored),
}

/// Errors after each of [`BUDGETS`] rollouts.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TuningAccuracy {
    pub mean: Vec<f64>,
    pub median: Vec<f64>,
}

/// What the data of a row allow.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Reference {
    /// Errors of the maximum-likelihood fit.
    pub mean: f64,
    pub median: f64,
    /// Mean of the Cramér–Rao bound over the targets, as a mean absolute error; none where some target says nothing.
    pub bound: Option<f64>,
}

pub fn courses(simulation: &Simulation, tuner: &BenchTuner, targets: &[DropTarget]) -> Result<Vec<Course>> {
    let one = |target: &DropTarget| match tuner {
        BenchTuner::Network(model) => ours::course(simulation, model, target, MOST),
        BenchTuner::Rival(Rival::Apex, _) => rivals::apex_loop(simulation, target, MOST),
        BenchTuner::Rival(Rival::Nearest, stored) => {
            nearest::search(&simulation.search(target, 0), stored.from(target.fall_m, &simulation.clock), MOST)
        }
        BenchTuner::Rival(Rival::Brent, _) => brent::search(&simulation.search(target, 0), MOST),
    };
    targets.par_iter().map(one).collect()
}

/// Errors of restitution.
pub fn accuracy(courses: &[Course], targets: &[DropTarget]) -> TuningAccuracy {
    summarise(|k| courses.iter().zip(targets).map(|(c, t)| (c[k] - t.restitution).abs()).collect())
}

/// Mean distance in height of the tuned simulator, cm.
pub fn distances_cm(simulation: &Simulation, courses: &[Course], targets: &[DropTarget]) -> Result<TuningAccuracy> {
    let one = |(course, target): (&Course, &DropTarget)| -> Result<Vec<f64>> {
        let at = |k: &usize| Ok(100.0 * mean_distance(&simulation.roll(target, course[*k])?, &target.heights_m));
        BUDGETS.iter().map(at).collect()
    };
    let all = courses.par_iter().zip(targets).map(one).collect::<Result<Vec<_>>>()?;
    let place = |k: usize| BUDGETS.iter().position(|b| *b == k).unwrap_or(0);
    Ok(summarise(|k| all.iter().map(|d| d[place(k)]).collect()))
}

fn summarise(errors: impl Fn(usize) -> Vec<f64>) -> TuningAccuracy {
    let (mean, median) = BUDGETS.iter().map(|&k| mean_and_median(errors(k))).unzip();
    TuningAccuracy { mean, median }
}

/// The maximum-likelihood fit and the bound, both from the closed form alone.
pub fn reference(simulation: &Simulation, conditions: Conditions, targets: &[DropTarget]) -> Reference {
    let clock = &simulation.clock;
    let one = |t: &DropTarget| {
        let error = (likelihood::fit(t.fall_m, clock, &t.heights_m) - t.restitution).abs();
        (error, likelihood::bound(t.fall_m, t.restitution, clock, conditions.noise_m))
    };
    let (errors, bounds): (Vec<f64>, Vec<f64>) = targets.par_iter().map(one).unzip();
    let bound = bounds.iter().sum::<f64>() / bounds.len() as f64;
    let (mean, median) = mean_and_median(errors);
    Reference { mean, median, bound: bound.is_finite().then_some(bound) }
}

/// A number with three digits: `0.000107` is `1.07e-4`.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if (0.01..1000.0).contains(&value.abs()) {
        return format!("{value:.3}");
    }
    format!("{value:.2e}")
}
