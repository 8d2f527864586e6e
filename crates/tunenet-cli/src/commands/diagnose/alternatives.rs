//! What each explanation would be in numbers, where recordings cannot choose between several.

use anyhow::Result;
use toml_edit::Array;
use tunenet_core::observation::Observation;
use tunenet_sim::SimulationFile;

use crate::answers::diagnose::Answer;
use crate::view::toml::alternatives::{fitted, open_to};

/// Each candidate with the parameters and coefficients that fit an object's recordings best with it, for whoever plans with
/// all of them, and how well it then fits. One that cannot be fitted alone is left out.
pub fn alternatives(answer: &Answer, object: usize) -> Array {
    let candidates = answer.candidates();
    let sure = answer.diagnosis.effects.iter().map(|e| e.effect.name).filter(|name| !candidates.contains(name));
    let sure: Vec<&str> = sure.collect();
    fitted(answer.loaded.objects[object].simulator.as_ref(), candidates, &sure, &seen_of(answer, object))
}

/// The drag that an object's recordings leave open beside the effects that are certain, which its `improved` file holds.
pub fn open(answer: &Answer, object: usize, improved: &SimulationFile) -> Result<Array> {
    let sure: Vec<&str> = answer.diagnosis.effects.iter().map(|e| e.effect.name).collect();
    Ok(open_to(improved, &sure, &seen_of(answer, object))?)
}

fn seen_of(answer: &Answer, object: usize) -> Vec<Observation> {
    let recorded = answer.loaded.recorded.iter().filter(|r| r.object == object && !r.held_out);
    recorded.map(|r| r.seen.clone()).collect()
}
