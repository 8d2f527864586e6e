//! What a fit should say besides its numbers.

use std::path::PathBuf;

use anyhow::Result;
use tunenet_core::findings;
use tunenet_core::observation::Note;
use tunenet_core::tune::{Outcome, Verdict};
use tunenet_formats::Recording;
use tunenet_sim::SimulationFile;
use tunenet_sim::replayed_arm::{replays, suspect};

use crate::args::Tune;
use crate::commands::load;
use crate::commands::odd_units::odd_units;
use crate::files::names;
use crate::findings::EFFECTS_HELD;

/// Adds what reading the recordings, the URDF and the fit showed.
pub fn add(
    options: &Tune,
    file: &SimulationFile,
    recordings: &[Recording],
    paths: &[PathBuf],
    outcome: &mut Outcome,
) -> Result<()> {
    let poor = outcome.notes.iter_mut().filter(|note| note.kind == findings::FIT_POOR);
    poor.for_each(|note| note.remedy = DIAGNOSE.into());
    if outcome.verdict != Verdict::Tuned {
        let names: Vec<String> = paths.iter().map(|path| names::file_name(path)).collect();
        let seen = recordings.iter().map(|recording| &recording.observation);
        outcome.notes.extend(odd_units(&names.iter().map(String::as_str).zip(seen).collect::<Vec<_>>()));
    }
    if replays(file) {
        suspect(file, outcome, options.reference.is_some());
        outcome.notes.splice(0..0, load::lacks(file)?);
    }
    outcome.notes.splice(0..0, load::left_out(file)?);
    outcome.notes.extend(held(file));
    let several = recordings.len() > 1;
    let named = paths.iter().zip(recordings).flat_map(|(path, recording)| {
        recording.notes.iter().map(move |note| {
            let which = if several { format!("{}: ", names::file_name(path)) } else { String::new() };
            Note { text: format!("{which}{}", note.text), ..note.clone() }
        })
    });
    outcome.notes.splice(0..0, named);
    Ok(())
}

/// Which effects of the file the fit did not change.
fn held(file: &SimulationFile) -> Option<Note> {
    let names = file.held_effects();
    let end = match names.as_slice() {
        [] => return None,
        [_] => "keeps its values; intervals do not include how uncertain these are",
        _ => "keep their values; intervals do not include how uncertain these are",
    };
    Some(Note::new(EFFECTS_HELD, format!("{} {end}", names.join(", ")), EFFECTS_HELD.remedy()))
}

/// What to type where a fit is poor.
const DIAGNOSE: &str = "search for the missing effect: `tunenet diagnose` with the same files";
