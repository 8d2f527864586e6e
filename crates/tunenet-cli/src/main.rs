//! `tunenet`: makes a simulator behave like a measured real thing.
//!
//! Arguments are read in [`cli`]; each command in [`commands`] loads, calls the libraries and renders; what goes wrong is
//! told by [`failure`], pages are drawn by [`report`]. No mathematics here.

mod cli;
mod commands;
mod failure;
mod report;
mod terminal;

use clap::Parser;

fn main() -> std::process::ExitCode {
    let arguments = match cli::Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are answers, everything else is a usage error; clap knows which goes where.
            let _ = error.print();
            return std::process::ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    match commands::run(arguments) {
        Ok(exit) => exit.into(),
        Err(error) => failure::tell(&error).into(),
    }
}
