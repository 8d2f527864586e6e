//! Where a simulation of equations leaves the range in which an effect of its file was seen to hold.

use tunenet_core::observation::Note;
use tunenet_core::simulator::{Prepared, Simulator};
use tunenet_formats::Result;

use crate::SimulationFile;
use crate::equations::valid::{Range, left, ranges};
use crate::observed_equations::equations_of;

/// A warning for every effect of equations that a simulation of these recordings, from their nuisance parameters, takes out of its range;
/// none of another kind of file. `files` has a file for each setup of the recordings.
///
/// # Errors
/// Where the files hold no simulator, or it refuses its own values.
pub fn outside(files: &[&SimulationFile], recordings: &[Prepared]) -> Result<Vec<Note>> {
    let Ok(scene) = files[0].equations() else { return Ok(Vec::new()) };
    let mut acting: Vec<(String, Vec<Range>)> = Vec::new();
    for effect in files[0].effects() {
        let Some(candidate) = scene.candidates.get(&effect.name) else { continue };
        // Reading the file refuses ranges that are none.
        let ranges = ranges(scene, &effect.name, candidate).unwrap_or_default();
        if !ranges.is_empty() {
            acting.push((effect.name.clone(), ranges));
        }
    }
    if acting.is_empty() {
        return Ok(Vec::new());
    }
    let simulator = equations_of(files, &|_, system| system.showing_states())?;
    let parameters: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let mut notes = Vec::new();
    for recording in recordings {
        let clock = recording.seen.clock();
        let mut states = vec![0.0; clock.len() * scene.states.len()];
        let known = recording.circumstances.as_deref().cloned().unwrap_or_default();
        let run = simulator.rollout_driven(&parameters, &recording.nuisance_values(), &known, clock, &mut states);
        // What cannot be simulated is reported by the simulation itself.
        if run.is_err() {
            continue;
        }
        acting.retain(|(name, ranges)| {
            let left = left(ranges, clock, &states);
            notes.extend(left.as_ref().map(|left| left.note(name)));
            left.is_none()
        });
    }
    Ok(notes)
}
