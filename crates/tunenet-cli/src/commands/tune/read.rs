//! A recording as `tune` reads it.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::Kind;
use tunenet_formats::Recording;

use crate::args::Tune;
use crate::commands::load;
use crate::files::names;
use crate::view::text::stage;

/// Reads it, with its reference run next to it.
pub fn read(path: &Path, options: &Tune, setups: &load::Setups, number: usize) -> Result<Recording> {
    let (file, setup) = (setups.file(number), setups.number(number));
    let recording = load::recording_of(file, setup, path, &options.reading, load::MOST_SAMPLES)?;
    let recording = load::attach_reference(file, recording, options.reference.as_deref(), &options.reading.numbers)?;
    let recording = setups.placed(number, recording);
    let seen = &recording.observation;
    let clock = seen.clock();
    let span = if seen.kind() == Kind::EventTimes {
        format!("{} bounces", seen.len())
    } else {
        format!("{} samples, {:.2} s", seen.len(), clock[clock.len() - 1] - clock[0])
    };
    if !options.each {
        stage("read", &format!("{}, {span}", names::file_name(path)));
    }
    Ok(recording)
}
