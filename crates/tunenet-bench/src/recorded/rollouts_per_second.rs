//! How fast one thread rolls the servo out that `diagnose` has found.

use std::path::Path;

use anyhow::{Context, Result};
use tunenet_core::observation::{Channel, Circumstances, Hold, Input};
use tunenet_sim::SimulationFile;
use tunenet_sim::observed_robot::robot;

use super::table::column;
use crate::timed_rollouts::per_second;

/// Rollouts of one measurement.
const ROLLOUTS: usize = 1000;

/// Rollouts per second of a simulation file under the commands of one recording, and how many seconds and samples that has.
///
/// # Errors
/// Where one of both cannot be read.
pub fn rollouts_per_second(file: &Path, recording: &Path) -> Result<(f64, f64, usize)> {
    let text = std::fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))?;
    let simulator = robot(&[&SimulationFile::parse(file, &text)?])?;
    let clock = column(recording, "t_s")?;
    let input = |name: &str, unit: &str, hold: Hold| -> Result<Input> {
        Ok(Input::sampled(Channel::new(name, unit), hold, clock.clone(), column(recording, name)?)?)
    };
    let inputs = vec![input("goal_rad", "rad", Hold::Linear)?, input("torque_on", "1", Hold::Previous)?];
    let start_s = clock.first().copied().unwrap_or_default();
    let driven = Circumstances { start: vec![0.0, 0.0], start_s, ..Circumstances::driven_by(inputs) };
    let each = per_second(&simulator, &[], (&driven, &clock), ROLLOUTS)?;
    let seconds = clock.last().copied().unwrap_or_default() - start_s;
    Ok((each, seconds, clock.len()))
}
