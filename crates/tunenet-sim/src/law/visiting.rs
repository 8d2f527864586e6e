//! A simulator with its own way to say what a rollout visits.

use tunenet_core::Result;
use tunenet_core::law::{Visit, Visiting};
use tunenet_core::observation::{Channel, Circumstances, Kind, Observation};
use tunenet_core::simulator::{Effect, Parameter, Preparation, Prepared, RolloutResult, Simulator};

/// What a rollout with these parameters and nuisance parameters of a recording visits at these instants.
pub type Visits = dyn Fn(&Prepared, &[f64], &[f64], &[f64]) -> Result<Vec<Visit>> + Send + Sync;

/// The simulator.
pub struct Following {
    pub simulator: Box<dyn Simulator>,
    pub visits: Box<Visits>,
}

impl Simulator for Following {
    fn parameters(&self) -> &[Parameter] {
        self.simulator.parameters()
    }

    fn channels(&self) -> &[Channel] {
        self.simulator.channels()
    }

    fn kind(&self) -> Kind {
        self.simulator.kind()
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        self.simulator.prepare(seen)
    }

    fn effects(&self) -> Vec<Effect> {
        self.simulator.effects()
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        self.simulator.with_effects(names)
    }

    fn rollout_driven(
        &self,
        parameters: &[f64],
        nuisances: &[f64],
        circumstances: &Circumstances,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        self.simulator.rollout_driven(parameters, nuisances, circumstances, clock, values)
    }

    fn rollout(&self, parameters: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        self.simulator.rollout(parameters, nuisances, clock, values)
    }
}

impl Visiting for Following {
    fn visits(
        &self,
        recording: &Prepared,
        parameters: &[f64],
        nuisances: &[f64],
        instants_s: &[f64],
    ) -> Result<Vec<Visit>> {
        (self.visits)(recording, parameters, nuisances, instants_s)
    }
}
