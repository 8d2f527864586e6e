//! Drops made by an integrator of fixed steps that finds contacts up to a step late: nothing here describes its contacts, so
//! only flights, judged apart, can tell what acts in the air.

use std::path::Path;

use tunenet_ball::diagnose;
use tunenet_core::diagnose::{Diagnosis, Recording, Settings, Subject, Verdict};
use tunenet_core::observation::{Kind, Observation};
use tunenet_sim::{Session, SimulationFile, simulator};

const STEP_S: f64 = 1.0 / 60.0;
const GRAVITY_M_S2: f64 = 9.81;
const SCENE: &str = "\
kind = \"ball\"
ball.radius_m = 0.5
surface.height_m = 0.0
parameters.restitution = { value = 0.5, min = 0.0, max = 1.0 }
";

/// A drop with quadratic drag, semi-implicit: velocity first, then position, then the contact wherever that led.
fn drop(height_m: f64, restitution: f64, drag_1_m: f64) -> Observation {
    let (mut z, mut v) = (height_m, 0.0f64);
    let mut rows = Vec::new();
    for _ in 0..200 {
        rows.push([0.0, 0.0, (z * 1e6).round() * 1e-6]);
        v -= (GRAVITY_M_S2 + drag_1_m * v * v.abs()) * STEP_S;
        z += v * STEP_S;
        if z < 0.5 && v < 0.0 {
            v *= -restitution;
        }
    }
    let clock = (0..200).map(|k| f64::from(k) * STEP_S).collect();
    Observation::positions(clock, &rows).unwrap()
}

fn diagnosed(drags_1_m: [f64; 3]) -> Diagnosis {
    let file = SimulationFile::parse(Path::new("ball.toml"), SCENE).unwrap();
    let simulator = simulator(&file, Kind::Positions, &Session::default()).unwrap();
    let drops = [(4.4, 0.6), (4.9, 0.7), (4.1, 0.65)];
    let seen: Vec<Observation> = drops.iter().zip(drags_1_m).map(|((h, e), c)| drop(*h, *e, c)).collect();
    let subjects: Vec<Subject> =
        (0..3).map(|i| Subject { name: format!("ball {i}"), simulator: simulator.as_ref() }).collect();
    let recordings: Vec<Recording> = seen
        .iter()
        .enumerate()
        .map(|(object, seen)| Recording { name: format!("drop {object}"), object, held_out: false, seen })
        .collect();
    diagnose(&subjects, &recordings, &Settings::default(), &|_| {}).unwrap()
}

#[test]
fn drag_is_found_with_its_size_although_contacts_are_not_understood() {
    let truth = [0.09, 0.03, 0.05];
    let found = diagnosed(truth);
    // Each ball was dropped once, so that beside what the contacts lack a lone name is not earned.
    assert!(matches!(found.verdict(), Verdict::Named | Verdict::OneOf), "{:?}: {:?}", found.verdict(), found.names());
    assert_eq!(found.names().first(), Some(&"quadratic_drag"));
    let drag = found.effects().iter().find(|e| e.effect.name == "quadratic_drag").expect("drag");
    for (value, truth) in drag.coefficients[0].values.iter().zip(truth) {
        // Steps of 1/60 s themselves are good for a few percent of a drag.
        assert!((value.value / truth - 1.0).abs() < 0.05, "{} of {truth}", value.value);
    }
}

#[test]
fn nothing_in_flight_is_named_where_nothing_acts() {
    let found = diagnosed([0.0; 3]);
    assert!(
        found.effects().iter().all(|e| e.effect.phase == tunenet_core::simulator::Phase::Event),
        "{:?}",
        found.names()
    );
    assert_ne!(found.verdict(), Verdict::None);
}
