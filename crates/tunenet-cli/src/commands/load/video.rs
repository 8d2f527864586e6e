//! The positions of a ball in a video.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::Observation;
use tunenet_formats::{Error, Recording};
use tunenet_video_protocol::VideoFinding;
use tunenet_video_protocol::track::{Metres, Tracked};

use crate::commands::video::TrackFailure;

/// The positions in what was found.
///
/// # Errors
/// [`TrackFailure`] where the ball never flies; [`Error::File`] where the video shows too little of it to say how large a pixel is.
pub fn positions(path: &Path, Tracked { facts, samples, .. }: &Tracked) -> Result<Recording> {
    if let Some(finding) = facts.rolls() {
        return Err(TrackFailure { path: path.into(), note: finding.note(), untracked: None }.into());
    }
    let Some(Metres { x_m, z_m }) = &samples.metres else {
        let message = "expected a flight that shows how large a pixel is, found none";
        return Err(Error::file(path, message, "record a whole fall, or track it with `--radius` or `--length`").into());
    };
    let places: Vec<[f64; 3]> = x_m.iter().zip(z_m).map(|(x, z)| [*x, 0.0, *z]).collect();
    let observation = Observation::positions(samples.t_s.clone(), &places)?;
    Ok(Recording { observation, notes: facts.warnings.iter().map(VideoFinding::note).collect() })
}
