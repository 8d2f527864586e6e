//! `tunenet train`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use serde_json::json;
use tunenet_core::network::{Preset, TrainDevice, TrainOptions};
use tunenet_formats::dataset::DatasetReader;
use tunenet_formats::{Action, Error};
use tunenet_formats::{save_model, train_file};

use crate::args::Train;
use crate::exit_status::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::names;
use crate::view::answer::Printout;
use crate::view::text::{progress, stage};

pub fn run(options: &Train) -> Result<Exit> {
    let began = Instant::now();
    let device = options.device.here()?;
    // What cannot be written in the end is refused at once.
    let output = Output::new(&options.out, "--out", Product::Model);
    destination::check(&[output], &[&options.data], options.writing.overwrite)?;
    let mut checkpoint = options.out.clone().into_os_string();
    checkpoint.push(".checkpoint");
    let checkpoint = PathBuf::from(checkpoint);
    let channels = DatasetReader::open(&options.data)?.header().channels.clone();
    let preset = Preset::named_for(options.preset.name(), &channels)?;
    let settings = TrainOptions {
        memory_bytes: usize::try_from(options.memory_mib).unwrap_or(usize::MAX >> 20) << 20,
        device,
        ..TrainOptions::new(preset, options.common.seed)
    };
    let bar = progress(0, "training");
    let mut last = None;
    let mut report = |now: &tunenet_core::network::TrainProgress| {
        bar.set_length(now.steps);
        bar.set_position(now.step);
        let validation = now.validation.map_or_else(String::new, |v| format!(", validation {v:.2e}"));
        bar.set_prefix(format!("loss {:.2e}{validation}", now.loss));
        last = Some(*now);
        true
    };
    let model = train_file(&options.data, &settings, Some(&checkpoint), &mut report)?;
    bar.finish_and_clear();
    save_model(&model, &options.out)?;
    // Only a saved model makes the checkpoint useless.
    if checkpoint.exists() {
        std::fs::remove_file(&checkpoint).map_err(|source| Error::io(&checkpoint, Action::Removing, source))?;
    }
    let seconds = began.elapsed().as_secs_f64();
    let (steps, loss) = last.map_or((0, 0.0), |l| (l.steps, l.loss));
    let validation = last.and_then(|l| l.validation);
    let named = model.parameters().iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
    let on = if device == TrainDevice::Cpu { "the CPU" } else { "a GPU" };
    let mut shown = Printout::default();
    shown.row("trained", &format!("{steps} steps for {named} on {on}, loss {loss:.2e}, {seconds:.1} s"));
    shown.show(options.common.json, || {
        json!({
            "schema": "tunenet.train/1", "file": names::file_name(&options.out), "preset": options.preset.name(),
            "seed": options.common.seed, "steps": steps, "loss": loss, "validation": validation,
            "seconds": seconds, "device": device.name(), "warnings": [],
        })
    })?;
    stage("wrote", &options.out.display().to_string());
    Ok(Exit::Done)
}
