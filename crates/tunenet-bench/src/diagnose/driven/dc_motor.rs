//! A brushed motor under voltage that turns a flywheel of known inertia (its two equations: voltage and torque balance).

use tunenet_core::simulator::Phase;

use super::plant::{Candidate, Encoder, Plant, Signal, Undeclared, Unknown, World};
use crate::runge_kutta::follow;

const INERTIA_KG_M2: f64 = 6e-4;
/// Below this speed dry friction fades, rad/s.
const FADES_RAD_S: f64 = 0.5;

pub static DC_MOTOR: Plant = Plant {
    name: "DC motor",
    unknowns: &[
        Unknown::new("resistance", "ohm", 1.0, (0.2, 5.0), (1.2, 2.0)),
        Unknown::new("torque_constant", "N*m/A", 0.1, (0.01, 0.5), (0.06, 0.09)),
        Unknown::new("damping", "N*m*s", 1e-3, (0.0, 0.05), (5e-4, 2e-3)),
        Unknown::new("inductance", "H", 0.01, (8e-3, 0.2), (0.015, 0.03)),
    ],
    channels: &[("angle", "rad", 0.02), ("current", "A", 0.02)],
    inputs: &[Signal { name: "voltage", unit: "V", amplitudes: (1.0, 4.0), frequencies_hz: (0.2, 4.0) }],
    start: &[],
    candidates: [
        Candidate::new("amplifier_delay", Phase::Actuator, "s", 0.25, 2e-3),
        Candidate::new("amplifier_gain", Phase::Actuator, "1", 3.0, 0.05).factor(0.2),
        Candidate::new("voltage_bias", Phase::Actuator, "V", 10.0, 0.05).signed(),
        Candidate::new("dead_zone", Phase::Actuator, "V", 6.0, 0.1),
        Candidate::new("dry_friction", Phase::Joint, "N*m", 0.5, 2e-3),
        Candidate::new("fan_load", Phase::Joint, "N*m*s2", 1e-2, 1e-6),
        Candidate::new("imbalance", Phase::Joint, "N*m", 2.0, 2e-3).signed(),
        Candidate::new("current_offset", Phase::Sensor, "A", 5.0, 0.01).signed(),
        Candidate::new("backlash", Phase::Sensor, "rad", 5.0, 0.05),
    ],
    seconds: 3.0,
    rate_hz: 100.0,
    step_s: 2.5e-3,
    simulate,
};

fn simulate(
    world: &World,
    voltage: &dyn Fn(usize, f64) -> f64,
    _: &[f64],
    clock: &[f64],
    step_s: f64,
    out: &mut [f64],
) {
    let &[resistance, constant, damping, inductance] = world.unknowns else { return out.fill(f64::NAN) };
    let e = world.effects;
    let slope = |t: f64, [angle, speed, current]: [f64; 3]| {
        let volts = world.acted(voltage(0, t - e.delay_s), t) + world.shaken(t);
        let rubbed = damping * speed + e.dry_friction * (speed / FADES_RAD_S).tanh() + e.air_drag * speed.abs() * speed;
        let turned = e.tilt * angle.sin()
            + world.size(Undeclared::Ripple) * (7.0 * angle).sin()
            + world.size(Undeclared::Spring) * angle;
        let spun_up = (constant * current - rubbed - turned) / INERTIA_KG_M2;
        [speed, spun_up, (volts - resistance * current - constant * speed) / inductance]
    };
    // The offset is that of the current; the encoder of the angle has none.
    let angle_only = World { effects: super::plant::Coefficients { offset: 0.0, ..e }, ..*world };
    let mut encoder = Encoder::new();
    follow([0.0; 3], clock, step_s, slope, |i, _, [angle, _, current]| {
        out[2 * i] = encoder.read(angle, &angle_only);
        out[2 * i + 1] = current + e.offset;
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under constant voltage it ends at the speed and the current at which both balances are 0.
    #[test]
    fn under_constant_voltage_it_reaches_its_speed() {
        let unknowns = [1.5, 0.07, 1e-3, 0.02];
        let world = World { unknowns: &unknowns, effects: DC_MOTOR.absent().into(), undeclared: None };
        let mut out = [0.0; 6];
        simulate(&world, &|_, _| 6.0, &[], &[0.0, 9.0, 10.0], 2.5e-3, &mut out);
        let speed = 6.0 * 0.07 / (0.07 * 0.07 + 1.5 * 1e-3);
        assert!((out[4] - out[2] - speed).abs() < 1e-6 * speed, "{out:?} {speed}");
        assert!((out[5] - 1e-3 * speed / 0.07).abs() < 1e-6, "{out:?}");
    }
}
