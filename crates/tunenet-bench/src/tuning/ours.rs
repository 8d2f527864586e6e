//! Our own networks: generated for, trained and asked in the loop of Algorithm 1.

use std::time::Instant;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use tunenet_core::network::{Course as Shown, Head, Model, Preset, TrainOptions};
use tunenet_core::tune::{Loop, walk};
use tunenet_formats::{load_model, save_model, train_file};

use super::super::process;
use super::super::search::Course;
use super::targets::{DropTarget, Simulation};
use crate::resume::Store;

/// What making a model took, s.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Seconds {
    #[serde(rename = "generate_seconds")]
    pub generate: f64,
    #[serde(rename = "train_seconds")]
    pub train: f64,
    /// How much of the training the processor spent on it: less, where other programs held the cores. None where the
    /// system does not report it.
    #[serde(rename = "train_on_core_seconds")]
    pub train_on_core: Option<f64>,
}

/// Time that this thread has spent on a core, s, from Linux's process table.
fn on_core_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}

/// Whether it is the paper's network in the paper's loop, however it was trained.
fn of_the_paper(preset: &Preset) -> bool {
    preset.head == Head::Tanh
}

/// A preset's own data set and how much shorter a quick training is.
fn recipe(preset: &Preset, quick: bool) -> (&'static str, &'static str, Preset) {
    let mut preset = preset.clone();
    if quick && let Shown::Remixed { steps, .. } = &mut preset.course {
        *steps /= 4;
    }
    if of_the_paper(&preset) { ("easy", "800", preset) } else { ("wide", "1000", preset) }
}

/// The model of a preset and a seed, from disk where it has been trained already.
pub fn trained(store: &Store, preset: &Preset, seed: u64, quick: bool) -> Result<(Model, Seconds)> {
    let name = format!("{}-{seed}", preset.name);
    let path = store.room("models")?.join(format!("{name}.safetensors"));
    let seconds = store.keep(&format!("training-{name}"), || {
        let (pairs, count, preset) = recipe(preset, quick);
        let data = path.with_extension("mcap");
        let began = Instant::now();
        let seed_text = seed.to_string();
        let out = data.to_str().context("the folder's name is not Unicode")?;
        // Files that another program left there must not be resumed.
        let _ = std::fs::remove_file(&data);
        process::run(&["gen", "ball", "--preset", pairs, "--pairs", count, "--seed", &seed_text, "--out", out])?;
        let generate = began.elapsed().as_secs_f64();
        let (began, core_began) = (Instant::now(), on_core_s());
        save_model(&train_file(&data, &TrainOptions::new(preset, seed), None, &mut |_| true)?, &path)?;
        let train = began.elapsed().as_secs_f64();
        let train_on_core = on_core_s().zip(core_began).map(|(now, then)| now - then);
        std::fs::remove_file(&data).with_context(|| format!("removing {}", data.display()))?;
        Ok(Seconds { generate, train, train_on_core })
    })?;
    Ok((load_model(&path)?, seconds))
}

/// The estimate after every rollout; the one that only judges the last iterate moves nothing.
pub fn course(simulation: &Simulation, model: &Model, target: &DropTarget, most: usize) -> Result<Course> {
    // As `tune` asks for the two: the paper's loop is the bare one. Values without a rollout are none, so both are clamped.
    let whole = !of_the_paper(model.preset());
    let how = Loop { iterations: most, clamp: true, secant: whole, best: whole, library: whole };
    let walk = walk(&simulation.ball, &target.prepared, model, &simulation.start(target), how)?;
    Ok(walk.answers.iter().map(|answer| answer[0]).collect())
}
