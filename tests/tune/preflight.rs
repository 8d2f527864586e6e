//! What is checked before tuning, as a process shows it.

use crate::common::{Drop, Folder, table};
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
    // Whether gravity has its usual value is asked, which is a note.
    assert_eq!(codes(&json["warnings"]), ["constant.assumed"]);
    assert_eq!(json["warnings"][0]["severity"], "note");
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
    let ran = folder.run("tune --sim scene.toml --observation mm.csv --force");
    assert!(ran.stdout.contains("FORCED") && !ran.stderr.contains("FORCED"), "{}", ran.stdout);
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

fn codes(warnings: &Value) -> Vec<&str> {
    warnings.as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect()
}

/// What `inspect` warns of, `tune` does, in the same words; what is not about the recording apart.
#[test]
fn inspect_and_tune_say_the_same() {
    let folder = Folder::with_scene();
    let times = [0.4, 1.0, 1.5, 1.9, 2.2, 2.9, 3.1];
    folder.write("missed.csv", format!("bounce_time_s\n{}\n", times.map(|t| t.to_string()).join("\n")));
    folder.write("late.csv", Drop { held_s: 0.5, frames: 300, ..Drop::default() }.csv().replace("x_m", "warmth_c"));
    folder.run("simulate --sim scene.toml --set release.height_m=1 --out log.mcap").ends(0);
    for name in ["missed.csv", "late.csv", "log.mcap"] {
        let inspected = folder.run(&format!("inspect {name} --json")).ends(0).json();
        let tuned = folder.run(&format!("tune --sim scene.toml --observation {name} --json")).json();
        let states = |checks: &Value| {
            let all = checks.as_array().unwrap().iter();
            all.map(|c| (c["code"].clone(), c["state"].clone())).collect::<Vec<_>>()
        };
        assert_eq!(states(&inspected["preflight"]), states(&tuned["preflight"][0]), "{name}");
        let all = tuned["warnings"].as_array().unwrap().iter();
        let later = ["fit.", "parameter.", "cache.", "friction.", "constant."];
        let told: Vec<&Value> =
            all.filter(|w| !later.iter().any(|l| w["code"].as_str().unwrap().starts_with(l))).collect();
        assert_eq!(inspected["warnings"].as_array().unwrap().iter().collect::<Vec<_>>(), told, "{name}");
    }
    let ran = folder.run("inspect missed.csv --json").ends(0);
    assert_eq!(codes(&ran.json()["warnings"]), ["bounces.missed"]);
    assert!(ran.stderr.contains("that time and the 1 after it are excluded"), "{}", ran.stderr);
}

/// The ball touches the floor just before the last sample but one or two: too late for a flight after it, which must not bend
/// the one before.
#[test]
fn a_bounce_in_the_last_samples_is_cut_off_and_said() {
    let folder = Folder::with_scene();
    let drop = Drop { restitution: 0.9, ..Drop::default() };
    let before = drop.frames().iter().filter(|(t, _)| *t < drop.impact_s(0)).count();
    for after in 1..=2 {
        folder.write("late.csv", Drop { frames: before + after, ..drop }.csv());
        let json = folder.run("tune --sim scene.toml --observation late.csv --json").ends(3).json();
        assert_eq!(json["verdict"], "not_identifiable");
        let checks = json["preflight"][0].as_array().unwrap();
        let bounce = checks.iter().find(|c| c["code"] == "contact.none").unwrap();
        assert!(
            bounce["state"] == "noticed" && bounce["text"].as_str().unwrap().contains("at the very end"),
            "{bounce}"
        );
        assert!(json["gap"]["after"].as_f64() < Some(0.0025), "{after}: {}", json["gap"]);
        let gravity = folder.run("inspect late.csv --json").json()["gravity"]["value_m_s2"].as_f64().unwrap();
        assert!((gravity - 9.81).abs() < 0.15, "{after}: {gravity}");
    }
}

/// A surface that is not touched, and an axis that was not measured, are not told as found in the data.
#[test]
fn what_the_data_do_not_show_is_no_estimate() {
    let folder = Folder::with_scene();
    let names = |line: &str| -> Vec<String> {
        let json = folder.run(&format!("tune --sim scene.toml --observation {line} --json")).json();
        let own = json["estimated"][0].as_array().unwrap().iter();
        own.map(|o| o["name"].as_str().unwrap().to_owned()).collect()
    };
    folder.write("fall.csv", Drop { frames: 40, ..Drop::default() }.csv());
    let fall = names("fall.csv");
    assert!(!fall.contains(&"surface.height".into()) && fall.contains(&"release.y".into()), "{fall:?}");
    let rows = Drop::default().frames();
    let rows: Vec<String> = rows.iter().map(|(t, [x, _, z])| format!("{t},{x},{z}")).collect();
    folder.write("flat.csv", format!("t_s,x_m,z_m\n{}\n", rows.join("\n")));
    assert_eq!(
        names("flat.csv"),
        ["release.x", "release.z", "release.velocity_x", "release.velocity_z", "surface.height"]
    );
}

/// As many bounces as unknowns fit whatever they are.
#[test]
fn three_bounces_leave_nothing_to_judge_by() {
    let folder = Folder::with_scene();
    folder.write("three.csv", "bounce_time_s\n0.4\n1.1\n1.66\n");
    let ran = folder.run("tune --sim scene.toml --observation three.csv --json").ends(3);
    let json = ran.json();
    assert_eq!(json["verdict"], "not_identifiable");
    assert_eq!(json["parameters"]["restitution"]["interval95"], serde_json::json!([0.0, 1.0]));
    assert!(codes(&json["warnings"]).contains(&"recordings.short"));
    assert!(ran.stderr.contains("bring at least 1 more event time\n"), "{}", ran.stderr);
    // A known height of fall is one unknown less.
    folder.run("tune --sim scene.toml --set release.height_m=0.98 --observation three.csv").ends(0);
}

/// A small part of the bench: the goals hold with some slack for few records.
#[test]
fn faults_are_found_and_good_records_are_not_blamed() {
    let folder = Folder::new();
    let quick = folder.run("bench preflight --quick --records 3 --seed 3 --json --out quick").ends(0).json();
    assert_eq!(quick["records"], 3);
    let json = folder.run("bench preflight --records 60 --seed 3 --json").ends(0).json();
    for fault in json["faults"].as_array().unwrap() {
        assert!(fault["found"].as_f64().unwrap() > 0.9, "{fault}");
    }
    for good in json["good"].as_array().unwrap() {
        assert!(good["rejected"].as_f64().unwrap() < 0.03 && good["noticed"].as_f64().unwrap() < 0.06, "{good}");
    }
}

/// A column that points down is named as such, and read with a minus.
#[test]
fn a_height_that_points_down_is_turned_by_a_sign() {
    let folder = Folder::with_scene();
    let down: Vec<_> = Drop::default().frames().iter().map(|(t, [x, y, z])| (*t, [*x, *y, -*z])).collect();
    folder.write("drop.csv", Drop::default().csv());
    folder.write("down.csv", table(&down).replace("z_m", "depth"));
    let ran = folder.run("tune --sim scene.toml down.csv --columns z_m=depth").ends(3);
    assert!(ran.stdout.contains("so z points down"), "{}", ran.stdout);
    assert!(ran.stderr.contains("`--columns z_m=-NAME`"), "{}", ran.stderr);
    let turned = folder.run("tune --sim scene.toml down.csv --columns z_m=-depth --json").ends(0);
    assert!(turned.stderr.contains("`z_m` is column `depth` with its sign reversed"), "{}", turned.stderr);
    let upright = folder.run("tune --sim scene.toml drop.csv --json").ends(0).json();
    assert_eq!(turned.json()["parameters"], upright["parameters"]);
    let clock = folder.run("tune --sim scene.toml drop.csv --columns t_s=-t_s").ends(1);
    assert!(clock.stderr.contains("`t_s` has no sign"), "{}", clock.stderr);
}

/// Of several recordings the answer says which it rests on, whose numbers are whose, and each remedy once.
#[test]
fn an_answer_says_which_recordings_it_rests_on() {
    let folder = Folder::with_scene();
    folder.write("a.csv", Drop::default().csv());
    folder.write("b.csv", Drop { seed: 2, ..Drop::default() }.csv());
    folder.write("mm.csv", in_millimetres());
    let ran = folder.run("tune --sim scene.toml a.csv mm.csv b.csv").ends(0);
    assert!(ran.stdout.contains("2 of 3 recordings used; rejected: mm.csv"), "{}", ran.stdout);
    for name in ["a.csv", "b.csv"] {
        assert!(ran.stdout.contains(&format!("also from the data of {name}: ")), "{}", ran.stdout);
    }
    let json = folder.run("tune --sim scene.toml a.csv mm.csv b.csv --json").ends(0).json();
    let used = |file: &str, used: bool| serde_json::json!({ "file": file, "used": used });
    assert_eq!(
        json["recordings"],
        serde_json::json!([used("a.csv", true), used("mm.csv", false), used("b.csv", true)])
    );
    let diagnosed = folder.run("diagnose --sim scene.toml a.csv mm.csv b.csv");
    assert!(diagnosed.stdout.contains("2 of 3 recordings used; rejected: mm.csv"), "{}", diagnosed.stdout);
    let plain = folder.run("tune --sim scene.toml a.csv b.csv").ends(0);
    assert!(!plain.stdout.contains("recordings used"), "{}", plain.stdout);
    for (name, seed) in [("c.csv", 3), ("d.csv", 4)] {
        folder.write(name, Drop { seed, ..Drop::default() }.csv().replace(",y_m", ",note"));
    }
    let notes = folder.run("tune --sim scene.toml c.csv d.csv").stderr;
    assert_eq!(notes.matches("columns.absent").count(), 2, "{notes}");
    assert_eq!(notes.matches("try: name them with `--columns`").count(), 1, "{notes}");
}
