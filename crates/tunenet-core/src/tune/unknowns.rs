//! Which numbers a fit may move: the tuned parameters, shared by all recordings, and each recording's nuisance parameters.

use crate::simulator::{Parameter, Prepared, Simulator};

/// A point of the search: all parameters of the simulator, and the nuisance parameters of every recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// All parameters, in the simulator's order.
    pub parameters: Vec<f64>,
    /// The nuisance parameters, shape `[recording][unknown]`.
    pub nuisances: Vec<Vec<f64>>,
}

impl Point {
    /// The parameters as they stand in the simulator, and the recordings' first guesses.
    #[must_use]
    pub fn start(simulator: &dyn Simulator, recordings: &[Prepared]) -> Self {
        let parameters = simulator.parameters().iter().map(|p| p.value).collect();
        Self { parameters, nuisances: recordings.iter().map(Prepared::nuisance_values).collect() }
    }

    /// The same point with the parameters at `positions` replaced.
    #[must_use]
    pub fn with(&self, positions: &[usize], values: &[f64]) -> Self {
        let mut changed = self.clone();
        for (&position, &value) in positions.iter().zip(values) {
            changed.parameters[position] = value;
        }
        changed
    }

    /// The parameters at `positions`.
    #[must_use]
    pub fn at(&self, positions: &[usize]) -> Vec<f64> {
        positions.iter().map(|&i| self.parameters[i]).collect()
    }
}

/// The positions of the parameters that may be tuned and about which at least one recording says something.
#[must_use]
pub fn free(parameters: &[Parameter], recordings: &[Prepared]) -> Vec<usize> {
    let heard = |i: usize| recordings.iter().any(|r| r.silent[i].is_none());
    (0..parameters.len()).filter(|&i| parameters[i].tune && heard(i)).collect()
}
