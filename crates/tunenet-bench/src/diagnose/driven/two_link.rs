//! A two-link arm in the plane that follows a reference by position control: angles and torques are seen.

use tunenet_core::simulator::Phase;

use super::plant::{Candidate, Encoder, Plant, Signal, Undeclared, Unknown, World};
use crate::runge_kutta::follow;
use crate::two_link::{TwoLinks, commanded};

const fn reference(name: &'static str) -> Signal {
    Signal { name, unit: "rad", amplitudes: (0.1, 0.4), frequencies_hz: (0.2, 1.2) }
}

pub static TWO_LINK: Plant = Plant {
    name: "two-link arm",
    unknowns: &[
        Unknown::new("payload", "kg", 0.5, (0.0, 5.0), (0.6, 1.6)),
        Unknown::new("viscous_1", "N*m*s", 0.5, (0.0, 5.0), (0.4, 1.2)),
        Unknown::new("viscous_2", "N*m*s", 0.5, (0.0, 5.0), (0.2, 0.6)),
        Unknown::new("coulomb_1", "N*m", 0.2, (0.0, 5.0), (0.4, 1.0)),
        Unknown::new("armature_1", "kg*m2", 0.01, (0.0, 0.5), (0.03, 0.09)),
    ],
    channels: &[("q1", "rad", 5e-4), ("q2", "rad", 5e-4), ("tau1", "N*m", 0.1), ("tau2", "N*m", 0.05)],
    inputs: &[reference("q1_reference"), reference("q2_reference")],
    start: &[],
    candidates: [
        Candidate::new("command_delay", Phase::Actuator, "s", 0.25, 2e-3),
        Candidate::new("motor_gain", Phase::Actuator, "1", 3.0, 0.05).factor(0.2),
        Candidate::new("torque_bias", Phase::Actuator, "N*m", 60.0, 0.1).signed(),
        Candidate::new("dead_zone", Phase::Actuator, "N*m", 60.0, 0.1),
        Candidate::new("elbow_friction", Phase::Joint, "N*m", 40.0, 0.05),
        Candidate::new("air_drag", Phase::Joint, "N*m*s2", 20.0, 0.05),
        Candidate::new("base_tilt", Phase::Joint, "rad", 1.0, 0.01).signed(),
        Candidate::new("encoder_offset", Phase::Sensor, "rad", 0.5, 1e-3).signed(),
        Candidate::new("backlash", Phase::Sensor, "rad", 0.5, 1e-3),
    ],
    seconds: 4.0,
    rate_hz: 60.0,
    step_s: 5e-3,
    simulate,
};

fn simulate(
    world: &World,
    reference: &dyn Fn(usize, f64) -> f64,
    _: &[f64],
    clock: &[f64],
    step_s: f64,
    out: &mut [f64],
) {
    let &[payload_kg, viscous_1, viscous_2, coulomb_1, armature_1] = world.unknowns else { return out.fill(f64::NAN) };
    let e = world.effects;
    let arm = TwoLinks {
        payload_kg,
        viscous: [viscous_1, viscous_2],
        coulomb: [coulomb_1, e.dry_friction],
        armature: [armature_1, 0.0],
        drag: e.air_drag,
        tilt: e.tilt,
    };
    let torque =
        |t: f64, q: [f64; 2], v: [f64; 2]| commanded([0, 1].map(|joint| reference(joint, t - e.delay_s)), q, v);
    let slope = |t: f64, [q1, q2, v1, v2]: [f64; 4]| {
        let [t1, t2] = torque(t, [q1, q2], [v1, v2]);
        let t1 = world.acted(t1, t) + world.shaken(t) + world.size(Undeclared::Ripple) * (11.0 * q1).sin();
        let t2 = t2 - world.size(Undeclared::Spring) * q2;
        let [a1, a2] = arm.acceleration([t1, t2], [q1, q2], [v1, v2]);
        [v1, v2, a1, a2]
    };
    let mut encoder = Encoder::new();
    let start = [reference(0, 0.0), reference(1, 0.0), 0.0, 0.0];
    follow(start, clock, step_s, slope, |i, t, [q1, q2, v1, v2]| {
        let [t1, t2] = torque(t, [q1, q2], [v1, v2]);
        out[4 * i..4 * i + 4].copy_from_slice(&[q1, encoder.read(q2, world), t1, t2]);
    });
}
