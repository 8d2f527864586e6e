//! Recordings of real things, where `TUNENET_MEASURED` names a folder that holds them; skipped without it.

mod common;

use std::path::{Path, PathBuf};

use common::{Folder, SCENE};
use serde_json::Value;

/// The files in a folder of the measured recordings whose names start and end so, sorted; `None` where there are none.
fn measured(folder: &str, start: &str, end: &str) -> Option<Vec<PathBuf>> {
    let Some(root) = std::env::var_os("TUNENET_MEASURED") else {
        eprintln!("skipped: TUNENET_MEASURED names no folder with measured recordings");
        return None;
    };
    let entries = std::fs::read_dir(Path::new(&root).join(folder)).expect("a folder of measured recordings");
    let mut files: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    let name = |path: &Path| path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    files.retain(|path| name(path).starts_with(start) && name(path).ends_with(end));
    files.sort();
    assert!(!files.is_empty(), "{folder}/{start}…{end}");
    Some(files)
}

/// `tune --each` over these files.
fn each(files: &[PathBuf]) -> Vec<Value> {
    let folder = Folder::with_scene();
    let mut command = folder.command();
    command.args(["tune", "--sim", "scene.toml", "--each", "--json", "--observation"]).args(files);
    let ran = common::Ran::from(command.output().unwrap());
    assert!(matches!(ran.code, Some(0 | 1 | 3)), "{:?}\n{}", ran.code, ran.stderr);
    let answers = ran.json()["observations"].as_array().unwrap().clone();
    assert_eq!(answers.len(), files.len());
    answers
}

fn verdict(answer: &Value) -> &str {
    answer["verdict"].as_str().unwrap_or("refused")
}

/// The median restitution of the usable answers, and how many there are.
fn median(answers: &[Value]) -> (f64, usize) {
    let usable = answers.iter().filter(|a| matches!(verdict(a), "tuned" | "poor_fit"));
    let mut values: Vec<f64> = usable.map(|a| a["parameters"]["restitution"]["value"].as_f64().unwrap()).collect();
    values.sort_by(f64::total_cmp);
    (values.get(values.len() / 2).copied().unwrap_or(f64::NAN), values.len())
}

fn tally(answers: &[Value]) -> String {
    let count = |word: &str| format!("{word} {}", answers.iter().filter(|a| verdict(a) == word).count());
    ["tuned", "poor_fit", "not_identifiable", "rejected", "refused"].map(count).join(", ")
}

/// A standard ball on a standard table: restitution .90 to .97.
#[test]
fn table_tennis_flights() {
    let Some(files) = measured("tt-flights", "", ".csv") else { return };
    let answers = each(&files);
    let (middle, usable) = median(&answers);
    eprintln!("flights: median {middle:.4} of {usable} usable; {}", tally(&answers));
    assert!((0.90..=0.97).contains(&middle), "{middle} of {usable}; {}", tally(&answers));
    assert!(usable * 2 > files.len(), "{}", tally(&answers));
    for answer in &answers {
        assert_ne!(verdict(answer), "refused", "{answer}");
        // Whoever gets no value gets a reason.
        let reasons = answer["warnings"].as_array().unwrap();
        assert!(matches!(verdict(answer), "tuned" | "poor_fit") || !reasons.is_empty(), "{answer}");
    }
}

/// From the ratio of successive intervals of the same recordings, by hand.
#[test]
fn heard_bounces() {
    for (start, expected, tolerance) in [
        ("pingpong_008", 0.947, 0.007),
        ("pingpong_015", 0.940, 0.007),
        ("pingpong_030", 0.926, 0.007),
        ("blue", 0.88, 0.015),
    ] {
        let Some(files) = measured("bounce-acoustic", start, ".csv") else { return };
        let answers = each(&files);
        let (middle, usable) = median(&answers);
        eprintln!("{start}: median {middle:.4} of {usable}; {}", tally(&answers));
        assert!((middle - expected).abs() <= tolerance, "{start}: {middle} of {usable}; {}", tally(&answers));
    }
}

/// A light ball loses more at speed, which a constant restitution cannot say: from 30 cm it shows.
#[test]
fn a_light_ball_from_30_cm_is_a_poor_fit() {
    let Some(files) = measured("bounce-acoustic", "pingpong_030", ".csv") else { return };
    let answers = each(&files);
    let poor = answers.iter().filter(|a| verdict(a) == "poor_fit").count();
    eprintln!("30 cm: {}", tally(&answers));
    assert!(poor * 2 > answers.len(), "{}", tally(&answers));
}

#[test]
fn logs_of_a_robot() {
    let Some(files) = measured("mcap-rosbag2", "", ".mcap") else { return };
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    for file in &files {
        let ran = common::Ran::from(folder.command().arg("inspect").arg(file).arg("--json").output().unwrap());
        assert!(matches!(ran.code, Some(0 | 1 | 3)), "{}: {:?}", file.display(), ran.code);
        assert!(!ran.stderr.is_empty());
        if ran.code == Some(1) {
            assert!(ran.stdout.is_empty() && ran.stderr.contains("help: "), "{}", ran.stderr);
        } else {
            assert!(ran.json()["topics"].is_array());
        }
        if file.ends_with("wrong_rmw_test_0.mcap") {
            let tune = folder.command().args(["tune", "--sim", "scene.toml", "--observation"]).arg(file).output();
            let refused = common::Ran::from(tune.unwrap()).ends(1);
            assert!(refused.stderr.contains("encoding"), "{}", refused.stderr);
            eprintln!("{}", refused.stderr);
        }
    }
}

#[test]
fn broken_lines_of_an_arm_are_listed() {
    let Some(files) = measured("ur10e-payload", "ur-20_02_19_15harm50secLoad", ".csv") else { return };
    let folder = Folder::new();
    // Time, then six joints' positions, velocities and currents; no header.
    let joints =
        ["q{}_rad", "dq{}_rad_s", "i{}_a"].map(|name| (1..=6).map(move |j| name.replace("{}", &j.to_string())));
    let names = std::iter::once("t_s".to_owned()).chain(joints.into_iter().flatten());
    let columns: Vec<String> = names.enumerate().map(|(i, name)| format!("{name}={}", i + 1)).collect();
    let mut command = folder.command();
    command.arg("inspect").arg(&files[0]).args(["--json", "--columns", &columns.join(",")]);
    let ran = common::Ran::from(command.output().unwrap()).ends(3);
    let json = ran.json();
    eprintln!("{} broken lines: {}", json["broken_count"], json["broken_lines"]);
    assert!(json["broken_count"].as_u64().is_some_and(|count| count > 0));
    assert!(json["broken_lines"].as_array().unwrap().iter().all(|b| b["line"].is_u64() && b["message"].is_string()));
}
