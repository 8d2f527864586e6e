//! Loading what several commands need.

use std::fmt::Write;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, Result};
use sha2::{Digest, Sha256};
use tunenet_core::Error;
use tunenet_core::observation::recording::{ReadOptions, Recording, open, read};
use tunenet_sim::SimulationFile;

use super::film;
use crate::cli::{Reading, Simulation};

/// A simulation file with its overrides.
pub fn simulation(options: &Simulation) -> Result<SimulationFile> {
    let mut file = SimulationFile::read(&options.sim)?;
    for assignment in &options.set {
        file.set(assignment)?;
    }
    Ok(file)
}

/// A recording from a file.
pub fn recording(path: &Path, reading: &Reading) -> Result<Recording> {
    Ok(read(path, &self::reading(reading))?)
}

/// A recording of what `file` simulates, from a file of numbers or a film.
pub fn recording_of(file: &SimulationFile, path: &Path, reading: &Reading) -> Result<Recording> {
    if !film::is_film(path) {
        return recording(path, reading);
    }
    if !reading.columns.is_empty() {
        let (expected, found) = ("a CSV file".into(), format!("the film {}", path.display()));
        return Err(Error::Setting { name: "columns", expected, found }.into());
    }
    let found = film::Asked::default().with("--topic", reading.topic.as_ref()).of(file).track(path)?;
    film::positions(path, &found)
}

/// The command line's say in how files are read.
pub fn reading(reading: &Reading) -> ReadOptions {
    ReadOptions { columns: reading.columns.clone(), topic: reading.topic.clone() }
}

/// Refuses an output that a long run could not be saved to (a folder, or a name in a folder that does not exist), and one
/// that is an input as well: nobody means to lose a measurement.
pub fn writable(out: &Path, inputs: &[&Path]) -> Result<()> {
    if let Ok(same) = out.canonicalize()
        && inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == same))
    {
        let message = "expected another file to write to, found one of the inputs";
        return Err(Error::file(out, message, "choose another name for --out").into());
    }
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    let kind = if out.is_dir() {
        std::io::ErrorKind::IsADirectory
    } else if folder.is_some_and(|folder| !folder.is_dir()) {
        std::io::ErrorKind::NotFound
    } else {
        return Ok(());
    };
    Err(Error::io(out, "writing", kind.into()).into())
}

/// Refuses an output whose name ends otherwise than its contents say: whoever finds the file later goes by its name.
pub fn ending(out: &Path, endings: &[&str]) -> Result<()> {
    let found = out.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if endings.contains(&found.as_str()) {
        return Ok(());
    }
    let each: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
    let (expected, found) = (format!("a name that ends in {}", each.join(" or ")), format!("`{}`", out.display()));
    Err(Error::Setting { name: "--out", expected, found }.into())
}

/// The SHA-256 of a file's bytes, in hexadecimal.
pub fn hash(path: &Path) -> Result<String> {
    let failed = |source| Error::io(path, "reading", source);
    let mut file = open(path)?;
    let mut hasher = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        let count = file.read(&mut buffer).map_err(failed)?;
        if count == 0 {
            break;
        }
        hasher.update(&buffer[..count]);
    }
    Ok(hex(&hasher.finalize()))
}

/// Bytes in hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// A file's own name, for output that must not depend on where it lies.
pub fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A pool of so many threads; of as many as the machine has cores where nothing is said.
pub fn threads(jobs: Option<usize>) -> Result<rayon::ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.unwrap_or(0));
    pool.build().context("starting threads")
}
