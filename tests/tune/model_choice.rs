//! Which network `tune` starts with, and what becomes of the cache.

use crate::common::{Drop, Folder};
use serde_json::Value;

fn source(json: &Value) -> &str {
    json["model"]["source"].as_str().unwrap()
}

fn codes(json: &Value) -> Vec<&str> {
    json["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect()
}

#[test]
fn a_drop_takes_the_built_in_network_and_bounce_times_none() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    let ran = folder.run("tune --sim scene.toml --observation drop.csv --json").ends(0);
    assert_eq!(source(&ran.json()), "built_in");
    assert!(ran.stderr.contains("model    built in\n"), "{}", ran.stderr);
    let drop = Drop { restitution: 0.8, ..Drop::default() };
    let times: Vec<String> = (0..8).map(|n| drop.impact_s(n).to_string()).collect();
    folder.write("clicks.csv", format!("bounce_time_s\n{}\n", times.join("\n")));
    let clicks = folder.run("tune --sim scene.toml --observation clicks.csv --json").ends(0);
    assert_eq!(source(&clicks.json()), "none");
    assert!(clicks.stderr.contains("model    not needed for bounce times\n"), "{}", clicks.stderr);
    assert!(!folder.path("cache").exists());
}

#[test]
fn a_scene_is_trained_for_once_and_a_damaged_entry_again() {
    let folder = Folder::with_scene();
    let observations = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/observations/throw.csv");
    folder.write("throw.csv", std::fs::read(observations).unwrap());
    let run = |more: &str| {
        let mut command = folder.command();
        command.args(["tune", "--sim", "scene.toml", "--observation", "throw.csv", "--json"]);
        command.args(["--set", "parameters.friction.tune=true", "--set", "parameters.friction.value=0.1"]);
        command.args(["--set", "parameters.friction.min=0", "--set", "parameters.friction.max=2"]);
        command.args(more.split_whitespace());
        crate::common::Ran::from(command.output().unwrap()).ends(0)
    };
    // A file where the folder should be: a note, and the answer all the same.
    folder.write("cache", "no folder");
    let first = run("");
    assert_eq!((source(&first.json()), codes(&first.json()).contains(&"cache.unusable")), ("trained", true));
    assert!(!first.stderr.contains("[="), "no bar in a pipe");
    std::fs::remove_file(folder.path("cache")).unwrap();
    let second = run("");
    assert_eq!(source(&second.json()), "trained");
    let entries: Vec<_> = std::fs::read_dir(folder.path("cache")).unwrap().map(|e| e.unwrap().path()).collect();
    let [entry] = &entries[..] else { panic!("{entries:?}") };
    let kept = std::fs::read(entry).unwrap();
    let third = run("");
    assert_eq!(source(&third.json()), "cached");
    assert_eq!(third.json()["parameters"], second.json()["parameters"]);
    // Cut short: found out, and made again with the same bytes.
    std::fs::write(entry, &kept[..kept.len() / 2]).unwrap();
    let fourth = run("");
    assert_eq!((source(&fourth.json()), codes(&fourth.json()).contains(&"cache.replaced")), ("trained", true));
    assert!(std::fs::read(entry).unwrap() == kept);
}

/// Outside 24 to 240 Hz, and with next to no samples: the truth lies in the interval, or nothing is claimed.
#[test]
fn there_is_no_silent_guess() {
    let folder = Folder::with_scene();
    let mut answered = 0;
    let drops = [(5.0, 20), (12.0, 30), (1000.0, 2000), (30.0, 3), (30.0, 5), (30.0, 8), (60.0, 10), (240.0, 10)];
    for (rate_hz, frames) in drops {
        let drop = Drop { restitution: 0.6, rate_hz, frames, noise_m: 0.002, seed: frames as u64, ..Drop::default() };
        folder.write("drop.csv", drop.csv());
        let ran = folder.run("tune --sim scene.toml --observation drop.csv --json");
        let json = ran.json();
        let verdict = json["verdict"].as_str().unwrap();
        if matches!(verdict, "tuned" | "poor_fit") {
            let interval = &json["parameters"]["restitution"]["interval95"];
            let (low, high) = (interval[0].as_f64().unwrap(), interval[1].as_f64().unwrap());
            // One interval in twenty may miss by a little.
            let slack = 0.5 * (high - low);
            assert!(low - slack <= 0.6 && 0.6 <= high + slack, "{rate_hz} Hz, {frames} samples: {low} to {high}");
            answered += 1;
        } else {
            assert_eq!(ran.code, Some(3), "{verdict}");
        }
    }
    assert!(answered >= 1, "1000 Hz shows all there is");
}
