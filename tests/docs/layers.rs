//! The layers of the command line: commands use answers and views, never the other way, and each of their files is short.

use std::path::{Path, PathBuf};

/// Longest file of a command.
const MOST_LINES: usize = 120;

fn files(layer: &str) -> Vec<(PathBuf, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(layer);
    let (mut left, mut found) = (vec![folder], Vec::new());
    while let Some(folder) = left.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                left.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                found.push((path.clone(), std::fs::read_to_string(path).unwrap()));
            }
        }
    }
    assert!(!found.is_empty(), "{layer}");
    found
}

#[test]
fn no_view_answer_file_or_argument_imports_a_command() {
    for layer in ["view", "answers", "files", "args", "shard"] {
        for (path, text) in files(layer) {
            assert!(!text.contains("crate::commands"), "{}", path.display());
        }
    }
    for layer in ["view", "answers", "files"] {
        for (path, text) in files(layer) {
            assert!(!text.contains("crate::args"), "{}", path.display());
        }
    }
}

#[test]
fn files_of_commands_are_short() {
    for (path, text) in files("commands") {
        let lines = text.lines().count();
        assert!(lines <= MOST_LINES, "{}: {lines} lines", path.display());
    }
}

/// The folders of a diagnosis in the order in which values flow through them.
const PIPELINE: [&str; 6] = ["evidence", "hypothesis", "judge", "discrepancy", "strategy", "answer"];

#[test]
fn values_of_a_diagnosis_flow_one_way() {
    let diagnose = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tunenet-core/src/diagnose");
    for (position, folder) in PIPELINE.iter().enumerate() {
        let paths: Vec<PathBuf> =
            std::fs::read_dir(diagnose.join(folder)).unwrap().map(|entry| entry.unwrap().path()).collect();
        assert!(paths.len() <= 12, "{folder}: {} files", paths.len());
        for path in paths {
            let text = std::fs::read_to_string(&path).unwrap();
            // Unit tests may use what comes later to judge by.
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            for later in &PIPELINE[position + 1..] {
                assert!(!code.contains(&format!("diagnose::{later}::")), "{} imports {later}", path.display());
            }
        }
    }
}
