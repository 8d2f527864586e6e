//! This crate and its tests speak of observations, simulators and estimates: of no ball, no robot, no file format and no command
//! line.

use std::fmt::Write;
use std::path::{Path, PathBuf};

const BALL_OR_ROBOT: [&str; 23] = [
    "ball",
    "balls",
    "bounce",
    "bounces",
    "bounced",
    "bouncing",
    "throw",
    "throws",
    "thrown",
    "drop",
    "drops",
    "dropped",
    "flight",
    "flights",
    "restitution",
    "release",
    "releases",
    "released",
    "spin",
    "spins",
    "grease",
    "payload",
    "payloads",
];
const FORMATS: [&str; 4] = ["csv", "mcap", "urdf", "toml"];

/// The words of a line: parts of identifiers stand alone, so that `BallScene` and `ball_scene` are two words each.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for c in line.chars() {
        if !c.is_ascii_alphanumeric() || (c.is_ascii_uppercase() && was_lower) {
            words.push(String::new());
        }
        if c.is_ascii_alphanumeric() {
            words.last_mut().expect("a word").push(c.to_ascii_lowercase());
        }
        was_lower = c.is_ascii_lowercase() || c.is_ascii_digit();
    }
    words
}

/// How often a line names something of a list; Rust's own `drop` and `Drop` end a value's life.
fn named(line: &str, list: &[&str]) -> usize {
    let line = line.replace("drop(", "").replace("impl Drop for", "");
    words(&line).iter().filter(|word| list.contains(&word.as_str())).count()
}

/// Flags of Rust's own test harness, with which a test starts itself.
const HARNESS: [&str; 3] = ["exact", "ignored", "nocapture"];

/// How often a line names a flag, a command of the tool, or the command line itself.
fn command_line(line: &str) -> usize {
    let flags = line.split("--").skip(1).filter(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()));
    let flags = flags.filter(|rest| !HARNESS.contains(&words(rest)[0].as_str()));
    let commands = line.split("tunenet ").skip(1).filter(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()));
    let itself = line.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| *word == "CLI");
    flags.count() + commands.count() + itself.count() + line.matches("command line").count()
}

/// How often a line names a type of paths.
fn path_types(line: &str) -> usize {
    line.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| ["Path", "PathBuf"].contains(word)).count()
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Fails where sources and tests of the crate, this file aside, have more of these words than allowed, and says where most are.
fn at_most(allowed: usize, what: &str, count: impl Fn(&str) -> usize) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["src", "tests"] {
        sources(&root.join(folder), &mut files);
    }
    files.retain(|path| !path.ends_with("tests/core/words.rs"));
    let text = |path: &PathBuf| std::fs::read_to_string(path).expect("a source");
    let mut places: Vec<(usize, &PathBuf)> =
        files.iter().map(|path| (text(path).lines().map(&count).sum(), path)).filter(|(n, _)| *n > 0).collect();
    places.sort();
    let total: usize = places.iter().map(|(n, _)| n).sum();
    let mut worst = String::new();
    for (n, path) in places.iter().rev().take(15) {
        writeln!(worst, "  {n:4}  {}", path.strip_prefix(root).expect("below it").display())
            .expect("a string takes all");
    }
    assert!(
        total <= allowed,
        "{total} words {what} in {} files, {allowed} are allowed; most in\n{worst}",
        places.len()
    );
    if total < allowed {
        eprintln!("{total} words {what}, {allowed} are allowed: lower that number");
    }
}

#[test]
fn core_knows_no_ball() {
    at_most(0, "of a ball or a robot", |line| named(line, &BALL_OR_ROBOT));
}

#[test]
fn core_knows_no_file_format() {
    at_most(0, "of file formats", |line| named(line, &FORMATS));
}

/// A temporary file has no name, so that core opens none by a path and refuses none.
#[test]
fn core_knows_no_path_of_a_file() {
    at_most(0, "of paths", path_types);
}

#[test]
fn core_knows_no_command_line() {
    at_most(0, "of the command line", command_line);
}

#[test]
fn words_are_found_in_identifiers_and_prose() {
    assert_eq!(
        words("let ball_x = BallScene::new(csv2);"),
        ["let", "ball", "x", "", "", "ball", "scene", "", "new", "csv2", "", ""]
    );
    assert_eq!(named("// a ball's csv, drop(it) dropped", &BALL_OR_ROBOT), 2);
    assert_eq!(path_types("use std::path::{Path, PathBuf}; // the PathLike on_path"), 2);
    assert_eq!(command_line("pass `--columns`, or `tunenet inspect`; a - b -- tunenet_core"), 2);
}
