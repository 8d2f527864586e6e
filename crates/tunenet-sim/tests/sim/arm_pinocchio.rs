//! Kinematics and inverse dynamics against Pinocchio's figures for the same URDF (fixtures/arm, with their script).

use nalgebra::{Matrix6xX, Vector3};
use serde_json::Value;
use tunenet_sim::arm::{Inertia, Kinematics, Model, PAYLOAD_NUMBERS, Recursion, gravity, payload_numbers, urdf};

const GRAVITY: f64 = 9.81;

fn arm() -> Model {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/jaco_robotiq.urdf");
    urdf::read(&path).unwrap().chain_to("grip").unwrap()
}

fn figures() -> Value {
    serde_json::from_str(include_str!("../fixtures/arm/pinocchio.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn apart(ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn validate_inverse_dynamics_against_pinocchio() {
    let (arm, figures) = (arm(), figures());
    let edge = figures["payload_edge_m"].as_f64().unwrap();
    let (mut kinds, mut worst) = (std::collections::BTreeMap::new(), 0.0_f64);
    for state in figures["states"].as_array().unwrap() {
        *kinds.entry(state["kind"].as_str().unwrap()).or_insert(0) += 1;
        let [q, dq, ddq] = ["q", "dq", "ddq"].map(|key| numbers(&state[key]));
        for (mass, torque) in state["torque_nm"].as_object().unwrap() {
            let load = Inertia::cube(mass.parse().unwrap(), Vector3::zeros(), edge);
            let loaded = arm.loaded(arm.frame("grip").unwrap(), &load);
            let mut ours = [0.0; 7];
            Recursion::new(&loaded, gravity(GRAVITY)).inverse_dynamics(&q, &dq, &ddq, &mut ours);
            worst = worst.max(apart(&ours, &numbers(torque)));
        }
    }
    assert!(kinds["circle"] > 10 && kinds["random"] > 10 && kinds["static"] > 5, "{kinds:?}");
    println!("torques within {worst:.1e} N·m of Pinocchio's");
    assert!(worst <= 1e-9, "{worst:e} N·m");
}

#[test]
fn validate_kinematics_against_pinocchio() {
    let (arm, figures) = (arm(), figures());
    let grip = arm.frame("grip").unwrap();
    let (mut at, mut jacobian) = (Kinematics::new(&arm), Matrix6xX::zeros(arm.degrees()));
    for state in figures["states"].as_array().unwrap() {
        at.update(&numbers(&state["q"]));
        let pose = at.frame(grip);
        let turned = pose.rotation.matrix().transpose();
        assert!(apart(pose.translation.vector.as_slice(), &numbers(&state["grip_position_m"])) < 1e-12);
        assert!(apart(turned.as_slice(), &numbers(&state["grip_rotation"])) < 1e-12);
        at.jacobian(grip, &mut jacobian);
        assert!(apart(jacobian.transpose().as_slice(), &numbers(&state["grip_jacobian"])) < 1e-12);
    }
}

/// Torques are linear in the ten numbers of a load, whatever its shape and place.
#[test]
fn the_regressor_adds_what_a_load_adds() {
    let (arm, figures) = (arm(), figures());
    let grip = arm.frame("grip").unwrap();
    let load =
        Inertia::cube(1.3, Vector3::new(0.03, -0.05, 0.11), 0.08).with(&Inertia::cube(0.4, Vector3::x() * 0.2, 0.0));
    let loaded = arm.loaded(grip, &load);
    let (mut bare, mut heavy) = (Recursion::new(&arm, gravity(GRAVITY)), Recursion::new(&loaded, gravity(GRAVITY)));
    let (mut without, mut with) = ([0.0; 7], [0.0; 7]);
    let mut regressor = [0.0; 7 * PAYLOAD_NUMBERS];
    for state in figures["states"].as_array().unwrap() {
        let [q, dq, ddq] = ["q", "dq", "ddq"].map(|key| numbers(&state[key]));
        bare.inverse_dynamics(&q, &dq, &ddq, &mut without);
        bare.payload_regressor(grip, &mut regressor);
        heavy.inverse_dynamics(&q, &dq, &ddq, &mut with);
        for joint in 0..7 {
            let row = &regressor[joint * PAYLOAD_NUMBERS..(joint + 1) * PAYLOAD_NUMBERS];
            let added: f64 = row.iter().zip(payload_numbers(&load)).map(|(y, n)| y * n).sum();
            assert!((without[joint] + added - with[joint]).abs() < 1e-9, "joint {}", joint + 1);
        }
    }
}
