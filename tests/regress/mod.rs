//! What `tune`, `diagnose` and `inspect` answer is pinned: verdicts, names, values and codes, in the files beside this one.
//!
//! A change that is not meant to change an answer changes none of them. One that is runs with `TUNENET_REGRESS_WRITE=1`, which
//! writes them anew, and the difference is read before it is committed.

mod cases;
mod digest;
mod measured;
mod peers;
mod pinned;

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use crate::common::Folder;
use crate::common::recorded::name;
use serde_json::{Value, json};

/// Words of a command line, then paths.
fn line(words: &str, paths: &[PathBuf]) -> Vec<OsString> {
    words.split_whitespace().map(OsString::from).chain(paths.iter().map(|p| p.clone().into_os_string())).collect()
}

/// Runs a command with `--json`: its exit status and answer, which is null where it refuses.
fn ask(here: &Folder, arguments: &[impl AsRef<OsStr>]) -> (Option<i32>, Value) {
    let output = here.command().args(arguments).arg("--json").output().expect("the binary starts");
    (output.status.code(), serde_json::from_slice(&output.stdout).unwrap_or_default())
}

/// The digest of one answer.
fn answer(here: &Folder, arguments: &[impl AsRef<OsStr>]) -> Value {
    match ask(here, arguments) {
        (exit, Value::Null) => json!({ "exit": exit }),
        (_, found) => digest::of(&found),
    }
}

/// The digests of `tune --each` over files, by their names.
fn each(here: &Folder, words: &str, paths: &[PathBuf]) -> Vec<(String, Value)> {
    of_each(&ask(here, &line(words, paths)).1, paths)
}

/// The digests of such an answer.
fn of_each(found: &Value, paths: &[PathBuf]) -> Vec<(String, Value)> {
    let answers = found["observations"].as_array().expect("an answer for each");
    assert_eq!(answers.len(), paths.len());
    paths.iter().zip(answers).map(|(path, one)| (name(path), digest::of(one))).collect()
}
