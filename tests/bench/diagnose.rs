//! `tunenet bench diagnose` as a process: it runs, writes its files, and goes on where it stopped.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

fn bench(folder: &Path) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tunenet-bench"));
    command.args(["diagnose", "--quick", "--only", "cost", "--json", "--out"]).arg(folder);
    let output = command.output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn a_quick_row_runs_and_resumes() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = bench(folder.path());
    for file in ["diagnose.md", "goals.md", "diagnose.csv", "confusion.csv", "diagnose.json"] {
        assert!(folder.path().join(file).is_file(), "{file} is missing");
    }
    assert_eq!(first["schema"], "tunenet.bench.diagnose/1");
    let row = &first["rows"][0];
    assert_eq!(row["row"], "cost");
    assert!(row["goals"].as_array().is_some_and(|goals| goals.len() == 2), "{row:#}");
    // Seconds are kept with their piece, so that nothing at all is measured again.
    assert_eq!(bench(folder.path()), first);
}
