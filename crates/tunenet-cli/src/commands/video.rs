//! Videos: what `tunenet-video`, which alone knows OpenCV, says of them.

use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result};
use serde_json::json;
use tunenet_core::observation::{Note, Observation};
use tunenet_core::{Error, Origin};
use tunenet_formats::Recording;
use tunenet_sim::SimulationFile;
use tunenet_video_protocol::track::{Metres, Tracked, Untracked};
use tunenet_video_protocol::{TrackAnswer, VideoFinding};

use crate::failure::Exit;
use crate::files::names;
use crate::files::programs::{self, VIDEO};
use crate::view::answer::Printout;

/// What videos' names end in.
const ENDINGS: [&str; 9] = ["mp4", "m4v", "mov", "avi", "mkv", "webm", "mpg", "mpeg", "3gp"];
/// What the names of other recordings end in.
const TABLES: [&str; 5] = ["csv", "tsv", "txt", "mcap", "json"];
/// How videos begin: where, and with which bytes.
const MARKS: [(usize, &[u8]); 4] = [(4, b"ftyp"), (8, b"AVI "), (0, b"\x1a\x45\xdf\xa3"), (0, b"\x00\x00\x01\xba")];

/// Whether a file is a video, by its name or, where that says nothing else, by its first bytes; so is a folder of pictures.
pub fn is_video(path: &Path) -> bool {
    if path.is_dir() {
        return names::pictures(path).is_ok_and(|pictures| !pictures.is_empty());
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

/// A video in which no ball could be followed: an answer, and no fault of the file.
#[derive(Debug, thiserror::Error)]
#[error("{}: {}", path.display(), note.text)]
pub struct Unseen {
    /// The video.
    pub path: PathBuf,
    /// Why, and what to try.
    pub note: Note,
    /// What was found, where no ball could be followed; one that rolls can be.
    pub untracked: Option<Untracked>,
}

/// What is asked of a video.
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
        let Ok(scene) = file.ball() else { return self };
        self.with("--gravity", Some(scene.world.gravity_m_s2.to_string()))
            .with("--expected-radius", Some(scene.ball.radius_m.to_string()))
            .with("--surface", scene.surface.height_m.map(|height| height.to_string()))
    }

    /// All that is found in the video at `path`.
    ///
    /// # Errors
    /// [`Unseen`] where no ball can be followed; [`Error::File`] where the video cannot be read or nothing reads videos here.
    pub fn track(self, path: &Path) -> Result<Tracked> {
        match self.run(path)? {
            TrackAnswer::Tracked(tracked) => Ok(*tracked),
            TrackAnswer::FileRefused { message, hint } => Err(Error::file(path, message, hint).into()),
            TrackAnswer::FlagRefused { flag, expected, found } => {
                Err(Error::Setting { origin: Origin::Flag, name: flag.word(), expected, found }.into())
            }
            TrackAnswer::Untracked(untracked) => {
                Err(Unseen { path: path.into(), note: untracked.finding.note(), untracked: Some(untracked) }.into())
            }
        }
    }

    fn run(&self, path: &Path) -> Result<TrackAnswer> {
        // Refused here, so that a path is wrong in the same words everywhere.
        if !is_video(path) {
            drop(tunenet_formats::open(path)?);
        }
        let program = programs::beside(VIDEO)?;
        if !program.is_file() {
            let message = format!("expected `{VIDEO}` in the folder of tunenet, found none");
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
            let message = format!("expected an answer of {VIDEO}, found none ({})", output.status);
            Error::file(path, message, "is the video complete, and is there enough memory?").into()
        })
    }
}

/// Says that a video shows no ball to tune to, where that is the error.
///
/// # Errors
/// Every other error.
pub fn render_unseen(error: anyhow::Error, schema: &str, json: bool) -> Result<Exit> {
    let unseen = error.downcast::<Unseen>()?;
    let mut shown = Printout::default();
    shown.verdict(&format!("REJECTED  {unseen}"));
    shown.warn(&unseen.note);
    shown.show(json, || {
        json!({
            "schema": schema, "verdict": "rejected", "parameters": {}, "iterations": [], "gap": null, "rollouts": 0,
            "seconds": 0.0, "warnings": [crate::view::json::warning(&unseen.note)],
        })
    })?;
    Ok(Exit::Inconclusive)
}

/// The positions in what was found.
///
/// # Errors
/// [`Unseen`] where the ball never flies; [`Error::File`] where the video shows too little of it to say how large a pixel is.
pub fn positions(path: &Path, Tracked { facts, samples, .. }: &Tracked) -> Result<Recording> {
    if let Some(finding) = facts.rolls() {
        return Err(Unseen { path: path.into(), note: finding.note(), untracked: None }.into());
    }
    let Some(Metres { x_m, z_m }) = &samples.metres else {
        let message = "expected a flight that shows how large a pixel is, found none";
        return Err(Error::file(path, message, "record a whole fall, or track it with `--radius` or `--length`").into());
    };
    let places: Vec<[f64; 3]> = x_m.iter().zip(z_m).map(|(x, z)| [*x, 0.0, *z]).collect();
    let observation = Observation::positions(samples.t_s.clone(), &places)?;
    Ok(Recording { observation, notes: facts.warnings.iter().map(VideoFinding::note).collect() })
}
