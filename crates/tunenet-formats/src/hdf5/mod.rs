//! HDF5 files of demonstrations: of robomimic and Isaac Lab (`data/demo_0/actions`, `obs/joint_pos`), of ALOHA (`action`,
//! `observations/qpos`), and any other whose arrays have a row for each instant. Every such array is as many columns, named by its path.
//!
//! | file | subject |
//! |---|---|
//! | `links` | links that name a path or another file |
//! | `tree`, `shape` | groups and arrays of a file; which arrays are columns |
//! | `episode` | the columns of one episode |
//! | `actions` | whether actions are what joints are sent to |
//! | `listing` | what a file says of itself |

mod actions;
mod episode;
mod links;
mod listing;
mod shape;
mod tree;

use std::path::{Path, PathBuf};

use hdf5_pure::File;

use self::links::links;
use self::tree::{Array, Found, arrays, episodes, one};
use crate::shown::{counted, list};
use crate::{Error, Result};
use tunenet_core::text::visible;

/// What is tried where a file is broken.
const AGAIN: &str = "copy the file again, or check it with `h5dump -H`";

/// What is tried where links are not followed.
const COPY: &str = "copy what a link names: with h5py, `del file['LINK']`, then `file.copy('NAME', 'LINK')`";

/// Most arrays or links that a message names.
const MOST_LISTED: usize = 8;

/// An open file.
pub(crate) struct Demonstrations {
    path: PathBuf,
    file: File,
    /// The names of the episodes, and the paths of their groups; one without a name where the file is a single episode.
    episodes: Vec<(String, String)>,
    /// Groups that hold nothing.
    empty: Vec<String>,
    /// What the file says of the simulator that it comes from, as JSON; empty where it says nothing.
    environment: String,
}

impl Demonstrations {
    /// Opens the file at `path`.
    ///
    /// # Errors
    /// [`Error::File`] where it is broken, or holds no arrays with a row for each instant.
    pub fn open(path: &Path) -> Result<Self> {
        let file = opened(path)?;
        let found = episodes(path, &file)?;
        Self::of(path, file, found)
    }

    /// As [`Self::open`], for who needs the episode of this name alone: where it is there, the others are not looked into.
    ///
    /// # Errors
    /// As [`Self::open`]. An episode that is not there is no error.
    pub fn holding(path: &Path, name: Option<&str>) -> Result<Self> {
        let Some(name) = name else { return Self::open(path) };
        let file = opened(path)?;
        match one(path, &file, name)? {
            Some(found) => Self::of(path, file, found),
            None => Self::open(path),
        }
    }

    fn of(path: &Path, file: File, found: Found) -> Result<Self> {
        if found.episodes.is_empty() {
            let message = format!(
                "expected arrays with a row for each instant, found none in {}",
                counted(found.groups, "group")
            );
            let message = found.left_out.map_or(message.clone(), |note| format!("{message}; {}", note.text));
            return Err(Error::file(path, message, "give a file of demonstrations or of a log"));
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            episodes: found.episodes,
            empty: found.empty,
            environment: found.environment,
        })
    }

    /// The names of its episodes; empty where it is a single one.
    pub fn names(&self) -> Vec<String> {
        self.episodes.iter().map(|(name, _)| name.clone()).filter(|name| !name.is_empty()).collect()
    }

    /// The group of the episode of this name, or of the only one.
    fn group(&self, name: Option<&str>) -> Result<&str> {
        match (name, self.episodes.as_slice()) {
            (None, [(_, only)]) => Ok(only),
            (None, several) => {
                let message = format!("expected one recording, found {}", counted(several.len(), "episode"));
                let hint = format!(
                    "name one, such as {}, or choose with `--episodes`",
                    self.path.join(&several[0].0).display()
                );
                Err(Error::file(&self.path, message, hint))
            }
            (Some(name), all) => {
                if let Some((_, group)) = all.iter().find(|(known, _)| known == name) {
                    return Ok(group);
                }
                let names = self.names();
                let there = list(names.iter().map(String::as_str), 6);
                let message = format!("expected an episode that is there ({there}), found `{name}`");
                Err(Error::file(&self.path, message, "`tunenet inspect` lists them"))
            }
        }
    }

    /// What the columns of an episode are called; none of its numbers are read.
    ///
    /// # Errors
    /// [`Error::File`] where there is no such episode, or it is broken.
    pub fn column_names(&self, name: Option<&str>) -> Result<Vec<String>> {
        let arrays = self.arrays(self.group(name)?)?;
        Ok(arrays.iter().flat_map(Array::column_names).collect())
    }

    /// The arrays of an episode.
    fn arrays(&self, group: &str) -> Result<Vec<Array>> {
        arrays(&self.path, &self.file, group)
    }
}

/// Arrays or links, each with what is said of it, as many as a message takes.
fn listed(all: &[(String, String)]) -> String {
    let one = |(name, said): &(String, String)| format!("{} ({})", list([name.as_str()], 1), visible(said));
    let mut shown: Vec<String> = all.iter().take(MOST_LISTED).map(one).collect();
    if all.len() > MOST_LISTED {
        shown.push(format!("and {} more", all.len() - MOST_LISTED));
    }
    shown.join(", ")
}

/// The file at `path`. A folder, a pipe and a device are refused as everywhere.
fn opened(path: &Path) -> Result<File> {
    drop(crate::source::open(path)?);
    File::open_streaming(path).map_err(|e| broken(path, &e))
}

/// What is wrong with a file that the crate refuses.
fn broken(path: &Path, error: &hdf5_pure::Error) -> Error {
    broken_in(path, "/", error)
}

/// The same, where the group that is read is known.
fn broken_in(path: &Path, group: &str, error: &hdf5_pure::Error) -> Error {
    // A link without an address is one to a name.
    if let hdf5_pure::Error::Format(hdf5_pure::FormatError::OffsetOverflow { offset: u64::MAX, .. }) = error {
        let named = File::open_streaming(path).map(|file| links(path, file.superblock(), group)).unwrap_or_default();
        let named = if named.is_empty() { String::new() } else { format!(": {}", listed(&named)) };
        let group = list([group], 1);
        let message = format!("expected arrays and groups in {group}, found a link, which is not followed{named}");
        return Error::file(path, message, COPY);
    }
    Error::file(path, format!("the HDF5 file is cut off, broken or not closed: {error}"), AGAIN)
}

#[cfg(test)]
mod tests;
