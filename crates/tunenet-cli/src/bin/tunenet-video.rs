//! The part of tunenet that sees: `tunenet` starts it as a child where a video is concerned.
//!
//! OpenCV brings some 250 shared libraries, which take a fifth of a second to load. A program of its own spares that to
//! every command that needs no video. It prints one JSON object on standard output and exits 0, or one sentence on standard
//! error and exits 1; wrong usage exits 2.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};
use tunenet_track::rehearsal::{self, Spoilt, Take};
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
    /// Print a video's facts as one JSON object
    #[command(after_help = "Example:\n  tunenet-video inspect throw.mp4")]
    Inspect {
        /// Video file
        file: PathBuf,
    },
    /// Render and track the films that standard input asks for; print the tracks as a JSON array
    #[command(hide = true)]
    Film,
}

fn main() -> ExitCode {
    let Arguments { command } = Arguments::parse();
    let done = match command {
        Command::Inspect { file } => inspect(&file),
        Command::Film => film(),
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

/// Films to make.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Order {
    seed: u64,
    radius_m: f64,
    #[serde(default)]
    spoilt: Spoilt,
    films: Vec<Take>,
}

/// The tracks of rendered films, in the order asked for.
fn film() -> Result<Value> {
    let order: Order = serde_json::from_reader(std::io::stdin().lock()).context("the order")?;
    let one = |(i, take): (usize, &Take)| -> Result<Value> {
        let seed = order.seed.wrapping_mul(0x9E37_79B9).wrapping_add(i as u64);
        match rehearsal::rehearse(take, order.radius_m, &order.spoilt, seed)? {
            Ok(track) => Ok(serde_json::to_value(track)?),
            Err(reason) => anyhow::bail!("film {}: {}", i + 1, reason.verdict()),
        }
    };
    let tracks = order.films.par_iter().enumerate().map(one).collect::<Result<Vec<_>>>()?;
    Ok(tracks.into())
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
