//! `tunenet-bench`, which `tunenet bench` starts: every figure that is claimed, measured here.
//!
//! A program of its own, so that the rivals and what they bring are no part of `tunenet`.

mod args;
mod counts;
mod diagnose;
mod equations_speed;
mod examples;
mod goals;
mod grow;
mod intervals;
mod joints;
mod law;
mod lazy;
mod output;
mod paper;
mod preflight;
mod process;
mod recorded;
mod regions;
mod resume;
mod rollouts;
mod runge_kutta;
mod scene;
mod search;
mod shot;
mod speed;
mod synthetic_video;
mod timed_rollouts;
mod tool;
mod tuning;
mod two_link;
mod video_speed;

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::CommandFactory;
use tunenet_cli::view::json::print;

use crate::args::{Arguments, Command, Measured};
use tunenet_cli::exit_status::Exit;

fn main() -> ExitCode {
    tunenet_cli::process(|arguments: Arguments| {
        arguments.detail.apply();
        match arguments.command {
            Command::Measure(bench) => measure(&bench),
            Command::Merged { bench, out, json } => {
                merged(serde_json::from_str(&bench).context("the benchmark of the shards")?, &out, json)
            }
            Command::Man => man(),
        }
    })
}

/// Prints the manual page.
fn man() -> Result<Exit> {
    let mut tool = Arguments::command();
    tool.build();
    let mut text = Vec::new();
    clap_mangen::Man::new(tool).render(&mut text)?;
    print(&text)?;
    Ok(Exit::Done)
}

/// The whole answer from the pieces that shards have brought to `out`.
fn merged(mut bench: Measured, out: &Path, as_json: bool) -> Result<Exit> {
    let (folder, common) = match &mut bench {
        Measured::Tuning(options) => (&mut options.out, &mut options.common),
        Measured::Diagnose(options) => (&mut options.out, &mut options.common),
        Measured::Law(options) => (&mut options.out, &mut options.common),
        Measured::Joints(options) => (&mut options.out, &mut options.common),
        Measured::Intervals(options) => (&mut options.out, &mut options.common),
        Measured::Regions(options) => (&mut options.out, &mut options.common),
        Measured::Preflight(options) => (&mut options.out, &mut options.common),
        Measured::Paper(options) => (&mut options.out, &mut options.common),
        Measured::Shot(options) => (&mut options.out, &mut options.common),
        Measured::Speed(_) | Measured::Rollouts(_) | Measured::Recorded(_) | Measured::Grow(_) => {
            anyhow::bail!("this bench has no shards")
        }
    };
    *folder = out.into();
    common.json = as_json;
    measure(&bench)
}

fn measure(bench: &Measured) -> Result<Exit> {
    match bench {
        Measured::Speed(options) => speed::run(options),
        Measured::Tuning(options) => tuning::run(options),
        Measured::Diagnose(options) => diagnose::run(options),
        Measured::Law(options) => law::run(options),
        Measured::Joints(options) => joints::run(options),
        Measured::Recorded(options) => recorded::run(options),
        Measured::Intervals(options) => intervals::run(options),
        Measured::Regions(options) => regions::run(options),
        Measured::Rollouts(options) => rollouts::run(options),
        Measured::Preflight(options) => preflight::run(options),
        Measured::Paper(options) => paper::run(options),
        Measured::Shot(options) => shot::run(options),
        Measured::Grow(options) => grow::run(options),
    }
}
