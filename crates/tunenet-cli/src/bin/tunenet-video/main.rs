//! The part of tunenet that sees: `tunenet` starts it as a child where a video is concerned.
//!
//! OpenCV brings some 250 shared libraries, which take a fifth of a second to load. A program of its own spares that to
//! every command that needs no video. It prints one JSON object on standard output and exits 0, or one sentence on standard
//! error and exits 1; wrong usage exits 2. What `track` cannot do is reported on standard output as well, for the parent to say.

mod speed;
mod synthetic;
mod track;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};
use serde::Serialize;

/// Reads videos for tunenet
#[derive(Debug, Parser)]
#[command(name = "tunenet-video", version, about, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Print the track of the ball in a video or a log as one JSON object
    #[command(after_help = "Example:\n  tunenet-video track drop.mp4")]
    Track(track::Options),
    /// Render and track the videos that standard input asks for; print the tracks as a JSON array
    #[command(name = "film", hide = true)]
    Synthetic,
    /// Measure how fast pictures are made, decoded and tracked
    #[command(hide = true)]
    Speed {
        /// Folder for the videos that are made
        folder: PathBuf,
    },
    /// Write a video of 4K frames
    #[command(name = "long-film", hide = true)]
    LongVideo {
        /// Where to
        path: PathBuf,
        /// How many
        frames: usize,
    },
}

fn main() -> ExitCode {
    let Arguments { command } = Arguments::parse();
    let done = match command {
        Command::Synthetic => synthetic::run().and_then(|tracks| print(&tracks)),
        Command::Speed { folder } => speed::run(&folder).and_then(|speed| print(&speed)),
        Command::LongVideo { path, frames } => speed::long_video(&path, frames),
        Command::Track(options) => track::run(&options).and_then(|answer| print(&answer)),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(anstream::stderr(), "{error}");
            if let Some(hint) = error.downcast_ref::<tunenet_formats::Error>().and_then(tunenet_formats::Error::hint) {
                let _ = writeln!(anstream::stderr(), "{hint}");
            }
            ExitCode::FAILURE
        }
    }
}

fn print(answer: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string(answer).context("the answer as JSON")?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{text}").and_then(|()| out.flush()).context("writing to standard output failed")
}
