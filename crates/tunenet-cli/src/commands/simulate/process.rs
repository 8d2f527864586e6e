//! `tunenet simulate` of a model of one's own: a program or equations.

use anyhow::Result;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Measured, Simulator, predict};
use tunenet_core::{Error, Origin};
use tunenet_sim::{Session, SimulationFile, law, observed};

use super::super::refusal::{self, Asked};
use super::notes;
use crate::args::Simulate;
use crate::commands::load::{Driven, inputs};
use crate::files::names;
use crate::view::text::warn_all;

/// What recordings of it would hold, each under the name of the recording that it is driven as.
pub fn simulated(options: &Simulate, file: &SimulationFile, session: &Session) -> Result<Vec<(String, Observation)>> {
    if options.bounces {
        let (expected, found) =
            ("`--bounces` with a ball's file only".into(), format!("`kind = \"{}\"`", file.domain().name()));
        return Err(Error::Setting { origin: Origin::Flag, name: "--bounces", expected, found }.into());
    }
    if options.manifest.is_none() {
        names::require_ending(&options.out, "--out", &["csv"])?;
    }
    let driven = Driven::of(
        (file, &options.simulation.set),
        options.inputs.as_deref(),
        options.manifest.as_deref(),
        &options.reading,
    )?;
    warn_all(&notes::of_all(&driven.recordings));
    let simulator: Box<dyn Simulator> = if options.truth {
        Box::new(Measured::new(observed::bare(&[file], session)?, &[])?)
    } else {
        driven.setups.simulator(Kind::Other, session)?
    };
    let parameters: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let prepared = driven.prepared(&simulator)?;
    let one = |prepared: &tunenet_core::simulator::Prepared| {
        predict(&simulator, prepared, &parameters, &prepared.nuisance_values(), prepared.seen.clock())
    };
    let values: tunenet_core::Result<Vec<Vec<f64>>> = prepared.iter().map(one).collect();
    session.settle()?;
    let values =
        values.map_err(|error| refusal::of_program(file, Asked::Present, &error).unwrap_or_else(|| error.into()))?;
    warn_all(&law::outside(&driven.setups.files(), &prepared)?);
    let names = driven.recordings.iter().map(|(name, _)| name.clone());
    let each = names.zip(prepared.iter().zip(values));
    each.map(|(name, (prepared, values))| Ok((name, inputs::with_columns(file, &prepared.seen.with_values(values)?)?)))
        .collect()
}
