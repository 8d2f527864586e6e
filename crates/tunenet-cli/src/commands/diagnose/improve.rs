//! Writes the improved simulation file, and models with its numbers.

use std::path::Path;

use anyhow::Result;
use tunenet_core::diagnose::Verdict;
use tunenet_formats::write_atomically;
use tunenet_sim::SimulationFile;

use crate::answers::diagnose::{Answer, value_of};
use crate::answers::improved::{UNFITTED, Written, improved, why_not};
use crate::args::Diagnose;
use crate::commands::models::{self, Intervals};
use crate::view::json::ranges;
use crate::view::text::stage;
use crate::view::toml::diagnose::provenance;
use crate::view::toml::law::provenance as law_provenance;

/// Writes the files that were asked for, one for each object that has an answer.
pub fn write(options: &Diagnose, answer: &Answer) -> Result<Written> {
    let Some(out) = &options.out else { return Ok(Written::NotAsked) };
    let diagnosis = answer.diagnosis;
    let gap = match (&diagnosis.gap, why_not(answer)) {
        (_, Some(why)) => return Ok(Written::Not(why)),
        (None, None) => return Ok(Written::Not(UNFITTED)),
        (Some(gap), None) => gap,
    };
    let mut written = Vec::new();
    for (number, object) in answer.loaded.objects.iter().enumerate() {
        let mut file = improved(answer, number)?;
        let made = match answer.found() {
            Some((found, law)) => law_provenance(options.common.seed, answer, found, law)?,
            None => provenance(options.common.seed, answer, gap, number, &file)?,
        };
        file.set_provenance(made.entries());
        let path =
            if answer.loaded.objects.len() == 1 { out.clone() } else { out.join(format!("{}.toml", object.name)) };
        file.move_to(&path);
        put(&path, &file)?;
        written.push(path);
    }
    Ok(Written::Files(written))
}

fn put(path: &Path, file: &SimulationFile) -> Result<()> {
    Ok(write_atomically(path, |out| out.write_all(file.text().as_bytes()))?)
}

/// Writes the intervals of parameters and coefficients where the answer has any; the path, where it was written.
pub fn write_ranges<'a>(options: &'a Diagnose, answer: &Answer) -> Result<Option<&'a Path>> {
    let Some(out) = options.out_ranges.as_deref() else { return Ok(None) };
    if let Some(why) = why_not(answer) {
        stage("ranges", &format!("not written: {why}"));
        return Ok(None);
    }
    let found = ranges::of_diagnosis(answer);
    if !found.undetermined.is_empty() {
        let open = found.undetermined.join(", ");
        stage("note", &format!("ranges leave out what the recordings do not determine: {open}"));
    }
    found.write(out)?;
    Ok(Some(out))
}

/// Writes the models that were asked for, where there is an answer.
pub fn write_models(options: &Diagnose, answer: &Answer) -> Result<()> {
    if !options.models.asked() {
        return Ok(());
    }
    match why_not(answer) {
        // Tuned numbers are worth a model, as they are after `tune`, even where something is missing that has no name.
        Some(why) if answer.diagnosis.verdict() == Verdict::Unknown && answer.diagnosis.gap.is_some() => {
            stage("note", &format!("models get the tuned numbers alone: {why}"));
        }
        Some(why) => {
            stage("model", &format!("not written: {why}"));
            return Ok(());
        }
        None => {}
    }
    let intervals = intervals(answer);
    if intervals.is_empty() {
        stage("model", "not written: the recordings determine none of its numbers");
        return Ok(());
    }
    models::write(&options.models, &improved(answer, 0)?, &intervals)
}

/// The 95 % intervals of the first object's parameters and effects, of those that the recordings determine.
fn intervals(answer: &Answer) -> Intervals {
    let ends = |(low, high): (f64, f64)| [low, high];
    let tuned = answer.parameters();
    let bounds = answer.loaded.objects[0].simulator.parameters();
    let determined = tuned.iter().filter(|p| p.object == 0 && p.is_determined(bounds));
    let parameters = determined.map(|p| (p.name.clone(), ends(p.interval95)));
    let mut all: Intervals = parameters.collect();
    for named in answer.effects_of(0) {
        for (i, coefficient) in named.coefficients.iter().enumerate() {
            // Which number under its key it is: that of a joint.
            let number = 1 + named.coefficients[..i].iter().filter(|other| other.key == coefficient.key).count();
            if let Some(value) = value_of(coefficient, 0).filter(|value| named.determines(&coefficient.key, value)) {
                let name = format!("{}.{}.{number}", named.effect.name, coefficient.key);
                all.insert(name, ends(value.interval95));
            }
        }
    }
    all
}
