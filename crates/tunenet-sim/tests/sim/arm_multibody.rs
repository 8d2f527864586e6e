//! Rapier's arm against inverse dynamics, which Pinocchio's figures judge in `arm_pinocchio.rs`.

use nalgebra::Vector3;
use tunenet_sim::arm::{Circle, ComputedTorque, Inertia, Model, Motion, Multibody, Recursion, gravity, urdf};

const GRAVITY: f64 = 9.81;
const STIFFNESS: f64 = 2500.0;

fn arm(mass_kg: f64) -> Model {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/jaco_robotiq.urdf");
    let arm = urdf::read(&path).unwrap().chain_to("grip").unwrap().weighed().unwrap();
    let load = Inertia::cube(mass_kg, Vector3::zeros(), 0.05);
    arm.loaded(arm.frame("grip").unwrap(), &load)
}

#[test]
fn validate_that_torques_of_inverse_dynamics_hold_the_arm_still() {
    let arm = arm(1.0);
    for q in [[3.5, 2.4, -3.0, 1.3, -0.2, 3.7, 2.2], [0.4, 3.9, 1.0, 4.4, 2.0, 2.0, -1.0]] {
        let mut hold = [0.0; 7];
        Recursion::new(&arm, gravity(GRAVITY)).inverse_dynamics(&q, &[0.0; 7], &[0.0; 7], &mut hold);
        let mut rapier = Multibody::new(&arm, gravity(GRAVITY), 1.0 / 240.0, &q, &[0.0; 7]).unwrap();
        let (mut now, mut speed) = ([0.0; 7], [0.0; 7]);
        for _ in 0..240 {
            rapier.step(&hold);
        }
        rapier.state(&mut now, &mut speed);
        let drift = speed.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        println!("after 1 s: {drift:.1e} rad/s");
        assert!(drift <= 1e-9, "{drift:e} rad/s");
        assert!(now.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}

/// Relative RMS between what the controller asks for and what the motion that came out needs, and the torques.
fn circle(mass_kg: f64, believed_kg: f64, rate_hz: u32, from_s: f64) -> (f64, Vec<[f64; 7]>) {
    let (arm, believed) = (arm(mass_kg), arm(believed_kg));
    let motion = Motion::circle(&believed, believed.frame("grip").unwrap(), &Circle::default()).unwrap();
    let (mut q, mut dq, mut wanted) = ([0.0; 7], [0.0; 7], ([0.0; 7], [0.0; 7], [0.0; 7]));
    motion.at(0.0, &mut q, &mut dq, &mut wanted.2);
    let mut rapier = Multibody::new(&arm, gravity(GRAVITY), 1.0 / f64::from(rate_hz), &q, &dq).unwrap();
    let mut controller = ComputedTorque::new(&believed, gravity(GRAVITY), STIFFNESS);
    let mut needed = Recursion::new(&arm, gravity(GRAVITY));
    let (mut torques, mut off, mut size) = (Vec::new(), 0.0, 0.0);
    for i in 0..5 * rate_hz {
        let time_s = f64::from(i) / f64::from(rate_hz);
        motion.at(time_s, &mut wanted.0, &mut wanted.1, &mut wanted.2);
        let mut torque = [0.0; 7];
        controller.torque((&q, &dq), (&wanted.0, &wanted.1, &wanted.2), &mut torque);
        rapier.step(&torque);
        let (before, mut exact) = ((q, dq), [0.0; 7]);
        rapier.state(&mut q, &mut dq);
        let ddq: Vec<f64> = dq.iter().zip(before.1).map(|(v, last)| (v - last) * f64::from(rate_hz)).collect();
        needed.inverse_dynamics(&before.0, &before.1, &ddq, &mut exact);
        if time_s > from_s {
            off += torque.iter().zip(exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            size += exact.iter().map(|t| t * t).sum::<f64>();
        }
        torques.push(torque);
    }
    ((off / size).sqrt(), torques)
}

#[test]
fn validate_the_torque_of_the_circle_with_the_true_model() {
    for mass in [0.0, 1.0, 2.0] {
        let (off, torques) = circle(mass, mass, 240, 0.0);
        let peak = torques.iter().map(|t| t[1].abs()).fold(0.0, f64::max);
        println!("{mass} kg: {off:.1e} relative RMS, joint 2 at most {peak:.1} N·m");
        assert!(off <= 5e-4, "{mass} kg: {off:e}");
    }
}

#[test]
fn validate_the_torque_of_a_controller_that_does_not_know_the_payload() {
    for mass in [0.5, 2.0] {
        let (off, torques) = circle(mass, 0.0, 240, 0.5);
        println!("{mass} kg, unknown: {off:.1e} relative RMS");
        assert!(off <= 1e-2, "{mass} kg: {off:e}");
        assert_eq!(circle(mass, 0.0, 240, 0.5).1, torques, "the same bits");
    }
}
