//! The command line of tunenet: estimates simulator parameters from recorded motion.
//!
//! Arguments are read in `args`; each of `commands` loads, calls the libraries and renders; `answers` say what was
//! found, [`view`] shows it; [`files`] knows names, hashes and what may be written over. [`exit_status`] says how a
//! command ends, [`failure`] reports errors. No mathematics here.

#![allow(
    clippy::missing_errors_doc,
    clippy::must_use_candidate,
    reason = "a library only for the programs of this workspace"
)]

mod answers;
mod args;
mod commands;
pub mod exit_status;
pub mod failure;
pub mod files;
pub mod findings;
pub mod shard;
pub mod view;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser;

pub use args::{Common, Detail, Sharing, jobs, pool};
use exit_status::Exit;

/// Runs the command that this process was started with.
pub fn main() -> ExitCode {
    let given: Vec<OsString> = std::env::args_os().skip(1).collect();
    match commands::bench::help(&given) {
        Some(asked) => ended(commands::bench::run(&asked, [])),
        None => process(commands::run),
    }
}

/// Runs a program whose arguments are `A`: says what is wrong with them, or what went wrong afterwards.
pub fn process<A: Parser>(run: impl FnOnce(A) -> anyhow::Result<Exit>) -> ExitCode {
    match A::try_parse() {
        Ok(arguments) => ended(args::check_threads().and_then(|()| run(arguments))),
        Err(error) => {
            // Help and version are answers, everything else is a usage error; clap knows which goes where.
            let _ = error.print();
            if error.use_stderr() { Exit::Usage } else { Exit::Done }.into()
        }
    }
}

fn ended(result: anyhow::Result<Exit>) -> ExitCode {
    result.unwrap_or_else(|error| failure::render(&error)).into()
}
