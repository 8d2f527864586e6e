//! The commands: each loads, calls the libraries, renders.

mod bench;
mod destination;
pub mod diagnose;
mod each;
pub(crate) mod film;
mod gen_arm;
mod gen_pairs;
mod gen_process;
mod globs;
mod init;
mod inspect;
pub(crate) mod load;
mod man;
mod merge;
mod model_cache;
pub(crate) mod plan;
mod refusal;
mod shard;
mod simulate;
mod simulate_arm;
mod simulate_process;
mod start;
mod track;
mod train;
pub(crate) mod tune;

use clap::CommandFactory;
use serde_json::Value;

use crate::cli::{Arguments, Command};
use crate::failure::Exit;

/// Runs what the command line asks for.
pub fn run(arguments: Arguments) -> anyhow::Result<Exit> {
    match arguments.command {
        Command::Tune(mut options) => {
            options.observation = globs::expanded(&options.observation, "--observation")?;
            tune::run(&options)
        }
        Command::Diagnose(mut options) => {
            options.observation = globs::expanded(&options.observation, "--observation")?;
            options.held_out = globs::expanded(&options.held_out, "--held-out")?;
            diagnose::run(&options)
        }
        Command::Plan(options) => plan::run(&options),
        Command::Track(options) => track::run(&options),
        Command::Simulate(options) => simulate::run(&options),
        Command::Inspect(mut options) => {
            options.files = globs::expanded(&options.files, "FILE")?;
            inspect::run(&options)
        }
        Command::Gen(options) => gen_pairs::run(&options),
        Command::Train(options) => train::run(&options),
        Command::Merge(options) => merge::run(&options),
        Command::Bench(options) => bench::run(&options),
        Command::Init(options) => init::run(&options),
        Command::Man { command } => man::run(command.as_deref()),
        Command::Completions { shell } => {
            clap_complete::generate(shell, &mut Arguments::command(), "tunenet", &mut std::io::stdout());
            Ok(Exit::Done)
        }
    }
}

/// Prints the one JSON object of a command. A reader that has gone away is no error.
fn print_json(value: &Value) {
    use std::io::Write;
    let _ = writeln!(std::io::stdout(), "{value:#}");
}
