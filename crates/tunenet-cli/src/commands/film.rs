//! Films: what `tunenet-video`, which alone knows OpenCV, says of them.

use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result};
use serde_json::{Value, json};
use tunenet_core::Error;
use tunenet_core::observation::recording::Recording;
use tunenet_core::observation::{Note, Observation};
use tunenet_sim::SimulationFile;

use super::print_json;
use crate::failure::Exit;
use crate::terminal::warn;

/// The program that reads films, beside this one.
const PROGRAM: &str = "tunenet-video";
/// What films' names end in.
const ENDINGS: [&str; 9] = ["mp4", "m4v", "mov", "avi", "mkv", "webm", "mpg", "mpeg", "3gp"];
/// What the names of a film's frames end in, where each is a file of its own.
const PICTURES: [&str; 6] = ["png", "jpg", "jpeg", "bmp", "tif", "tiff"];
/// What the names of other recordings end in.
const TABLES: [&str; 5] = ["csv", "tsv", "txt", "mcap", "json"];
/// How films begin: where, and with which bytes.
const MARKS: [(usize, &[u8]); 4] = [(4, b"ftyp"), (8, b"AVI "), (0, b"\x1a\x45\xdf\xa3"), (0, b"\x00\x00\x01\xba")];
/// The code of a ball that never leaves the ground, which tells nothing of a bounce.
const ROLLS: &str = "ball.rolls";
/// The codes of what may be noticed of a film.
const CODES: [&str; 16] = [
    "ball.background",
    "ball.cut",
    "ball.gone",
    "ball.lost",
    "ball.none",
    "ball.rolls",
    "ball.shape",
    "ball.two",
    "camera.bumped",
    "camera.moves",
    "film.dropped",
    "film.repeated",
    "film.truncated",
    "flight.odd",
    "scale.disagrees",
    "film.other",
];

/// Where the program that sees must lie: beside this one.
pub fn program() -> Result<PathBuf> {
    let own = std::env::current_exe().context("this program's own path")?;
    Ok(own.with_file_name(format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX)))
}

/// The pictures in a folder, in the order of their names.
pub fn pictures(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let picture =
        |path: &PathBuf| path.extension().is_some_and(|e| PICTURES.iter().any(|known| e.eq_ignore_ascii_case(known)));
    let all = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<PathBuf>>>()?;
    let mut pictures: Vec<PathBuf> = all.into_iter().filter(picture).collect();
    pictures.sort();
    Ok(pictures)
}

/// Whether a file is a film, by its name or, where that says nothing else, by its first bytes; so is a folder of pictures.
pub fn is_film(path: &Path) -> bool {
    if path.is_dir() {
        return pictures(path).is_ok_and(|pictures| !pictures.is_empty());
    }
    // Pipes are waited for where they are opened, and a folder is refused by whoever reads it.
    let file = std::fs::metadata(path).is_ok_and(|about| about.is_file());
    let table = path.extension().is_some_and(|e| TABLES.iter().any(|known| e.eq_ignore_ascii_case(known)));
    if !file || table {
        return false;
    }
    let named = path.extension().is_some_and(|e| ENDINGS.iter().any(|known| e.eq_ignore_ascii_case(known)));
    let mut start = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(16).read_to_end(&mut start));
    named || read.is_ok() && MARKS.iter().any(|(at, mark)| start.get(*at..).is_some_and(|s| s.starts_with(mark)))
}

/// A film in which no ball could be followed: an answer, and no fault of the file.
#[derive(Debug, thiserror::Error)]
#[error("{}: {}", path.display(), note.text)]
pub struct Unseen {
    /// The film.
    pub path: PathBuf,
    /// Why, and what to try.
    pub note: Note,
    /// All that was found.
    pub object: Value,
}

/// What is asked of a film.
#[derive(Debug, Default)]
pub struct Asked {
    arguments: Vec<OsString>,
}

impl Asked {
    /// Adds a flag with its value, where there is one.
    pub fn with(mut self, flag: &str, value: Option<impl Into<OsString>>) -> Self {
        if let Some(value) = value {
            self.arguments.extend([flag.into(), value.into()]);
        }
        self
    }

    /// Adds a length in m and px.
    pub fn length(mut self, length: Option<(f64, f64)>) -> Self {
        if let Some((metres, pixels)) = length {
            self.arguments.extend(["--length".into(), metres.to_string().into(), pixels.to_string().into()]);
        }
        self
    }

    /// Adds what a simulation file says of the ball.
    pub fn of(self, file: &SimulationFile) -> Self {
        let number = |key: &str| file.number(key).map(|n| n.to_string());
        self.with("--gravity", number("world.gravity_m_s2"))
            .with("--expected-radius", number("ball.radius_m"))
            .with("--surface", number("surface.height_m"))
    }

    /// All that is found in the film at `path`.
    ///
    /// # Errors
    /// [`Unseen`] where no ball can be followed; [`Error::File`] where the film cannot be read or nothing reads films here.
    pub fn track(self, path: &Path) -> Result<Value> {
        let object = self.run(path)?;
        let text = |key: &str| object[key].as_str().unwrap_or_default().to_owned();
        if object.get("error").is_some() {
            return Err(Error::file(path, text("error"), text("hint")).into());
        }
        if object.get("setting").is_some() {
            let name = ["--color", "--camera-rate", "--rate", "--radius", "--length", "--topic"];
            let name = name.into_iter().find(|n| *n == text("setting")).unwrap_or("--color");
            return Err(Error::Setting { name, expected: text("expected"), found: text("found") }.into());
        }
        if object["verdict"] != "tracked" {
            let note = note(&object["reason"]);
            return Err(Unseen { path: path.into(), note, object }.into());
        }
        Ok(object)
    }

    fn run(&self, path: &Path) -> Result<Value> {
        // Refused here, so that a path is wrong in the same words everywhere.
        if !is_film(path) {
            drop(tunenet_core::observation::recording::open(path)?);
        }
        let program = program()?;
        if !program.is_file() {
            let message = format!("expected the part of tunenet that reads films beside it, found no `{PROGRAM}`");
            let hint = "`make build` makes it; it needs OpenCV. Or track with another program, and give its CSV";
            return Err(Error::file(path, message, hint).into());
        }
        let output = Command::new(&program)
            .arg("track")
            .args(&self.arguments)
            .arg("--")
            .arg(path)
            // What FFmpeg finds wrong is told in the answer, in words of ours.
            .env("OPENCV_FFMPEG_LOGLEVEL", "-8")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .output()
            .with_context(|| format!("starting {}", program.display()))?;
        serde_json::from_slice(&output.stdout).map_err(|_| {
            let message = format!("expected an answer of {PROGRAM}, found none ({})", output.status);
            Error::file(path, message, "is the film whole, and is there memory enough?").into()
        })
    }
}

/// Says that a film shows no ball to tune to, where that is the error.
///
/// # Errors
/// Every other error.
pub fn tell_unseen(error: anyhow::Error, schema: &str, json: bool) -> Result<Exit> {
    let unseen = error.downcast::<Unseen>()?;
    let (bold, reset) = (anstyle::Style::new().bold(), anstyle::Reset);
    anstream::eprintln!("{bold}REJECTED  {unseen}{reset}");
    warn(&unseen.note);
    if json {
        print_json(&json!({
            "schema": schema, "verdict": "rejected", "parameters": {}, "iterations": [], "gap": null, "rollouts": 0,
            "seconds": 0.0, "warnings": [super::tune::warning(&unseen.note)],
        }))?;
    }
    Ok(Exit::Inconclusive)
}

/// A note that the other program sent.
pub fn note(sent: &Value) -> Note {
    let text = |key: &str| sent[key].as_str().unwrap_or_default().to_owned();
    let code = CODES.into_iter().find(|code| *code == text("code")).unwrap_or("film.other");
    Note::new(code, text("text"), text("remedy"))
}

/// A column of samples.
pub fn column(object: &Value, name: &str) -> Option<Vec<f64>> {
    object["samples"][name].as_array()?.iter().map(Value::as_f64).collect()
}

/// The positions in what was found.
///
/// # Errors
/// [`Unseen`] where the ball never flies; [`Error::File`] where the film shows too little of it to say how large a pixel is.
pub fn positions(path: &Path, object: &Value) -> Result<Recording> {
    let warnings: Vec<Note> = object["warnings"].as_array().into_iter().flatten().map(note).collect();
    if let Some(note) = warnings.iter().find(|n| n.code == ROLLS) {
        return Err(Unseen { path: path.into(), note: note.clone(), object: object.clone() }.into());
    }
    let columns = ["t_s", "x_m", "z_m"].map(|name| column(object, name));
    let [Some(times), Some(x), Some(z)] = columns else {
        let message = "expected a flight that shows how large a pixel is, found none";
        return Err(Error::file(path, message, "record a whole fall, or track it with `--radius` or `--length`").into());
    };
    let places: Vec<[f64; 3]> = x.into_iter().zip(z).map(|(x, z)| [x, 0.0, z]).collect();
    let observation = Observation::positions(times, &places)?;
    Ok(Recording { observation, notes: warnings })
}
