//! Simulators whose motion is smooth between events.

use super::Simulator;

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
}
