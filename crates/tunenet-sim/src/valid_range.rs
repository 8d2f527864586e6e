//! Where a rollout leaves the range in which the formula of an effect was seen to hold.

use tunenet_core::observation::Note;

use crate::findings;

/// A variable outside its range.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LeftRange {
    pub variable: String,
    pub value: f64,
    /// On the clock of the recording, s.
    pub time_s: f64,
    pub range: (f64, f64),
}

impl LeftRange {
    /// What a user should know of it; `effect` is the name of the formula's effect.
    pub fn note(&self, effect: &str) -> Note {
        let Self { variable, value, time_s, range: (low, high) } = self;
        let text = format!(
            "`{variable}` is {value:.3} at {time_s:.3} s; the formula of `{effect}` was seen to hold from {low} to {high}"
        );
        let remedy = "rely on it within the range only, or record there and diagnose again";
        Note::new(findings::EFFECT_OUTSIDE, text, remedy)
    }
}
