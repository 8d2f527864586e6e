//! Recordings whose answers are known to be wrong today, where `TUNENET_CASES` names a folder that holds them. The pinned file
//! says of each what would be right.

use std::path::{Path, PathBuf};

use super::{answer, line, pinned};
use crate::common::Folder;
use crate::common::recorded::{files, folder, name};

const VARIABLE: &str = "TUNENET_CASES";

/// Single drops: the file, and the height of its floor where that is given.
const DROPS: [(&str, Option<f64>); 13] = [
    ("081", Some(0.0)),
    ("099", Some(0.36)),
    ("403", Some(-0.125)),
    ("437", Some(-0.215)),
    ("483", Some(-0.165)),
    ("371", Some(-0.26)),
    ("161", None),
    ("169", None),
    ("514", None),
    ("005", None),
    ("242", None),
    ("drag_13_0", None),
    ("drag_7_0", None),
];

#[test]
fn regress_cases_of_single_drops() {
    let Some(from) = folder(VARIABLE, "ball") else { return };
    let here = Folder::new();
    let sim = from.join("ball.toml").display().to_string();
    let drop = |(file, floor_m): (&str, Option<f64>)| {
        let floor = floor_m.map(|m| format!("--set surface.height_m={m:?}")).unwrap_or_default();
        let words = format!("tune --sim {sim} {floor} --observation");
        (file.to_owned(), answer(&here, &line(&words, &[from.join(format!("{file}.csv"))])))
    };
    let mut found: Vec<_> = DROPS.into_iter().map(drop).collect();
    let words = format!("diagnose --sim {sim} --observation");
    found.push(("tall".into(), answer(&here, &line(&words, &files(&from, "tall_", ".csv")))));
    pinned::check("cases-drops", &found);
}

/// A folder of numbered drops, the last `held_out` of them to judge by.
fn set(here: &Folder, from: &Path, folder: &str) -> (String, serde_json::Value) {
    let drops = files(&from.join(folder), "", ".csv");
    let held_out = if folder.starts_with("deg_") { 1 } else { 2 };
    let (seen, held_out) = drops.split_at(drops.len() - held_out);
    let sim = from.join(if folder.starts_with("mass_") { "heavy.toml" } else { "ball.toml" });
    let mut words = line(&format!("diagnose --sim {} --observation", sim.display()), seen);
    words.extend(line("--held-out", held_out));
    (folder.to_owned(), answer(here, &words))
}

/// The folders whose names start so.
fn sets(group: &str, starts: &[&str]) {
    let Some(from) = folder(VARIABLE, "ball") else { return };
    let here = Folder::new();
    let folders = files(&from, "", "").into_iter().filter(|path| path.is_dir()).map(|path| name(&path));
    let those = folders.filter(|folder| starts.iter().any(|start| folder.starts_with(start)));
    pinned::check(group, &those.map(|folder| set(&here, &from, &folder)).collect::<Vec<_>>());
}

#[test]
fn regress_cases_outside_the_catalogue() {
    sets("cases-outside", &["outside_", "gen_u_", "hidden_gust"]);
}

#[test]
fn regress_cases_of_the_catalogue() {
    sets("cases-inside", &["hidden_bounce", "hidden_tangential", "single_", "xz_", "mass_", "deg_"]);
}

#[test]
fn regress_cases_of_three_effects() {
    sets("cases-three", &["three_"]);
}

#[test]
fn regress_cases_of_an_arm() {
    let Some(from) = folder(VARIABLE, "arm") else { return };
    let here = Folder::new();
    let log = |name: &str| from.join(format!("{name}.csv"));
    let ask = |words: &str, paths: &[PathBuf]| {
        let sim = from.join("mine.toml").display().to_string();
        answer(&here, &line(&format!("{} --observation", words.replacen("mine", &sim, 1)), paths))
    };
    let mut found = Vec::new();
    for name in ["clean", "fric", "link", "both"] {
        let held_out = log(&format!("{name}_b")).display().to_string();
        let words = format!("diagnose --sim mine --held-out {held_out}");
        found.push((format!("diagnose {name}"), ask(&words, &[log(&format!("{name}_a"))])));
    }
    for name in ["fweak_a", "load_a", "loadonly_a"] {
        for command in ["tune", "diagnose"] {
            found.push((format!("{command} {name}"), ask(&format!("{command} --sim mine"), &[log(name)])));
        }
    }
    let bare = format!("diagnose --sim {} --observation", from.join("bare.toml").display());
    found.push(("diagnose clean, nothing to tune".into(), answer(&here, &line(&bare, &[log("clean_a")]))));
    pinned::check("cases-arm", &found);
}
