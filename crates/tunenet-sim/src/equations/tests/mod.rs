//! Rollouts against closed forms and an independent integrator.

mod closed_forms;
mod events;
mod friction;
mod inputs;
mod refused;

use std::sync::Arc;

use tunenet_core::observation::{Channel, Circumstances, Hold, Input};
use tunenet_core::simulator::Run;

use super::rollout;
use super::system::System;
use crate::scene::EquationsScene;

/// A system from the tables of a file; parameters are named as they are given.
pub fn system(text: &str, parameters: &[&str]) -> System {
    let scene: EquationsScene = toml_edit::de::from_str(text).unwrap();
    let parameters: Vec<(&str, Option<&str>)> = parameters.iter().map(|name| (*name, None)).collect();
    System::new(&scene, &parameters).unwrap_or_else(|misfit| panic!("{misfit:?}"))
}

/// What drives and starts a rollout.
#[derive(Debug, Clone, Default)]
pub struct Given {
    pub parameters: Vec<f64>,
    pub coefficients: Vec<f64>,
    pub start: Vec<f64>,
    pub inputs: Vec<Input>,
    pub start_s: f64,
}

pub fn input(hold: Hold, times: &[f64], values: &[f64]) -> Input {
    Input::sampled(Channel::new("u", "V"), hold, times.to_vec(), values.to_vec()).unwrap()
}

pub fn tried(system: &System, given: &Given, times: &[f64]) -> Result<Vec<f64>, String> {
    let recording = Arc::new(Circumstances {
        start_s: given.start_s,
        inputs: given.inputs.clone(),
        start: given.start.clone(),
        ..Circumstances::default()
    });
    let run = Run {
        numbers: &[],
        parameters: &given.parameters,
        coefficients: &given.coefficients,
        recording: &recording,
        start: &given.start,
        times_s: times,
    };
    let mut values = vec![f64::NAN; times.len() * system.outputs.len()];
    rollout(system, &run, &mut values).map(|()| values).map_err(|error| error.message().to_owned())
}

pub fn run(system: &System, given: &Given, times: &[f64]) -> Vec<f64> {
    tried(system, given, times).unwrap()
}

pub fn clock(count: usize, step_s: f64) -> Vec<f64> {
    (0..count).map(|i| i as f64 * step_s).collect()
}

/// Classical Runge–Kutta steps of a fixed length, far shorter than anything that moves.
pub fn rk4<const N: usize>(
    f: impl Fn(f64, [f64; N]) -> [f64; N],
    start: [f64; N],
    times: &[f64],
    step_s: f64,
) -> Vec<[f64; N]> {
    let (mut t, mut y) = (0.0, start);
    let moved = |y: [f64; N], h: f64, k: [f64; N]| std::array::from_fn(|i| y[i] + h * k[i]);
    times
        .iter()
        .map(|until| {
            while t < *until {
                let h = (until - t).min(step_s);
                let a = f(t, y);
                let b = f(t + h / 2.0, moved(y, h / 2.0, a));
                let c = f(t + h / 2.0, moved(y, h / 2.0, b));
                let d = f(t + h, moved(y, h, c));
                y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
                t = if h < step_s { *until } else { t + h };
            }
            y
        })
        .collect()
}
