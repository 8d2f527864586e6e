//! `tunenet simulate` of a program of one's own.

use anyhow::Result;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Measured, Simulator, rollout};
use tunenet_core::{Error, Origin};
use tunenet_sim::{ProcessSimulator, Session, SimulationFile, observed};

use super::super::refusal::{self, Asked};
use crate::args::Simulate;
use crate::files::names;

/// What a recording of it would hold.
pub fn simulated(options: &Simulate, file: &SimulationFile, session: &Session) -> Result<Observation> {
    if options.bounces {
        let (expected, found) = ("`--bounces` with a ball's file only".into(), "a program's".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--bounces", expected, found }.into());
    }
    names::require_ending(&options.out, "--out", &["csv"])?;
    let program = ProcessSimulator::start(file, session)?;
    let seen = if options.truth { Measured::new(program, &[])? } else { observed::seen(file, program)? };
    let parameters: Vec<f64> = seen.parameters().iter().map(|p| p.value).collect();
    let clock = file.record().clock();
    let values = rollout(&seen, &parameters, &[], &clock);
    session.settle()?;
    let values =
        values.map_err(|error| refusal::of_program(file, Asked::Present, &error).unwrap_or_else(|| error.into()))?;
    Ok(Observation::new(Kind::Other, seen.channels().to_vec(), clock, values)?)
}
