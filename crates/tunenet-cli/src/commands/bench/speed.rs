//! `tunenet bench speed`.

use std::time::Instant;

use anyhow::{Context, Result};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use tunenet_core::network::{Preset, TrainOptions, train};
use tunenet_sim::ball::{Scene, State, positions};

use super::film_speed::Films;
use super::process;
use crate::cli::BenchSpeed;
use crate::commands::print_json;
use crate::failure::Exit;
use crate::terminal::{stage, table};

const FRAMES: usize = 400;
const RATE_HZ: f64 = 60.0;
/// Each figure is the median of this many measurements.
const REPEATS: usize = 5;
/// Pairs whose generation is weighed.
const MANY_PAIRS: &str = "100000";

/// The simulation that a whole `tune` is timed on: the paper's ball, its height known.
const SCENE: &str = include_str!("../../../../../assets/ball_easy.toml");

pub fn run(options: &BenchSpeed) -> Result<Exit> {
    let clock: Vec<f64> = (0..FRAMES).map(|i| i as f64 / RATE_HZ).collect();
    let mut random = ChaCha8Rng::seed_from_u64(options.common.seed);
    let drops: Vec<(f64, f64)> =
        (0..400).map(|_| (random.random_range(0.0..1.0), random.random_range(4.0..5.0))).collect();
    stage("rolling", "400 drops of 400 frames, then 40 at each restitution");
    let mean = frames_per_second(&clock, &drops)?;
    let (worst, worst_restitution) = worst_speed(&clock, &drops)?;

    let folder = tempfile::tempdir().context("a temporary folder")?;
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (scene, data, model, drop, many) =
        (at("scene.toml"), at("data.mcap"), at("model.safetensors"), at("drop.csv"), at("many.mcap"));
    std::fs::write(&scene, SCENE)?;
    process::run(&["gen", "ball", "--preset", "easy", "--pairs", "800", "--out", &data])?;

    stage("training", "preset `paper`, 800 pairs, 200 epochs, one thread");
    let settings = TrainOptions { preset: Preset::paper(), seed: options.common.seed, checkpoint: None };
    let began = Instant::now();
    train(data.as_ref(), &settings, &mut |_| true)?.save(&model)?;
    let training_s = began.elapsed().as_secs_f64();

    stage("tuning", "whole processes, K = 5");
    process::run(&["simulate", "--sim", &scene, "--set", "parameters.restitution.value=0.63", "--out", &drop])?;
    let tune = ["tune", "--sim", &scene, "--observation", &drop, "--model", &model, "--iterations", "5", "--json"];
    let tuning_s = median((0..2 * REPEATS).map(|_| process::run(&tune).map(|c| c.seconds)).collect::<Result<_>>()?);
    let starting_s =
        median((0..2 * REPEATS).map(|_| process::run(&["--version"]).map(|c| c.seconds)).collect::<Result<_>>()?);

    stage("writing", "100,000 pairs");
    let many = process::run(&["gen", "ball", "--preset", "easy", "--pairs", MANY_PAIRS, "--out", &many])?;
    let peak = many.peak_bytes.map_or_else(|| "not known here".into(), |b| format!("{:.0} MB", b as f64 / 1e6));

    stage("filming", "160 × 120 px in memory, a film of 1080p, two of 4K");
    let films = Films::measure(folder.path())?;

    let row = |what: &str, value: String| vec![what.to_string(), value];
    let mut rows = vec![
        row(
            "ball, 400 frames at 60 Hz, one core, mean over restitution 0 to 1",
            format!("{:.2} M frames/s", mean / 1e6),
        ),
        row(
            &format!("the same at the worst restitution, {worst_restitution:.2}"),
            format!("{:.2} M frames/s", worst / 1e6),
        ),
        row("train, preset paper, 800 pairs, 200 epochs, one core", format!("{training_s:.2} s")),
        row("tune, K = 5, trained network, whole process", format!("{:.0} ms", tuning_s * 1e3)),
        row("start of the process alone", format!("{:.1} ms", starting_s * 1e3)),
        row("gen, 100,000 pairs, all cores", format!("{:.1} s", many.seconds)),
        row("its greatest memory", peak),
    ];
    rows.extend(films.rows());
    anstream::eprintln!("{}", table(&rows));
    if options.common.json {
        print_json(&json!({
            "schema": "tunenet.bench.speed/1",
            "ball": { "mean_frames_s": mean, "worst_frames_s": worst, "worst_restitution": worst_restitution },
            "train": { "preset": "paper", "pairs": 800, "epochs": 200, "seconds": training_s },
            "tune": { "iterations": 5, "process_seconds": tuning_s, "start_seconds": starting_s },
            "gen": { "pairs": 100_000, "seconds": many.seconds, "peak_bytes": many.peak_bytes },
            "film": films.as_json(),
            "warnings": [],
        }));
    }
    Ok(Exit::Done)
}

/// The slowest restitution of 21, and its speed in frames per second.
fn worst_speed(clock: &[f64], drops: &[(f64, f64)]) -> Result<(f64, f64)> {
    let mut worst = (f64::INFINITY, 0.0);
    for step in 0..=20 {
        let restitution = f64::from(step) / 20.0;
        let drops: Vec<(f64, f64)> = drops.iter().take(40).map(|d| (restitution, d.1)).collect();
        let speed = frames_per_second(clock, &drops)?;
        if speed < worst.0 {
            worst = (speed, restitution);
        }
    }
    Ok(worst)
}

/// Frames per second of one thread over `drops` (restitution and height of the centre, m), the median of [`REPEATS`].
fn frames_per_second(clock: &[f64], drops: &[(f64, f64)]) -> Result<f64> {
    let mut out = vec![0.0; 3 * clock.len()];
    let mut speeds = Vec::with_capacity(REPEATS);
    for _ in 0..REPEATS {
        let began = Instant::now();
        for &(restitution, height) in drops {
            let scene = Scene { restitution, radius_m: 0.5, mass_kg: 1.0, friction: 0.0, ..Scene::default() };
            positions(&scene, &State::at([0.0, 0.0, height]), 0.0, clock, &mut out).map_err(anyhow::Error::msg)?;
            std::hint::black_box(&out);
        }
        speeds.push((drops.len() * clock.len()) as f64 / began.elapsed().as_secs_f64());
    }
    Ok(median(speeds))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
