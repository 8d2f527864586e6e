//! A payload weighed twice: what a calibration leaves open, runs the wrong way round, and answers that contradict themselves.

use crate::arm::pendulum::{self, Beside, SCENE, log, noise, plain};
use crate::common::{Folder, Ran};
use serde_json::Value;

/// A sensor that shows this many times the torque.
const GAIN: f64 = 1.1;

fn folder() -> Folder {
    let folder = pendulum::folder();
    folder.write(
        "arm.toml",
        format!("{SCENE}[parameters.torque_gain]\nvalue = 1.0\nmin = 0.1\nmax = 10.0\ntune = false\n"),
    );
    folder
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "numbers of samples, small and above 0")]
fn whole(value: f64) -> u32 {
    value.round() as u32
}

/// A log of a sensor with [`GAIN`], and with so many times the noise beside its own.
fn shown(payload_kg: f64, noisier: f64) -> String {
    log(Beside { payload_kg, ..Beside::default() }, |t, [q, dq, torque]| {
        let torque = GAIN * torque + noisier * noise(10_000 + whole(100.0 * t + 1000.0 * payload_kg));
        format!("{t:.3},{q:.9},{dq:.9},{torque:.9}")
    })
}

fn of(answer: &Value, name: &str) -> (f64, f64, f64) {
    let p = &answer["parameters"][name];
    let end = |i: usize| p["interval95"][i].as_f64().unwrap();
    (p["value"].as_f64().unwrap(), end(0), end(1))
}

/// The warning or check of this code.
fn said(answer: &Value, code: &str) -> String {
    let all = answer["warnings"].as_array().unwrap();
    all.iter().find(|w| w["code"] == code).unwrap_or_else(|| panic!("no {code} in {all:?}"))["text"]
        .as_str()
        .unwrap()
        .into()
}

fn state(answer: &Value, code: &str) -> String {
    let all = answer["preflight"][0].as_array().unwrap();
    all.iter().find(|c| c["code"] == code).unwrap_or_else(|| panic!("no {code} in {all:?}"))["state"]
        .as_str()
        .unwrap()
        .into()
}

fn calibrate(folder: &Folder) -> Value {
    folder.write("known.csv", shown(0.8, 40.0));
    folder.write("bare.csv", shown(0.0, 40.0));
    let line = "tune --sim arm.toml --set parameters.payload_mass.value=0.8 --set parameters.payload_mass.tune=false \
                --set parameters.torque_gain.tune=true --observation known.csv --reference bare.csv --out calibrated.toml --json";
    folder.run(line).json()
}

/// m = p / g with the product p that the run shows, so that at the low end of g it is m g / low.
#[test]
fn the_gain_that_was_calibrated_is_not_taken_as_exact() {
    let folder = folder();
    let (gain, low, high) = of(&calibrate(&folder), "torque_gain");
    assert!(low < GAIN && GAIN < high && (high - low) / gain > 0.01, "{gain} ({low} to {high})");
    folder.write("unknown.csv", shown(1.3, 0.0));
    folder.write("bare2.csv", shown(0.0, 1.0));
    let line = "tune --sim calibrated.toml --set parameters.torque_gain.tune=false --set parameters.payload_mass.tune=true \
                --observation unknown.csv --reference bare2.csv --json";
    let answer = folder.run(&format!("{line} --out weighed.toml")).json();
    let exact = folder.run(&format!("{line} --set parameters.torque_gain.value={gain}")).json();
    let ((mass, a, b), (same, c, d)) = (of(&answer, "payload_mass"), of(&exact, "payload_mass"));
    assert!((mass - same).abs() < 1e-9 && a < 1.3 && 1.3 < b, "{mass} ({a} to {b})");
    let expected = (0.5 * (d - c)).hypot(mass * gain / low - mass);
    assert!((0.5 * (b - a) / expected - 1.0).abs() < 0.01, "{} against {expected}", 0.5 * (b - a));
    assert!(0.5 * (d - c) < 0.5 * expected, "the calibration would not matter here");
    assert!(said(&answer, "parameter.carried").contains("`torque_gain`"));
    assert!(exact["warnings"].as_array().unwrap().iter().all(|w| w["code"] != "parameter.carried"));
    // A third weighing knows it still; and what the reference was stands beside its hash.
    let text = folder.text("weighed.toml");
    assert!(
        text.contains("torque_gain = [1.") && text.contains("reference = { file = \"bare2.csv\", sha256 = \""),
        "{text}"
    );
    let third = line.replace("calibrated", "weighed");
    assert!(said(&folder.run(&third).json(), "parameter.carried").contains("`torque_gain`"));
}

#[test]
fn mass_and_gain_together_are_doubted() {
    let folder = folder();
    folder.write("run.csv", shown(0.8, 0.0));
    let line = "tune --sim arm.toml --set parameters.torque_gain.tune=true --observation run.csv --json";
    let answer = folder.run(line).json();
    assert_eq!(state(&answer, "payload.gain"), "noticed");
    let text = said(&answer, "payload.gain");
    assert!(text.contains("only the link masses of the URDF") && text.contains("correlation -"), "{text}");
}

/// One gain from two known payloads, each of its own recording; a payload that only one of them knows is none that they share.
#[test]
fn recordings_of_one_arm_may_hold_payloads_of_different_known_mass() {
    let folder = folder();
    let entry = |name: &str, keys: &str| format!("[[observation]]\nfile = \"{name}.csv\"\n{keys}\n");
    for (name, payload_kg) in [("light", 0.8), ("heavy", 1.6)] {
        folder.write(&format!("{name}.csv"), shown(payload_kg, 1.0));
    }
    folder.write("known.toml", entry("light", "payload_mass_kg = 0.8") + &entry("heavy", "payload_mass_kg = 1.6"));
    let tune = "tune --sim arm.toml --set parameters.torque_gain.tune=true --manifest known.toml --json";
    let answer = folder.run(tune).ends(0).json();
    let (gain, low, high) = of(&answer, "torque_gain");
    assert!((gain - GAIN).abs() < 0.01 && low <= high, "{gain}");
    folder.write("half.toml", entry("light", "payload_mass_kg = 0.8") + &entry("heavy", ""));
    let half = tune.replace("known.toml", "half.toml");
    crate::common::refused(&folder, &half, &["the same `payload_mass` in every setup, 0.8", "another `object`"]);
}

/// What stands on which stream, without times.
fn streams(ran: &Ran) -> String {
    let seconds = |word: &str| word.ends_with("s,") && word[..word.len() - 2].parse::<f64>().is_ok();
    let line = |line: &str| line.split(' ').filter(|w| !seconds(w)).collect::<Vec<_>>().join(" ");
    let text = |all: &str| all.lines().filter(|l| !l.contains(" rollouts, ")).map(line).collect::<Vec<_>>().join("\n");
    format!("-- standard output\n{}\n-- standard error\n{}", text(&ran.stdout), text(&ran.stderr))
}

#[test]
fn runs_the_wrong_way_round_and_turned_signs_are_told() {
    let folder = folder();
    folder.write("held.csv", shown(0.8, 0.0));
    folder.write("bare.csv", shown(0.0, 1.0));
    let swapped = folder.run("tune --sim arm.toml --observation bare.csv --reference held.csv").ends(3);
    insta::assert_snapshot!("arm_swapped", streams(&swapped));
    let turned = log(Beside { payload_kg: 0.8, ..Beside::default() }, |t, [q, dq, torque]| {
        format!("{t:.3},{q:.9},{dq:.9},{:.9}", -torque)
    });
    folder.write("turned.csv", turned);
    let turned = folder.run("tune --sim arm.toml --observation turned.csv").ends(3);
    insta::assert_snapshot!("arm_turned", streams(&turned));
    let right = folder.run("tune --sim arm.toml --observation held.csv --reference bare.csv --json").json();
    assert_eq!([state(&right, "joints.signs"), state(&right, "reference.swapped")], ["passed", "passed"]);
}

/// 0.8 kg that hang 0.4 m away would be thinner than foam; 4 kg may.
#[test]
fn a_payload_where_none_can_be_is_doubted() {
    let folder = folder();
    for (name, payload_kg) in [("light", 0.8), ("heavier", 1.2), ("heavy", 4.0)] {
        folder.write(&format!("{name}.csv"), log(Beside { payload_kg, ..Beside::default() }, plain));
    }
    let tune = |sim: &str, name: &str, kg: f64| {
        let fixed = format!("--set parameters.payload_mass.value={kg} --set parameters.payload_mass.tune=false");
        let place = "--set parameters.payload_com_z.tune=true --out tuned.toml --overwrite --json";
        folder.run(&format!("tune --sim {sim} --observation {name}.csv {fixed} {place}")).json()
    };
    assert_eq!(state(&tune("arm.toml", "heavy", 4.0), "payload.place"), "passed");
    let light = tune("arm.toml", "light", 0.8);
    assert_eq!(state(&light, "payload.place"), "noticed");
    assert!(
        said(&light, "payload.place").contains("0.400 m from its link, which is implausible for a payload of 0.800 kg"),
        "{light}"
    );
    folder.write("first.toml", folder.read("tuned.toml"));
    assert_eq!(state(&tune("first.toml", "light", 0.8), "payload.moved"), "passed");
    let moved = tune("first.toml", "heavier", 0.8);
    assert!(said(&moved, "payload.moved").contains("`payload_com_z`"), "{moved}");
}
