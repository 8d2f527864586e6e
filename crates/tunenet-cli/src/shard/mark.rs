//! The file `shard.json` in the folder of a finished shard: what it is a share of, and what has to lie there.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tunenet_core::network::Shard;
use tunenet_formats::{Action, Error, write_atomically};

use crate::files::{hash, programs};

/// The mark's name in its folder.
const NAME: &str = "shard.json";
/// Of the mark's form.
const SCHEMA: &str = "tunenet.shard.mark/1";

/// What was cut into shards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Job {
    /// A bench, with everything on its command line that decides what comes out.
    Bench(Value),
    /// `tune --each` or `diagnose --each`.
    Each {
        /// `tune` or `diagnose`.
        tool: String,
        /// A digest of everything but the recordings that decides what comes out.
        run: String,
        /// All recordings, of every shard, by the names of their results.
        recordings: Vec<String>,
    },
}

impl Job {
    /// The program that does it, as a digest of its bytes.
    ///
    /// # Errors
    /// Where that program cannot be read.
    pub fn program(&self) -> Result<String> {
        match self {
            Self::Bench(_) => hash::sha256(&programs::sibling(programs::BENCH)?),
            Self::Each { .. } => hash::sha256(&std::env::current_exe().context("this program's own path")?),
        }
    }
}

/// The mark.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mark {
    schema: String,
    /// The version that wrote the shard.
    pub version: String,
    /// The program itself, as a digest: a version alone would not distinguish two builds.
    pub program: String,
    /// Which share this is.
    pub shard: Shard,
    /// Of what.
    pub job: Job,
    /// Every file of the shard, by its path within the folder, with its SHA-256.
    pub files: BTreeMap<String, String>,
}

impl Mark {
    /// Writes the mark of a finished shard, of whatever lies in its folder.
    pub fn write(folder: &Path, shard: Shard, job: Job) -> Result<()> {
        let mut files = BTreeMap::new();
        for path in listed(folder)? {
            let hash = hash::sha256(&folder.join(&path))?;
            files.insert(path, hash);
        }
        let mark = Self {
            schema: SCHEMA.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            program: job.program()?,
            shard,
            job,
            files,
        };
        let text = format!("{}\n", serde_json::to_string_pretty(&mark)?);
        Ok(write_atomically(folder.join(NAME), |file| file.write_all(text.as_bytes()))?)
    }

    /// The mark of the shard in `folder`.
    ///
    /// # Errors
    /// [`Error::File`] where there is none, since the shard is not finished, or no mark that can be read.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(NAME);
        let again = "run the command that makes it again; it resumes";
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound && folder.is_dir() => {
                let message = format!("expected a finished shard, found a folder without `{NAME}`");
                return Err(Error::file(folder, message, again).into());
            }
            Err(error) => return Err(Error::io(path, Action::Reading, error).into()),
        };
        let value: Value = serde_json::from_str(&text).unwrap_or_default();
        if value["schema"] != SCHEMA {
            return Err(Error::file(
                path,
                format!("expected the mark of a shard, {SCHEMA}, found something else"),
                again,
            )
            .into());
        }
        let ours = env!("CARGO_PKG_VERSION");
        if let Some(version) = value["version"].as_str().filter(|version| *version != ours) {
            let message = format!("expected a shard by tunenet {ours}, found one by {version}");
            return Err(Error::file(folder, message, "merge with the version that wrote the shards").into());
        }
        let damaged = || Error::file(&path, "expected the mark of a shard, found one that is damaged", again);
        serde_json::from_value(value).map_err(|_| damaged().into())
    }

    /// Refuses a shard in which a file is missing or has other contents than when the shard was finished.
    pub fn check(&self, folder: &Path) -> Result<()> {
        if let Some((path, found)) = self.broken(folder).next() {
            let message = format!("expected what shard {} wrote there, found {found}", self.shard);
            let hint = "give the command that makes the shard again; it makes what is missing";
            return Err(Error::file(folder.join(path), message, hint).into());
        }
        Ok(())
    }

    fn broken<'a>(&'a self, folder: &'a Path) -> impl Iterator<Item = (&'a str, &'static str)> + 'a {
        self.files.iter().filter_map(move |(path, expected)| {
            let at = folder.join(path);
            if !at.is_file() {
                return Some((path.as_str(), "nothing"));
            }
            (hash::sha256(&at).ok().as_ref() != Some(expected)).then_some((path.as_str(), "other contents"))
        })
    }
}

/// Before a shard is worked on: removes what is damaged of a finished one, so that it is made again, and reports each.
pub fn clear_damage(folder: &Path) -> Result<Vec<String>> {
    let Ok(mark) = Mark::read(folder) else { return Ok(Vec::new()) };
    let mut damaged = Vec::new();
    for (path, found) in mark.broken(folder) {
        let at = folder.join(path);
        if found != "nothing" {
            std::fs::remove_file(&at).map_err(|source| Error::io(&at, Action::Removing, source))?;
        }
        damaged.push(format!("{}, which had {found}", at.display()));
    }
    let mark = folder.join(NAME);
    std::fs::remove_file(&mark).map_err(|source| Error::io(&mark, Action::Removing, source))?;
    Ok(damaged)
}

/// Every file in `folder` but the mark, by its path within, in order.
fn listed(folder: &Path) -> Result<Vec<String>> {
    let (mut files, mut folders) = (Vec::new(), vec![PathBuf::new()]);
    while let Some(within) = folders.pop() {
        let at = folder.join(&within);
        let failed = |source| Error::io(&at, Action::Reading, source);
        for entry in std::fs::read_dir(&at).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let path = within.join(entry.file_name());
            if entry.path().is_dir() {
                folders.push(path);
            } else if path != Path::new(NAME) {
                let text = path.to_str().with_context(|| format!("the name of {} is not Unicode", path.display()))?;
                files.push(text.replace('\\', "/"));
            }
        }
    }
    files.sort();
    Ok(files)
}
