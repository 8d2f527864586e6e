//! Equations as a simulator that core can tune and diagnose.

use tunenet_core::simulator::{Model, RolloutResult, Run};

use super::rollout::rollout;
use super::system::System;

/// Equations that simulate: one system for each setup of the recordings, which differ in constants and starts.
#[derive(Debug, Clone)]
pub struct EquationsModel {
    systems: Vec<System>,
}

impl EquationsModel {
    /// Of the systems of all setups, at least one.
    #[must_use]
    pub fn new(systems: Vec<System>) -> Self {
        Self { systems }
    }
}

impl Model for EquationsModel {
    fn simulate(&self, run: &Run, values: &mut [f64]) -> RolloutResult {
        let setup = run.recording.setup;
        let system = self.systems.get(setup).ok_or_else(|| format!("no equations for setup {setup}"))?;
        rollout(system, run, values)
    }

    fn checks_states(&self) -> bool {
        true
    }
}
