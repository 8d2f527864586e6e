//! What is checked before tuning, as a process shows it.

mod common;

use common::{Drop, Folder, table};
use serde_json::Value;

fn state<'a>(checks: &'a Value, code: &str) -> &'a str {
    let all = checks.as_array().unwrap();
    all.iter().find(|c| c["code"] == code).map_or("absent", |c| c["state"].as_str().unwrap())
}

/// A drop in millimetres under the name of metres.
fn in_millimetres() -> String {
    let frames: Vec<_> = Drop::default().frames().iter().map(|(t, p)| (*t, p.map(|v| 1000.0 * v))).collect();
    table(&frames)
}

#[test]
fn a_clean_drop_is_not_warned_of() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    let ran = folder.run("tune --sim scene.toml --observation drop.csv --json").ends(0);
    let json = ran.json();
    assert_eq!(json["warnings"], serde_json::json!([]));
    assert_eq!(json["forced"], false);
    let checks = json["preflight"][0].as_array().unwrap();
    assert!(
        checks.len() > 15 && checks.iter().all(|c| c["state"] == "passed" || c["state"] == "not_run"),
        "{checks:?}"
    );
    assert!(ran.stderr.contains("checked  "), "{}", ran.stderr);
}

#[test]
fn a_wrong_unit_is_rejected_and_forced_loudly() {
    let folder = Folder::with_scene();
    folder.write("mm.csv", in_millimetres());
    let ran = folder.run("tune --sim scene.toml --observation mm.csv --json --out tuned.toml").ends(3);
    let json = ran.json();
    assert_eq!((json["verdict"].as_str(), json["forced"].as_bool()), (Some("rejected"), Some(false)));
    assert_eq!(state(&json["preflight"][0], "units.wrong"), "failed");
    assert!(ran.stderr.contains("millimetres") && ran.stderr.contains("z_mm"), "{}", ran.stderr);
    assert!(!folder.path("tuned.toml").exists());
    let ran = folder.run("tune --sim scene.toml --observation mm.csv --force --json");
    let json = ran.json();
    assert_eq!(json["forced"], true);
    assert_ne!(json["verdict"], "rejected");
    assert!(json["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "preflight.forced"));
    assert!(ran.stderr.contains("FORCED"), "{}", ran.stderr);
    folder.run("inspect mm.csv").ends(3);
}

#[test]
fn what_the_file_says_is_compared_with_what_is_seen() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    for (wrong, code) in [("surface.height_m=0.1", "surface.disagrees"), ("release.height_m=1.2", "release.disagrees")]
    {
        let json = folder.run(&format!("tune --sim scene.toml --set {wrong} --observation drop.csv --json")).json();
        assert_eq!(state(&json["preflight"][0], code), "noticed", "{wrong}");
        let right = if code.starts_with('s') { "surface.height_m=0" } else { "release.height_m=1" };
        let json = folder.run(&format!("tune --sim scene.toml --set {right} --observation drop.csv --json")).json();
        assert_eq!(state(&json["preflight"][0], code), "passed", "{right}");
    }
}

#[test]
fn several_files_are_told_apart_by_name() {
    let folder = Folder::with_scene();
    folder.write("a.csv", Drop::default().csv());
    folder.write("b.csv", Drop { held_s: 0.5, seed: 2, ..Drop::default() }.csv());
    let ran = folder.run("tune --sim scene.toml --observation a.csv b.csv").ends(0);
    assert!(ran.stderr.contains("b.csv: the first 0.5"), "{}", ran.stderr);
    let json = folder.run("inspect a.csv b.csv --json").ends(0).json();
    assert_eq!(json["schema"], "tunenet.inspect.files/1");
    assert!((json["gravity"]["value_m_s2"].as_f64().unwrap() - 9.81).abs() < 0.05, "{}", json["gravity"]);
}

/// A small part of the bench: the goals hold with some slack for few records.
#[test]
fn faults_are_found_and_good_records_are_not_blamed() {
    let json = Folder::new().run("bench preflight --records 60 --seed 3 --json").ends(0).json();
    for fault in json["faults"].as_array().unwrap() {
        assert!(fault["found"].as_f64().unwrap() > 0.9, "{fault}");
    }
    for good in json["good"].as_array().unwrap() {
        assert!(good["rejected"].as_f64().unwrap() < 0.03 && good["noticed"].as_f64().unwrap() < 0.06, "{good}");
    }
}
