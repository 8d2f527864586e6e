//! The simulation file with what was found in it.

use std::path::Path;

use anyhow::Result;
use toml_edit::{Array, InlineTable};
use tunenet_core::observation::Observation;
use tunenet_core::tune::{Outcome, Verdict};
use tunenet_formats::{Recording, write_atomically};
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use crate::answers::tune::{forced, is_written};
use crate::args::Tune;
use crate::files::hash;
use crate::view::toml::alternatives;

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
    let mut intervals = InlineTable::new();
    for p in &outcome.parameters {
        if file.domain() == Domain::Arm {
            tuned.set_arm_value(&p.name, p.value, joints)?;
        } else {
            tuned.set_value(&p.name, p.value);
        }
        intervals.insert(p.name.replace('.', "_"), Array::from_iter([p.interval95.0, p.interval95.1]).into());
    }
    // What was known of a value that stayed is known of it still.
    for p in file.parameters()? {
        if let Some((low, high)) = p.known95 {
            intervals.insert(p.name, Array::from_iter([low, high]).into());
        }
    }
    let mut observations = Array::new();
    for path in &options.observation {
        observations.push(hash::fingerprint(path)?);
    }
    let reference = options.reference.as_deref().map(hash::fingerprint).transpose()?;
    let mut estimated = Array::new();
    for own in &outcome.nuisances {
        let one: InlineTable = own.iter().map(|p| (p.name.replace('.', "_"), p.value)).collect();
        estimated.push(one);
    }
    let verdict = serde_json::to_value(outcome.verdict)?;
    let seed = i64::try_from(options.common.seed).unwrap_or(i64::MAX);
    let mut entries: Vec<(&str, toml_edit::Value)> = vec![
        ("tool", concat!("tunenet ", env!("CARGO_PKG_VERSION")).into()),
        ("command", "tune".into()),
        ("seed", seed.into()),
        ("verdict", verdict.as_str().unwrap_or_default().into()),
        ("observations", observations.into()),
    ];
    entries.extend(reference.map(|reference| ("reference", reference.into())));
    entries.extend([("interval95", intervals.into()), ("estimated", estimated.into())]);
    if outcome.verdict == Verdict::Tuned && !forced(outcome) {
        let seen: Vec<Observation> = recordings.iter().map(|r| r.observation.clone()).collect();
        // What only plans go by must not cost the answer.
        let open = alternatives::open_to(&tuned, &[], &seen).unwrap_or_default();
        entries.extend((!open.is_empty()).then(|| ("open_drag", open.into())));
    }
    entries.extend([
        ("gap_unit", gap.unit.as_str().into()),
        ("gap_before", gap.before.into()),
        ("gap_after", gap.after.into()),
        ("gap_noise_floor", gap.noise_floor.into()),
    ]);
    tuned.set_provenance(&entries);
    tuned.move_program(out);
    write_atomically(out, |file| file.write_all(tuned.text().as_bytes()))?;
    Ok(())
}
