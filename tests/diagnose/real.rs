//! Diagnosis of recordings that nobody here made: two other engines, where `TUNENET_PEERS` names a folder that holds them,
//! and real balls, where `TUNENET_MEASURED` does; skipped without.

use std::process::Command;

use crate::common::recorded::{self, FALLEN, fallen, fallen_entry, files, measured, metres};
use crate::common::{Folder, Ran, ball};
use serde_json::Value;

fn run(command: &mut Command) -> Value {
    judged(&Ran::from(command.arg("--json").output().expect("the binary starts")))
}

/// What a diagnosis answered, in a line for whoever reads the test's output.
fn judged(ran: &Ran) -> Value {
    assert!(matches!(ran.code, Some(0 | 3)), "{}", ran.stderr);
    let json = ran.json();
    let of = |key: &str| &json[key];
    eprintln!(
        "  {} {} of {}, gap {}, {} rollouts, {:.1} s",
        of("verdict"),
        names(&json["effects"], "name").join(" + "),
        of("candidates"),
        of("gap"),
        of("rollouts"),
        json["seconds"].as_f64().unwrap_or(0.0),
    );
    json
}

/// What a failure is told with.
fn short(json: &Value) -> String {
    ["verdict", "effects", "candidates", "gap", "adequacy", "description"]
        .map(|key| format!("{key} {}", json[key]))
        .join("\n")
}

fn names(list: &Value, key: &str) -> Vec<String> {
    let name = |v: &Value| v.get(key).unwrap_or(v).as_str().unwrap_or_default().to_owned();
    list.as_array().into_iter().flatten().map(name).collect()
}

/// Whether `effect` is named or in the set that is.
fn offers(json: &Value, effect: &str) -> bool {
    let named = json["verdict"] == "named" || json["verdict"] == "one_of";
    named
        && (names(&json["effects"], "name").contains(&effect.into())
            || names(&json["candidates"], "").contains(&effect.into()))
}

fn is_named(json: &Value, effect: &str) -> bool {
    json["verdict"] == "named" && names(&json["effects"], "name").contains(&effect.into())
}

/// A set of another engine, `count` files of it, each its own object. The other engines put the ball's radius at .5 m.
fn peers(set: &str, count: usize) -> Option<Value> {
    let ran = recorded::peers_diagnosed(set, count)?;
    eprintln!("{set}:");
    Some(judged(&ran))
}

#[test]
fn another_engine_with_drag() {
    for set in ["pybullet_drag", "mujoco_drag"] {
        let Some(json) = peers(set, 5) else { return };
        assert!(offers(&json, "quadratic_drag"), "{set}: {}", short(&json));
    }
}

#[test]
fn another_engine_with_a_tilted_floor() {
    let Some(json) = peers("mujoco_tilt", 2) else { return };
    assert!(offers(&json, "surface_tilt"), "{}", short(&json));
}

#[test]
fn another_engine_with_late_contacts_on_a_tilted_floor() {
    let Some(json) = peers("pybullet_tilt", 2) else { return };
    assert!(offers(&json, "surface_tilt"), "{}", short(&json));
}

#[test]
fn another_engine_whose_fast_bounces_return_less() {
    let Some(json) = peers("mujoco_eslope", 5) else { return };
    assert!(offers(&json, "speed_dependent_restitution"), "{}", short(&json));
}

#[test]
#[ignore = "not reached: rebounds of one ball stray by .10 from its law, which changes by .04 (rms, 60 bounces). Most of that is \
            where the contact was found: this engine brakes what it finds above the surface and pushes what it finds below it. \
            With three numbers for that, .024 is left, and an exponent of .20 shows; but sets without the effect then show .05 \
            to .17, one of them at p = .004"]
fn another_engine_with_late_contacts_whose_fast_bounces_return_less() {
    let Some(json) = peers("pybullet_eslope", 10) else { return };
    assert!(offers(&json, "speed_dependent_restitution"), "{}", short(&json));
}

#[test]
fn another_engine_in_the_wind() {
    for set in ["pybullet_wind", "mujoco_wind"] {
        let Some(json) = peers(set, 3) else { return };
        assert!(offers(&json, "wind"), "{set}: {}", short(&json));
    }
}

/// Its contacts last; what flies there flies as here.
#[test]
fn another_engine_with_nothing_hidden() {
    for set in ["mujoco_easy", "mujoco_hard"] {
        let Some(json) = peers(set, 5) else { return };
        let effects = json["effects"].as_array().expect("effects");
        let at_contact = effects.iter().all(|e| e["where"]["phase"] == "contact");
        assert!(json["verdict"] != "none" && at_contact, "{set}: {}", short(&json));
    }
}

#[test]
fn foam_needs_air_and_rubber_does_not() {
    let Some(from) = measured("three-balls") else { return };
    let [red, black, white] = FALLEN.map(|one| {
        let (name, .., radius_m, mass_kg) = one;
        let here = Folder::new();
        here.write("fall.csv", fallen(&from, one));
        here.write("ball.toml", ball(radius_m, Some(mass_kg)));
        eprintln!("{name}:");
        run(here.command().args(["diagnose", "--sim", "ball.toml", "--observation", "fall.csv"]))
    });
    assert!(is_named(&red, "quadratic_drag") && names(&red["effects"], "name").len() == 1, "{}", short(&red));
    assert!(["none", "insufficient"].contains(&black["verdict"].as_str().unwrap_or_default()), "{}", short(&black));
    let named = names(&white["effects"], "name");
    assert!(white["verdict"] != "named" || named == ["quadratic_drag"], "{}", short(&white));
}

/// The same three as one manifest: each has its own size, foam shows the air clearly and rubber does not need it.
#[test]
fn three_balls_together_show_drag() {
    let Some(from) = measured("three-balls") else { return };
    let here = Folder::new();
    for one in FALLEN {
        here.write(&format!("{}.csv", one.0), fallen(&from, one));
    }
    here.write("m.toml", FALLEN.map(fallen_entry).concat());
    here.write("ball.toml", ball(0.02, None));
    eprintln!("three balls:");
    let json = run(here.command().args(["diagnose", "--sim", "ball.toml", "--manifest", "m.toml"]));
    assert!(is_named(&json, "quadratic_drag") && names(&json["effects"], "name").len() == 1, "{}", short(&json));
    let own = json["objects"].as_array().expect("one for each");
    let verdict = |name: &str| own.iter().find(|o| o["object"] == name).map(|o| &o["verdict"]).expect("an object");
    assert!(verdict("red") == "named" && verdict("black") == "none", "{own:#?}");
    let each = json["effects"][0]["coefficients"]["drag_coefficient"]["objects"].as_array().expect("one for each");
    let of = |name: &str| each.iter().find(|o| o["object"] == name).and_then(|o| o["value"].as_f64()).expect("a value");
    assert!((0.4..1.2).contains(&of("red")), "{each:?}");
}

fn flights(count: usize) -> Option<Value> {
    let ran = recorded::flights_diagnosed(count)?;
    eprintln!("{count} flights:");
    Some(judged(&ran))
}

#[test]
fn table_tennis_flights_show_drag_together() {
    let Some(json) = flights(12) else { return };
    assert!(is_named(&json, "quadratic_drag"), "{}", short(&json));
    let effects = json["effects"].as_array().expect("effects");
    let drag = effects.iter().find(|e| e["name"] == "quadratic_drag").expect("drag");
    let coefficient = drag["coefficients"]["drag_coefficient"]["value"].as_f64().expect("a drag coefficient");
    eprintln!("  drag coefficient {coefficient:.3}");
    assert!((0.3..=0.7).contains(&coefficient), "{drag:#}");
    // Flights differ by more than their noise, and the interval says so: two halves of them do not exclude each other.
    let warned = names(&json["warnings"], "code");
    assert!(warned.contains(&"intervals.widened".into()) && json["gap"]["of"] == "flights", "{warned:?}");
    let held_out = &json["gap"]["held_out"];
    let ratio = held_out["after"].as_f64().expect("held out") / held_out["before"].as_f64().expect("held out");
    assert!(ratio <= 0.5, "{held_out}");
}

/// One flight alone leaves a choice; what is written of it is one effect, with which tuning fits no worse than without.
#[test]
fn one_flight_cannot_tell() {
    let Some(all) = recorded::single_flights_diagnosed() else { return };
    for (file, answer) in all {
        let (name, (ran, written)) = (file.display(), answer.as_ref());
        eprintln!("{name}:");
        let json = judged(ran);
        assert!(json["verdict"] != "named", "{name} {}", short(&json));
        if json["verdict"] == "one_of" {
            let here = Folder::new();
            here.write("ball.toml", ball(0.02, Some(0.0027)));
            here.write("o.toml", written.as_ref().expect("a file with the best of them"));
            let gap = |sim: &str| {
                let tuned = here.run(&format!("tune --sim {sim} --observation {name} --json")).json();
                tuned["gap"]["after"].as_f64().expect("a gap")
            };
            let (with, without) = (gap("o.toml"), gap("ball.toml"));
            assert!(with < 1.05 * without, "{name}: {with} with, {without} without\n{}", short(&json));
        }
    }
    let Some(json) = flights(1) else { return };
    assert_eq!(json["verdict"], "one_of", "{}", short(&json));
    assert!(offers(&json, "quadratic_drag"), "{}", short(&json));
}

#[test]
fn heard_bounces_leave_two_explanations() {
    let Some(from) = measured("bounce-acoustic") else { return };
    let files = files(&from, "pingpong_0", ".csv");
    let here = Folder::new();
    here.write("ball.toml", ball(0.02, None));
    eprintln!("{} lists of bounces:", files.len());
    let json = run(here.command().args(["diagnose", "--sim", "ball.toml", "--observation"]).args(files));
    assert_eq!(names(&json["candidates"], ""), ["quadratic_drag", "speed_dependent_restitution"], "{}", short(&json));
    let held_out = &json["gap"]["held_out"];
    let ratio = held_out["after"].as_f64().expect("held out") / held_out["before"].as_f64().expect("held out");
    assert!(ratio <= 0.5, "{held_out}");
}

#[test]
fn a_basketball_in_a_picture_whose_pixels_are_not_square() {
    let Some(from) = measured("basketball-throw") else { return };
    let here = Folder::new();
    here.write("throw.csv", metres(&from.join("OUTPUT.csv"), 60.0, 23.37 / 0.12, 1.0));
    here.write("ball.toml", ball(0.747 / std::f64::consts::TAU, Some(0.5)));
    eprintln!("basketball:");
    let json = run(here.command().args(["diagnose", "--sim", "ball.toml", "--observation", "throw.csv"]));
    assert!(offers(&json, "aspect_ratio") || offers(&json, "length_scale"), "{}", short(&json));
}

/// No length is known in these pictures: gravity itself is the only scale, so lengths stay free.
#[test]
#[ignore = "not reached: `unknown`, nearest wind, magnus and perspective. All launches fly the same way, so that wind and a tilted \
            camera do what drag does, and nothing brings the held-out launch's 11.1 mm down to the noise, 2.3 mm"]
fn spinning_launches_show_drag() {
    let Some(from) = measured("pingpong-serve-px") else { return };
    let here = Folder::new();
    let mut names = Vec::new();
    for (i, file) in files(&from, "IMG", ".csv").iter().enumerate() {
        // From the mean apparent gravity of its README, 6200 px/s².
        let name = format!("launch_{i}.csv");
        here.write(&name, metres(file, 240.0, 6200.0 / 9.81, -1.0));
        names.push(name);
    }
    here.write("ball.toml", ball(0.02, Some(0.0027)));
    eprintln!("{} launches:", names.len());
    let json = run(here.command().args(["diagnose", "--sim", "ball.toml", "--observation"]).args(names));
    assert!(offers(&json, "quadratic_drag"), "{}", short(&json));
}
