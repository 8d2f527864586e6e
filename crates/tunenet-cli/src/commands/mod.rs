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

use std::io::{ErrorKind, Write};

use clap::CommandFactory;
use serde_json::Value;
use tunenet_core::Error;

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
            // Written to memory first: where it is written to a pipe that closes, clap_complete panics.
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "tunenet", &mut text);
            print(&text)?;
            Ok(Exit::Done)
        }
    }
}

/// Prints the one JSON object of a command.
///
/// # Errors
/// As [`print()`].
fn print_json(value: &Value) -> tunenet_core::Result<()> {
    print(format!("{value:#}\n").as_bytes())
}

/// Writes an answer to standard output. A reader that has gone away is no error.
///
/// # Errors
/// [`Error::Io`] where it cannot be written: half an answer must not pass for a whole one.
fn print(text: &[u8]) -> tunenet_core::Result<()> {
    write_to(&mut std::io::stdout().lock(), text)
}

fn write_to(out: &mut dyn Write, text: &[u8]) -> tunenet_core::Result<()> {
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Io { path: "standard output".into(), action: "writing", source })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Broken(ErrorKind);

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(self.0.into())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_left_is_no_error_and_a_full_disk_is_one() {
        assert!(write_to(&mut Broken(ErrorKind::BrokenPipe), b"{}").is_ok());
        let full = write_to(&mut Broken(ErrorKind::StorageFull), b"{}").unwrap_err().to_string();
        assert!(full.starts_with("standard output: writing failed: "), "{full}");
    }
}
