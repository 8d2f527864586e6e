//! Recordings, or a limit on rollouts, that cannot give an answer.

use crate::diagnose::Settings;
use crate::diagnose::answer::{Conclusion, Diagnosis, Use, driven_experiment};
use crate::diagnose::hypothesis::context::Context;
use crate::findings;
use crate::observation::{Kind, Note};

/// Fewer values than this beyond the unknowns say nothing of what is missing.
const LEAST_FREEDOM: usize = 12;

/// The answer of recordings that cannot give one.
pub(in crate::diagnose) fn too_little(context: &Context, uses: &[Use], notes: &[Note]) -> Option<Diagnosis> {
    let values = context.count();
    let nuisances: usize = context.recordings().iter().map(|r| r.prepared.nuisances.len()).sum();
    let parameters: usize =
        context.subjects.iter().map(|s| s.simulator.parameters().iter().filter(|p| p.tune).count()).sum();
    let unknowns = nuisances + parameters;
    let note = if context.recordings().is_empty() {
        Note::new(
            findings::RECORDINGS_NONE,
            "no recording passed the checks",
            "correct the recordings as their notes say",
        )
    } else if values < unknowns + LEAST_FREEDOM {
        let text = format!(
            "a diagnosis takes {LEAST_FREEDOM} values more than unknowns; these recordings have {values} for {unknowns} unknowns"
        );
        Note::new(findings::RECORDINGS_SHORT, text, "bring longer recordings, or more of them")
    } else {
        return None;
    };
    let joints = context.subjects.iter().all(|s| s.simulator.kind() == Kind::Joints);
    let notes = notes.iter().cloned().chain([note]).collect();
    let first = joints.then(driven_experiment::first);
    Some(Diagnosis { next_experiment: first, margin: context.margin(), ..insufficient(context.settings, uses, notes) })
}

/// The answer where fewer rollouts were allowed than the search takes.
pub(in crate::diagnose) fn too_few_rollouts(
    settings: &Settings,
    most: usize,
    uses: &[Use],
    notes: &[Note],
) -> Diagnosis {
    let text = format!("the limit of {most} rollouts ended the search before all candidates were compared");
    let note = Note::new(findings::ROLLOUTS_LIMIT, text, "allow more rollouts");
    insufficient(settings, uses, notes.iter().cloned().chain([note]).collect())
}

fn insufficient(settings: &Settings, uses: &[Use], notes: Vec<Note>) -> Diagnosis {
    Diagnosis {
        conclusion: Conclusion::Insufficient,
        objects: Vec::new(),
        candidates: Vec::new(),
        gap: None,
        gaps: Vec::new(),
        adequacy: Vec::new(),
        next_experiment: None,
        margin: settings.margin,
        least_gain: settings.margin,
        parameters: Vec::new(),
        tied: Vec::new(),
        explained: Vec::new(),
        uses: uses.to_vec(),
        notes,
        rollouts: 0,
    }
}
