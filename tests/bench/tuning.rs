//! `tunenet bench tuning` as a process: it runs, writes its three files, and goes on where it stopped.

use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

fn bench(folder: &Path) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tunenet-bench"));
    command.args(["tuning", "--quick", "--only", "easy-0", "--targets", "20", "--json", "--out"]).arg(folder);
    let output = command.output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("JSON is Unicode")
}

fn written(path: &Path) -> SystemTime {
    path.metadata().expect("a cell").modified().expect("a time")
}

#[test]
fn a_quick_row_runs_and_resumes() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = bench(folder.path());
    for file in ["tuning.md", "tuning.csv", "tuning.json"] {
        assert!(folder.path().join(file).is_file(), "{file} is missing");
    }
    let results: serde_json::Value = serde_json::from_str(&first).expect("JSON");
    let row = &results["rows"][0];
    assert_eq!(
        (&results["schema"], &row["row"], &row["targets"]),
        (&"tunenet.bench.tuning/1".into(), &"easy-0".into(), &20.into())
    );
    let methods: Vec<&str> =
        row["methods"].as_array().expect("a list").iter().filter_map(|m| m["name"].as_str()).collect();
    assert_eq!(methods, ["default", "paper", "apex", "nearest", "brent"]);
    // Even a quarter of the training finds a noise-free target in five rollouts.
    assert!(row["methods"][0]["mean"][3].as_f64().expect("a number") < 1e-4);

    let cells = folder.path().join("cells");
    let (kept, lost) = (cells.join("training-default-0.json"), cells.join("easy-0-brent.json"));
    let before = written(&kept);
    // What a clock decides is known by its name: the rest has the same bytes in every run.
    let text = std::fs::read_to_string(&kept).expect("a cell");
    let training: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let keys: Vec<&String> = training["value"].as_object().expect("an object").keys().collect();
    assert!(!keys.is_empty() && keys.iter().all(|key| key.ends_with("seconds")), "{keys:?}");
    std::fs::remove_file(&lost).expect("a cell");
    assert_eq!(bench(folder.path()), first);
    assert_eq!(written(&kept), before);
    assert!(lost.is_file());
}
