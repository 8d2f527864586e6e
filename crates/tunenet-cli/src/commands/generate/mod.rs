//! `tunenet gen`: data sets of rollout pairs.

mod arm;
mod ball;
mod process;
mod under_recordings;
mod write;

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_formats::Error;
use tunenet_sim::simulation_file;

use self::write::place;
use super::load::Driven;
use crate::args::{Domain, Gen, Simulation};
use crate::exit_status::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::names;

pub fn run(options: &Gen) -> Result<Exit> {
    let given = [&options.sim, &options.inputs, &options.manifest];
    let own = input_files(options);
    let inputs: Vec<&Path> = given.into_iter().flatten().chain(&own).map(AsRef::as_ref).collect();
    names::require_ending(&options.out, "--out", &["mcap"])?;
    let out = place(options);
    let output = Output::new(&out, "--out", Product::Dataset);
    destination::check(&[output], &inputs, options.writing.overwrite)?;
    if out.exists() && !out.is_file() {
        let message = "expected a file to write to, found a device";
        return Err(Error::file(&out, message, "choose a name that ends in .mcap").into());
    }
    let reads = options.inputs.is_some() || options.manifest.is_some();
    if let Some(name) = options.reading.given().filter(|_| !reads) {
        let (expected, found) = ("a recording that drives the simulation (`--inputs` or `--manifest`)", "none".into());
        let origin = tunenet_core::Origin::Flag;
        return Err(tunenet_core::Error::Setting { origin, name, expected: expected.into(), found }.into());
    }
    if let (true, false) = (reads, matches!(options.domain, Domain::Process | Domain::Equations | Domain::Robot)) {
        let name = if options.inputs.is_some() { "--inputs" } else { "--manifest" };
        let (expected, found) =
            ("`gen process`, `gen equations` or `gen robot` for recorded inputs".into(), "another scene".into());
        return Err(tunenet_core::Error::Setting { origin: tunenet_core::Origin::Flag, name, expected, found }.into());
    }
    match options.domain {
        Domain::Arm => arm::run(options),
        Domain::Process => process::run(options, simulation_file::Domain::Process),
        Domain::Equations => process::run(options, simulation_file::Domain::Equations),
        Domain::Robot => process::run(options, simulation_file::Domain::Robot),
        Domain::Ball | Domain::BallVideo => ball::run(options, &out),
    }
}

/// The files of their own in which the inputs of a program stand.
fn input_files(options: &Gen) -> Vec<PathBuf> {
    let Some(sim) = options.sim.clone() else { return Vec::new() };
    let simulation = Simulation { sim, set: options.set.clone() };
    Driven::input_files(&simulation, options.inputs.as_deref(), options.manifest.as_deref())
}
