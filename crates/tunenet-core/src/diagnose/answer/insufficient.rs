//! Recordings that cannot give an answer.

use crate::diagnose::answer::{Conclusion, Diagnosis, Use, driven_experiment};
use crate::diagnose::hypothesis::context::Context;
use crate::findings;
use crate::observation::{Kind, Note};

/// Fewer values than this beyond the unknowns say nothing of what is missing.
const LEAST_FREEDOM: usize = 12;

/// The answer of recordings that cannot give one.
pub(in crate::diagnose) fn too_little(context: &Context, uses: &[Use], notes: &[Note]) -> Option<Diagnosis> {
    let values = context.count();
    let nuisances: usize = context.sets().iter().map(|s| s.prepared.nuisances.len()).sum();
    let parameters: usize =
        context.subjects.iter().map(|s| s.simulator.parameters().iter().filter(|p| p.tune).count()).sum();
    let unknowns = nuisances + parameters;
    let note = if context.sets().is_empty() {
        Note::new(findings::RECORDINGS_NONE, "no recording can be used to fit", "see what was noted of each")
    } else if values < unknowns + LEAST_FREEDOM {
        let text = format!("{values} values for {unknowns} unknowns leave nothing to judge by");
        Note::new(findings::RECORDINGS_SHORT, text, "bring longer recordings, or more of them")
    } else {
        return None;
    };
    let joints = context.subjects.iter().all(|s| s.simulator.kind() == Kind::Joints);
    Some(Diagnosis {
        conclusion: Conclusion::Insufficient,
        objects: Vec::new(),
        candidates: Vec::new(),
        gap: None,
        gaps: Vec::new(),
        adequacy: Vec::new(),
        next_experiment: joints.then(driven_experiment::first),
        margin: context.margin(),
        least_gain: context.settings.margin,
        parameters: Vec::new(),
        explained: Vec::new(),
        uses: uses.to_vec(),
        notes: notes.iter().cloned().chain([note]).collect(),
        rollouts: 0,
    })
}
