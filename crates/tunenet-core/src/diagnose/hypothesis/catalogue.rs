//! What may be missing: the effects that every subject knows, and simulators that carry some of them.

use std::ops::Deref;

use crate::Result;
use crate::diagnose::Subject;
use crate::simulator::{Effect, Measured, Phase, Simulator, Text};

/// An effect that may be missing.
#[derive(Clone)]
pub(in crate::diagnose) struct Entry {
    pub name: Text,
    /// The entry as each subject has it: the ranges may differ with mass and size.
    pub of: Vec<Effect>,
    /// For each coefficient: whether the recordings depend on it; what acts along an axis that was not measured is not free.
    pub seen: Vec<bool>,
}

impl Entry {
    /// Whether all objects share its coefficients.
    pub fn shared(&self) -> bool {
        self.of[0].phase == Phase::Measurement
    }

    /// Whether it is a random effect: its draws, one or more to each event, are nuisance parameters of a recording.
    pub fn is_random_effect(&self) -> bool {
        self.of[0].random
    }
}

/// A simulator, lent or made.
pub(in crate::diagnose) enum Carrier<'a> {
    Plain(&'a dyn Simulator),
    Made(Box<dyn Simulator>),
    Seen(Measured<&'a dyn Simulator>),
}

impl<'a> Deref for Carrier<'a> {
    type Target = dyn Simulator + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Plain(simulator) => *simulator,
            Self::Made(simulator) => simulator.as_ref(),
            Self::Seen(simulator) => simulator,
        }
    }
}

/// The effects that all subjects know, and those of how they were seen.
pub(in crate::diagnose) fn catalogue(subjects: &[Subject]) -> Vec<Entry> {
    let known: Vec<Vec<Effect>> = subjects
        .iter()
        .map(|s| s.simulator.effects().into_iter().chain(s.simulator.measured_effects()).collect())
        .collect();
    let everywhere = |effect: &Effect| {
        let of: Option<Vec<Effect>> =
            known.iter().map(|effects| effects.iter().find(|e| e.name == effect.name).cloned()).collect();
        of.map(|of| Entry { name: effect.name.clone(), of, seen: vec![true; effect.coefficients.len()] })
    };
    known.first().into_iter().flatten().filter_map(everywhere).collect()
}

/// `subject` with these effects added.
pub(in crate::diagnose) fn carrier<'a>(subject: &Subject<'a>, effects: &[&Entry]) -> Result<Carrier<'a>> {
    let names: Vec<&str> = effects.iter().map(|e| e.name.as_ref()).collect();
    // A simulator may have effects of the measurement of its own.
    let own = subject.simulator.effects();
    let around = |e: &&&Entry| e.shared() && !own.iter().any(|effect| effect.name == e.name);
    let (seen, physical): (Vec<&Entry>, Vec<&Entry>) = effects.iter().partition(around);
    if names.is_empty() {
        return Ok(Carrier::Plain(subject.simulator));
    }
    let made = subject.simulator.with_effects(&names);
    if seen.is_empty() || made.is_ok() {
        return made.map(Carrier::Made);
    }
    let seen: Vec<&str> = seen.iter().map(|e| e.name.as_ref()).collect();
    let physical: Vec<&str> = physical.iter().map(|e| e.name.as_ref()).collect();
    Ok(if physical.is_empty() {
        Carrier::Seen(Measured::new(subject.simulator, &seen)?)
    } else {
        Carrier::Made(Box::new(Measured::new(subject.simulator.with_effects(&physical)?, &seen)?))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{entry, in_swings};

    #[test]
    fn a_subject_carries_physical_and_measurement_effects() {
        in_swings(&[], 1, 0, |context| {
            let names: Vec<&str> = context.catalogue.iter().map(|e| e.name.as_ref()).collect();
            assert!(names.contains(&"viscous_friction") && names.contains(&"time_scale"), "{names:?}");
            let of = |name: &str| &context.catalogue[entry(context, name)];
            assert!(of("time_scale").shared() && !of("rest_angle").shared());
            let carried = carrier(&context.subjects[0], &[of("rest_angle"), of("time_scale")]).unwrap();
            let names: Vec<&str> = carried.parameters().iter().map(|p| p.name.as_str()).collect();
            assert_eq!(names[..2], ["length", "rest_angle.angle_rad"]);
            assert!(names[2].starts_with("time_scale."), "{names:?}");
        });
    }
}
