//! `tunenet bench`: starts the separate program `tunenet-bench`, which contains competing methods that nothing else needs.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;
use tunenet_formats::Error;

use crate::exit_status::Exit;
use crate::files::programs::{self, BENCH};

/// What the other program is asked for by `tunenet help bench`, which clap would answer from the little that is known of
/// it here.
pub fn help(arguments: &[OsString]) -> Option<Vec<OsString>> {
    let (help, rest) = arguments.split_first().filter(|(first, _)| *first == "help")?;
    let (_, about) = rest.split_first().filter(|(first, _)| *first == "bench")?;
    Some([std::slice::from_ref(help), about].concat())
}

/// Becomes the program that measures, with `flags` before its arguments, where the system can do that, so that signals and memory are its own.
pub fn run(arguments: &[impl AsRef<OsStr>], flags: impl IntoIterator<Item = &'static str>) -> Result<Exit> {
    let program = programs::sibling(BENCH)?;
    if !program.is_file() {
        let message = format!("expected the benchmark program next to tunenet, found no `{BENCH}`");
        return Err(Error::file(
            program,
            message,
            "build it in the folder of the sources: `cargo install --locked --path crates/tunenet-bench`",
        )
        .into());
    }
    let mut command = Command::new(&program);
    command.args(flags).args(arguments);
    started(command).with_context(|| format!("starting {}", program.display()))
}

/// Prints the whole answer of a bench from the pieces that shards have brought to `out`.
pub fn merged(bench: &Value, out: &Path, as_json: bool) -> Result<Exit> {
    let mut arguments: Vec<OsString> = vec!["merged".into(), bench.to_string().into(), "--out".into(), out.into()];
    arguments.extend(as_json.then(|| "--json".into()));
    run(&arguments, [])
}

#[cfg(unix)]
fn started(mut command: Command) -> std::io::Result<Exit> {
    use std::os::unix::process::CommandExt;
    Err(command.exec())
}

#[cfg(not(unix))]
fn started(mut command: Command) -> std::io::Result<Exit> {
    let status = command.status()?;
    std::process::exit(status.code().unwrap_or(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn help_on_benches_is_asked_of_their_program() {
        let asked = |line: &str| help(&line.split(' ').map(OsString::from).collect::<Vec<_>>());
        assert_eq!(asked("help bench paper"), Some(vec!["help".into(), "paper".into()]));
        assert_eq!(asked("help bench"), Some(vec!["help".into()]));
        assert_eq!([asked("help tune"), asked("bench paper"), asked("")], [None, None, None]);
    }
}
