//! A driven cart on a track that may slope, with dry friction.

use std::sync::Arc;

use anyhow::{Context as _, Result};
use rand_chacha::ChaCha8Rng;
use tunenet_core::observation::{Channel, Circumstances, Observation};
use tunenet_core::simulator::{FnSimulator, Parameter, Simulator};
use tunenet_core::testing::PushedCart;

use super::problem::{Problem, noisy};
use crate::runge_kutta::follow;
use crate::scene::GRAVITY_M_S2;

const NOISE_M: f64 = 1e-3;
const STEP_S: f64 = 5e-3;
/// Below this speed dry friction fades, m/s.
const FADES_M_S: f64 = 0.05;
/// Mass, damping, stiffness, dry friction, slope.
const TRUTH: [f64; 5] = [1.2, 1.8, 3.0, 0.6, 0.02];

/// The cart with `count` recordings.
pub fn problem(count: usize, most_rollouts: usize, draw: &mut ChaCha8Rng, seed: u64) -> Result<Problem> {
    let [mass_kg, damping_ns_m, stiffness_n_m, ..] = TRUTH;
    // Forces and instants are those of carts without friction; what is seen follows from the equation here.
    let carts = PushedCart { mass_kg, damping_ns_m, delay_s: 0.0, stiffness_n_m }.recordings(count, 0.0, seed)?;
    let recordings = carts.iter().map(|cart| {
        let circumstances = cart.circumstances().context("a pushed cart has a force")?;
        let mut values = vec![0.0; cart.len()];
        positions(TRUTH, |t| circumstances.inputs[0].at(0, t), cart.clock(), STEP_S / 2.0, &mut values);
        let seen = Observation::new(cart.kind(), cart.channels().to_vec(), cart.clock().to_vec(), values)?;
        Ok(noisy(&seen, &[NOISE_M], draw)?.under(Arc::<Circumstances>::clone(circumstances)))
    });
    let recordings = recordings.collect::<Result<Vec<_>>>()?;
    Ok(Problem { name: "driven cart", simulator: simulator()?, recordings, noise: vec![NOISE_M], most_rollouts })
}

fn simulator() -> Result<Box<dyn Simulator>> {
    let parameters = vec![
        Parameter::new("mass", "kg", 2.0, 0.3, 5.0)?,
        Parameter::new("damping", "N*s/m", 3.0, 0.0, 20.0)?,
        Parameter::new("stiffness", "N/m", 1.0, 0.0, 30.0)?,
        Parameter::new("dry_friction", "N", 0.2, 0.0, 5.0)?,
        Parameter::new("slope", "rad", 0.0, -0.2, 0.2)?,
    ];
    Ok(Box::new(FnSimulator::new(parameters, vec![Channel::new("x", "m")], |p, run, clock, out| {
        let values: [f64; 5] = p.try_into().map_err(|_| format!("expected 5 numbers, found {}", p.len()))?;
        positions(values, |t| run.input(0, t), clock, STEP_S, out);
        Ok(())
    })))
}

fn positions(values: [f64; 5], force: impl Fn(f64) -> f64, clock: &[f64], step_s: f64, out: &mut [f64]) {
    let [mass, damping, stiffness, dry, slope] = values;
    let slope = |t: f64, [x, v]: [f64; 2]| {
        let braked = damping * v + stiffness * x + dry * (v / FADES_M_S).tanh();
        [v, (force(t) - braked) / mass - GRAVITY_M_S2 * slope.sin()]
    };
    follow([0.0; 2], clock, step_s, slope, |i, _, [x, _]| out[i] = x);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_dry_friction_and_slope_it_is_the_closed_form() {
        let cart = PushedCart { mass_kg: 1.2, damping_ns_m: 1.8, delay_s: 0.0, stiffness_n_m: 3.0 };
        for seen in cart.recordings(2, 0.0, 4).unwrap() {
            let inputs = &seen.circumstances().unwrap().inputs;
            let mut values = vec![0.0; seen.len()];
            positions([1.2, 1.8, 3.0, 0.0, 0.0], |t| inputs[0].at(0, t), seen.clock(), STEP_S, &mut values);
            let worst = values.iter().zip(seen.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-4, "{worst}");
        }
    }
}
