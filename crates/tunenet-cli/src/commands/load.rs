//! Loading what several commands need.

use std::fmt::Write;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, Result};
use sha2::{Digest, Sha256};
use toml_edit::{DocumentMut, InlineTable};
use tunenet_core::Error;
use tunenet_core::observation::Note;
use tunenet_core::observation::recording::{ReadOptions, Recording, open, read, read_text};
use tunenet_sim::replayed_arm::{ReplayedArm, replays, with_reference};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{SimulationFile, process};

use super::film;
use crate::cli::{Leave, Reading, Simulation};

/// A simulation file with its overrides.
pub fn simulation(options: &Simulation) -> Result<SimulationFile> {
    let mut file = SimulationFile::read(&options.sim)?;
    for assignment in &options.set {
        file.set(assignment)?;
    }
    Ok(file)
}

/// The same, with leave to run the program that it names where that is given; without it such a file is refused before anything
/// else is done.
pub fn simulation_with(options: &Simulation, leave: Leave) -> Result<SimulationFile> {
    let mut file = simulation(options)?;
    if leave.allow_process {
        file.allow_process();
    }
    if file.domain() == Domain::Process {
        process::leave(&file)?;
    }
    Ok(file)
}

/// Refuses a simulation file of another kind than a command needs.
pub fn of_kind(file: &SimulationFile, needed: Domain) -> Result<()> {
    if file.domain() == needed {
        return Ok(());
    }
    let message = format!("expected `kind = \"{}\"` here, found \"{}\"", needed.name(), file.domain().name());
    Err(Error::file(file.path(), message, format!("`tunenet init {}` writes one to start from", needed.name())).into())
}

/// Most samples of one recording that are looked at and fitted to; more would not sharpen the answer by as much as they
/// cost.
pub const MOST_SAMPLES: usize = 20_000;

/// A recording from a file of numbers, as `tune` and `inspect` alike look at it.
pub fn recording(path: &Path, reading: &Reading) -> Result<Recording> {
    at_most(MOST_SAMPLES, read(path, &self::reading(reading))?)
}

/// The recording with at most so many of its samples.
fn at_most(most: usize, mut recording: Recording) -> Result<Recording> {
    let samples = recording.observation.len();
    if let Some(fewer) = recording.observation.thinned(most)? {
        let text = format!("{} of {samples} samples are used, evenly chosen", fewer.len());
        recording.notes.push(Note::new("samples.thinned", text, ""));
        recording.observation = fewer;
    }
    Ok(recording)
}

/// A recording of what `file` simulates, from a file of numbers or a film, with at most so many samples.
pub fn recording_of(file: &SimulationFile, path: &Path, reading: &Reading, most: usize) -> Result<Recording> {
    no_manifest(path)?;
    if replays(file) {
        return log(file, path, reading);
    }
    if file.domain() == Domain::Process {
        return of_channels(file, path, reading, most);
    }
    if !film::is_film(path) {
        return at_most(most, read(path, &self::reading(reading))?);
    }
    if !reading.columns.is_empty() {
        let (expected, found) = ("a CSV file".into(), format!("the film {}", path.display()));
        return Err(Error::Setting { name: "columns", expected, found }.into());
    }
    let asked = film::Asked::default()
        .with("--topic", reading.topic.as_ref())
        .with("--camera-rate", reading.camera_rate.map(|r| r.to_string()));
    let found = asked.of(file).track(path)?;
    at_most(most, film::positions(path, &found)?)
}

/// Refuses a manifest where a recording is asked for.
fn no_manifest(path: &Path) -> Result<()> {
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        return Ok(());
    }
    let document = read_text(path)?.parse::<DocumentMut>().unwrap_or_default();
    let Some(all) = document.get("observation").and_then(|all| all.as_array_of_tables()) else { return Ok(()) };
    let message = format!("expected a recording, found a manifest of {}", all.len());
    let hint =
        "`tunenet diagnose --manifest` takes it; give `tune` its recordings one by one, each with `--observation`";
    Err(Error::file(path, message, hint).into())
}

/// A series on the channels that the program of `file` predicts; it is not run for that.
pub fn of_channels(file: &SimulationFile, path: &Path, reading: &Reading, most: usize) -> Result<Recording> {
    if film::is_film(path) {
        let message = "expected a series on the channels of the simulation, found a film";
        let hint = "`tunenet track` makes a CSV file of a ball's positions in it";
        return Err(Error::file(path, message, hint).into());
    }
    let options = ReadOptions { channels: process::channels(file)?, ..self::reading(reading) };
    at_most(most, read(path, &options)?)
}

/// Most samples of a log of joints: torques are averaged, so that more of them are of use, and each costs little.
const MOST_OF_A_LOG: usize = 60_000;

/// A log of the joints of the arm of `file`, matched by name where its messages have names; what its URDF leaves out is noted.
fn log(file: &SimulationFile, path: &Path, reading: &Reading) -> Result<Recording> {
    let arm = ReplayedArm::from_file(file)?;
    let options = ReadOptions { joints: arm.joint_names(), ..self::reading(reading) };
    at_most(MOST_OF_A_LOG, read(path, &options)?)
}

/// What the URDF of the replayed arm of `file` lacks, of the joints that move.
pub fn lacks(file: &SimulationFile) -> Result<Vec<Note>> {
    if !replays(file) {
        return Ok(Vec::new());
    }
    let arm = ReplayedArm::from_file(file)?;
    let moves = |note: &&Note| arm.joint_names().iter().any(|name| note.text.contains(&format!("`{name}`")));
    Ok(arm.notes().iter().filter(|n| n.code == "urdf.limits").filter(moves).cloned().collect())
}

/// `recording` with the run without payload at `reference` beside it, where there is one.
pub fn beside(
    file: &SimulationFile,
    recording: Recording,
    reference: Option<&Path>,
    reading: &Reading,
) -> Result<Recording> {
    let Some(path) = reference else { return Ok(recording) };
    if !replays(file) {
        let (expected, found) = ("an arm with `motion.kind = \"replay\"`".into(), "another simulation".into());
        return Err(Error::Setting { name: "--reference", expected, found }.into());
    }
    let bare = log(file, path, reading)?;
    let (observation, note) = with_reference(&recording.observation, &bare.observation).with_context(|| name(path))?;
    let mut notes = recording.notes;
    notes.extend(bare.notes.into_iter().map(|note| Note { text: format!("{}: {}", name(path), note.text), ..note }));
    notes.push(note);
    Ok(Recording { observation, notes })
}

/// The command line's say in how files are read.
pub fn reading(reading: &Reading) -> ReadOptions {
    ReadOptions {
        columns: reading.columns.clone(),
        topic: reading.topic.clone(),
        skip_broken: reading.skip_broken,
        ..ReadOptions::default()
    }
}

/// Refuses a recording that is given twice, whatever it is called: the same evidence counted twice looks like twice as much.
/// Only files of one length are read, so that a single large one costs nothing.
pub fn distinct<'a>(recordings: impl Iterator<Item = &'a Path>) -> Result<()> {
    let mut seen: Vec<(&Path, u64)> = Vec::new();
    for path in recordings {
        // What cannot be read is refused by whoever reads it.
        let length = std::fs::metadata(path).map_or(0, |about| about.len());
        for (other, _) in seen.iter().filter(|(_, known)| *known == length && length > 0) {
            if hash(path)? == hash(other)? {
                let message = format!("expected another recording, found the same as in {}", other.display());
                return Err(Error::file(path, message, "give every recording once").into());
            }
        }
        seen.push((path, length));
    }
    Ok(())
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

/// The SHA-256 of a file's bytes, in hexadecimal; of a folder of frames, that of all their bytes.
pub fn hash(path: &Path) -> Result<String> {
    let mut hasher = Sha256::new();
    if path.is_dir() {
        for picture in film::pictures(path).map_err(|source| Error::io(path, "reading", source))? {
            digest(&picture, &mut hasher)?;
        }
    } else {
        digest(path, &mut hasher)?;
    }
    Ok(hex(&hasher.finalize()))
}

/// A file's name and hash, as `[provenance]` names what was read.
pub fn fingerprint(path: &Path) -> Result<InlineTable> {
    let mut one = InlineTable::new();
    one.insert("file", name(path).into());
    one.insert("sha256", hash(path)?.into());
    Ok(one)
}

fn digest(path: &Path, hasher: &mut Sha256) -> Result<()> {
    let failed = |source| Error::io(path, "reading", source);
    let mut file = open(path)?;
    let mut buffer = vec![0; 1 << 16];
    loop {
        let count = file.read(&mut buffer).map_err(failed)?;
        if count == 0 {
            break;
        }
        hasher.update(&buffer[..count]);
    }
    Ok(())
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

/// The SHA-256 of the URDF that a simulation names, where it names one that is there.
pub fn urdf_hash(options: &Simulation) -> Result<Option<String>> {
    let named = options.urdf_set().or_else(|| super::destination::urdf_beside(&options.sim));
    named.filter(|path| path.is_file()).map(|path| hash(&path)).transpose()
}

/// A pool of so many threads; of as many as the machine has cores where nothing is said.
pub fn threads(jobs: Option<usize>) -> Result<rayon::ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.unwrap_or(0));
    pool.build().context("starting threads")
}
