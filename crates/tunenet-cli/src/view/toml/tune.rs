//! The provenance of a tuned simulation file: intervals, what each recording began with, and what stays open.

use anyhow::Result;
use toml_edit::{Array, InlineTable};
use tunenet_core::observation::Observation;
use tunenet_core::simulator::Parameter;
use tunenet_core::tune::{Gap, Outcome, Verdict};
use tunenet_formats::Recording;
use tunenet_sim::SimulationFile;

use super::alternatives;
use super::provenance::Provenance;
use crate::answers::tune::forced;

/// What a tuned file was made from.
pub struct Inputs {
    pub seed: u64,
    /// The recordings, each with its hash.
    pub observations: Array,
    /// The run without payload that was aligned with them.
    pub reference: Option<InlineTable>,
}

/// The provenance of the file that was `tuned` from the one that was given.
///
/// # Errors
/// Where the given file's parameters cannot be read.
pub fn provenance(
    inputs: Inputs,
    (given, tuned): (&SimulationFile, &SimulationFile),
    (recordings, outcome): (&[Recording], &Outcome),
    gap: &Gap,
) -> Result<Provenance> {
    let mut intervals: Vec<(String, (f64, f64))> =
        outcome.parameters.iter().map(|p| (p.name.clone(), p.interval95)).collect();
    // What was known of a value that stayed is known of it still.
    intervals.extend(given.parameters()?.into_iter().filter_map(|p| Some((p.name, p.known95?))));
    let start = |nuisances: &Vec<Parameter>| {
        nuisances.iter().map(|p| (p.name.replace('.', "_"), p.value)).collect::<InlineTable>()
    };
    let one_setup =
        inputs.observations.iter().all(|one| one.as_inline_table().is_none_or(|one| !one.contains_key("scene")));
    let mut made = Provenance::new("tune", inputs.seed, outcome.verdict)?.with("observations", inputs.observations);
    if let Some(reference) = inputs.reference {
        made = made.with("reference", reference);
    }
    made = made.with_intervals(intervals).with("estimated", outcome.nuisances.iter().map(start).collect::<Array>());
    // What is open to a ball is asked of its file alone, which not all of these recordings were made in.
    if outcome.verdict == Verdict::Tuned && !forced(outcome) && one_setup {
        let seen: Vec<Observation> = recordings.iter().map(|r| r.observation.clone()).collect();
        // What only plans go by must not cost the answer.
        made = made.with_any("open_drag", alternatives::open_to(tuned, &[], &seen).unwrap_or_default());
    }
    Ok(made.with_gap(&gap.unit, [gap.before, gap.after, gap.noise_floor]))
}
