//! What people read: help, an answer, a warning and an error, word for word, without colour and without a terminal.

use crate::common::{DROP, Drop, Folder, SCENE};

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
    let commands = [
        "",
        " init",
        " tune",
        " diagnose",
        " plan",
        " track",
        " simulate",
        " inspect",
        " gen",
        " train",
        " merge",
        " bench",
        " completions",
    ];
    for command in commands.into_iter().chain([" man"]) {
        help(command);
    }
}

#[test]
fn quiet_benches_print_no_notes() {
    for line in ["bench preflight --records 2 --quiet", "-q bench preflight --records 2"] {
        let ran = Folder::new().run(line).ends(0);
        assert!(ran.stderr.is_empty(), "{line}: {}", ran.stderr);
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
    plain(&ran.stdout);
    plain(&ran.stderr);
    filtered(|| insta::assert_snapshot!("tune_answer", ran.stdout));
    filtered(|| insta::assert_snapshot!("tune_notes", ran.stderr));
}

#[test]
fn an_honest_no() {
    let folder = Folder::with_scene();
    folder.write("short.csv", Drop { frames: 30, ..Drop::default() }.csv());
    let ran = folder.run("tune --sim scene.toml --observation short.csv").ends(3);
    filtered(|| insta::assert_snapshot!("tune_no_bounce", ran.stdout));
    filtered(|| insta::assert_snapshot!("tune_no_bounce_notes", ran.stderr));
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
        let ran = crate::common::Ran::from(output).ends(0);
        plain(&ran.stdout);
        plain(&ran.stderr);
        let notes: Vec<&str> = ran.stderr.lines().collect();
        assert!(ran.stdout.lines().count() <= 1, "{}", ran.stdout);
        // A slow machine says now and then how far it is.
        let (wrote, progress) = notes.split_last().unwrap();
        assert!(wrote.starts_with("wrote    "), "{}", ran.stderr);
        assert!(progress.iter().all(|line| line.contains(" of ") && line.ends_with(" s")), "{}", ran.stderr);
    }
}

/// Colours are for terminals, for those who force them, and for nobody where `NO_COLOR` is set.
#[test]
fn colour_obeys_the_environment() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop { held_s: 0.3, frames: 300, ..Drop::default() }.csv());
    folder.write("bad.csv", "t_s,z_m\n0.0,1.0\n0.1,0.6b31\n0.2,0.4\n");
    folder.write("drop.toml", DROP);
    // An answer with a warning, an error with its line, an error without one, one of the command line, a long run with a
    // bar, an inspection: whether standard output and standard error are coloured.
    for (line, answer, notes) in [
        ("tune --sim scene.toml drop.csv", true, true),
        ("tune --sim scene.toml bad.csv", false, true),
        ("tune --sim scene.toml none.csv", false, true),
        ("tune --sim scene.toml", false, true),
        ("gen ball --sim drop.toml --pairs 200 --out pairs.mcap", false, false),
        ("inspect drop.csv", false, true),
    ] {
        let run = |variables: &[(&str, &str)]| {
            let mut command = folder.command();
            command.env_remove("NO_COLOR").envs(variables.iter().copied()).args(line.split_whitespace());
            crate::common::Ran::from(command.output().unwrap())
        };
        for quiet in [run(&[]), run(&[("NO_COLOR", "1")]), run(&[("NO_COLOR", "1"), ("CLICOLOR_FORCE", "1")])] {
            plain(&quiet.stderr);
            plain(&quiet.stdout);
        }
        let forced = run(&[("CLICOLOR_FORCE", "1")]);
        assert_eq!(forced.stderr.contains('\u{1b}'), notes, "{line}: {:?}", forced.stderr);
        assert_eq!(forced.stdout.contains('\u{1b}'), answer, "{line}: {:?}", forced.stdout);
        assert!(!forced.stderr.contains('\r'), "{line}: {:?}", forced.stderr);
    }
}

/// What `--json` prints stays one object without colour, also where colours are forced.
#[test]
fn json_is_never_coloured() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    let mut command = folder.command();
    command.env_remove("NO_COLOR").env("CLICOLOR_FORCE", "1");
    command.args(["tune", "--sim", "scene.toml", "--observation", "drop.csv", "--json"]);
    assert!(crate::common::Ran::from(command.output().unwrap()).ends(0).json()["verdict"] == "tuned");
}
