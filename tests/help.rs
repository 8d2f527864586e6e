//! What people read: help, an answer, a warning and an error, word for word, without colour and without a terminal.

mod common;

use common::{DROP, Drop, Folder, SCENE};

/// Help goes to standard output, has no escape codes, and is kept under `tests/snapshots`.
fn help(command: &str) {
    let ran = Folder::new().run(&format!("{command} --help")).ends(0);
    assert!(ran.stderr.is_empty(), "{}", ran.stderr);
    plain(&ran.stdout);
    insta::assert_snapshot!(format!("help{}", command.replace(' ', "_")), ran.stdout);
}

#[track_caller]
fn plain(text: &str) {
    assert!(!text.contains('\u{1b}') && !text.contains('\r') && !text.contains("[="), "{text:?}");
}

#[test]
fn help_of_the_tool_and_of_every_command() {
    for command in ["", " tune", " diagnose", " simulate", " inspect", " gen", " train", " bench", " completions"] {
        help(command);
    }
}

/// Seconds and the version change from run to run; everything else stays.
fn filtered(check: impl FnOnce()) {
    insta::with_settings!({ filters => [
        (r"\d+\.\d s\b", "[seconds] s"),
        (r"tunenet \d+\.\d+\.\d+\S*", "tunenet [version]"),
        (r"\d+ rollouts", "[rollouts] rollouts"),
    ] }, { check() });
}

#[test]
fn an_answer_with_a_warning() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    let ran = folder.run("tune --sim scene.toml --observation drop.csv --out tuned.toml").ends(0);
    assert!(ran.stdout.is_empty(), "{}", ran.stdout);
    plain(&ran.stderr);
    filtered(|| insta::assert_snapshot!("tune_answer", ran.stderr));
}

#[test]
fn an_honest_no() {
    let folder = Folder::with_scene();
    folder.write("short.csv", Drop { frames: 30, ..Drop::default() }.csv());
    let ran = folder.run("tune --sim scene.toml --observation short.csv").ends(3);
    filtered(|| insta::assert_snapshot!("tune_no_bounce", ran.stderr));
}

#[test]
fn errors_point_at_the_place() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE.replace("value = 0.5", "value = 1.7"));
    folder.write("drop.csv", "t_s,z_m\n0.0,1.0\n0.1,0.6b31\n0.2,0.4\n");
    let bounds = folder.run("tune --sim scene.toml --observation drop.csv").ends(1);
    plain(&bounds.stderr);
    insta::assert_snapshot!("error_bounds", bounds.stderr);
    folder.write("scene.toml", SCENE);
    insta::assert_snapshot!("error_cell", folder.run("tune --sim scene.toml --observation drop.csv").ends(1).stderr);
    insta::assert_snapshot!("error_missing", folder.run("tune --sim scene.toml --observation none.csv").ends(1).stderr);
}

/// Bars are for terminals: a long run leaves one line for each finished stage, also where colours are not forbidden.
#[test]
fn no_bars_and_no_colour_without_a_terminal() {
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    for line in [
        "gen ball --sim drop.toml --pairs 2000 --out pairs.mcap",
        "train --data pairs.mcap --preset paper --out m.safetensors",
    ] {
        let output = folder.command().env_remove("NO_COLOR").args(line.split_whitespace()).output().unwrap();
        let ran = common::Ran::from(output).ends(0);
        plain(&ran.stderr);
        assert!(ran.stderr.lines().count() <= 2, "{}", ran.stderr);
    }
}
