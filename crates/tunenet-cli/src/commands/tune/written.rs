//! The simulation file with what was found in it.

use std::path::Path;

use anyhow::Result;
use toml_edit::Array;
use tunenet_core::tune::Outcome;
use tunenet_formats::{Recording, write_atomically};
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use crate::answers::tune::is_written;
use crate::args::Tune;
use crate::files::hash;
use crate::view::toml::tune::{Inputs, provenance};

/// Writes the tuned file; `out` never holds half of one.
pub fn write_tuned(
    options: &Tune,
    file: &SimulationFile,
    recordings: &[Recording],
    outcome: &Outcome,
    out: &Path,
) -> Result<()> {
    let (Some(gap), true) = (&outcome.gap, is_written(outcome)) else { return Ok(()) };
    let mut tuned = file.clone();
    let joints = outcome.recordings.first().map_or(0, |r| r.seen.channels().len());
    for p in &outcome.parameters {
        match (file.domain(), p.name.split_once('.')) {
            (Domain::Arm, _) => tuned.set_arm_value(&p.name, p.value, joints)?,
            (Domain::Ball | Domain::Process, Some((effect, key))) => tuned.add_effect(effect, &[(key, p.value)])?,
            _ => tuned.set_value(&p.name, p.value),
        }
    }
    let observations = options.observation.iter().map(|path| hash::fingerprint(path)).collect::<Result<Array>>()?;
    let reference = options.reference.as_deref().map(hash::fingerprint).transpose()?;
    let inputs = Inputs { seed: options.common.seed, observations, reference };
    let made = provenance(inputs, (file, &tuned), (recordings, outcome), gap)?;
    tuned.set_provenance(made.entries());
    tuned.move_program(out);
    write_atomically(out, |file| file.write_all(tuned.text().as_bytes()))?;
    Ok(())
}
