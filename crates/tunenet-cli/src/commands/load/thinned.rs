//! Recordings with at most so many samples.

use anyhow::Result;
use tunenet_core::observation::Note;
use tunenet_formats::Recording;

use crate::findings;

/// Most samples of one recording that are looked at and fitted to; more would not sharpen the answer by as much as they
/// cost.
pub const MOST_SAMPLES: usize = 20_000;

/// The recording with at most as many samples as are looked at.
pub fn thinned(recording: Recording) -> Result<Recording> {
    at_most(MOST_SAMPLES, recording)
}

/// The recording with at most so many of its samples.
pub fn at_most(most: usize, mut recording: Recording) -> Result<Recording> {
    let samples = recording.observation.len();
    if let Some(fewer) = recording.observation.thinned(most)? {
        let text = format!("{} of {samples} samples are used, evenly chosen", fewer.len());
        recording.notes.push(Note::new(findings::SAMPLES_THINNED, text, ""));
        recording.observation = fewer;
    }
    Ok(recording)
}
