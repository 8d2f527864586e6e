//! How fast one thread rolls the servo out that `diagnose` has found, over all its held-out runs.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use tunenet_core::observation::{Channel, Circumstances, Hold, Input};
use tunenet_sim::SimulationFile;
use tunenet_sim::observed_robot::robot;

use super::table::column;
use crate::timed_rollouts::per_second;

/// Rollouts of one recording in one measurement.
const ROLLOUTS: usize = 200;

/// What was measured.
pub struct Speed {
    /// Rollouts per second over all recordings, each rolled out equally often.
    pub all: f64,
    /// The same of the recording whose rollouts take longest.
    pub slowest: f64,
    /// How long the longest recording lasts, s, and its samples.
    pub longest_s: f64,
    pub samples: usize,
}

/// How fast a simulation file is rolled out under the commands of these recordings.
///
/// # Errors
/// Where one of them cannot be read, or there are none.
pub fn rollouts_per_second(file: &Path, recordings: &[PathBuf]) -> Result<Speed> {
    let each: Vec<(f64, f64, usize)> = recordings.iter().map(|one| of_one(file, one)).collect::<Result<_>>()?;
    let (_, longest_s, samples) = *each.iter().max_by(|a, b| a.1.total_cmp(&b.1)).context("expected recordings")?;
    let all = each.len() as f64 / each.iter().map(|one| one.0.recip()).sum::<f64>();
    let slowest = each.iter().map(|one| one.0).fold(f64::INFINITY, f64::min);
    Ok(Speed { all, slowest, longest_s, samples })
}

/// Rollouts per second of one recording, and how many seconds and samples it has.
fn of_one(file: &Path, recording: &Path) -> Result<(f64, f64, usize)> {
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
