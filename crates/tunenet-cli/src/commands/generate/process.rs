//! `tunenet gen process` and `tunenet gen equations`.

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use tunenet_core::Origin;
use tunenet_core::network::{CoveredParameter, DatasetHeader, PairDraw};
use tunenet_core::observation::{Channel, Circumstances, Kind};
use tunenet_core::simulator::{Parameter, Prepared, RolloutResult, Simulator};
use tunenet_formats::Error;
use tunenet_formats::dataset::{DatasetWriter, generate};
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use super::super::load::{self, Driven};
use super::super::refusal::{self, Asked};
use super::write::{made, place};
use crate::args::{Gen, Numbers, Pairs};
use crate::failure::Exit;

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
    let driven = Driven::of(&file, options.inputs.as_deref(), options.manifest.as_deref(), &Numbers::default())?;
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
    made(options, &header, |report| {
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

/// A program whose rollouts are driven as recordings were: the one nuisance parameter is the number of the recording.
struct UnderRecordings {
    inner: Box<dyn Simulator>,
    recordings: Vec<Prepared>,
}

impl Simulator for UnderRecordings {
    fn parameters(&self) -> &[Parameter] {
        self.inner.parameters()
    }

    fn channels(&self) -> &[Channel] {
        self.inner.channels()
    }

    fn rollout(&self, parameters: &[f64], recording: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        let is = |(i, _): &(usize, &Prepared)| Some(&(*i as f64)) == recording.first();
        let numbered = self.recordings.iter().enumerate().find(is).map(|(_, recording)| recording);
        let recording = numbered.unwrap_or(&self.recordings[0]);
        let bare = Circumstances::default();
        let known = recording.circumstances.as_deref().unwrap_or(&bare);
        self.inner.rollout_driven(parameters, &recording.nuisance_values(), known, clock, values)
    }
}
