//! Simulators: parameters, channels and rollouts.

mod assumed;
mod declared;
mod effect;
mod effects;
mod fn_simulator;
mod measured;
mod parameter;
mod prepared;
mod rollout_error;
mod rollouts;
mod scale;
mod segmentation;
mod segmented;
mod setups;
mod start_state;

pub use assumed::Assumed;
pub use declared::{Declared, Model, Run};
pub use effect::{Coefficient, Effect, Excitation, Follows, Phase, Side, Text, Twin};
pub use effects::measurement_effects;
pub use fn_simulator::FnSimulator;
pub use measured::Measured;
pub use parameter::Parameter;
pub use prepared::{Preparation, Prepared, Rejected};
pub use rollout_error::{RolloutError, RolloutResult};
pub(crate) use rollouts::every;
pub use rollouts::{predict, rollout, rollouts};
pub use scale::Scale;
pub use segmentation::Segmentation;
pub use segmented::{ProposedStart, Segmented};
pub use setups::Setups;
pub(crate) use start_state::STATE;
pub use start_state::{StartState, StartValue};

use auto_impl::auto_impl;

use crate::observation::{Channel, Circumstances, Kind, Observation};
use crate::{Error, Origin, Result};

/// Anything that can be rolled out with given parameters. Implement this to tune a simulator of your own.
///
/// Only [`parameters`](Simulator::parameters), [`channels`](Simulator::channels) and [`rollout`](Simulator::rollout) are
/// needed; a complete example stands in `examples/pendulum.rs` of this crate.
///
/// A rollout takes two kinds of parameters:
/// - **parameters** belong to the thing itself (its friction, its load) and are what a user asks for;
/// - **nuisance parameters** belong to one recording (its initial state, the height of a surface) and are estimated with
///   it and then discarded. See [`prepare`](Simulator::prepare).
///
/// What stands behind a reference or lies in a box is a simulator as well.
#[auto_impl(&, Box)]
pub trait Simulator: Send + Sync {
    /// The parameters in the order in which [`rollout`](Simulator::rollout) takes them, with value, bounds and unit.
    fn parameters(&self) -> &[Parameter];

    /// What is observed, in the order of the values that a rollout writes.
    fn channels(&self) -> &[Channel];

    /// Which kind of observation this simulator predicts.
    fn kind(&self) -> Kind {
        Kind::Other
    }

    /// Makes `seen` ready: cuts it to what can be explained, and names its nuisance parameters.
    ///
    /// # Errors
    /// Where `seen` is a kind of observation that this simulator does not predict.
    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        Ok(Preparation::Usable(Box::new(Prepared::whole(seen.clone(), self.parameters().len()))))
    }

    /// The physical effects that it can take on beyond its base model, absent at present. None, unless it says so.
    fn effects(&self) -> Vec<Effect> {
        Vec::new()
    }

    /// The effects of the measurement that may be looked for around it: those of its [`kind`](Simulator::kind), unless it has its own.
    fn measured_effects(&self) -> Vec<Effect> {
        measurement_effects(self.kind())
    }

    /// The same simulator with these of its [`effects`](Simulator::effects) added: their coefficients follow its
    /// parameters in the order of `names`, each at its absent value, free to tune, and named by
    /// [`Effect::parameter_name`]. An effect that it already has at fixed values begins there instead.
    ///
    /// # Errors
    /// [`Error::Setting`] where it does not know one of them.
    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        Err(Error::Setting {
            origin: Origin::Caller,
            name: "effects",
            expected: "an effect of this simulator".into(),
            found: names.join(", "),
        })
    }

    /// Constants that it takes for granted although only their usual values are known. None, unless it says so.
    fn assumed(&self) -> Vec<Assumed> {
        Vec::new()
    }

    /// This simulator as one whose recordings consist of segments between events, where it knows any.
    fn segmented(&self) -> Option<&dyn Segmented> {
        None
    }

    /// As [`rollout`](Self::rollout), in the circumstances of one recording: what drove the thing, where it started, its constants.
    /// It is asked where [`prepare`](Self::prepare) gives [circumstances](Prepared::circumstances).
    ///
    /// # Errors
    /// As [`rollout`](Self::rollout).
    fn rollout_driven(
        &self,
        parameters: &[f64],
        nuisances: &[f64],
        circumstances: &Circumstances,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        let _ = circumstances;
        self.rollout(parameters, nuisances, clock, values)
    }

    /// Simulates once and writes the prediction for every instant of `clock` into `values`, row-major
    /// `[sample, channel]`. `parameters` are all of [`parameters`](Simulator::parameters), `nuisances` all of
    /// [`Prepared::nuisances`]. Deterministic: the same arguments give the same bits.
    ///
    /// # Errors
    /// A sentence for users where these values cannot be simulated, or where the simulator failed.
    fn rollout(&self, parameters: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult;
}
