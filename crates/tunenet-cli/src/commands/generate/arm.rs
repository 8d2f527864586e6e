//! `tunenet gen arm`.

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use tunenet_core::network::{CoveredParameter, DatasetHeader, PairDraw};
use tunenet_core::simulator::Simulator;
use tunenet_core::{Error, Origin};
use tunenet_formats::dataset::generate;
use tunenet_sim::{ObservedArm, SimulationFile, simulation_file};

use super::super::load;
use super::write::{made, place};
use crate::args::{Gen, Pairs};
use crate::exit_status::Exit;

pub fn run(options: &Gen) -> Result<Exit> {
    let preset = options.preset.unwrap_or(Pairs::Paper);
    let Some((proposed, target)) = masses_kg(preset) else {
        let (expected, found) = ("`paper`, `hard` or `wide` for an arm".into(), format!("`{preset:?}`").to_lowercase());
        return Err(Error::Setting { origin: Origin::Flag, name: "--preset", expected, found }.into());
    };
    let Some(path) = &options.sim else {
        let expected = "an arm's simulation file, such as assets/arm.toml".into();
        return Err(Error::Setting { origin: Origin::Flag, name: "--sim", expected, found: "none".into() }.into());
    };
    let mut file = SimulationFile::read(path)?;
    for assignment in &options.set {
        file.set(assignment)?;
    }
    load::of_kind(&file, simulation_file::Domain::Arm)?;
    let arm = ObservedArm::new(&file)?;
    let header = header(&arm, &file, preset, options.common.seed, options.pairs);
    let rest: Vec<f64> = arm.parameters()[1..].iter().map(|p| p.value).collect();
    let draw = |_: u64, random: &mut ChaCha8Rng| {
        let mut with = |(low, high): (f64, f64)| [&[random.random_range(low..=high)], rest.as_slice()].concat();
        PairDraw { proposed: with(proposed), target: with(target), own: Vec::new(), scale: None }
    };
    let (shard, out) = (options.sharing.shard, place(options));
    made(options, (&header, &[]), |report| generate(&arm, &header, shard, &draw, &out, report))
}

/// The payloads that proposed and target are drawn from, kg.
pub fn masses_kg(preset: Pairs) -> Option<((f64, f64), (f64, f64))> {
    match preset {
        Pairs::Paper => Some(((0.0, 1.0), (0.0, 1.0))),
        Pairs::Hard => Some(((0.0, 1.0), (1.0, 2.0))),
        Pairs::Wide => Some(((0.0, 2.0), (0.0, 2.0))),
        Pairs::Easy | Pairs::General => None,
    }
}

/// What all pairs of a set share.
fn header(arm: &ObservedArm, file: &SimulationFile, preset: Pairs, seed: u64, pairs: u64) -> DatasetHeader {
    let (proposed, target) = masses_kg(preset).unwrap_or_default();
    let covered = |(i, p): (usize, &tunenet_core::simulator::Parameter)| {
        let (min, max) = if i == 0 { (proposed.0.min(target.0), proposed.1.max(target.1)) } else { (p.min, p.max) };
        CoveredParameter { name: p.name.clone(), unit: p.unit.clone(), min, max, tuned: i == 0 }
    };
    DatasetHeader {
        preset: format!("arm/{preset:?}").to_lowercase(),
        seed,
        pairs,
        parameters: arm.parameters().iter().enumerate().map(covered).collect(),
        channels: arm.channels().to_vec(),
        target_channels: Vec::new(),
        clock: arm.clock(file.record().rate_hz),
        scene: file.text(),
    }
}
