//! Videos: what `tunenet-video`, the only program that knows OpenCV, says of them.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result};
use tunenet_core::Origin;
use tunenet_core::observation::Note;
use tunenet_formats::Error;
use tunenet_sim::SimulationFile;
use tunenet_video_protocol::TrackAnswer;
use tunenet_video_protocol::track::{Tracked, Untracked};

use crate::files::programs::{self, VIDEO};
use crate::files::videos::is_video;

/// Largest picture that is decoded, in pixels: 8K video has half as many. Each takes some ten bytes of memory.
const MOST_PIXELS: u32 = 1 << 26;

/// A video in which no ball could be followed: an answer, and no fault of the file.
#[derive(Debug, thiserror::Error)]
#[error("{}: {}", path.display(), note.text)]
pub struct TrackFailure {
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
    /// [`TrackFailure`] where no ball can be followed; [`Error::File`] where the video cannot be read or nothing reads videos here.
    pub fn track(self, path: &Path) -> Result<Tracked> {
        match self.run(path)? {
            TrackAnswer::Tracked(tracked) => Ok(*tracked),
            TrackAnswer::FileRefused { message, hint } => Err(Error::file(path, message, hint).into()),
            TrackAnswer::FlagRefused { flag, expected, found } => {
                Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: flag.word(), expected, found }.into())
            }
            TrackAnswer::Untracked(untracked) => {
                Err(TrackFailure { path: path.into(), note: untracked.finding.note(), untracked: Some(untracked) }
                    .into())
            }
        }
    }

    fn run(&self, path: &Path) -> Result<TrackAnswer> {
        // Refused here, so that a path is wrong in the same words everywhere.
        if !is_video(path) {
            drop(tunenet_formats::open(path)?);
        }
        if path.is_file() {
            tunenet_formats::refuse_git_lfs_pointer(path)?;
        }
        let program = programs::sibling(VIDEO)?;
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
            // What FFmpeg finds wrong is reported in the answer, in our own words.
            .env("OPENCV_FFMPEG_LOGLEVEL", "-8")
            .env("OPENCV_IO_MAX_IMAGE_PIXELS", MOST_PIXELS.to_string())
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
