//! Files and folders that the feature `logs` reads.

use std::path::{Path, PathBuf};

use crate::documents::refuse_git_lfs_pointer;
use crate::format::{Format, WITH_LOGS};
#[cfg(feature = "logs")]
use crate::hdf5::Demonstrations;
#[cfg(feature = "logs")]
use crate::lerobot::DataSet;
use crate::log::files as log_files;
#[cfg(feature = "logs")]
use crate::mat;
#[cfg(feature = "logs")]
use crate::npz;
#[cfg(feature = "logs")]
use crate::parquet::Parquet;
use crate::place::{Place, is_data_set};
use crate::recording::{ReadOptions, Recording};
use crate::sheet::Sheet;
use crate::{Episodes, Error, Result, shell_word};

/// The columns of a file of one table.
///
/// # Errors
/// [`Error::File`] where it cannot be used.
#[cfg(feature = "logs")]
pub(crate) fn table(path: &Path, format: Format) -> Result<Sheet> {
    match format {
        Format::Parquet => Parquet::open(path)?.sheet(),
        Format::Npy => npz::single(path),
        Format::Npz => npz::several(path),
        Format::Mat => mat::table(path),
        Format::Csv | Format::Mcap | Format::PackedMcap | Format::Bag | Format::Hdf5 => Err(unread(path)),
    }
}

/// The observation that an episode makes.
///
/// # Errors
/// [`Error::File`] where it cannot be used.
#[cfg(feature = "logs")]
pub(crate) fn episode(path: &Path, place: &Place, options: &ReadOptions) -> Result<Recording> {
    let name = place.episode.as_deref();
    if place.path.is_dir() {
        return DataSet::holding(&place.path, name)?.read(path, name, options);
    }
    Demonstrations::holding(&place.path, name)?.read(path, name, options)
}

/// What a file or folder of episodes says of itself.
///
/// # Errors
/// [`Error::File`] where it cannot be used.
#[cfg(feature = "logs")]
pub(crate) fn listing(place: &Place, options: &ReadOptions) -> Result<Episodes> {
    let name = place.episode.as_deref();
    if place.path.is_dir() {
        return DataSet::holding(&place.path, name)?.listing(name, options);
    }
    Demonstrations::holding(&place.path, name)?.listing(name, options)
}

/// What the columns of a recording are called that is neither a text nor a log.
///
/// # Errors
/// [`Error::File`] where it cannot be used.
#[cfg(feature = "logs")]
pub(crate) fn column_names(place: &Place, format: Option<Format>) -> Result<Vec<String>> {
    let name = place.episode.as_deref();
    match format {
        None => DataSet::column_names(&place.path),
        Some(Format::Hdf5) => Demonstrations::holding(&place.path, name)?.column_names(name),
        Some(Format::Parquet) => Parquet::open(&place.path)?.column_names(),
        Some(other) => Ok(table(&place.path, other)?.names),
    }
}

/// The files in which the recording at a place stands, each once.
///
/// # Errors
/// [`Error::File`] where a folder holds none.
pub(crate) fn files(place: &Place) -> Result<Vec<PathBuf>> {
    if place.path.is_dir() && is_data_set(&place.path) {
        #[cfg(feature = "logs")]
        return DataSet::holding(&place.path, place.episode.as_deref())?.files(place.episode.as_deref());
        #[cfg(not(feature = "logs"))]
        return Err(unread(&place.path));
    }
    log_files::files(&place.path)
}

/// Without the readers, no such file comes this far.
#[cfg(not(feature = "logs"))]
pub(crate) fn table(path: &Path, _: Format) -> Result<Sheet> {
    Err(unread(path))
}

/// As [`table`].
#[cfg(not(feature = "logs"))]
pub(crate) fn column_names(place: &Place, _: Option<Format>) -> Result<Vec<String>> {
    Err(unread(&place.path))
}

/// A folder of episodes, which this build does not read.
#[cfg(not(feature = "logs"))]
pub(crate) fn episode(_: &Path, place: &Place, _: &ReadOptions) -> Result<Recording> {
    Err(unread(&place.path))
}

/// As [`episode`].
#[cfg(not(feature = "logs"))]
pub(crate) fn listing(place: &Place, _: &ReadOptions) -> Result<Episodes> {
    Err(unread(&place.path))
}

fn unread(path: &Path) -> Error {
    let message = "expected CSV or MCAP, which this build reads, found a data set of LeRobot";
    Error::file(path, message, WITH_LOGS)
}

/// That a folder is no recording, and what it lacks.
pub(crate) fn no_recording(folder: &Path) -> Error {
    let files = some_files(folder);
    for path in &files {
        if let Err(pointer) = refuse_git_lfs_pointer(path) {
            return pointer;
        }
    }
    let tables = files.iter().any(|path| path.extension().is_some_and(|e| e == "parquet"));
    if tables && folder.join("data").is_dir() {
        let message = "expected `meta/info.json` next to the folder `data` of a LeRobot data set, found none";
        return Error::file(folder, message, "download the folder `meta` as well, or give one `.parquet` file");
    }
    let message = if tables {
        "expected a recording, found a folder with Parquet files and without the `meta/info.json` of a LeRobot data set"
    } else {
        "expected a recording, found a folder that holds none (ROS 2 bag, LeRobot data set)"
    };
    let named = |path: &&PathBuf| ENDINGS.iter().any(|ending| path.to_string_lossy().to_lowercase().ends_with(ending));
    let hint = files.iter().find(named).map_or_else(
        || "name one file in it".to_owned(),
        |path| format!("name one file in it, such as {}", shell_word(&path.to_string_lossy())),
    );
    Error::file(folder, message, hint)
}

/// How the names of recordings end.
const ENDINGS: [&str; 10] = [".csv", ".mcap", ".db3", ".hdf5", ".h5", ".parquet", ".npz", ".npy", ".mat", ".zstd"];

/// Files in a folder and the folders below it, as many as show what it is.
fn some_files(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![(folder.to_owned(), 0)]);
    while let Some((folder, depth)) = folders.pop() {
        let mut entries: Vec<PathBuf> =
            std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|e| e.path()).take(100).collect();
        entries.sort();
        for path in entries {
            if path.is_file() && found.len() < 100 {
                found.push(path);
            } else if depth < 3 && path.is_dir() && folders.len() < 100 {
                folders.push((path, depth + 1));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_tables_is_no_data_set_with_a_part_missing() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.parquet"), b"PAR1").unwrap();
        let refused = no_recording(folder.path());
        assert!(refused.to_string().contains("a folder with Parquet files"), "{refused}");
        assert!(refused.hint().unwrap().ends_with("a.parquet"), "{refused}");
        std::fs::create_dir(folder.path().join("data")).unwrap();
        assert!(no_recording(folder.path()).to_string().contains("next to the folder `data`"));
    }
}
