//! How fast one thread rolls out the equations that `tunenet init equations` writes: a damped pendulum.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use tunenet_core::observation::{Channel, Circumstances, Hold, Input};
use tunenet_core::simulator::Simulator as _;
use tunenet_core::statistics::median;
use tunenet_sim::SimulationFile;
use tunenet_sim::observed_equations::equations;
use tunenet_sim::simulation_file::{Domain, template};

/// Samples of a rollout, at so many per second.
pub const SAMPLES: usize = 216;
const RATE_HZ: f64 = 72.0;
/// The figure is the median of so many measurements of so many rollouts.
const REPEATS: usize = 5;
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
    let numbers: Vec<f64> = simulator.parameters().iter().map(|parameter| parameter.value).collect();
    let mut values = vec![0.0; SAMPLES];
    let mut each = Vec::with_capacity(REPEATS);
    for _ in 0..REPEATS {
        let began = Instant::now();
        for _ in 0..ROLLOUTS {
            let rolled = simulator.rollout_driven(black_box(&numbers), &[0.5], &driven, &clock, &mut values);
            rolled.map_err(|error| anyhow::anyhow!("{error}"))?;
            black_box(&values);
        }
        each.push(ROLLOUTS as f64 / began.elapsed().as_secs_f64());
    }
    Ok(median(each).unwrap_or(f64::NAN))
}
