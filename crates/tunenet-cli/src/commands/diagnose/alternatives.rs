//! What each explanation would be in numbers, where recordings cannot choose between several.

use toml_edit::{Array, InlineTable};
use tunenet_core::observation::Observation;
use tunenet_core::simulator::Simulator;
use tunenet_core::tune::{Settings, tune};

use super::answer::Answer;

/// Each candidate with the parameters and coefficients that fit an object's recordings best with it, for whoever plans with
/// all of them. One that cannot be fitted alone is left out.
pub fn alternatives(answer: &Answer, object: usize) -> Array {
    let candidates = answer.candidates();
    let sure = answer.diagnosis.effects.iter().map(|e| e.effect.name).filter(|name| !candidates.contains(name));
    let sure: Vec<&str> = sure.collect();
    let recorded = answer.loaded.recorded.iter().filter(|r| r.object == object && !r.held_out);
    let seen: Vec<Observation> = recorded.map(|r| r.seen.clone()).collect();
    let simulator = &answer.loaded.objects[object].simulator;
    candidates.iter().filter_map(|name| fitted(simulator.as_ref(), name, &sure, &seen)).collect()
}

/// One of them, beside what is certain.
pub(crate) fn fitted(
    simulator: &dyn Simulator,
    name: &str,
    sure: &[&str],
    seen: &[Observation],
) -> Option<InlineTable> {
    let names: Vec<&str> = sure.iter().copied().chain([name]).collect();
    let with = simulator.with_effects(&names).ok()?;
    let outcome = tune(&with, seen, None, &Settings::default()).ok()?;
    let mut one = InlineTable::new();
    one.insert("name", name.into());
    for found in &outcome.parameters {
        let own = found.name.strip_prefix(name).and_then(|rest| rest.strip_prefix('.'));
        one.insert(own.map_or_else(|| found.name.replace('.', "_"), str::to_owned), found.value.into());
    }
    (one.len() > 1).then_some(one)
}
