//! A two-link arm in the plane that follows a reference by position control (equations of motion: Spong, Hutchinson and Vidyasagar
//! 2006, section 7.4): angles and torques are seen.

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use tunenet_core::observation::{Channel, Circumstances, Hold, Input, Kind, Observation};
use tunenet_core::simulator::{FnSimulator, Parameter, Simulator};

use super::problem::{Problem, noisy};
use super::runge_kutta::follow;
use crate::scene::GRAVITY_M_S2;

/// Lengths, m, and masses, kg, of the links; they are uniform rods, and the payload is a point at the tip.
const LENGTH_M: [f64; 2] = [0.4, 0.35];
const MASS_KG: [f64; 2] = [2.1, 1.2];
/// Gains of the controllers: N·m/rad, and N·m·s/rad.
const STIFFNESS: [f64; 2] = [150.0, 80.0];
const DAMPING: [f64; 2] = [8.0, 4.0];
/// Below this speed Coulomb friction fades, rad/s.
const FADES_RAD_S: f64 = 0.05;
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
    let torque = |t: f64, q: [f64; 2], v: [f64; 2]| -> [f64; 2] {
        std::array::from_fn(|i| STIFFNESS[i] * (reference(i, t) - q[i]) - DAMPING[i] * v[i])
    };
    let slope = |t: f64, [q1, q2, v1, v2]: [f64; 4]| {
        let [a1, a2] = acceleration(values, [q1, q2], [v1, v2], torque(t, [q1, q2], [v1, v2]));
        [v1, v2, a1, a2]
    };
    let start = [reference(0, 0.0), reference(1, 0.0), 0.0, 0.0];
    follow(start, clock, step_s, slope, |i, t, [q1, q2, v1, v2]| {
        let [t1, t2] = torque(t, [q1, q2], [v1, v2]);
        out[4 * i..4 * i + 4].copy_from_slice(&[q1, q2, t1, t2]);
    });
}

/// Angles are 0 where the arm hangs straight down.
fn acceleration(values: [f64; 7], q: [f64; 2], v: [f64; 2], torque: [f64; 2]) -> [f64; 2] {
    let [payload, viscous_1, viscous_2, coulomb_1, coulomb_2, armature_1, armature_2] = values;
    let ([l1, l2], [m1, m2]) = (LENGTH_M, MASS_KG);
    // Mass times length of what the second link carries, and its inertia about its joint.
    let (first, inertia) = (m2 * l2 / 2.0 + payload * l2, m2 * l2 * l2 / 3.0 + payload * l2 * l2);
    let (sin, cos) = q[1].sin_cos();
    let both = inertia + l1 * first * cos;
    let m11 = m1 * l1 * l1 / 3.0 + (m2 + payload) * l1 * l1 + 2.0 * l1 * first * cos + inertia + armature_1;
    let m22 = inertia + armature_2;
    let whirl = l1 * first * sin;
    let weight_2 = GRAVITY_M_S2 * first * (q[0] + q[1]).sin();
    let weight_1 = GRAVITY_M_S2 * (m1 / 2.0 + m2 + payload) * l1 * q[0].sin() + weight_2;
    let friction = |viscous: f64, coulomb: f64, v: f64| viscous * v + coulomb * (v / FADES_RAD_S).tanh();
    let r1 = torque[0] + whirl * (2.0 * v[0] * v[1] + v[1] * v[1]) - weight_1 - friction(viscous_1, coulomb_1, v[0]);
    let r2 = torque[1] - whirl * v[0] * v[0] - weight_2 - friction(viscous_2, coulomb_2, v[1]);
    let determinant = m11 * m22 - both * both;
    [(m22 * r1 - both * r2) / determinant, (m11 * r2 - both * r1) / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kinetic and potential energy from the speeds of the points of both rods.
    fn energy(payload: f64, [q1, q2, v1, v2]: [f64; 4]) -> f64 {
        let ([l1, l2], [m1, m2]) = (LENGTH_M, MASS_KG);
        let point = |mass: f64, a: f64, b: f64| {
            let (q, v) = (q1 + q2, v1 + v2);
            let (x, z) = (a * v1 * q1.cos() + b * v * q.cos(), a * v1 * q1.sin() + b * v * q.sin());
            mass * (0.5 * (x * x + z * z) - GRAVITY_M_S2 * (a * q1.cos() + b * q.cos()))
        };
        let rod = |mass: f64, a: [f64; 2], b: [f64; 2]| {
            // Simpson's rule is exact for squares.
            let at = |s: f64| point(1.0, a[0] + s * a[1], b[0] + s * b[1]);
            mass * (at(0.0) + 4.0 * at(0.5) + at(1.0)) / 6.0
        };
        rod(m1, [0.0, l1], [0.0, 0.0]) + rod(m2, [l1, 0.0], [0.0, l2]) + point(payload, l1, l2)
    }

    #[test]
    fn an_arm_without_friction_keeps_its_energy() {
        let values = [1.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let slope = |_: f64, [q1, q2, v1, v2]: [f64; 4]| {
            let [a1, a2] = acceleration(values, [q1, q2], [v1, v2], [0.0; 2]);
            [v1, v2, a1, a2]
        };
        let start = [1.2, -0.7, 0.4, 2.0];
        let before = energy(1.3, start);
        let mut worst: f64 = 0.0;
        follow(start, &[0.5, 1.0, 2.0], 5e-4, slope, |_, _, state| {
            worst = worst.max((energy(1.3, state) - before).abs());
        });
        assert!(worst < 1e-6, "{worst} J of {before} J");
    }
}
