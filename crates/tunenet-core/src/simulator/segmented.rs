//! Simulators whose motion is smooth between events.

use super::{Prepared, Simulator};

/// A start from which a recording could be made next.
#[derive(Debug, Clone, PartialEq)]
pub struct ProposedStart {
    /// How to make it, as something to do.
    pub text: String,
    /// Its numbers by name, each with its unit in the name or in that of the nuisance parameter, for scripts.
    pub settings: Vec<(String, f64)>,
    /// Values of the recording's nuisance parameters, in their order.
    pub nuisances: Vec<f64>,
    /// Its speed along the surface at which events happen, in m/s.
    pub tangential_m_s: f64,
}

/// A simulator whose recordings consist of free segments between events (impacts, steps, switches of a mode).
///
/// A wrong model of the events corrupts every prediction after the first of them. A free segment alone, with a start state of
/// its own, does not depend on them. [`Simulator::segmented`] says whether a simulator is one.
pub trait Segmented: Simulator {
    /// The same simulator without events. A recording of it is one free segment, whose start state is unknown. `None` where
    /// nothing is observed between events.
    fn free_segment(&self) -> Option<Box<dyn Simulator>>;

    /// The same simulator with the state that no channel shows as nuisance parameters of every recording (the angular velocity
    /// of a body recorded by its centre), after those that it has. The hidden state acts between events and at events.
    /// `None` where it has none.
    fn with_hidden_state(&self) -> Option<Box<dyn Simulator>> {
        None
    }

    /// As [`with_hidden_state`](Self::with_hidden_state), where the hidden state acts at events only.
    fn with_hidden_state_at_events(&self) -> Option<Box<dyn Simulator>> {
        None
    }

    /// Starts from which a recording like `prepared`, whose nuisance parameters have these values, could be made next. No channel
    /// of `unmeasured` shows a motion there either. Empty where nobody can choose a start.
    fn proposed_starts(&self, _prepared: &Prepared, _nuisances: &[f64], _unmeasured: &[usize]) -> Vec<ProposedStart> {
        Vec::new()
    }
}
