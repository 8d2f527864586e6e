//! Blind sets of `tunenet bench diagnose`: one share of its quick run, drawn from a seed that no result is made from.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Map, Value};

use crate::pinned;

/// The entries of a folder by their names, sorted.
fn entries(folder: &Path) -> BTreeMap<String, PathBuf> {
    let found = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry"));
    found.map(|entry| (entry.file_name().to_string_lossy().into_owned(), entry.path())).collect()
}

/// Runs a share, and gives the trials of each of its pieces.
fn trials(words: &str) -> Vec<(String, Value)> {
    let here = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_tunenet-bench"));
    command.current_dir(here.path()).args(["diagnose", "--quick", "--seed", "7", "--out", "out"]);
    let output = command.args(words.split(' ')).output().expect("the binary starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let share = entries(here.path()).into_values().next().expect("the folder of a share");
    entries(&share.join("cells")).iter().flat_map(|(name, path)| piece(name, path)).collect()
}

fn piece(name: &str, path: &Path) -> Vec<(String, Value)> {
    let text = std::fs::read(path).expect("a piece");
    let mut kept: Value = serde_json::from_slice(&text).expect("JSON");
    timeless(&mut kept);
    let trials = kept["value"].as_array().expect("the trials of a piece");
    trials
        .iter()
        .enumerate()
        .map(|(i, trial)| (format!("{} {i}", name.trim_end_matches(".json")), trial.clone()))
        .collect()
}

/// Leaves out how long it took.
fn timeless(value: &mut Value) {
    match value {
        Value::Object(map) => {
            let kept = std::mem::take(map).into_iter().filter(|(key, value)| key != "seconds" && !value.is_null());
            *map = kept.collect::<Map<_, _>>();
            map.values_mut().for_each(timeless);
        }
        Value::Array(all) => all.iter_mut().for_each(timeless),
        _ => {}
    }
}

#[test]
fn regress_blind_sets_of_a_ball() {
    pinned::check("blind-ball", &trials("--shard 3/10"));
}

#[test]
fn regress_blind_sets_of_an_arm() {
    pinned::check("blind-arm", &trials("--arm --shard 0/4"));
}
