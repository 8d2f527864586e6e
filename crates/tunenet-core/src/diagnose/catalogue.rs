//! What may be missing: the effects that every subject knows, and simulators that carry some of them.

use std::ops::Deref;

use super::Subject;
use crate::Result;
use crate::simulator::{Effect, Phase, Simulator};

/// An effect that may be missing.
pub(super) struct Entry {
    pub name: &'static str,
    /// The entry as each subject has it: the ranges may differ with mass and size.
    pub of: Vec<Effect>,
}

impl Entry {
    /// Whether all objects share its coefficients.
    pub fn shared(&self) -> bool {
        self.of[0].phase == Phase::Measurement
    }

    pub fn width(&self) -> usize {
        self.of[0].coefficients.len()
    }
}

/// A simulator, lent or made.
pub(super) enum Carrier<'a> {
    Plain(&'a dyn Simulator),
    Made(Box<dyn Simulator>),
}

impl<'a> Deref for Carrier<'a> {
    type Target = dyn Simulator + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Plain(simulator) => *simulator,
            Self::Made(simulator) => simulator.as_ref(),
        }
    }
}

/// The effects that all subjects know.
pub(super) fn catalogue(subjects: &[Subject]) -> Vec<Entry> {
    let known: Vec<Vec<Effect>> = subjects.iter().map(|s| s.simulator.effects()).collect();
    let everywhere = |effect: &Effect| {
        let of: Option<Vec<Effect>> =
            known.iter().map(|effects| effects.iter().find(|e| e.name == effect.name).cloned()).collect();
        of.map(|of| Entry { name: effect.name, of })
    };
    known.first().map_or_else(Vec::new, |first| first.iter().filter_map(everywhere).collect())
}

/// `subject` with these effects added.
pub(super) fn carrier<'a>(subject: &Subject<'a>, effects: &[&Entry]) -> Result<Carrier<'a>> {
    let names: Vec<&str> = effects.iter().map(|e| e.name).collect();
    if names.is_empty() {
        return Ok(Carrier::Plain(subject.simulator));
    }
    subject.simulator.with_effects(&names).map(Carrier::Made)
}
