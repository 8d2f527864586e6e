//! Data sets of LeRobot, versions 2 and 3: a folder with `meta/info.json` and Parquet files, in which commands and states of a
//! robot's joints stand episode by episode.
//!
//! | file | subject |
//! |---|---|
//! | `info` | rate, features and their names |
//! | `index` | which episodes are there, and where |
//! | `episode` | the columns of one episode, in their units |
//! | `listing` | what a data set says of itself, and the units that its numbers suggest |
//!
//! Source: the format as the `lerobot` package writes it (`codebase_version` v2.0, v2.1, v3.0).

mod episode;
mod index;
mod info;
mod listing;

use std::path::{Path, PathBuf};

use self::index::{Episode, Index, index, one};
use self::info::Info;
use crate::numbered::{EPISODE, of_episode};
use crate::shown::{counted, list, shortened};
use crate::{Error, Result};
use tunenet_core::text::visible;

/// A data set.
pub(crate) struct DataSet {
    folder: PathBuf,
    info: Info,
    index: Index,
}

/// The folder of the data set in `folder`: itself, or the only one of the folders below it that is one.
pub(crate) fn root(folder: &Path) -> Option<PathBuf> {
    let is_one = |folder: &Path| folder.join("meta").join("info.json").is_file();
    if is_one(folder) {
        return Some(folder.to_owned());
    }
    let below = |folder: &Path| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).filter(|path| path.is_dir()).take(1000).collect()
    };
    let first = below(folder);
    let second: Vec<PathBuf> = first.iter().flat_map(|folder| below(folder)).collect();
    let mut found = first.into_iter().chain(second).filter(|folder| is_one(folder));
    let one = found.next()?;
    found.next().is_none().then_some(one)
}

impl DataSet {
    /// Opens the data set in `folder`.
    ///
    /// # Errors
    /// [`Error::Io`] or [`Error::File`] where it is none, or a broken one.
    pub fn open(folder: &Path) -> Result<Self> {
        let folder = root(folder).unwrap_or_else(|| folder.to_owned());
        let info = Info::read(&folder)?;
        let index = index(&folder, &info)?;
        if index.episodes.is_empty() {
            if let Some(pointer) = index.pointers.first() {
                // Every one of its files is one.
                crate::refuse_git_lfs_pointer(pointer)?;
            }
            if let Some(path) = info.unusual_path() {
                let path = visible(&shortened(path));
                let message = format!(
                    "expected Parquet files at `{path}` (`data_path` in `meta/info.json`), found none with an episode"
                );
                let hint = "download the folder `data` of the data set as well, or correct `data_path`";
                return Err(Error::file(&folder, message, hint));
            }
            let message = "expected Parquet files below `data`, found none with an episode";
            return Err(Error::file(&folder, message, "download the folder `data` of the data set as well"));
        }
        Ok(Self { folder, info, index })
    }

    /// As [`Self::open`], for who needs the episode of this name alone: where it is there, the others are not looked for.
    ///
    /// # Errors
    /// As [`Self::open`]. An episode that is not there is no error.
    pub fn holding(folder: &Path, name: Option<&str>) -> Result<Self> {
        let Some(number) = name.and_then(of_episode) else { return Self::open(folder) };
        let root = root(folder).unwrap_or_else(|| folder.to_owned());
        let info = Info::read(&root)?;
        match one(&root, &info, number)? {
            Some(episode) => {
                let index = Index { episodes: vec![episode], pointers: Vec::new() };
                Ok(Self { folder: root, info, index })
            }
            None => Self::open(folder),
        }
    }

    /// What its columns are called, without looking into any of its files of data.
    ///
    /// # Errors
    /// Where `meta/info.json` cannot be used.
    pub fn column_names(folder: &Path) -> Result<Vec<String>> {
        let info = Info::read(&root(folder).unwrap_or_else(|| folder.to_owned()))?;
        Ok(info.features.into_iter().flat_map(|feature| feature.names).collect())
    }

    /// The names of the episodes that are there.
    pub fn names(&self) -> Vec<String> {
        self.index.episodes.iter().map(|episode| format!("{EPISODE}{}", episode.number)).collect()
    }

    /// The episode of this name; the only one where none is named.
    fn episode(&self, name: Option<&str>) -> Result<&Episode> {
        let all = &self.index.episodes;
        let name = match (name, all.as_slice()) {
            (Some(name), _) => name,
            (None, [only]) => return Ok(only),
            (None, several) => {
                let message = format!("expected one recording, found {}", counted(several.len(), "episode"));
                let first = self.folder.join(format!("{EPISODE}{}", several[0].number));
                let hint = format!("name one, such as {}, or choose with `--episodes`", first.display());
                return Err(Error::file(&self.folder, message, hint));
            }
        };
        let found = of_episode(name).and_then(|number| all.iter().find(|episode| episode.number == number));
        found.ok_or_else(|| {
            let names = self.names();
            let there = list(names.iter().map(String::as_str), 6);
            let message = format!("expected an episode that is there ({there}), found `{name}`");
            let hint = if self.index.pointers.is_empty() {
                "download the file of that episode as well"
            } else {
                "run `git lfs pull` in its repository, which downloads the files that are missing"
            };
            Error::file(&self.folder, message, hint)
        })
    }

    /// The files in which an episode stands, with the one that says what its columns are.
    ///
    /// # Errors
    /// [`Error::File`] where there is no such episode.
    pub fn files(&self, name: Option<&str>) -> Result<Vec<PathBuf>> {
        let mut files = vec![self.folder.join("meta").join("info.json")];
        files.extend(self.episode(name)?.files.iter().cloned());
        Ok(files)
    }
}

#[cfg(test)]
mod tests;
