//! What is missing: where simulation and measurement disagree, and which effect would make them agree.
//!
//! ```text
//! recordings → prepare → tune → score every candidate → fit the best → what else explains as much? → is the rest noise?
//! ```
//!
//! The folders stand in the order in which values flow through them, and none imports a later one:
//!
//! | folder | what it makes |
//! |---|---|
//! | `evidence` | prepared recordings, those held out, and a model of their noise |
//! | `hypothesis` | effects, parameters and nuisance parameters with their fit; forward selection |
//! | `judge` | tests of what a hypothesis leaves: noise, practical significance, heterogeneity, held-out proof |
//! | `discrepancy` | the search where no recording is expected to be explained down to its noise |
//! | `strategy` | attempts at the whole record, at segments, with discrepancy as noise, with random effects of events |
//! | `answer` | the verdict, its numbers and the next experiment |
//!
//! [`diagnose`] runs the whole chain. A smaller residual does not prove a name, since any further coefficient shrinks it; so
//! an effect is named only where the information criterion gains clearly, its coefficients are physical, nothing else of the
//! catalogue does as well, and what is left looks like noise. Otherwise the answer says which of these failed.

mod answer;
mod discrepancy;
mod evidence;
mod hypothesis;
mod input;
mod judge;
mod pipeline;
mod strategy;

#[cfg(test)]
mod tests;

pub use answer::odd_recording::OddRecording;
pub use answer::{
    Candidate, Change, Conclusion, Diagnosis, Evidence, Explained, Fitted, Gap, GapOf, NamedEffect, NextExperiment,
    OfObject, OwnEffect, PartGap, Tuned, Use, Value, Verdict,
};
pub use evidence::recording::PreparedRecording;
pub use hypothesis::plausibility::{Exclusion, OutOfRange};
pub use hypothesis::wording::{GENERAL, Wording};
pub use input::{Progress, Recording, Settings, Subject};
pub use judge::Test;
pub use judge::validation_doubt::Doubt;
pub use pipeline::{Explanation, Problem, Strategy};

use crate::estimate::{RolloutLog, unread_states};
use crate::findings;
use crate::observation::Note;
use crate::simulator::{Preparation, Prepared};
use crate::{Error, Origin, Result};
use answer::insufficient::too_few_rollouts;
use evidence::copies;
use evidence::validation_split::{hold_end_out, set_aside};
use pipeline::Preparations;

/// Finds which effects are missing from the simulators of `subjects`, given what was seen of them.
///
/// All recordings of one object share its parameters and the coefficients of physical effects; all objects share which
/// effects there are, and the coefficients of measurement effects.
///
/// # Errors
/// [`Error::Setting`] where a setting is out of range or a recording names no subject; [`Error::Observation`] where a
/// recording is of another kind than its simulator predicts; whatever a simulator refuses with every start.
pub fn diagnose(
    subjects: &[Subject],
    recordings: &[Recording],
    settings: &Settings,
    progress: &dyn Fn(Progress),
) -> Result<Diagnosis> {
    diagnose_with(&[&OddRecording], subjects, recordings, settings, progress)
}

/// As [`diagnose`], with these strategies for recordings that are not explained as they are, in the order in which they are
/// tried.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_with(
    strategies: &[&dyn Strategy],
    subjects: &[Subject],
    recordings: &[Recording],
    settings: &Settings,
    progress: &dyn Fn(Progress),
) -> Result<Diagnosis> {
    settings.check()?;
    if let Some(lost) = recordings.iter().find(|r| r.object >= subjects.len()) {
        let (expected, found) =
            (format!("one of {} subjects", subjects.len()), format!("{} of {}", lost.object, lost.name));
        return Err(Error::Setting { origin: Origin::Caller, name: "object", expected, found });
    }
    let mut uses = Vec::new();
    let mut usable = Vec::new();
    for (i, recording) in recordings.iter().enumerate() {
        let mut one = Use { name: recording.name.clone(), used: true, held_out: recording.held_out, notes: Vec::new() };
        match subjects[recording.object].simulator.prepare(recording.seen)? {
            Preparation::Usable(prepared) => {
                one.notes.clone_from(&prepared.notes);
                usable.push(PreparedRecording::new(i, recording.object, recording.held_out, *prepared));
            }
            Preparation::Rejected(rejected) => {
                one.used = false;
                progress(Progress::NotUsed { name: &recording.name, why: &rejected.note });
                one.notes.push(rejected.note);
            }
        }
        uses.push(one);
    }
    copies::label(&mut usable);
    let mut notes = Vec::new();
    let choose = settings.set_aside && !usable.iter().any(|r| r.held_out);
    if choose && !usable.is_empty() && usable.iter().all(PreparedRecording::driven) {
        let ends = usable.iter_mut().map(hold_end_out).collect::<Result<Vec<_>>>()?;
        usable.extend(ends.into_iter().flatten());
        let text = "the last third of each recording is held out for validation";
        notes.push(Note::new(findings::HELD_OUT_CHOSEN, text, ""));
    } else if choose {
        let objects: Vec<usize> = usable.iter().map(|r| r.object).collect();
        for i in set_aside(&objects, settings.seed) {
            usable[i].held_out = true;
            uses[usable[i].index].held_out = true;
        }
        let names: Vec<&str> = uses.iter().filter(|u| u.held_out).map(|u| u.name.as_str()).collect();
        if !names.is_empty() {
            notes.push(Note::new(
                findings::HELD_OUT_CHOSEN,
                format!("held out for validation: {}", names.join(", ")),
                "",
            ));
        }
    }
    let rollouts = RolloutLog::new(settings.max_rollouts, None, None).strict();
    for note in unread_starts(subjects, &usable, &rollouts) {
        progress(Progress::Noticed(&note));
        notes.push(note);
    }
    let preparations = Preparations { uses, notes };
    let problem = Problem::new((subjects, recordings), (settings, progress), (&usable, &preparations), &rollouts);
    let first = problem.as_recorded();
    // What the limit ended is not used, not even in part: what it had reached depends on the number of threads.
    if let Some(most) = settings.max_rollouts.filter(|_| rollouts.was_short()) {
        let Preparations { uses, notes } = &preparations;
        return Ok(Diagnosis { rollouts: most, ..too_few_rollouts(settings, most, uses, notes) });
    }
    let mut best = first?;
    for strategy in strategies.iter().filter(|_| !settings.quick) {
        if !strategy.applies(&problem, &best) {
            continue;
        }
        let found = strategy.attempt(&problem, &best);
        if let Some(most) = settings.max_rollouts.filter(|_| rollouts.was_short()) {
            let text = format!("the limit of {most} rollouts ended the search for a better explanation");
            best.diagnosis.notes.push(Note::new(findings::ROLLOUTS_LIMIT, text, "allow more rollouts"));
            break;
        }
        best = found?.unwrap_or(best);
    }
    if settings.quick {
        let text = "the diagnosis was quick: it ended with the first explanation, tried no other strategy and designed no next experiment";
        best.diagnosis.notes.push(Note::new(findings::FIT_QUICK, text, "make the full diagnosis"));
    }
    Ok(Diagnosis { rollouts: rollouts.count(), ..best.diagnosis })
}

/// What is said of initial states that change nothing at the first guesses, in any recording of a subject.
fn unread_starts(subjects: &[Subject], recordings: &[PreparedRecording], rollouts: &RolloutLog) -> Vec<Note> {
    let of = |(object, subject): (usize, &Subject)| {
        let ready =
            || recordings.iter().filter(|recording| recording.object == object).map(PreparedRecording::prepared);
        let guesses: Vec<Vec<f64>> = ready().map(Prepared::nuisance_values).collect();
        let each = ready().zip(&guesses).enumerate().map(|(d, (one, nuisances))| (d, one, nuisances.as_slice()));
        let parameters: Vec<f64> = subject.simulator.parameters().iter().map(|p| p.value).collect();
        let log = rollouts.remainder();
        let notes = unread_states(subject.simulator, &each.collect::<Vec<_>>(), &parameters, &log);
        rollouts.add(log.count());
        let whose = if subjects.len() > 1 { format!("{}: ", subject.name) } else { String::new() };
        notes.into_iter().map(move |note| Note { text: format!("{whose}{}", note.text), ..note }).collect::<Vec<_>>()
    };
    subjects.iter().enumerate().flat_map(of).collect()
}
