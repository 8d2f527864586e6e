//! Other programs as judges: Python processes that read models and say what they are.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

pub mod generator;
pub mod newton_euler;

/// Whether a Python with these modules is there; prints why not.
pub fn python_with(module: &str) -> bool {
    let found = Command::new("python3").args(["-c", &format!("import {module}")]).output();
    let there = found.is_ok_and(|output| output.status.success());
    if !there {
        println!("skipped: no python3 with {module}");
    }
    there
}

/// What MuJoCo makes of each of these files.
pub fn judge(paths: &[PathBuf]) -> Vec<Value> {
    ask("judge.py", paths)
}

/// What a script of this folder makes of each of these files.
pub fn ask(script: &str, paths: &[PathBuf]) -> Vec<Value> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models/support").join(script);
    let mut python = Command::new("python3")
        .arg(script)
        // MuJoCo leaves its log where it runs.
        .current_dir(paths[0].parent().expect("a file in a folder"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("python3 starts");
    let mut list = python.stdin.take().expect("piped");
    for path in paths {
        writeln!(list, "{}", path.display()).expect("the judge reads");
    }
    drop(list);
    let output = python.wait_with_output().expect("the judge ends");
    let text = String::from_utf8(output.stdout).expect("JSON");
    let answers: Vec<Value> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    assert_eq!(answers.len(), paths.len(), "one answer a file");
    answers
}

/// A list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|n| n.as_f64().expect("a number")).collect()
}
