//! The part of tunenet that sees: `tunenet` starts it as a child where a video is concerned.
//!
//! OpenCV brings some 250 shared libraries, which take a fifth of a second to load. A program of its own spares that to
//! every command that needs no video. It prints one JSON object on standard output and exits 0, or one sentence on standard
//! error and exits 1; wrong usage exits 2. What `track` cannot do is told on standard output as well, for the parent to say.

mod rehearse;
mod speed;
mod track;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};
use serde_json::{Value, json};
use tunenet_track::video;

/// Reads videos for tunenet
#[derive(Debug, Parser)]
#[command(name = "tunenet-video", version, about, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Print the track of the ball in a film or a log as one JSON object
    #[command(after_help = "Example:\n  tunenet-video track drop.mp4")]
    Track(track::Options),
    /// Print a video's facts as one JSON object
    #[command(after_help = "Example:\n  tunenet-video inspect throw.mp4")]
    Inspect {
        /// Video file
        file: PathBuf,
    },
    /// Render and track the films that standard input asks for; print the tracks as a JSON array
    #[command(hide = true)]
    Film,
    /// Measure how fast pictures are made, decoded and tracked
    #[command(hide = true)]
    Speed {
        /// Folder for the films that this takes
        folder: PathBuf,
    },
    /// Write a film of 4K frames
    #[command(hide = true)]
    LongFilm {
        /// Where to
        path: PathBuf,
        /// How many
        frames: usize,
    },
}

fn main() -> ExitCode {
    let Arguments { command } = Arguments::parse();
    let done = match command {
        Command::Inspect { file } => inspect(&file),
        Command::Film => rehearse::run(),
        Command::Speed { folder } => speed::run(&folder),
        Command::LongFilm { path, frames } => speed::long_film(&path, frames),
        Command::Track(options) => track::run(&options),
    };
    match done.and_then(|object| print(&object)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            anstream::eprintln!("{error}");
            if let Some(hint) = error.downcast_ref::<tunenet_core::Error>().and_then(tunenet_core::Error::hint) {
                anstream::eprintln!("{hint}");
            }
            ExitCode::FAILURE
        }
    }
}

/// The facts of a video; `kind` tells the parent what it was given.
fn inspect(path: &Path) -> Result<Value> {
    let clip = video::open(path)?;
    Ok(json!({
        "schema": 1,
        "kind": "video",
        "file": clip.path.to_string_lossy(),
        "width_px": clip.width_px,
        "height_px": clip.height_px,
        "frames_per_s": clip.frames_per_s,
        "frames": clip.frames,
        "duration_s": clip.frames as f64 / clip.frames_per_s,
    }))
}

fn print(object: &Value) -> Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{object}").and_then(|()| out.flush()).context("writing to standard output failed")
}
