//! Recordings of one ball in several setups, which a manifest describes: one restitution for all.

use std::fmt::Write as _;

use crate::common::{Drop, Folder, refused, table};
use crate::docs::page::text;

const MOON_M_S2: f64 = 1.62;
const EARTH_M_S2: f64 = 9.81;

/// A fall under another gravity is that on the earth, with time stretched by the square root of the ratio.
fn on_the_moon(fall: &Drop) -> String {
    let stretch = (EARTH_M_S2 / MOON_M_S2).sqrt();
    table(&fall.frames().into_iter().map(|(t, at)| (t * stretch, at)).collect::<Vec<_>>())
}

/// Two drops on the earth and two on the moon, of restitution 0.7, and the manifest that says so.
fn recorded() -> Folder {
    let folder = Folder::with_scene();
    let mut manifest = String::new();
    for (name, moon, height_m, seed) in
        [("low", false, 0.8, 1), ("high", false, 1.3, 2), ("moon", true, 1.0, 3), ("far", true, 1.5, 4)]
    {
        let fall = Drop { height_m, seed, ..Drop::default() };
        folder.write(&format!("{name}.csv"), if moon { on_the_moon(&fall) } else { fall.csv() });
        writeln!(manifest, "[[observation]]\nfile = \"{name}.csv\"").unwrap();
        manifest += if moon { "world.gravity_m_s2 = 1.62\n" } else { "" };
    }
    folder.write("runs.toml", manifest);
    folder
}

#[test]
fn one_restitution_is_found_in_two_gravities() {
    let folder = recorded();
    let line = "tune --sim scene.toml --manifest runs.toml --out tuned.toml --json";
    let json = folder.run(line).ends(0).json();
    assert_eq!(json["verdict"], "tuned", "{json:#}");
    let found = json["parameters"]["restitution"]["value"].as_f64().unwrap();
    assert!((found - 0.7).abs() < 2e-3, "{found}");
    let note = json["warnings"].as_array().unwrap().iter().find(|w| w["code"] == "setups.differ").unwrap();
    assert!(note["text"].as_str().unwrap().contains("`world.gravity_m_s2`"), "{note}");
    let written = folder.text("tuned.toml");
    assert!(!written.contains("[world]") && written.contains("scene = { \"world.gravity_m_s2\" = 1.62 }"), "{written}");
    // Without the manifest the drops on the moon are none that fall as they should.
    let apart = folder.run("tune --sim scene.toml low.csv high.csv moon.csv far.csv --json").json();
    let used = apart["recordings"].as_array().unwrap().iter().filter(|one| one["used"] == true).count();
    assert_eq!(used, 2, "{apart:#}");
    let forced = folder.run("tune --sim scene.toml low.csv high.csv moon.csv far.csv --force --json").ends(3).json();
    assert_eq!(forced["verdict"], "poor_fit", "{forced:#}");
}

#[test]
fn nothing_is_missing_where_only_gravity_differs() {
    let folder = recorded();
    let line = "diagnose --sim scene.toml --manifest runs.toml --json --report page.html";
    let json = folder.run(line).ends(0).json();
    assert_eq!(json["verdict"], "none", "{json:#}");
    let found = json["parameters"][0]["value"].as_f64().unwrap();
    assert!((found - 0.7).abs() < 2e-3, "{found}");
}

/// What every line says, or what the file says already, makes no setup of its own: the answer is that without a manifest.
#[test]
fn keys_that_change_nothing_leave_every_digit() {
    let folder = recorded();
    let entry = |name: &str, keys: &str| format!("[[observation]]\nfile = \"{name}.csv\"\n{keys}");
    folder.write("same.toml", entry("low", "ball.radius_m = 0.02\n") + &entry("high", ""));
    let answer = |line: &str| folder.run(line).ends(0).json();
    let [plain, listed] = ["low.csv high.csv", "--manifest same.toml"]
        .map(|given| answer(&format!("tune --sim scene.toml {given} --json")));
    for key in ["parameters", "gap", "rollouts", "model", "warnings"] {
        assert_eq!(plain[key], listed[key], "{key}");
    }
}

#[test]
fn what_recordings_of_one_object_share_is_refused_in_one_sentence() {
    let folder = recorded();
    let tune = "tune --sim scene.toml --manifest keys.toml";
    for (key, value) in [("parameters.restitution.value", "0.4"), ("effects.quadratic_drag.c_1_m", "0.01")] {
        let lines =
            format!("[[observation]]\nfile = \"low.csv\"\n[[observation]]\nfile = \"high.csv\"\n{key} = {value}\n");
        folder.write("keys.toml", lines);
        let expected = format!("high.csv: expected the same `{key}` in all recordings of one object (nothing as in `");
        refused(&folder, tune, &[&expected, &format!("found {value}"), "another `object`"]);
        refused(
            &folder,
            &tune.replace("tune", "diagnose"),
            &[&format!("the same `{key}` in all recordings of `ball`")],
        );
    }
}

#[test]
fn simulate_writes_the_scene_of_each_line() {
    let folder = recorded();
    folder.run("simulate --sim scene.toml --set release.height_m=1 --set record.frames=240 --manifest runs.toml --out made").ends(0);
    let made = folder.text("made/moon.csv");
    let at = |text: &str, frame: usize| -> f64 {
        text.lines().nth(frame + 1).unwrap().rsplit(',').next().unwrap().parse().unwrap()
    };
    // Free fall from 1 m, the radius of the ball above.
    let second: f64 = made.lines().nth(2).unwrap().split(',').next().unwrap().parse().unwrap();
    assert!((at(&made, 1) - (1.02 - 0.5 * MOON_M_S2 * second * second)).abs() < 1e-6, "{made}");
    let earth = folder.text("made/low.csv");
    assert!((at(&earth, 1) - (1.02 - 0.5 * EARTH_M_S2 * second * second)).abs() < 1e-6, "{earth}");
}

/// The manifest that the page on tuning shows: what it simulates, it tunes to.
#[test]
fn the_manifest_of_the_page_is_one() {
    let folder = Folder::with_scene();
    let page = text("docs/tune.md");
    let (_, shown) = page.split_once("```toml\n[[observation]]").unwrap();
    folder.write("runs.toml", format!("[[observation]]{}", shown.split_once("```").unwrap().0));
    let given = "--set release.height_m=1 --set record.frames=240 --set parameters.restitution.value=0.63";
    folder.run(&format!("simulate --sim scene.toml {given} --manifest runs.toml --out .")).ends(0);
    let json = folder.run("tune --sim scene.toml --manifest runs.toml --json").ends(0).json();
    let found = json["parameters"]["restitution"]["value"].as_f64().unwrap();
    assert!((found - 0.63).abs() < 1e-4, "{json:#}");
}

#[test]
fn inspect_checks_each_recording_against_the_gravity_of_its_line() {
    let folder = recorded();
    let text = folder.run("inspect --sim scene.toml --manifest runs.toml").ends(0).stdout;
    assert!(text.contains("scene    world.gravity_m_s2 = 1.62") && text.contains("1.62 expected"), "{text}");
}
