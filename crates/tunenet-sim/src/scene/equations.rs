//! The scene of equations that stand in the file itself.

use indexmap::IndexMap;
use serde::Deserialize;

use super::{Candidates, Inputs, Record, Starts};

/// A simulator written as differential equations.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EquationsScene {
    /// `[states.NAME]`, in the order of the file.
    pub states: IndexMap<String, State>,
    /// A formula for the derivative of every state by time.
    pub derivatives: IndexMap<String, String>,
    /// A formula for every channel; every state is one where this is empty.
    #[serde(default)]
    pub outputs: IndexMap<String, String>,
    /// Numbers that formulas may use.
    #[serde(default)]
    pub constants: IndexMap<String, f64>,
    /// What happens at an instant.
    #[serde(default)]
    pub events: IndexMap<String, Event>,
    /// What is written of it.
    #[serde(default)]
    pub record: Record,
    /// What drives the thing.
    #[serde(default)]
    pub inputs: Inputs,
    /// Where its states start.
    #[serde(default)]
    pub start: Starts,
    /// Effects that it may lack.
    #[serde(default)]
    pub candidates: Candidates,
}

impl EquationsScene {
    /// What it predicts: the names of its outputs, or of its states where it names none.
    #[must_use]
    pub fn headers(&self) -> Vec<String> {
        let states = || self.states.keys().cloned().collect();
        if self.outputs.is_empty() { states() } else { self.outputs.keys().cloned().collect() }
    }
}

/// `[states.NAME]`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct State {
    /// Its unit, where its name does not end in one.
    pub unit: Option<String>,
}

/// `[events.NAME]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// It happens when this formula falls through zero.
    pub when: String,
    /// What states are afterwards.
    #[serde(default)]
    pub then: IndexMap<String, String>,
}
