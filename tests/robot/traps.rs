//! What a search for effects of a joint is misled by: local minima, switches inside a step, rich forms before plain ones, and a fit
//! that other gains and loads do not bear out.

use serde_json::Value;

use super::folder;
use super::truth::{NONE, Truth, recorded, simulation};

/// Near the truth, and where the fit leads into the other basin of both frictions: hardly any dry friction and four times the viscous.
const NEAR: [f64; 6] = [6.0, 1.2, 0.02, 0.12, 0.022, 0.0];
const OTHER_BASIN: [f64; 6] = [7.0, 1.0, 0.08, 0.01, 0.03, 0.0];

/// The answer to runs of `truth`, with masses as `stated`, from these starts of the parameters.
fn answer(truth: &Truth, starts: [f64; 6], stated: impl Fn(usize, f64) -> f64) -> Value {
    let folder = folder();
    recorded(&folder, truth, stated);
    simulation(&folder, starts);
    folder.run("diagnose --sim servo.toml --manifest runs.toml --json").json()
}

fn as_stated(_: usize, mass: f64) -> f64 {
    mass
}

/// Each effect of the answer with what could be in its place.
fn places(answer: &Value) -> Vec<Vec<String>> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let place = |effect: &Value| {
        let others = effect["alternatives"].as_array().unwrap().iter().map(text);
        std::iter::once(text(&effect["name"])).chain(others).collect()
    };
    answer["effects"].as_array().unwrap().iter().map(place).collect()
}

#[test]
fn a_local_minimum_of_the_frictions_earns_no_name() {
    for starts in [OTHER_BASIN, NEAR] {
        let answer = answer(&NONE, starts, as_stated);
        assert!(places(&answer).is_empty(), "{answer:#}");
        let value = |name: &str| {
            let found = answer["parameters"].as_array().unwrap().iter().find(|one| one["name"] == name).unwrap();
            found["value"].as_f64().unwrap()
        };
        let (dry, viscous) = (value("hinge__coulomb"), value("hinge__viscous"));
        assert!((dry - 0.13).abs() < 0.02 && viscous < 0.05, "{dry} {viscous}");
    }
}

#[test]
fn friction_by_the_load_is_no_richer_friction() {
    let answer = answer(&Truth { mu: 0.15, ..NONE }, NEAR, as_stated);
    let places = places(&answer);
    assert!(places.len() == 1 && places[0].iter().any(|name| name == "load_friction"), "{answer:#}");
}

/// A mass that is stated wrong in the runs that are fitted looks like an effect there, and not in those that are held out.
#[test]
fn what_other_loads_do_not_bear_out_is_no_name() {
    let answer = answer(&NONE, NEAR, |number, mass| if number == 2 { 1.35 * mass } else { mass });
    let alone: Vec<Vec<String>> = places(&answer).into_iter().filter(|place| place.len() == 1).collect();
    assert!(alone.is_empty() || !answer["doubt"].is_null(), "{answer:#}");
}

#[test]
fn twins_are_named_together_and_no_recording_is_asked_for() {
    let late = answer(&Truth { command_delay: 0.03, ..NONE }, NEAR, as_stated);
    let mut names = places(&late).concat();
    names.sort_unstable();
    assert_eq!(names, ["command_delay", "time_delay"], "{late:#}");
    let next = late["next_experiment"]["text"].as_str().unwrap();
    for part in ["no recording of these channels distinguishes", "released", "two clocks"] {
        assert!(next.contains(part), "{next}");
    }
    let strong = answer(&Truth { gain: 2.5, ..NONE }, NEAR, as_stated);
    let names = places(&strong).concat();
    for name in ["firmware_gain", "duty_limit"] {
        assert!(names.iter().any(|known| known == name), "{strong:#}");
    }
    let next = strong["next_experiment"]["text"].as_str().unwrap();
    assert!(next.contains("data sheet"), "{next}");
}

/// Delays are continuous: a release that is late by less than a step of the integration counts.
#[test]
fn a_late_release_is_found_although_it_lies_inside_a_step() {
    let answer = answer(&Truth { release_delay: 0.0437, ..NONE }, NEAR, as_stated);
    let place = places(&answer).into_iter().find(|place| place.iter().any(|name| name == "release_delay"));
    assert!(place.is_some(), "{answer:#}");
    let effects = answer["effects"].as_array().unwrap();
    if let Some(found) = effects.iter().find(|effect| effect["name"] == "release_delay") {
        let delay = found["coefficients"]["s"]["value"].as_f64().unwrap();
        assert!((delay - 0.0437).abs() < 0.002, "{delay}");
    }
}
