//! What was measured, as one value, and the goals held against it.

use serde::Serialize;

use super::general;
use super::measure::{Reference, TuningAccuracy};
use super::ours::Seconds;
use super::rows::{BUDGETS, Goal, Limit, Statistic};
use crate::output::mean_and_sd;

/// One way of tuning in one row. With several trainings, means over them.
#[derive(Debug, Clone, Serialize)]
pub struct MethodErrors {
    pub name: &'static str,
    pub title: String,
    pub trainings: usize,
    /// At each budget.
    pub mean: Vec<f64>,
    pub median: Vec<f64>,
    /// Standard deviation of `mean` over the trainings; empty for one.
    pub spread: Vec<f64>,
}

impl MethodErrors {
    pub fn new(name: &'static str, title: String, runs: &[TuningAccuracy]) -> Self {
        let over = |pick: &dyn Fn(&TuningAccuracy) -> &Vec<f64>| -> Vec<(f64, f64)> {
            (0..BUDGETS.len()).map(|b| mean_and_sd(&runs.iter().map(|r| pick(r)[b]).collect::<Vec<_>>())).collect()
        };
        let (mean, spread): (Vec<f64>, Vec<f64>) = over(&|r| &r.mean).into_iter().unzip();
        let median = over(&|r| &r.median).into_iter().map(|m| m.0).collect();
        let spread = if runs.len() > 1 { spread } else { vec![] };
        Self { name, title, trainings: runs.len(), mean, median, spread }
    }

    fn at(&self, rollouts: usize, statistic: Statistic) -> Option<f64> {
        let place = BUDGETS.iter().position(|b| *b == rollouts)?;
        Some(match statistic {
            Statistic::Mean => self.mean[place],
            Statistic::Median => self.median[place],
        })
    }
}

/// One row, or one set of drops from another engine.
#[derive(Debug, Clone, Serialize)]
pub struct TuningTable {
    pub row: String,
    /// What the numbers are.
    pub unit: &'static str,
    pub targets: usize,
    /// Standard deviation of the noise, m; none where drops were not made here.
    pub noise_m: Option<f64>,
    pub reference: Option<Reference>,
    pub methods: Vec<MethodErrors>,
    pub goals: Vec<TuningGoalResult>,
    /// What the goals leave unsaid.
    pub note: Option<&'static str>,
}

/// A goal and what became of it.
#[derive(Debug, Clone, Serialize)]
pub struct TuningGoalResult {
    pub rollouts: usize,
    pub statistic: &'static str,
    pub limit: f64,
    /// How the limit came about.
    pub limit_is: String,
    pub measured: f64,
    pub met: bool,
}

/// Holds `default`, the first of the methods, against a goal; none where what the goal is measured in is not there.
pub fn hold(goal: &Goal, methods: &[MethodErrors], reference: Option<&Reference>) -> Option<TuningGoalResult> {
    let measured = methods.first()?.at(goal.rollouts, goal.statistic)?;
    let (limit, limit_is) = match goal.limit {
        Limit::Absolute(limit) => (limit, String::new()),
        Limit::Bounds(times) => (times * reference?.bound?, format!("{times} × bound")),
        Limit::Likelihoods(times) => {
            let fit = match goal.statistic {
                Statistic::Mean => reference?.mean,
                Statistic::Median => reference?.median,
            };
            (times * fit, format!("{times} × likelihood"))
        }
    };
    let statistic = match goal.statistic {
        Statistic::Mean => "mean",
        Statistic::Median => "median",
    };
    Some(TuningGoalResult { rollouts: goal.rollouts, statistic, limit, limit_is, measured, met: measured <= limit })
}

/// Everything.
#[derive(Debug, Clone, Serialize)]
pub struct TuningResults {
    pub schema: &'static str,
    pub command: String,
    pub version: &'static str,
    pub seed: u64,
    pub targets: u64,
    pub quick: bool,
    pub trainings: Vec<u64>,
    pub rollouts: Vec<usize>,
    pub rows: Vec<TuningTable>,
    pub general: Vec<general::GeneralTable>,
    /// Making one model of preset `default`, alone on the machine.
    pub making: Option<Seconds>,
    pub making_limit_s: f64,
    pub warnings: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_held_against_their_own_measure() {
        let run = TuningAccuracy { mean: vec![0.3; 5], median: vec![0.1; 5] };
        let methods = [MethodErrors::new("default", String::new(), &[run])];
        let reference = Reference { mean: 0.2, median: 0.1, bound: Some(0.1) };
        let goal = |limit, statistic| Goal { rollouts: 5, statistic, limit };
        let held = |limit, statistic| hold(&goal(limit, statistic), &methods, Some(&reference)).unwrap().met;
        assert!(held(Limit::Absolute(0.3), Statistic::Mean) && !held(Limit::Absolute(0.29), Statistic::Mean));
        assert!(held(Limit::Bounds(3.1), Statistic::Mean) && !held(Limit::Bounds(2.9), Statistic::Mean));
        assert!(held(Limit::Likelihoods(1.0), Statistic::Median) && !held(Limit::Likelihoods(1.4), Statistic::Mean));
        assert!(hold(&goal(Limit::Bounds(1.0), Statistic::Mean), &methods, None).is_none());
    }

    #[test]
    fn numbers_are_short() {
        use super::super::measure::short;
        assert_eq!([0.0, 0.000_107, 0.031_25, 9.4].map(short), ["0", "1.07e-4", "0.031", "9.400"]);
    }
}
