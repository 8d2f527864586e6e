//! What is known of a recording besides what was observed.

use super::Input;

/// The circumstances of one recording, which its simulator needs for every rollout.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Circumstances {
    /// What the recording is called in sentences for users, such as a file's name; empty where it has none.
    pub name: String,
    /// Which setup of its simulator the recording has (constants and initial states that differ from recording to recording): a
    /// position, 0 where there is only one.
    pub setup: usize,
    /// The recording's first instant, s: its initial state holds there. [`prepare`](crate::simulator::Simulator::prepare) sets it.
    pub start_s: f64,
    /// What drove the thing.
    pub inputs: Vec<Input>,
    /// The initial state as far as it is known, in the order of the simulator's states. Empty before
    /// [`prepare`](crate::simulator::Simulator::prepare), and where a simulator has no states.
    pub start: Vec<f64>,
}

impl Circumstances {
    /// What drove a recording, on the clock of that recording.
    #[must_use]
    pub fn driven_by(inputs: Vec<Input>) -> Self {
        Self { inputs, ..Self::default() }
    }

    /// The same on a clock that starts this much earlier.
    pub(super) fn earlier(&self, by_s: f64) -> Self {
        let inputs = self.inputs.iter().map(|input| input.earlier(by_s)).collect();
        Self { start_s: self.start_s - by_s, inputs, ..self.clone() }
    }
}
