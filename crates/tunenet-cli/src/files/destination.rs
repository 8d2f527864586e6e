//! Where a command may write: never over what it reads, and over a file that is there already only where tunenet itself
//! wrote one of that kind, so that the same command can be given again, or where it is asked to.

use std::io::Read;
use std::path::{Component, Path, PathBuf};

use anyhow::Result;
use toml_edit::DocumentMut;
use tunenet_core::Origin;
use tunenet_formats::RolloutFile;
use tunenet_formats::dataset::DatasetReader;
use tunenet_formats::load_model;
use tunenet_formats::read_text;
use tunenet_formats::{Action, Error};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{SimulationFile, process};

use crate::files::names;

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Product {
    /// A simulation file with tunenet's provenance.
    Simulation,
    /// A report.
    Page,
    /// A data set of rollout pairs.
    Dataset,
    /// A trained network.
    Model,
    /// An answer, or several, as JSON.
    Answer,
    /// Answered rollouts of a tuning.
    Rollouts,
    /// Something that cannot be distinguished from a user's own file, such as a recording.
    Unmarked,
}

impl Product {
    /// What may be replaced by it.
    fn name(self) -> &'static str {
        match self {
            Self::Simulation => "a new name, or a simulation file that tunenet wrote",
            Self::Page => "a new name, or a report that tunenet wrote",
            Self::Dataset => "a new name, or a data set that tunenet wrote",
            Self::Model => "a new name, or a model that tunenet wrote",
            Self::Answer => "a new name, or an answer that tunenet wrote",
            Self::Rollouts => "a new name, or rollouts that `tunenet tune` kept",
            Self::Unmarked => "a new name",
        }
    }

    /// What its name ends in; none where any name will do, or where its command knows.
    fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Simulation => &["toml"],
            Self::Page => &["html", "htm"],
            Self::Dataset => &["mcap"],
            Self::Model => &["safetensors"],
            Self::Answer => &["json"],
            Self::Rollouts | Self::Unmarked => &[],
        }
    }

    /// Whether `path` is one of these already, by what it says of itself.
    fn is(self, path: &Path) -> bool {
        match self {
            Self::Simulation => std::fs::read_to_string(path)
                .ok()
                .and_then(|text| text.parse::<DocumentMut>().ok())
                .and_then(|file| Some(file.get("provenance")?.get("tool")?.as_str()?.starts_with("tunenet ")))
                .unwrap_or(false),
            Self::Page => beginning(path).is_ok_and(|start| is_page(&start)),
            Self::Dataset => {
                DatasetReader::open(path).is_ok() || DatasetReader::open_shard(path).is_ok() || is_cut_shard(path)
            }
            Self::Model => load_model(path).is_ok(),
            Self::Answer => std::fs::read_to_string(path)
                .ok()
                .and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok())
                .and_then(|answer| Some(answer.get("schema")?.as_str()?.starts_with("tunenet.")))
                .unwrap_or(false),
            Self::Rollouts => RolloutFile::is_one(path),
            Self::Unmarked => false,
        }
    }
}

/// Whether a file that begins so is a report of tunenet, of any version.
pub fn is_page(start: &str) -> bool {
    start.starts_with("<!DOCTYPE html>") && start.contains("<meta name=\"generator\" content=\"tunenet ")
}

/// One file that is to be written.
#[derive(Debug, Clone)]
pub struct Output {
    /// Its name.
    pub path: PathBuf,
    /// The flag that named it, which is what a person can change.
    pub flag: &'static str,
    /// What it will hold.
    pub product: Product,
    /// Whether its folder is made where there is none.
    pub makes_folder: bool,
}

impl Output {
    /// A file whose folder has to be there.
    #[must_use]
    pub fn new(path: &Path, flag: &'static str, product: Product) -> Self {
        Self { path: path.to_path_buf(), flag, product, makes_folder: false }
    }
}

/// The model of an arm or a robot that a simulation or a task file names, which is read with it.
pub fn neighbouring_urdf(input: &Path) -> Option<PathBuf> {
    if input.extension()? != "toml" {
        return None;
    }
    let file: DocumentMut = read_text(input).ok()?.parse().ok()?;
    let named = |table: &str, key: &str| file.get(table)?.get(key)?.as_str();
    Some(input.parent()?.join(named("arm", "urdf").or(named("robot", "model"))?))
}

/// The files among the words of the command that a simulation file names: the program, or what its interpreter reads.
fn neighbouring_programs(input: &Path) -> Vec<PathBuf> {
    if input.extension().is_none_or(|ending| ending != "toml") {
        return Vec::new();
    }
    let Ok(file) = SimulationFile::read(input) else { return Vec::new() };
    programs(&file)
}

/// The files among the words of the command of a simulation file.
pub fn programs(file: &SimulationFile) -> Vec<PathBuf> {
    if file.domain() != Domain::Process {
        return Vec::new();
    }
    let folder = file.program_folder();
    process::words(file).into_iter().map(|word| folder.join(word)).filter(|path| path.is_file()).collect()
}

/// Refuses, before any work is done, outputs that are one of the `inputs` or a URDF or a program that one of them names, that
/// are one another, whose names end otherwise than their contents say, that cannot be written, or that would replace what tunenet did not write; the last not where `overwrite`
/// is asked for.
pub fn check(outputs: &[Output], inputs: &[&Path], overwrite: bool) -> Result<()> {
    let urdfs = inputs.iter().filter_map(|input| neighbouring_urdf(input));
    let programs = inputs.iter().flat_map(|input| neighbouring_programs(input));
    let siblings: Vec<PathBuf> = urdfs.chain(programs).collect();
    let inputs: Vec<&Path> = inputs.iter().copied().chain(siblings.iter().map(PathBuf::as_path)).collect();
    for (number, output) in outputs.iter().enumerate() {
        let Output { path, flag, product, makes_folder } = output;
        let place = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        if let Some(other) = outputs[..number].iter().find(|other| place(&other.path) == place(path)) {
            let (expected, found) = (format!("another file than `{}`", other.flag), names::file_name(path));
            return Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: flag, expected, found }.into());
        }
        if let Ok(same) = path.canonicalize()
            && inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == same))
        {
            let message = "this file is read as an input, and would be overwritten";
            return Err(Error::file(path, message, format!("choose another name for {flag}")).into());
        }
        if !product.endings().is_empty() && !is_device(path) {
            names::require_ending(path, flag, product.endings())?;
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if path.is_dir() {
            return Err(Error::io(path, Action::Writing, std::io::ErrorKind::IsADirectory.into()).into());
        }
        if let Some(folder) = folder {
            leads_somewhere(path, folder, *makes_folder)?;
        }
        if !overwrite && holds_something(path) && !product.is(path) {
            return Err(taken(output).into());
        }
    }
    Ok(())
}

/// Refuses what `named` would be written into, where a part of the way to it is missing or is a file. With `makes` a folder that
/// is missing is made, but none that only `..` leaves again.
pub fn leads_somewhere(named: &Path, folder: &Path, makes: bool) -> Result<()> {
    let mut way = PathBuf::new();
    let mut parts = folder.components().peekable();
    while let Some(part) = parts.next() {
        way.push(part);
        match std::fs::metadata(&way) {
            Ok(about) if about.is_dir() => continue,
            Ok(_) => {
                let message = format!("expected a folder at {}, found a file", way.display());
                return Err(Error::file(named, message, "name a folder, or write to another place").into());
            }
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(Error::io(&way, Action::Reading, error).into());
            }
            Err(_) => {}
        }
        if parts.clone().any(|later| later == Component::ParentDir) {
            let message = format!("expected a folder at {} before `..`, found none", way.display());
            let hint = "make it, or write the path without it";
            return Err(Error::file(named, message, hint).into());
        }
        if !makes {
            let message = format!("the folder {} does not exist", way.display());
            return Err(Error::file(named, message, "make the folder first").into());
        }
        return Ok(());
    }
    Ok(())
}

/// What is said where something stands in the way.
pub fn taken(output: &Output) -> Error {
    let message = format!("expected {}, found a file that is there already", output.product.name());
    Error::file(&output.path, message, format!("choose another {}, or replace it with --overwrite", output.flag))
}

/// Whether it is a device or a pipe, which has no name of its own choice: `/dev/null`.
fn is_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|about| !about.is_file() && !about.is_dir())
}

/// Whether a file with contents stands there, or a link that leads nowhere: somebody made it. A device or a pipe holds
/// nothing, and an empty file has nothing to lose.
pub fn holds_something(path: &Path) -> bool {
    match std::fs::metadata(path) {
        Ok(about) => about.is_file() && about.len() > 0,
        Err(_) => path.symlink_metadata().is_ok(),
    }
}

/// Whether a file has the name of a shard and begins as tunenet's logs do, though it ends before it says more: a node that was
/// switched off leaves it.
fn is_cut_shard(path: &Path) -> bool {
    let named = path.file_name().is_some_and(|name| name.to_string_lossy().contains(".shard-"));
    named && beginning(path).is_ok_and(|start| start.contains("MCAP0") && start.contains("tunenet "))
}

/// The first kilobyte of a file as text.
fn beginning(path: &Path) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(1024).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
