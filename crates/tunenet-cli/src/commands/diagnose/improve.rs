//! Writes the improved simulation file, and the URDF with the friction that was found.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_core::simulator::Simulator;
use tunenet_core::{Error, Origin};
use tunenet_formats::write_atomically;
use tunenet_sim::SimulationFile;
use tunenet_sim::arm::model_file::with_friction;
use tunenet_sim::observed_arm::urdf_path;
use tunenet_sim::replayed_arm::{ReplayedArm, replays};

use crate::answers::diagnose::Answer;
use crate::answers::improved::{UNFITTED, Written, improved, why_not};
use crate::args::Diagnose;
use crate::view::json::ranges;
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
        file.move_program(&path);
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
    let Some(out) = options.out_ranges.as_deref().filter(|_| why_not(answer).is_none()) else {
        return Ok(None);
    };
    ranges::write(out, &ranges::of_diagnosis(answer))?;
    Ok(Some(out))
}

/// Writes the URDF of the first object with the friction that was found in it; the path, where there was some.
pub fn write_urdf(options: &Diagnose, answer: &Answer) -> Result<Option<PathBuf>> {
    let Some(out) = &options.out_urdf else { return Ok(None) };
    let file = &answer.loaded.objects[0].file;
    if !replays(file) {
        let (expected, found) = ("an arm with `motion.kind = \"replay\"`".into(), "another simulation".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--out-urdf", expected, found }.into());
    }
    let found = answer.diagnosis.effects().iter().any(|e| e.effect.name.ends_with("_friction"));
    if why_not(answer).is_some() || !found {
        return Ok(None);
    }
    let arm = ReplayedArm::from_file(&improved(answer, 0)?)?;
    let values: Vec<f64> = arm.parameters().iter().map(|p| p.value).collect();
    let text = with_friction(&urdf_path(file)?, &arm.friction(&values))?;
    write_atomically(out, |out| out.write_all(text.as_bytes()))?;
    Ok(Some(out.clone()))
}
