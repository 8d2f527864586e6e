//! The simulation file with what was found in it.

use std::path::Path;

use anyhow::Result;
use toml_edit::{Array, InlineTable};
use tunenet_core::tune::{Estimate, Outcome, Verdict};
use tunenet_formats::{Recording, write_atomically};
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use crate::answers::tune::{is_written, why_no_model};
use crate::args::Tune;
use crate::commands::load::{self, Setups};
use crate::commands::{models, start};
use crate::files::hash;
use crate::view::json::ranges;
use crate::view::text::stage;
use crate::view::toml::tune::{Inputs, provenance};

/// Refuses, before anything is read, what cannot be tuned, and models that the simulation does not have.
pub fn check(options: &Tune, file: &SimulationFile) -> Result<()> {
    start::check(options, file)?;
    models::check(&options.models, file, 1)
}

/// Writes the tuned file; `out` never holds half of one.
pub fn write_tuned(
    options: &Tune,
    setups: &Setups,
    recordings: &[Recording],
    outcome: &Outcome,
    out: &Path,
) -> Result<()> {
    let (Some(gap), true) = (&outcome.gap, is_written(outcome)) else { return Ok(()) };
    let file = setups.common();
    let mut tuned = tuned(file, outcome, &outcome.parameters)?;
    let observations = options.observation.iter().enumerate().map(|(i, path)| observation(path, setups, i));
    let observations = observations.collect::<Result<Array>>()?;
    let reference = options.reference.as_deref().map(hash::fingerprint).transpose()?;
    let inputs = Inputs { seed: options.common.seed, observations, reference };
    let made = provenance(inputs, (file, &tuned), (recordings, outcome), gap)?;
    tuned.set_provenance(made.entries());
    tuned.move_to(out);
    write_atomically(out, |file| file.write_all(tuned.text().as_bytes()))?;
    Ok(())
}

/// The file with the values of these parameters.
fn tuned<'e>(
    file: &SimulationFile,
    outcome: &Outcome,
    parameters: impl IntoIterator<Item = &'e Estimate>,
) -> Result<SimulationFile> {
    let mut tuned = file.clone();
    let joints = outcome.recordings.first().map_or(0, |r| r.seen.channels().len());
    for p in parameters {
        match (file.domain(), p.name.split_once('.')) {
            (Domain::Arm, _) => tuned.set_arm_value(&p.name, p.value, joints)?,
            (Domain::Robot, _) => tuned.set_robot_value(&p.name, p.value)?,
            (Domain::Ball | Domain::Process | Domain::Equations, Some((effect, key))) => {
                tuned.add_effect(effect, &[(key, p.value)])?;
            }
            _ => tuned.set_value(&p.name, p.value),
        }
    }
    Ok(tuned)
}

/// Writes the models that were asked for. They get all numbers as they were fitted, if the recordings determine any: those that are tied
/// reproduce the recordings only together.
fn write_models(options: &Tune, setups: &Setups, outcome: &Outcome) -> Result<()> {
    if !options.models.asked() {
        return Ok(());
    }
    let (known, open): (Vec<&Estimate>, Vec<&Estimate>) = outcome.parameters.iter().partition(|p| p.identified);
    if let Some(why) = why_no_model(outcome) {
        stage("model", &format!("not written: {why}"));
        return Ok(());
    }
    if !open.is_empty() {
        let names: Vec<String> = open.iter().map(|p| format!("`{}`", p.name)).collect();
        let text = "the recordings determine only combinations of these, which models hold as fitted";
        stage("note", &format!("{text}: {}", names.join(", ")));
    }
    let intervals = known.iter().map(|p| (p.name.clone(), [p.interval95.0, p.interval95.1])).collect();
    models::write(&options.models, &tuned(setups.common(), outcome, &outcome.parameters)?, &intervals)
}

/// Writes what was asked for besides the simulation file: intervals and models.
pub fn write_others(options: &Tune, setups: &Setups, outcome: &Outcome) -> Result<()> {
    write_ranges(options, outcome)?;
    write_models(options, setups, outcome)
}

/// Writes the intervals of the tuned parameters, where they were asked for; those of a poor fit are none to draw from.
fn write_ranges(options: &Tune, outcome: &Outcome) -> Result<()> {
    let Some(out) = options.out_ranges.as_deref() else { return Ok(()) };
    if outcome.verdict != Verdict::Tuned {
        stage("ranges", "not written: the verdict is not TUNED");
        return Ok(());
    }
    ranges::of_tuning(outcome).write(out)?;
    stage("ranges", &out.display().to_string());
    Ok(())
}

/// A recording, the files of their own in which its inputs stand, and the keys of the scene that it has for itself.
fn observation(path: &Path, setups: &Setups, number: usize) -> Result<InlineTable> {
    let mut one = hash::fingerprint(path)?;
    let own = load::own_files(setups.file(number), path);
    if !own.is_empty() {
        one.insert("inputs", hash::fingerprints(&own)?.into());
    }
    let scene = setups.differences().scene(number);
    if !scene.is_empty() {
        one.insert("scene", scene.into());
    }
    Ok(one)
}
