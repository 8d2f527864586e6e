//! A two-link arm in the plane that follows a reference by position control: angles and torques are seen.

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use tunenet_core::observation::{Channel, Circumstances, Hold, Input, Kind, Observation};
use tunenet_core::simulator::{FnSimulator, Parameter, Simulator};

use super::problem::{Problem, noisy};
use crate::runge_kutta::follow;
use crate::two_link::{TwoLinks, commanded};

const STEP_S: f64 = 2.5e-3;
const SECONDS: f64 = 5.0;
const RATE_HZ: f64 = 60.0;
const REFERENCE_HZ: f64 = 500.0;
/// Of both angles, rad, and both torques, N·m.
const NOISE: [f64; 4] = [5e-4, 5e-4, 0.1, 0.05];
/// Payload, viscous friction, Coulomb friction and armature of both joints.
const TRUTH: [f64; 7] = [1.3, 0.9, 0.35, 0.8, 0.3, 0.06, 0.02];

/// The arm with one recording.
pub fn problem(most_rollouts: usize, draw: &mut ChaCha8Rng) -> Result<Problem> {
    let simulator = simulator()?;
    let inputs = ["q1_reference", "q2_reference"].map(|name| reference(name, draw));
    let inputs = inputs.into_iter().collect::<Result<Vec<_>>>()?;
    let clock = even(RATE_HZ);
    let mut values = vec![0.0; 4 * clock.len()];
    simulate(TRUTH, |joint, t| inputs[joint].at(0, t), &clock, STEP_S / 2.0, &mut values);
    let seen = Observation::new(Kind::Other, simulator.channels().to_vec(), clock, values)?;
    let recordings = vec![noisy(&seen, &NOISE, draw)?.under(Circumstances::driven_by(inputs))];
    Ok(Problem { name: "two-link arm", simulator, recordings, noise: NOISE.to_vec(), most_rollouts })
}

fn even(rate_hz: f64) -> Vec<f64> {
    (0..u32::MAX).map(|i| f64::from(i) / rate_hz).take_while(|t| *t <= SECONDS).collect()
}

/// A sum of three sinusoids.
fn reference(name: &str, draw: &mut ChaCha8Rng) -> Result<Input> {
    let waves: [[f64; 3]; 3] = std::array::from_fn(|_| {
        [draw.random_range(0.1..0.5), draw.random_range(0.2..1.2), draw.random_range(0.0..TAU)]
    });
    let clock = even(REFERENCE_HZ);
    let values = clock.iter().map(|t| waves.iter().map(|[a, f, p]| a * (TAU * f * t + p).sin()).sum()).collect();
    Ok(Input::sampled(Channel::new(name, "rad"), Hold::Linear, clock, values)?)
}

fn simulator() -> Result<Box<dyn Simulator>> {
    let parameters = vec![
        Parameter::new("payload", "kg", 0.5, 0.0, 5.0)?,
        Parameter::new("viscous_1", "N*m*s", 0.5, 0.0, 5.0)?,
        Parameter::new("viscous_2", "N*m*s", 0.5, 0.0, 5.0)?,
        Parameter::new("coulomb_1", "N*m", 0.2, 0.0, 5.0)?,
        Parameter::new("coulomb_2", "N*m", 0.2, 0.0, 5.0)?,
        Parameter::new("armature_1", "kg*m2", 0.01, 0.0, 0.5)?,
        Parameter::new("armature_2", "kg*m2", 0.01, 0.0, 0.5)?,
    ];
    let channels =
        [("q1", "rad"), ("q2", "rad"), ("tau1", "N*m"), ("tau2", "N*m")].map(|(name, unit)| Channel::new(name, unit));
    Ok(Box::new(FnSimulator::new(parameters, channels.to_vec(), |p, run, clock, out| {
        let values: [f64; 7] = p.try_into().map_err(|_| format!("expected 7 numbers, found {}", p.len()))?;
        simulate(values, |joint, t| run.input(joint, t), clock, STEP_S, out);
        Ok(())
    })))
}

/// Writes angles and torques at each instant; at 0 s the arm rests at its reference.
fn simulate(values: [f64; 7], reference: impl Fn(usize, f64) -> f64, clock: &[f64], step_s: f64, out: &mut [f64]) {
    let [payload_kg, viscous_1, viscous_2, coulomb_1, coulomb_2, armature_1, armature_2] = values;
    let arm = TwoLinks {
        payload_kg,
        viscous: [viscous_1, viscous_2],
        coulomb: [coulomb_1, coulomb_2],
        armature: [armature_1, armature_2],
        ..TwoLinks::default()
    };
    let torque = |t: f64, q: [f64; 2], v: [f64; 2]| commanded([reference(0, t), reference(1, t)], q, v);
    let slope = |t: f64, [q1, q2, v1, v2]: [f64; 4]| {
        let [a1, a2] = arm.acceleration(torque(t, [q1, q2], [v1, v2]), [q1, q2], [v1, v2]);
        [v1, v2, a1, a2]
    };
    let start = [reference(0, 0.0), reference(1, 0.0), 0.0, 0.0];
    follow(start, clock, step_s, slope, |i, t, [q1, q2, v1, v2]| {
        let [t1, t2] = torque(t, [q1, q2], [v1, v2]);
        out[4 * i..4 * i + 4].copy_from_slice(&[q1, q2, t1, t2]);
    });
}
