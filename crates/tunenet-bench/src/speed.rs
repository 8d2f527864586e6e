//! `tunenet bench speed`.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use tunenet_core::network::{Preset, TrainOptions};
use tunenet_formats::{save_model, train_file};
use tunenet_sim::SimulationFile;
use tunenet_sim::ball::{Scene, State, positions};
use tunenet_sim::shot::{ArmReach, Belief, Rule, Settings, ShotScene, Task, plan};

use super::process;
use super::video_speed::VideoFigures;
use crate::args::BenchSpeed;
use crate::equations_speed;
use crate::scene::{PAPER_BALL, SHOT, URDF};
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{note, stage, table};

const FRAMES: usize = 400;
const RATE_HZ: f64 = 60.0;
/// Each figure is the median of this many measurements.
const REPEATS: usize = 5;
/// Pairs whose generation is weighed.
const MANY_PAIRS: &str = "100000";

/// The ball of the shot that is planned.
const PLANNED: &str = "\
kind = \"ball\"
ball.radius_m = 0.03
[parameters.restitution]
value = 0.72
min = 0.0
max = 1.0
[effects.quadratic_drag]
c_1_m = 0.05
[provenance]
verdict = \"tuned\"
interval95 = { restitution = [0.70, 0.74] }
";

pub fn run(options: &BenchSpeed) -> Result<Exit> {
    if let Some(shard) = options.sharing.shard {
        let (expected, found) =
            ("none: `bench speed` times one machine, and has nothing to cut".into(), format!("`{shard}`"));
        return Err(tunenet_core::Error::Setting {
            origin: tunenet_core::Origin::Flag,
            name: "--shard",
            expected,
            found,
        }
        .into());
    }
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
    std::fs::write(&scene, PAPER_BALL)?;
    process::run(&["gen", "ball", "--preset", "easy", "--pairs", "800", "--out", &data])?;

    stage("training", "preset `paper`, 800 pairs, 200 epochs, one thread");
    let settings = TrainOptions::new(Preset::paper(), options.common.seed);
    let began = Instant::now();
    save_model(&train_file(data.as_ref(), &settings, None, &mut |_| true)?, &model)?;
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

    stage("video", "160 × 120 px in memory, one video of 1080p, two of 4K");
    let videos = VideoFigures::measure(folder.path())?;

    stage("planning", "a shot, 100 heights");
    let [nearest_s, probability_s] = [Rule::Nearest, Rule::Probability].map(|rule| plan_seconds(folder.path(), rule));
    let (nearest_s, probability_s) = (nearest_s?, probability_s?);

    stage("rolling", "a pendulum as equations");
    let pendulum = equations_speed::rollouts_per_second()?;

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
        row(
            &format!("damped pendulum as equations, {} samples, one core", equations_speed::SAMPLES),
            format!("{pendulum:.0} rollouts/s"),
        ),
        row("train, preset paper, 800 pairs, 200 epochs, one core", format!("{training_s:.2} s")),
        row("tune, K = 5, trained network, whole process", format!("{:.0} ms", tuning_s * 1e3)),
        row("start of the process alone", format!("{:.1} ms", starting_s * 1e3)),
        row("gen, 100,000 pairs, all cores", format!("{:.1} s", many.seconds)),
        row("peak memory of `gen`", peak),
    ];
    rows.extend([
        row("plan, 100 heights of an arm, the nearest path, all cores", format!("{:.1} ms", nearest_s * 1e3)),
        row("the same by Monte Carlo with 256 balls", format!("{:.0} ms", probability_s * 1e3)),
    ]);
    rows.extend(videos.rows());
    if options.common.json {
        // For whoever keeps both of one run.
        table(&rows).lines().for_each(note);
        print_json(&json!({
            "schema": "tunenet.bench.speed/1",
            "ball": { "mean_frames_s": mean, "worst_frames_s": worst, "worst_restitution": worst_restitution },
            "equations": { "pendulum_rollouts_s": pendulum, "samples": equations_speed::SAMPLES },
            "train": { "preset": "paper", "pairs": 800, "epochs": 200, "seconds": training_s },
            "tune": { "iterations": 5, "process_seconds": tuning_s, "start_seconds": starting_s },
            "gen": { "pairs": 100_000, "seconds": many.seconds, "peak_bytes": many.peak_bytes },
            "plan": { "heights": Settings::default().heights, "nearest_seconds": nearest_s, "probability_seconds": probability_s },
            "film": videos.as_json(),
            "warnings": [],
        }))?;
    } else {
        answer::line(&table(&rows))?;
    }
    Ok(Exit::Done)
}

/// Seconds from read files to a plan, the arm's postures with it: the median of [`REPEATS`].
fn plan_seconds(folder: &Path, rule: Rule) -> Result<f64> {
    std::fs::write(folder.join("jaco_robotiq.urdf"), URDF)?;
    let task = Task::parse(&folder.join("shot.toml"), SHOT)?;
    let file = SimulationFile::parse("ball.toml".as_ref(), PLANNED)?;
    let settings = Settings { rule, ..Settings::default() };
    let timed = || -> Result<f64> {
        let began = Instant::now();
        let radius_m = file.ball()?.ball.radius_m;
        let scene = ShotScene::new(&task, radius_m).map_err(anyhow::Error::msg)?;
        let belief = Belief::new(&file, &task)?;
        let arm = ArmReach::new(task.arm.as_ref().context("the ready task has an arm")?)?;
        std::hint::black_box(plan(&scene, &belief, task.release.heights_m, &arm, &settings)?);
        Ok(began.elapsed().as_secs_f64())
    };
    Ok(median((0..REPEATS).map(|_| timed()).collect::<Result<_>>()?))
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

/// The median of figures of which there is at least one.
fn median(values: Vec<f64>) -> f64 {
    tunenet_core::statistics::median(values).unwrap_or(f64::NAN)
}
