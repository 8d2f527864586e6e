//! Recordings that cannot give an answer.

use super::answer::{Diagnosis, Use, Verdict};
use super::decide::margin;
use super::study::Study;
use crate::observation::Note;

/// Fewer values than this beyond the unknowns say nothing of what is missing.
const LEAST_FREEDOM: usize = 12;

/// The answer of recordings that cannot give one.
pub(super) fn too_little(study: &Study, uses: &[Use], notes: &[Note]) -> Option<Diagnosis> {
    let values = study.count();
    let own: usize = study.sets.iter().map(|s| s.prepared.own.len()).sum();
    let parameters: usize =
        study.subjects.iter().map(|s| s.simulator.parameters().iter().filter(|p| p.tune).count()).sum();
    let unknowns = own + parameters;
    let note = if study.sets.is_empty() {
        Note::new("recordings.none", "no recording can be used to fit", "see what was noted of each")
    } else if values < unknowns + LEAST_FREEDOM {
        let text = format!("{values} values for {unknowns} unknowns leave nothing to judge by");
        Note::new("recordings.short", text, "bring longer recordings, or more of them")
    } else {
        return None;
    };
    Some(Diagnosis {
        verdict: Verdict::Insufficient,
        objects: Vec::new(),
        effects: Vec::new(),
        names: Vec::new(),
        candidates: Vec::new(),
        gap: None,
        adequacy: Vec::new(),
        next_experiment: None,
        margin: margin(study),
        least_gain: study.settings.margin,
        doubt: None,
        description: None,
        remains: None,
        parameters: Vec::new(),
        explained: Vec::new(),
        uses: uses.to_vec(),
        notes: notes.iter().cloned().chain([note]).collect(),
        rollouts: 0,
    })
}
