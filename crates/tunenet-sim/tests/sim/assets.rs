//! The ready scenes and observations of the project's `assets` folder hold what their README says.

use std::path::{Path, PathBuf};
use std::process::Command;

use tunenet_core::tune::{Settings, Verdict, tune};
use tunenet_formats::{ReadOptions, read};
use tunenet_sim::shot::Task;
use tunenet_sim::{ObservedBall, SimulationFile};

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets")
}

/// The files of a folder with this ending, in order.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == ending));
    paths.sort();
    paths
}

#[test]
fn every_scene_is_read_and_keeps_its_bytes() {
    let mut read = 0;
    for path in files(&assets(), "toml") {
        let text = std::fs::read_to_string(&path).unwrap();
        if text.contains("kind = \"shot\"") {
            Task::read(&path).unwrap_or_else(|e| panic!("{e}"));
            continue;
        }
        let file = SimulationFile::read(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(file.text(), text, "{}", path.display());
        file.parameters().unwrap();
        read += 1;
    }
    assert!(read >= 5, "only {read} scenes");
}

/// Tunes a scene to an observation made by another integrator; returns each parameter's value and interval.
fn tuned(scene: &str, observation: &str, set: &[&str]) -> Vec<(f64, (f64, f64))> {
    let mut file = SimulationFile::read(&assets().join(scene)).unwrap();
    for assignment in set {
        file.set(assignment).unwrap();
    }
    let seen = read(assets().join("observations").join(observation), &ReadOptions::default()).unwrap().observation;
    let ball = ObservedBall::new(&file, seen.kind()).unwrap();
    let outcome = tune(&ball, &[seen], None, &Settings::default()).unwrap();
    assert_eq!(outcome.verdict, Verdict::Tuned, "{observation}: {:?}", outcome.notes);
    outcome.parameters.iter().map(|p| (p.value, p.interval95)).collect()
}

#[track_caller]
fn holds((value, (low, high)): (f64, (f64, f64)), truth: f64, near: f64) {
    assert!((value - truth).abs() < near, "{value} is not {truth}");
    // The seeds were not chosen: an interval of 95 % may miss the truth, but not by its own width again.
    let slack = 0.5 * (high - low);
    assert!((low - slack..=high + slack).contains(&truth), "{low} to {high} is far from {truth}");
}

#[test]
fn the_drop_gives_its_restitution_back() {
    holds(tuned("ball.toml", "drop.csv", &[])[0], 0.83, 2e-3);
}

#[test]
fn the_throw_gives_restitution_and_friction_back() {
    let found = tuned("ball.toml", "throw.csv", &["parameters.friction.value=0.15", "parameters.friction.tune=true"]);
    holds(found[0], 0.75, 5e-3);
    holds(found[1], 0.2, 2e-2);
}

#[test]
fn the_bounce_times_give_their_restitution_back() {
    holds(tuned("ball.toml", "bounces.csv", &[])[0], 0.9, 1e-3);
}

#[test]
fn the_table_tennis_ball_gives_its_restitution_back() {
    holds(tuned("table_tennis.toml", "table_tennis.csv", &[])[0], 0.88, 2e-3);
}

#[test]
fn the_observations_are_made_again_byte_by_byte() {
    let folder = tempfile::tempdir().unwrap();
    let script = assets().join("make_observations.py");
    match Command::new("python3").arg(&script).arg(folder.path()).status() {
        Err(error) => return eprintln!("skipped: python3 does not run here ({error})"),
        Ok(status) => assert!(status.success(), "{status}"),
    }
    let (kept, made) = (files(&assets().join("observations"), "csv"), files(folder.path(), "csv"));
    assert_eq!(kept.len(), made.len());
    for (kept, made) in kept.iter().zip(&made) {
        assert_eq!(kept.file_name(), made.file_name());
        assert!(std::fs::read(kept).unwrap() == std::fs::read(made).unwrap(), "{} differs", kept.display());
    }
}
