//! What a fit should say besides its numbers.

use std::path::PathBuf;

use anyhow::Result;
use tunenet_core::findings;
use tunenet_core::observation::{Note, Observation, OddScale, odd_scales, with_decimals};
use tunenet_core::tune::{Outcome, Verdict};
use tunenet_formats::Recording;
use tunenet_sim::SimulationFile;
use tunenet_sim::replayed_arm::{replays, suspect};

use crate::args::Tune;
use crate::commands::load;
use crate::files::names;
use crate::findings::UNITS_DIFFER;

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
        outcome.notes.extend(odd_units(recordings, paths));
    }
    if replays(file) {
        suspect(file, outcome, options.reference.is_some());
        outcome.notes.splice(0..0, load::lacks(file)?);
    }
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

/// What is said of recordings that are on another scale than the others.
fn odd_units(recordings: &[Recording], paths: &[PathBuf]) -> Vec<Note> {
    let seen: Vec<&Observation> = recordings.iter().map(|recording| &recording.observation).collect();
    let note = |odd: OddScale| {
        let (times, which) = if odd.ratio > 1.0 { (odd.ratio, "as much as") } else { (odd.ratio.recip(), "less than") };
        let (name, times) = (names::file_name(&paths[odd.recording]), with_decimals(times, 0));
        let text = format!("{name}: `{}` varies {times} times {which} in the other recordings", odd.header);
        Note::new(UNITS_DIFFER, text, "check its unit: degrees among radians, or milli-units, look like that")
    };
    odd_scales(&seen).into_iter().map(note).collect()
}

/// What to type where a fit is poor.
const DIAGNOSE: &str = "search for the missing effect: `tunenet diagnose` with the same files";
