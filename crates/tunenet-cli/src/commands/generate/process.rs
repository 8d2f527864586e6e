//! `tunenet gen process` and `tunenet gen equations`.

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use tunenet_core::Origin;
use tunenet_core::network::{CoveredParameter, DatasetHeader, PairDraw};
use tunenet_core::observation::{Kind, Note};
use tunenet_core::simulator::{Parameter, Simulator};
use tunenet_formats::Error;
use tunenet_formats::dataset::{DatasetWriter, generate};
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use super::super::load::{self, Driven};
use super::super::refusal::{self, Asked};
use super::under_recordings::UnderRecordings;
use super::write::{made, place};
use crate::args::{Gen, Pairs};
use crate::exit_status::Exit;

pub fn run(options: &Gen, domain: Domain) -> Result<Exit> {
    let preset = options.preset.unwrap_or(Pairs::Wide);
    if preset != Pairs::Wide {
        let (expected, found) = (format!("`wide` for `gen {}`", domain.name()), format!("`{preset:?}`").to_lowercase());
        return Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: "--preset", expected, found }.into());
    }
    let Some(path) = &options.sim else {
        let expected = format!("a simulation file, such as `tunenet init {}` writes", domain.name());
        return Err(tunenet_core::Error::Setting {
            origin: Origin::Flag,
            name: "--sim",
            expected,
            found: "none".into(),
        }
        .into());
    };
    let mut file = SimulationFile::read(path)?;
    for assignment in &options.set {
        file.set(assignment)?;
    }
    load::of_kind(&file, domain)?;
    let session = load::session(options.permission);
    let driven =
        Driven::of((&file, &options.set), options.inputs.as_deref(), options.manifest.as_deref(), &options.reading)?;
    let inner = driven.setups.simulator(Kind::Other, &session)?;
    let program = UnderRecordings { recordings: driven.prepared(&inner)?, inner };
    if !program.parameters().iter().any(|p| p.tune) {
        let message = "expected at least one parameter with `tune = true`, found none";
        return Err(Error::file(path, message, "pairs differ in what is tuned").into());
    }
    let covered = |p: &Parameter| CoveredParameter {
        name: p.name.clone(),
        unit: p.unit.clone(),
        min: p.min,
        max: p.max,
        tuned: p.tune,
    };
    let header = DatasetHeader {
        preset: format!("{}/wide", domain.name()),
        seed: options.common.seed,
        pairs: options.pairs,
        parameters: program.parameters().iter().map(covered).collect(),
        channels: program.channels().to_vec(),
        target_channels: Vec::new(),
        clock: program.recordings[0].seen.clock().to_vec(),
        scene: file.text(),
    };
    let draw = |number: u64, random: &mut ChaCha8Rng| {
        let mut values = || {
            let one = |p: &Parameter| if p.tune { random.random_range(p.min..=p.max) } else { p.value };
            program.parameters().iter().map(one).collect::<Vec<f64>>()
        };
        let own = vec![(number % program.recordings.len() as u64) as f64];
        PairDraw { proposed: values(), target: values(), own, scale: None }
    };
    let out = place(options);
    let notes: Vec<Note> =
        driven.recordings.iter().flat_map(|(name, one)| one.notes.iter().map(|note| named(name, note))).collect();
    made(options, (&header, &notes), |report| {
        // Only what the program still stands by in the end gets its name.
        let mut stands = |done, all| (done < all || session.settle().is_ok()) && report(done, all);
        let generated = generate(&program, &header, options.sharing.shard, &draw, &out, &mut stands);
        if session.drifted() {
            DatasetWriter::forget(&out)?;
        }
        // A rollout that fails is not kept; a program that is gone is the reason that is reported.
        session.failed()?;
        generated.map_err(|error| {
            let refused = match &error {
                Error::Core(own) => refusal::of_program(&file, Asked::Within, own),
                _ => None,
            };
            refused.unwrap_or(error)
        })
    })
}

/// A note with the name of its recording, where it has one.
fn named(name: &str, note: &Note) -> Note {
    let text = if name.is_empty() { note.text.clone() } else { format!("{name}: {}", note.text) };
    Note { text, ..note.clone() }
}
