//! A cart on a track that a motor pushes, with a pole that hangs from it (equations of motion: Lagrange's, of a rod with a bob).

use tunenet_core::simulator::Phase;

use super::plant::{Candidate, Encoder, Plant, Signal, Undeclared, Unknown, World};
use crate::runge_kutta::follow;
use crate::scene::GRAVITY_M_S2;

/// The pole is a uniform rod.
const ROD_KG: f64 = 0.2;
const LENGTH_M: f64 = 0.6;
/// Below these speeds dry friction fades.
const FADES_M_S: f64 = 0.05;
const FADES_RAD_S: f64 = 0.1;

pub static CART_POLE: Plant = Plant {
    name: "cart-pole",
    unknowns: &[
        Unknown::new("cart_mass", "kg", 1.5, (0.3, 5.0), (1.2, 2.2)),
        Unknown::new("bob_mass", "kg", 0.1, (0.01, 1.0), (0.1, 0.25)),
        Unknown::new("slide_damping", "N*s/m", 3.0, (0.0, 20.0), (2.5, 5.0)),
        Unknown::new("hinge_damping", "N*m*s", 0.01, (0.0, 0.3), (0.01, 0.03)),
        Unknown::new("slide_friction", "N", 0.2, (0.0, 5.0), (0.5, 1.2)),
    ],
    channels: &[("x", "m", 1e-3), ("theta", "rad", 2e-3)],
    inputs: &[Signal { name: "force", unit: "N", amplitudes: (1.5, 5.0), frequencies_hz: (0.2, 2.5) }],
    start: &[("theta", 1, (-0.8, 0.8))],
    candidates: [
        Candidate::new("motor_delay", Phase::Actuator, "s", 0.25, 5e-3),
        Candidate::new("motor_gain", Phase::Actuator, "1", 2.0, 0.05).factor(0.3),
        Candidate::new("force_bias", Phase::Actuator, "N", 10.0, 0.1).signed(),
        Candidate::new("dead_zone", Phase::Actuator, "N", 6.0, 0.1),
        Candidate::new("hinge_friction", Phase::Joint, "N*m", 0.5, 3e-3),
        Candidate::new("air_drag", Phase::Joint, "N*m*s2", 0.5, 2e-3),
        Candidate::new("track_tilt", Phase::Joint, "rad", 0.5, 0.01).signed(),
        Candidate::new("encoder_offset", Phase::Sensor, "rad", 0.8, 0.01).signed(),
        Candidate::new("backlash", Phase::Sensor, "rad", 0.8, 5e-3),
    ],
    seconds: 4.0,
    rate_hz: 100.0,
    step_s: 5e-3,
    simulate,
};

fn simulate(
    world: &World,
    force: &dyn Fn(usize, f64) -> f64,
    start: &[f64],
    clock: &[f64],
    step_s: f64,
    out: &mut [f64],
) {
    let e = world.effects;
    let slope = |t: f64, state: [f64; 4]| {
        let pushed = world.acted(force(0, t - e.delay_s), t) + world.shaken(t);
        let [x, _, v, w] = state;
        let [a, b] = acceleration(world, pushed + ripple_and_spring(world, x), state);
        [v, w, a, b]
    };
    let mut encoder = Encoder::new();
    follow([0.0, start[0] - e.offset, 0.0, 0.0], clock, step_s, slope, |i, _, [x, theta, ..]| {
        out[2 * i] = x;
        out[2 * i + 1] = encoder.read(theta, world);
    });
}

fn ripple_and_spring(world: &World, x: f64) -> f64 {
    world.size(Undeclared::Ripple) * (60.0 * x).sin() - world.size(Undeclared::Spring) * x
}

/// Of the cart, m/s², and of the pole, rad/s²; the angle is 0 where the pole hangs square to the track.
fn acceleration(world: &World, pushed_n: f64, [_, theta, v, w]: [f64; 4]) -> [f64; 2] {
    let &[cart, bob, slide_damping, hinge_damping, slide_friction] = world.unknowns else { return [f64::NAN; 2] };
    let e = world.effects;
    let mass = cart + ROD_KG + bob;
    let moment = (0.5 * ROD_KG + bob) * LENGTH_M;
    let inertia = (ROD_KG / 3.0 + bob) * LENGTH_M * LENGTH_M;
    let (sin, cos) = theta.sin_cos();
    // Gravity along the track and square to it.
    let (along, square) = (GRAVITY_M_S2 * e.tilt.sin(), GRAVITY_M_S2 * e.tilt.cos());
    let braked = slide_damping * v + slide_friction * (v / FADES_M_S).tanh();
    let force = pushed_n - braked + mass * along + moment * sin * w * w;
    let rubbed = hinge_damping * w + e.dry_friction * (w / FADES_RAD_S).tanh() + e.air_drag * w.abs() * w;
    let torque = moment * (along * cos - square * sin) - rubbed;
    let coupled = moment * cos;
    let determinant = mass * inertia - coupled * coupled;
    [(inertia * force - coupled * torque) / determinant, (mass * torque - coupled * force) / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without friction the energy is kept, on a track that is tilted as well.
    #[test]
    fn without_friction_the_energy_is_kept() {
        let mut effects = CART_POLE.absent();
        effects[6] = 0.1;
        let unknowns = [1.7, 0.16, 0.0, 0.0, 0.0];
        let world = World { unknowns: &unknowns, effects: effects.into(), undeclared: None };
        let energy = |[x, theta, v, w]: [f64; 4]| {
            let (sin, cos) = (0.1_f64.sin(), 0.1_f64.cos());
            let part = |mass: f64, s: f64| {
                let (along, down) = (x + s * theta.sin(), -s * theta.cos());
                let speed = [v + s * w * theta.cos(), s * w * theta.sin()];
                let height = -along * sin + down * cos;
                mass * (0.5 * (speed[0] * speed[0] + speed[1] * speed[1]) + GRAVITY_M_S2 * height)
            };
            // Simpson's rule is exact for the rod.
            let rod = (part(1.0, 0.0) + 4.0 * part(1.0, 0.5 * LENGTH_M) + part(1.0, LENGTH_M)) / 6.0;
            part(1.7, 0.0) + ROD_KG * rod + part(0.16, LENGTH_M)
        };
        let slope = |_: f64, state: [f64; 4]| {
            let [a, b] = acceleration(&world, 0.0, state);
            [state[2], state[3], a, b]
        };
        let start = [0.1, 0.9, -0.3, 1.5];
        let mut worst: f64 = 0.0;
        follow(start, &[0.3, 1.0, 2.0], 1e-3, slope, |_, _, state| {
            worst = worst.max((energy(state) - energy(start)).abs());
        });
        assert!(worst < 1e-7, "{worst}");
    }
}
