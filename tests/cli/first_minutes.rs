//! What a stranger meets first: a file to start from, a table with foreign names, a slip on the command line.

use crate::common::{Drop, Folder, refused};

/// Wrong usage: status 2, nothing on standard output, `wanted` on standard error.
#[track_caller]
fn misused(folder: &Folder, line: &str, wanted: &[&str]) {
    let before = folder.names();
    let ran = folder.run(line).ends(2);
    assert!(ran.stdout.is_empty(), "{}", ran.stdout);
    for text in wanted {
        assert!(ran.stderr.contains(text), "{line}: no `{text}` in:\n{}", ran.stderr);
    }
    assert_eq!(folder.names(), before, "{line}");
}

#[test]
fn a_file_to_start_from_can_be_tuned_with() {
    let folder = Folder::new();
    let drop = Drop { floor_m: 0.3, held_s: 0.2, ..Drop::default() };
    folder.write("drop.csv", drop.csv());
    let json = folder.run("init ball --json").ends(0).json();
    assert_eq!((json["schema"].as_str(), json["file"].as_str()), (Some("tunenet.init/1"), Some("ball.toml")));
    folder.run("inspect ball.toml").ends(0);
    let tuned = folder.run("tune --sim ball.toml --observation drop.csv --json --out tuned.toml").ends(0).json();
    let interval = &tuned["parameters"]["restitution"]["interval95"];
    assert!(
        (tuned["parameters"]["restitution"]["value"].as_f64().unwrap() - drop.restitution).abs() < 2e-3,
        "{interval}"
    );
    // What was tuned still has every comment.
    let comments = |name: &str| {
        let text = folder.text(name);
        text.lines().filter(|line| line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(comments("tuned.toml"), comments("ball.toml"));
}

#[test]
fn nothing_is_overwritten_unasked() {
    let folder = Folder::new();
    folder.write("ball.toml", "mine");
    refused(&folder, "init ball", &["ball.toml: expected a new name", "--overwrite"]);
    assert_eq!(folder.read("ball.toml"), b"mine");
    folder.run("init ball --overwrite").ends(0);
    folder.run("init ball --out other.toml").ends(0);
    assert_eq!(folder.read("ball.toml"), folder.read("other.toml"));
    folder.run("init arm").ends(0);
    misused(&folder, "init kite", &["kite", "[possible values: ball, arm, process, equations, robot]"]);
    misused(&folder, "init ball --out ball.csv", &["`--out`", "ends in .toml", "`ball.csv`"]);
    refused(&folder, "init ball --out none/ball.toml", &["none/ball.toml", "make the folder first"]);
}

#[test]
fn a_flag_is_blamed_for_what_it_says() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    let line = "tune --sim scene.toml --observation drop.csv --json --out tuned.toml";
    for (flag, wanted) in [
        ("--set parameters.restitution.tune=false", &["`--set`", "none after `parameters.restitution.tune=false`"][..]),
        ("--initial foo=1", &["`--initial`: expected a parameter (restitution, friction), found `foo`"]),
        ("--initial restitution=7", &["`--initial`: expected 0 to 1 for `restitution`, found 7"]),
    ] {
        misused(&folder, &format!("{line} {flag}"), wanted);
        assert!(!folder.run(&format!("{line} {flag}")).stderr.contains("drop.csv"), "{flag}");
    }
    let fixed = folder.text("scene.toml") + "tune = false\n";
    folder.write("scene.toml", fixed);
    refused(
        &folder,
        line,
        &["scene.toml: expected at least one parameter with `tune = true`", "restitution.tune=true"],
    );
    misused(&folder, "gen ball --pairs 3 --out pairs.csv", &["`--out`", "ends in .mcap", "`pairs.csv`"]);
    misused(&folder, "tun", &["similar subcommand exists: 'tune'"]);
    misused(&folder, "tune --observations drop.csv", &["--observation"]);
    misused(&folder, "man tun", &["expected a command (init, tune"]);
    misused(&folder, "", &["Usage: tunenet [OPTIONS] <COMMAND>", "tunenet init ball"]);
}

/// What is proposed for a foreign table works when it is typed.
#[test]
fn the_mapping_that_is_proposed_works() {
    let folder = Folder::with_scene();
    let good = Drop::default().csv();
    for (header, proposed) in [
        ("time,px,py,height", "--columns t_s=time,z_m=height"),
        ("time (s),pos_x,pos_y,pos_z", "--columns x_m=pos_x,y_m=pos_y,z_m=pos_z"),
        ("Zeit [s],a,b,Höhe [m]", "--columns 't_s=Zeit [s],z_m=Höhe [m]'"),
        ("t,x,w,y", "--columns t_s=t,x_m=x,z_m=y"),
    ] {
        folder.write("a.csv", good.replacen("t_s,x_m,y_m,z_m", header, 1));
        let ran = folder.run("inspect a.csv").ends(1);
        assert!(ran.stdout.contains("table    240 rows\n"), "{}", ran.stdout);
        assert!(ran.stdout.contains(&format!("  try: `{proposed}`")), "{header}: {}", ran.stdout);
        let json = folder.run("inspect a.csv --json").json();
        assert!(json["remedy"].as_str().unwrap().contains(proposed), "{json}");
        for command in ["inspect a.csv", "tune --sim scene.toml --observation a.csv"] {
            let typed = folder.shell(&format!("$TUNENET {command} {proposed}"));
            assert_eq!(typed.code, Some(0), "{command} {proposed}: {}", typed.stderr);
        }
    }
}

#[test]
fn every_command_has_examples_and_a_manual_page() {
    let folder = Folder::new();
    for command in ["init", "tune", "simulate", "inspect", "gen", "train", "bench", "completions", "man"] {
        let help = folder.run(&format!("help {command}")).ends(0).stdout;
        assert_eq!(help, folder.run(&format!("{command} --help")).ends(0).stdout);
        assert!(help.contains(&format!("Examples:\n  tunenet {command}")), "{help}");
        let page = folder.run(&format!("man {command}")).ends(0).stdout;
        assert!(page.contains(&format!("tunenet {command}")) && page.contains(".SH SYNOPSIS"), "{page}");
    }
}
