//! `tunenet simulate`.

mod arm;
mod process;

use std::path::Path;

use anyhow::Result;
use serde_json::json;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Measured, Simulator, rollout};
use tunenet_formats::{Error, kind_name, write_csv, write_mcap};
use tunenet_sim::scene::BallScene;
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{ObservedBall, SimulationFile, observed};

use super::load;
use crate::args::Simulate;
use crate::failure::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::{hash, names};
use crate::view::answer::Printout;
use crate::view::text::stage;

pub fn run(options: &Simulate) -> Result<Exit> {
    names::require_ending(&options.out, "--out", &["csv", "mcap"])?;
    let output = Output::new(&options.out, "--out", Product::Unmarked);
    // What stands there may be the very same; that shows only when it is made.
    destination::check(std::slice::from_ref(&output), &[&options.simulation.sim], true)?;
    let (mut file, session) = load::simulation_with(&options.simulation, options.permission)?;
    let observation = match file.domain() {
        Domain::Arm => arm::simulated(options, &file)?,
        Domain::Process => process::simulated(options, &file, &session)?,
        Domain::Ball => ball(options, &mut file)?,
    };
    write(options, &output, &observation)
}

/// What a ball's recording would hold.
fn ball(options: &Simulate, file: &mut SimulationFile) -> Result<Observation> {
    let BallScene { release, surface, .. } = file.ball()?.clone();
    if release.height_m.is_none() && release.position_m.is_none() {
        let message = "expected where the ball starts, found neither `release.height_m` nor `release.position_m`";
        return Err(Error::file(file.path(), message, "try `--set release.height_m=1.0`").into());
    }
    // What a drop leaves unsaid: at rest, onto a surface at height 0, let go at once.
    for (missing, key) in [
        (release.velocity_m_s.is_none(), "release.velocity_m_s=[0,0,0]"),
        (release.time_s.is_none(), "release.time_s=0"),
        (surface.height_m.is_none(), "surface.height_m=0"),
    ] {
        if missing {
            file.set(key)?;
        }
    }
    let kind = if options.bounces { Kind::EventTimes } else { Kind::Positions };
    let ball = ObservedBall::new(file, kind)?;
    let parameters: Vec<f64> = ball.parameters().iter().map(|p| p.value).collect();
    let nuisances = ball.nuisances_at_rest(release.time_s.unwrap_or(0.0));
    let seen = if options.truth { Measured::new(&ball, &[])? } else { observed::seen(file, &ball)? };
    Ok(if options.bounces {
        let count =
            ball.impacts_within(&parameters, &nuisances, file.record().clock().last().copied().unwrap_or(0.0))?;
        let index: Vec<f64> = (0..count).map(|i| i as f64).collect();
        let times = rollout(&seen, &parameters, &nuisances, &index)?;
        tunenet_ball::bounce_times(times)?
    } else {
        let clock = file.record().clock();
        let values = rollout(&seen, &parameters, &nuisances, &clock)?;
        Observation::new(kind, ball.channels().to_vec(), clock, values)?
    })
}

/// Writes what was simulated, and says so.
fn write(options: &Simulate, output: &Output, observation: &Observation) -> Result<Exit> {
    let csv = options.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    let write = |to: &Path| if csv { write_csv(observation, to) } else { write_mcap(observation, to) };
    if options.writing.overwrite || !destination::holds_something(&options.out) {
        write(&options.out)?;
    } else {
        let again = tempfile::NamedTempFile::new()?;
        write(again.path())?;
        if hash::sha256(again.path())? != hash::sha256(&options.out)? {
            return Err(destination::taken(output).into());
        }
    }
    stage("wrote", &format!("{}, {} samples", options.out.display(), observation.len()));
    Printout::default().show(options.common.json, || {
        json!({
            "schema": "tunenet.simulate/1", "file": names::file_name(&options.out), "kind": kind_name(observation.kind()),
            "samples": observation.len(), "warnings": [],
        })
    })?;
    Ok(Exit::Done)
}
