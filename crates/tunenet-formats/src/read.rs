//! Reading a recording in any format.

use std::path::Path;

use tunenet_core::observation::{Kind, Observation};

use crate::clock_jump::without_jumps;
use crate::csv::own_columns;
use crate::format::{Format, format};
use crate::recording::{LARGEST, ReadOptions, Recording, Role};
use crate::shown::shown_path;
use crate::source::unchanged;
use crate::{Error, Origin, Result, csv, mcap};

/// The observation in a CSV or MCAP file.
///
/// # Errors
/// [`Error::Io`] where the system refuses the file, [`Error::Text`] where a line of a CSV file cannot be used,
/// [`Error::File`] where the file as a whole cannot, [`Setting`](tunenet_core::Error::Setting) where `options`
/// contradict themselves, and [`Observation`](tunenet_core::Error::Observation) where the numbers make no observation.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Recording> {
    let path = path.as_ref();
    let recording = unchanged(path, || read_once(path, options)).and_then(without_jumps)?;
    refuse_far(path, &recording.observation)?;
    Ok(recording)
}

fn read_once(path: &Path, options: &ReadOptions) -> Result<Recording> {
    match format(path)? {
        Format::Csv if options.topic.is_some() => Err(tunenet_core::Error::Setting {
            origin: Origin::Flag,
            name: "topic",
            expected: "an MCAP file".into(),
            found: format!("the text file {}", shown_path(path)),
        }
        .into()),
        Format::Csv => csv::series::read(path, options),
        Format::Mcap if !options.columns.is_empty() && options.role == Role::Predicted => {
            Err(tunenet_core::Error::Setting {
                origin: Origin::Flag,
                name: "columns",
                expected: "a CSV file".into(),
                found: format!("the MCAP file {}", shown_path(path)),
            }
            .into())
        }
        Format::Mcap => {
            let recording = mcap::series::read(path, options)?;
            refuse_too_large(path, &recording.observation)?;
            if options.channels.is_empty() { Ok(recording) } else { own_columns::chosen(path, recording, options) }
        }
    }
}

/// Farthest position from the origin, in m: beyond a planet, and near enough for a double to hold a hundredth of a micrometre.
const FARTHEST_M: f64 = 1e8;

/// Positions beyond [`FARTHEST_M`] are refused: they hold an offset, or another unit.
fn refuse_far(path: &Path, seen: &Observation) -> Result<()> {
    if seen.kind() != Kind::Positions {
        return Ok(());
    }
    let width = seen.channels().len();
    let Some(at) = seen.values().iter().position(|v| v.abs() > FARTHEST_M) else { return Ok(()) };
    let (channel, sample, found) = (&seen.channels()[at % width].name, at / width + 1, seen.values()[at]);
    let message = format!(
        "expected positions within {FARTHEST_M:e} m of the origin, found `{channel}` {found:e} m at sample {sample}"
    );
    Err(Error::file(path, message, "check the unit, or subtract the offset"))
}

/// Numbers beyond [`LARGEST`] are refused with their sample.
fn refuse_too_large(path: &Path, seen: &Observation) -> Result<()> {
    let width = seen.channels().len();
    let Some(at) = seen.values().iter().position(|v| v.abs() > LARGEST) else { return Ok(()) };
    let (channel, sample, found) = (&seen.channels()[at % width].name, at / width + 1, seen.values()[at]);
    let message = format!("`{channel}` at sample {sample} is too large: expected at most {LARGEST:e}, found {found:e}");
    Err(Error::file(path, message, "check the unit, or leave the message out"))
}
