//! `tunenet bench`.

use std::time::Instant;

use anyhow::Result;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use tunenet_sim::ball::{Scene, State, positions};

use super::print_json;
use crate::cli::{Bench, Measured};
use crate::failure::Exit;
use crate::terminal::table;

const FRAMES: usize = 400;
const RATE_HZ: f64 = 60.0;
/// Rollouts between two looks at the clock.
const ROUND: usize = 50;
/// Each figure is the median of this many measurements.
const REPEATS: usize = 5;

pub fn run(options: &Bench) -> Result<Exit> {
    let Measured::Speed = options.what;
    let clock: Vec<f64> = (0..FRAMES).map(|i| i as f64 / RATE_HZ).collect();
    let mut random = ChaCha8Rng::seed_from_u64(options.common.seed);
    let drops: Vec<(f64, f64)> =
        (0..400).map(|_| (random.random_range(0.0..1.0), random.random_range(4.0..5.0))).collect();
    let mean = frames_per_second(&clock, &drops)?;
    let mut worst = (f64::INFINITY, 0.0);
    for step in 0..=20 {
        let e = f64::from(step) / 20.0;
        let drops: Vec<(f64, f64)> = drops.iter().take(40).map(|d| (e, d.1)).collect();
        let speed = frames_per_second(&clock, &drops)?;
        if speed < worst.0 {
            worst = (speed, e);
        }
    }
    let rows = vec![
        vec!["ball, 400 frames at 60 Hz, one core".into(), "frames/s".into()],
        vec!["mean over restitution 0 to 1".into(), format!("{:.2} M", mean / 1e6)],
        vec![format!("worst restitution, {:.2}", worst.1), format!("{:.2} M", worst.0 / 1e6)],
    ];
    anstream::eprintln!("{}", table(&rows));
    if options.common.json {
        let speeds: Value = json!({ "mean_frames_s": mean, "worst_frames_s": worst.0, "worst_restitution": worst.1 });
        print_json(&json!({ "schema": "tunenet.bench.speed/1", "ball": speeds, "warnings": [] }));
    }
    Ok(Exit::Done)
}

/// Frames per second of one thread over `drops` (restitution and height of the centre, m), the median of [`REPEATS`].
fn frames_per_second(clock: &[f64], drops: &[(f64, f64)]) -> Result<f64> {
    let mut out = vec![0.0; 3 * clock.len()];
    let mut speeds = Vec::with_capacity(REPEATS);
    for _ in 0..REPEATS {
        let (began, mut frames) = (Instant::now(), 0usize);
        for &(restitution, height) in drops.iter().cycle().take(drops.len().max(ROUND)) {
            let scene = Scene { restitution, radius_m: 0.5, mass_kg: 1.0, friction: 0.0, ..Scene::default() };
            positions(&scene, &State::at([0.0, 0.0, height]), 0.0, clock, &mut out).map_err(anyhow::Error::msg)?;
            frames += std::hint::black_box(&out).len() / 3;
        }
        speeds.push(frames as f64 / began.elapsed().as_secs_f64());
    }
    speeds.sort_by(f64::total_cmp);
    Ok(speeds[REPEATS / 2])
}
