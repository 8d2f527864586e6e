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
use std::path::{Path, PathBuf};

use crate::common::Folder;
use serde_json::{Value, json};

/// A folder that an environment variable names, and that is there.
fn folder(variable: &str, inside: &str) -> Option<PathBuf> {
    let path = std::env::var_os(variable).map(|root| Path::new(&root).join(inside)).filter(|path| path.is_dir());
    if path.is_none() {
        eprintln!("skipped: {variable} names no folder with {inside}");
    }
    path
}

/// The files of a folder whose names start and end so, sorted.
fn files(folder: &Path, start: &str, end: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut files: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    files.retain(|path| name(path).starts_with(start) && name(path).ends_with(end));
    files.sort();
    files
}

fn name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

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
    let (_, found) = ask(here, &line(words, paths));
    let answers = found["observations"].as_array().expect("an answer for each");
    assert_eq!(answers.len(), paths.len());
    paths.iter().zip(answers).map(|(path, one)| (name(path), digest::of(one))).collect()
}

/// A ball's scene without a word about its start.
fn ball(radius_m: f64, mass_kg: Option<f64>) -> String {
    let mass = mass_kg.map(|m| format!("ball.mass_kg = {m}\n")).unwrap_or_default();
    format!(
        "kind = \"ball\"\nball.radius_m = {radius_m}\n{mass}\n[parameters.restitution]\nvalue = 0.8\nmin = 0.0\nmax = 1.0\n"
    )
}
