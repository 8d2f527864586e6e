//! Reading a recording in any format.

use std::path::{Path, PathBuf};

use tunenet_core::observation::{Kind, Observation};

use crate::clock_jump::without_jumps;
use crate::csv::own_columns;
use crate::format::{Format, format};
use crate::log::files::{files, is_bag};
use crate::others;
use crate::place::{Place, is_data_set};
use crate::recording::{LARGEST, ReadOptions, Recording};
use crate::shown::shown_path;
use crate::source::unchanged;
use crate::{Error, Origin, Result, csv, log};

/// The observation in a file, or in a folder of one recording.
///
/// # Errors
/// [`Error::Io`] where the system refuses the file, [`Error::Text`] where a line of a CSV file cannot be used,
/// [`Error::File`] where the file as a whole cannot, [`Setting`](tunenet_core::Error::Setting) where `options`
/// contradict themselves, and [`Observation`](tunenet_core::Error::Observation) where the numbers make no observation.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Recording> {
    let path = path.as_ref();
    let place = Place::of(path);
    let recording = unchanged(&watched(&place)?, || read_once(path, &place, options)).and_then(without_jumps)?;
    refuse_far(path, &recording.observation)?;
    Ok(recording)
}

/// Refuses what `options` say of files of another kind than the one at `path`, where nothing would come of it.
///
/// # Errors
/// [`Setting`](tunenet_core::Error::Setting) with the kinds of files that a flag is about; [`Error::Io`] or [`Error::File`] where there is
/// no recording.
pub fn refuse_unused_options(path: impl AsRef<Path>, options: &ReadOptions) -> Result<()> {
    if options.units.is_empty() && options.rate_hz.is_none() {
        return Ok(());
    }
    let path = path.as_ref();
    let kind = kind_of(&Place::of(path))?;
    let refuse = |name, expected: &str, what: &str| {
        let found = format!("{what} {}", shown_path(path));
        Err(tunenet_core::Error::Setting { origin: Origin::Flag, name, expected: expected.into(), found }.into())
    };
    let what = match kind {
        Some(Format::Hdf5) => return Ok(()),
        None if options.rate_hz.is_none() => return Ok(()),
        None => "the data set, which states its rate,",
        Some(Format::Mcap | Format::PackedMcap | Format::Bag) => "the log",
        Some(Format::Csv) => "the text file",
        Some(Format::Parquet | Format::Npy | Format::Npz | Format::Mat) => "the table",
    };
    if options.rate_hz.is_some() {
        return refuse("rate", "an HDF5 file, which may have no column of times", what);
    }
    let by_file = options.units.iter().all(|rule| rule.calibrated.is_some());
    refuse(
        if by_file { "calibration" } else { "units" },
        "a data set of LeRobot or an HDF5 file (others have them in `--columns`, as in q1_deg=elbow)",
        what,
    )
}

/// What the recording at a place stands in: `None` is a data set of LeRobot.
///
/// # Errors
/// [`Error::Io`] or [`Error::File`] where there is no recording.
pub(crate) fn kind_of(place: &Place) -> Result<Option<Format>> {
    if !place.path.is_dir() {
        return format(&place.path).map(Some);
    }
    if is_data_set(&place.path) {
        return Ok(None);
    }
    if !is_bag(&place.path) {
        return Err(others::no_recording(&place.path));
    }
    // All files of a log are of one kind.
    files(&place.path)?.first().map(|file| format(file)).transpose()
}

fn read_once(path: &Path, place: &Place, options: &ReadOptions) -> Result<Recording> {
    refuse_unused_options(path, options)?;
    if place.path.is_dir() {
        return folder(path, place, options);
    }
    let kind = format(&place.path)?;
    if kind == Format::Hdf5 {
        return others::episode(path, place, options);
    }
    match kind {
        Format::Csv if options.topic.is_some() => Err(tunenet_core::Error::Setting {
            origin: Origin::Flag,
            name: "topic",
            expected: "a log with topics (MCAP, ROS 2 bag)".into(),
            found: format!("the text file {}", shown_path(path)),
        }
        .into()),
        Format::Csv => csv::series::read(path, options),
        Format::Mcap | Format::PackedMcap | Format::Bag => log(path, options),
        other => others::table(path, other)?.recording(path, options),
    }
}

/// A recording in a folder.
fn folder(path: &Path, place: &Place, options: &ReadOptions) -> Result<Recording> {
    if is_data_set(&place.path) {
        return others::episode(path, place, options);
    }
    if is_bag(&place.path) {
        return log(path, options);
    }
    Err(others::no_recording(&place.path))
}

/// The files that must not change while the recording at a place is read.
fn watched(place: &Place) -> Result<Vec<PathBuf>> {
    let of_files = place.path.is_dir() && (is_data_set(&place.path) || is_bag(&place.path));
    if of_files { others::files(place) } else { Ok(vec![place.path.clone()]) }
}

fn log(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let recording = log::series::read(path, options)?;
    refuse_too_large(path, &recording.observation)?;
    let as_asked = options.channels.is_empty() || recording.observation.channels() == options.channels;
    if as_asked { Ok(recording) } else { own_columns::chosen(path, recording, options) }
}

/// The files in which the recording at `path` stands, each once and in their order.
///
/// # Errors
/// [`Error::File`] where a folder holds none.
pub fn files_of(path: impl AsRef<Path>) -> Result<Vec<PathBuf>> {
    others::files(&Place::of(path.as_ref()))
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
