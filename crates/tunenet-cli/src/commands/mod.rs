//! The commands: each loads, calls the libraries, renders.

pub mod bench;
pub mod diagnose;
mod each;
mod episodes;
mod generate;
mod globs;
mod init;
mod inspect;
pub(crate) mod load;
mod man;
mod merge;
mod models;
mod odd_units;
pub(crate) mod plan;
mod refusal;
mod simulate;
mod start;
mod track;
mod train;
pub(crate) mod tune;
pub(crate) mod video;

use std::path::PathBuf;

use clap::CommandFactory;

use crate::args::{Arguments, Command};
use crate::exit_status::Exit;
use crate::view::json;

/// Runs what the command line asks for.
pub fn run(arguments: Arguments) -> anyhow::Result<Exit> {
    arguments.detail.apply();
    let detail = arguments.detail;
    match arguments.command {
        Command::Tune(mut options) => {
            options.observation = recordings(options.recordings.drain(..), &options.observation)?;
            options.observation = episodes::each(&options.observation, options.reading.episodes.as_ref())?;
            let entries = tune::entries(&options)?;
            options.observation.extend(entries.into_iter().map(|entry| entry.path));
            tune::run(&options)
        }
        Command::Diagnose(mut options) => {
            options.observation = recordings(options.recordings.drain(..), &options.observation)?;
            options.observation = episodes::each(&options.observation, options.reading.episodes.as_ref())?;
            options.held_out = episodes::each(&globs::expanded(&options.held_out, "--held-out")?, None)?;
            diagnose::run(&options)
        }
        Command::Plan(options) => plan::run(&options),
        Command::Track(options) => track::run(&options),
        Command::Simulate(options) => simulate::run(&options),
        Command::Inspect(mut options) => {
            options.files = globs::expanded(&options.files, "FILE")?;
            if let Some(chosen) = &options.reading.episodes {
                options.files = episodes::each(&options.files, Some(chosen))?;
            }
            inspect::run(&options)
        }
        Command::Gen(options) => generate::run(&options),
        Command::Train(options) => train::run(&options),
        Command::Merge(options) => merge::run(&options),
        Command::Bench { arguments } => bench::run(&arguments, detail.flags()),
        Command::Init(options) => init::run(&options),
        Command::Man { command } => man::run(command.as_deref()),
        Command::Completions { shell } => {
            // Written to memory first: where it is written to a pipe that closes, clap_complete panics.
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "tunenet", &mut text);
            json::print(&text)?;
            Ok(Exit::Done)
        }
    }
}

/// All recordings of a command line: the positional ones, then those of `--observation`.
fn recordings(positional: impl Iterator<Item = PathBuf>, observation: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut all = globs::expanded(&positional.collect::<Vec<_>>(), "RECORDING")?;
    all.append(&mut globs::expanded(observation, "--observation")?);
    Ok(all)
}
