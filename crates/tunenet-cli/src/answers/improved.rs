//! The improved simulation file: tuned parameters and the named effects.

use std::path::PathBuf;

use anyhow::Result;
use toml_edit::DocumentMut;
use tunenet_core::diagnose::{Diagnosis, NamedEffect, Verdict};
use tunenet_core::simulator::Simulator;
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use super::diagnose::{Answer, Edited, Object, value_of};

/// What was written, and why nothing was where nothing was.
pub enum Written {
    NotAsked,
    Files(Vec<PathBuf>),
    Not(&'static str),
}

/// Why there is no improved file.
pub fn why_not(answer: &Answer) -> Option<&'static str> {
    match answer.found() {
        Some((_, law)) if law.bounded => None,
        Some(_) => Some("the law grows without bound outside the range in which it was seen"),
        None => why_not_of(answer.diagnosis),
    }
}

fn why_not_of(diagnosis: &Diagnosis) -> Option<&'static str> {
    match diagnosis.verdict() {
        Verdict::Unknown => Some("no known effect explains the recordings"),
        Verdict::Insufficient => Some("there is no answer"),
        Verdict::None | Verdict::Named | Verdict::OneOf => diagnosis.gap.is_none().then_some(UNFITTED),
    }
}

/// The file of an object with the tuned parameters and those of the named effects that it needs.
pub fn improved(answer: &Answer, number: usize) -> Result<SimulationFile> {
    let diagnosis = answer.diagnosis;
    let mut file = answer.loaded.objects[number].file.clone();
    if let Some((found, law)) = answer.found() {
        return Ok(tunenet_sim::law::written(&file, &found.parameters, law)?);
    }
    if file.domain() == Domain::Arm {
        return improved_arm(answer, number, file);
    }
    if file.domain() == Domain::Robot {
        return improved_robot(answer, number, file);
    }
    for tuned in diagnosis.parameters.iter().filter(|p| p.object == number) {
        // A coefficient of an effect that the file has already bears both names.
        match tuned.name.split_once('.') {
            Some((effect, key)) => file.add_effect(effect, &[(key, tuned.value)])?,
            None => file.set_value(&tuned.name, tuned.value),
        }
    }
    for effect in answer.effects_of(number) {
        if file.candidate(&effect.effect.name).is_some() {
            file.add_declared(&effect.effect.name, &values_of(effect, number))?;
            continue;
        }
        let values: Vec<(&str, f64)> =
            effect.coefficients.iter().filter_map(|c| Some((c.key.as_ref(), value_of(c, number)?.value))).collect();
        file.add_effect(&effect.effect.name, &values)?;
    }
    Ok(file)
}

/// The same of an arm, whose effects have numbers for each joint.
fn improved_arm(answer: &Answer, number: usize, mut file: SimulationFile) -> Result<SimulationFile> {
    let joints = answer.loaded.objects[number].simulator.channels().len();
    for tuned in answer.diagnosis.parameters.iter().filter(|p| p.object == number) {
        file.set_arm_value(&tuned.name, tuned.value, joints)?;
    }
    for effect in answer.effects_of(number) {
        let values = values_of(effect, number);
        if file.candidate(&effect.effect.name).is_some() {
            file.add_declared(&effect.effect.name, &values)?;
        } else {
            file.add_arm_effect(&effect.effect.name, &values)?;
        }
    }
    Ok(file)
}

/// The same of robot joints, whose effects have numbers for each joint.
fn improved_robot(answer: &Answer, number: usize, mut file: SimulationFile) -> Result<SimulationFile> {
    for tuned in answer.diagnosis.parameters.iter().filter(|p| p.object == number) {
        file.set_robot_value(&tuned.name, tuned.value)?;
    }
    for effect in answer.effects_of(number) {
        let values = values_of(effect, number);
        if file.candidate(&effect.effect.name).is_some() {
            file.add_declared(&effect.effect.name, &values)?;
        } else {
            file.add_robot_effect(&effect.effect.name, &values)?;
        }
    }
    Ok(file)
}

/// The values of an effect's coefficients for an object, in the order of the catalogue.
fn values_of(effect: &NamedEffect, number: usize) -> Vec<f64> {
    effect.coefficients.iter().filter_map(|c| Some(value_of(c, number)?.value)).collect()
}

fn without_provenance(text: &str) -> Result<String> {
    let mut document: DocumentMut = text.parse()?;
    document.remove("provenance");
    Ok(document.to_string())
}

/// Where no fit was possible.
pub const UNFITTED: &str = "nothing could be fitted";

/// What the answer changes in the simulation file of every object, or why it changes nothing.
pub fn edits(given: &SimulationFile, answer: &Answer) -> Result<std::result::Result<Vec<Edited>, &'static str>> {
    if let Some(why) = why_not(answer) {
        return Ok(Err(why));
    }
    let given = without_provenance(&given.text())?;
    let one = |(number, object): (usize, &Object)| {
        let improved = without_provenance(&improved(answer, number)?.text())?;
        Ok(Edited { object: object.name.clone(), given: given.clone(), improved })
    };
    answer.loaded.objects.iter().enumerate().map(one).collect::<Result<_>>().map(Ok)
}
