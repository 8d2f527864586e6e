//! How fast one thread rolls out the equations that `tunenet init equations` writes: a damped pendulum.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::{Channel, Circumstances, Hold, Input};
use tunenet_sim::SimulationFile;
use tunenet_sim::observed_equations::equations;
use tunenet_sim::simulation_file::{Domain, template};

use crate::timed_rollouts::per_second;

/// Samples of a rollout, at so many per second.
pub const SAMPLES: usize = 216;
const RATE_HZ: f64 = 72.0;
/// Rollouts of one measurement.
const ROLLOUTS: usize = 10_000;

/// Rollouts per second from an angle of 0.5 rad, its motor at rest.
///
/// # Errors
/// Where the equations cannot be simulated.
pub fn rollouts_per_second() -> Result<f64> {
    let file = SimulationFile::parse(Path::new("equations.toml"), &template(Domain::Equations))?;
    let simulator = equations(&[&file])?;
    let clock: Vec<f64> = (0..SAMPLES).map(|i| i as f64 / RATE_HZ).collect();
    let input = Input::sampled(Channel::new("u", "V"), Hold::Previous, clock.clone(), vec![0.0; SAMPLES])?;
    let driven = Circumstances { start: vec![0.5, 0.0], ..Circumstances::driven_by(vec![input]) };
    per_second(&simulator, &[0.5], (&driven, &clock), ROLLOUTS)
}
