//! Asks the library for a diagnosis, and shows what it does meanwhile.

use anyhow::Result;
use tunenet_ball::diagnose;
use tunenet_core::diagnose::{Diagnosis, Settings, Subject};
use tunenet_core::observation::{Note, Observation};
use tunenet_sim::law::contested;
use tunenet_sim::simulation_file::Domain;

use crate::answers::diagnose::Loaded;
use crate::commands::refusal::{self, Asked};
use crate::view::text::diagnose as text;

/// Asks the library, showing what it does.
pub fn ask(loaded: &Loaded, settings: &Settings) -> Result<Diagnosis> {
    let subjects: Vec<Subject> =
        loaded.objects.iter().map(|o| Subject { name: o.name.clone(), simulator: o.simulator.as_ref() }).collect();
    let working = crate::view::text::working("diagnosing");
    let diagnosis = diagnose(&subjects, &loaded.recordings(), settings, &|at| text::progress(&working, at));
    working.finish_and_clear();
    // A program that is gone says more than that the fit failed.
    loaded.objects.iter().try_for_each(|object| object.session.settle())?;
    let refusal =
        |error: &tunenet_core::Error| refusal::of_program(&loaded.objects.first()?.file, Asked::Present, error);
    if let Some(refusal) = diagnosis.as_ref().err().and_then(refusal) {
        return Err(refusal.into());
    }
    let mut diagnosis = match loaded.objects.as_slice() {
        // A quick diagnosis ends with its first explanation, and a limit of rollouts holds for all.
        [object] if object.setups.len() == 1 && !settings.quick && settings.max_rollouts.is_none() => {
            let seen: Vec<&Observation> = loaded.recorded.iter().map(|one| &one.seen).collect();
            contested(&object.file, diagnosis?, &seen)
        }
        _ => diagnosis?,
    };
    for object in &loaded.objects {
        let which = if loaded.objects.len() > 1 { format!("{}: ", object.name) } else { String::new() };
        let notes = object.session.notes().into_iter();
        diagnosis.notes.extend(notes.map(|note| Note { text: format!("{which}{}", note.text), ..note }));
    }
    if loaded.objects.iter().any(|object| object.file.domain() == Domain::Process) {
        // Equal requests were simulated once.
        let all: u64 = loaded.objects.iter().map(|object| object.session.rollouts()).sum();
        diagnosis.rollouts = usize::try_from(all).unwrap_or(usize::MAX);
    }
    Ok(diagnosis)
}
