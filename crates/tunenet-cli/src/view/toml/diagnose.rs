//! The provenance of an improved simulation file: the evidence for each effect, and what the recordings leave open.

use anyhow::Result;
use toml_edit::{Array, InlineTable};
use tunenet_core::diagnose::{Change, Gap, GapOf, NamedEffect, Verdict};
use tunenet_core::observation::Observation;
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use super::alternatives::{Stated, fitted, open_to};
use super::provenance::Provenance;
use crate::answers::diagnose::{Answer, Recorded, gap_of, is_per_joint, value_of};

/// The provenance of the `improved` file of one object: what was read, which effects were named, and on what evidence.
pub fn provenance(
    seed: u64,
    answer: &Answer,
    gap: &Gap,
    object: usize,
    improved: &SimulationFile,
) -> Result<Provenance> {
    let diagnosis = answer.diagnosis;
    let mine = diagnosis.parameters.iter().filter(|p| p.object == object);
    let effects = answer.effects_of(object);
    let unneeded =
        diagnosis.effects().iter().map(|e| e.effect.name.as_ref()).filter(|name: &&str| !holds(&effects, name));
    let mut made = Provenance::new("diagnose", seed, diagnosis.verdict())?
        .with("observations", observations(answer, object))
        .with_intervals(mine.map(|p| (p.name.clone(), p.interval95)))
        .with("effects", effects.iter().map(|e| evidence(e, object)).collect::<Array>())
        .with_any("not_needed", unneeded.collect());
    let ambiguous = diagnosis.verdict() == Verdict::OneOf && !effects.is_empty();
    if ambiguous {
        // Of effects that are not distinguished only one is written, never all together.
        made = made
            .with("candidates", candidates(answer, &effects).into_iter().collect::<Array>())
            .with("chosen", effects.iter().map(|e| e.effect.name.as_ref()).collect::<Array>());
        // Numbers of flights alone are not those that a fit to whole recordings finds, where these are not explained.
        // A robot's other explanations are fitted anew by whoever needs them: they take as long as the diagnosis.
        if gap.of == GapOf::Recordings && improved.domain() != Domain::Robot {
            made = made.with("alternatives", alternatives(answer, &effects, object));
        }
    }
    // What is open to a ball is asked of its file alone, which not all of these recordings were made in.
    let one_setup = answer.loaded.recorded.iter().all(|recorded| recorded.object != object || recorded.own.is_empty());
    if !ambiguous && one_setup {
        let sure: Vec<&str> = effects.iter().map(|e| e.effect.name.as_ref()).collect();
        made = made.with_any("open_drag", open_to(improved, &sure, &seen_of(answer, object))?);
    }
    made = made.with("gap_of", gap_of(gap)).with_gap(&gap.unit, [gap.before, gap.after, gap.noise_floor]);
    let pairs = [
        (["held_out_before", "held_out_after"], &gap.held_out),
        (["forecast_before", "forecast_after"], &gap.forecast),
    ];
    for ([before, after], change) in pairs {
        if let Some(Change { before: old, after: new }) = change {
            made = made.with(before, *old).with(after, *new);
        }
    }
    Ok(made)
}

/// The recordings of one object that were read.
fn observations(answer: &Answer, object: usize) -> Array {
    let one = |recorded: &Recorded| {
        let used = answer.diagnosis.uses.iter().find(|u| u.name == recorded.name);
        let mut one = InlineTable::new();
        one.insert("file", recorded.name.as_str().into());
        one.insert("sha256", recorded.hash.as_str().into());
        one.insert("held_out", used.map_or(recorded.held_out, |u| u.held_out).into());
        if let Some(reference) = &recorded.reference {
            one.insert("reference", reference.clone().into());
        }
        if !recorded.inputs.is_empty() {
            one.insert("inputs", recorded.inputs.clone().into());
        }
        if !recorded.own.is_empty() {
            one.insert("scene", recorded.own.clone().into());
        }
        one
    };
    answer.loaded.recorded.iter().filter(|r| r.object == object).map(one).collect()
}

/// What an effect stands there for.
fn evidence(named: &NamedEffect, object: usize) -> InlineTable {
    let mut one = InlineTable::new();
    one.insert("name", named.effect.name.as_ref().into());
    one.insert("bic_gain", named.evidence.bic_gain.into());
    if let Some(other) = &named.evidence.runner_up {
        one.insert("runner_up", other.as_ref().into());
        one.insert("runner_up_bic_gap", named.evidence.runner_up_bic_gap.into());
    }
    for fitted in &named.coefficients {
        let same = named.coefficients.iter().filter(|other| other.key == fitted.key);
        let ranges: Vec<Array> = same
            .filter_map(|c| value_of(c, object))
            .map(|value| Array::from_iter([value.interval95.0, value.interval95.1]))
            .collect();
        let key = format!("{}_interval95", fitted.key);
        match <[Array; 1]>::try_from(ranges) {
            Ok([alone]) if !is_per_joint(named) => one.insert(key, alone.into()),
            Ok([alone]) => one.insert(key, [alone].into_iter().collect::<Array>().into()),
            Err(ranges) => one.insert(key, ranges.into_iter().collect::<Array>().into()),
        };
    }
    one
}

/// Each candidate with the parameters and coefficients that fit an object's recordings best with it, for whoever plans with
/// all of them, and how well it then fits. One that cannot be fitted alone is left out.
fn alternatives(answer: &Answer, effects: &[&NamedEffect], object: usize) -> Array {
    let candidates = candidates(answer, effects);
    let sure = effects.iter().map(|e| e.effect.name.as_ref()).filter(|name| !candidates.contains(name));
    let sure: Vec<&str> = sure.collect();
    let stated = stated(answer, effects, &sure, object);
    let simulator = answer.loaded.objects[object].simulator.as_ref();
    fitted(simulator, &candidates, &sure, &seen_of(answer, object), stated.as_ref())
}

/// The effect that the file holds with its numbers, where it and what is certain are all effects of the answer: the same explanation is
/// not stated twice with other numbers.
fn stated<'e>(
    answer: &Answer,
    effects: &[&'e NamedEffect],
    sure: &[&str],
    object: usize,
) -> Option<(&'e str, Vec<Stated>)> {
    let mut chosen = effects.iter().filter(|e| !sure.contains(&e.effect.name.as_ref()));
    let (first, None) = (chosen.next()?, chosen.next()) else { return None };
    if effects.iter().any(|e| is_per_joint(e)) {
        return None;
    }
    let parameters = answer.diagnosis.parameters.iter().filter(|p| p.object == object);
    let parameters = parameters.map(|p| (p.name.clone(), p.value, p.interval95));
    let coefficients = effects.iter().flat_map(|e| {
        let of_object = e.coefficients.iter().filter_map(|c| Some((&c.key, value_of(c, object)?)));
        of_object.map(|(key, value)| (format!("{}.{key}", e.effect.name), value.value, value.interval95))
    });
    Some((first.effect.name.as_ref(), parameters.chain(coefficients).collect()))
}

/// The names of the confusable set that belong to the effects of one object.
fn candidates<'e>(answer: &'e Answer, effects: &[&NamedEffect]) -> Vec<&'e str> {
    let names = answer.candidates().into_iter();
    names
        .filter(|name| holds(effects, name) || effects.iter().any(|e| e.alternatives.iter().any(|other| other == name)))
        .collect()
}

fn holds(effects: &[&NamedEffect], name: &str) -> bool {
    effects.iter().any(|e| e.effect.name == name)
}

fn seen_of(answer: &Answer, object: usize) -> Vec<Observation> {
    let recorded = answer.loaded.recorded.iter().filter(|r| r.object == object && !r.held_out);
    recorded.map(|r| r.seen.clone()).collect()
}
