//! How many rollouts one thread makes in a second.

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use tunenet_core::observation::Circumstances;
use tunenet_core::simulator::Simulator;
use tunenet_core::statistics::median;

/// The figure is the median of so many measurements.
const REPEATS: usize = 5;

/// Rollouts per second at the simulator's own values, from `start` and driven by `driven`, each measured over so many `rollouts`.
///
/// # Errors
/// Where a rollout is refused.
pub fn per_second(
    simulator: &dyn Simulator,
    start: &[f64],
    (driven, clock): (&Circumstances, &[f64]),
    rollouts: usize,
) -> Result<f64> {
    let numbers: Vec<f64> = simulator.parameters().iter().map(|parameter| parameter.value).collect();
    let mut values = vec![0.0; clock.len() * simulator.channels().len()];
    let mut each = Vec::with_capacity(REPEATS);
    for _ in 0..REPEATS {
        let began = Instant::now();
        for _ in 0..rollouts {
            simulator.rollout_driven(black_box(&numbers), start, driven, clock, &mut values)?;
            black_box(&values);
        }
        each.push(rollouts as f64 / began.elapsed().as_secs_f64());
    }
    Ok(median(each).unwrap_or(f64::NAN))
}
