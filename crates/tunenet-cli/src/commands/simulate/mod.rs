//! `tunenet simulate`.

mod arm;
mod notes;
mod process;
mod scenes;
mod write;

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_core::Origin;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Measured, Simulator, rollout};
use tunenet_formats::Error;
use tunenet_sim::scene::BallScene;
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{ObservedBall, SimulationFile, observed};

use self::write::{described, write, write_all};
use super::load::{self, Driven};
use crate::args::Simulate;
use crate::exit_status::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::names;
use crate::view::answer::Printout;
use crate::view::text::warn_all;

pub fn run(options: &Simulate) -> Result<Exit> {
    let inputs = || [Some(options.simulation.sim.as_path()), options.inputs.as_deref(), options.manifest.as_deref()];
    let own = Driven::input_files(&options.simulation, options.inputs.as_deref(), options.manifest.as_deref());
    let inputs: Vec<&Path> = inputs().into_iter().flatten().chain(own.iter().map(PathBuf::as_path)).collect();
    let output = |path: &Path| Output::new(path, "--out", Product::Unmarked);
    if options.manifest.is_none() {
        names::require_ending(&options.out, "--out", &["csv", "mcap"])?;
        // What stands there may be the very same; that shows only when it is made.
        destination::check(&[output(&options.out)], &inputs, true)?;
    }
    let (mut file, session) = load::simulation_with(&options.simulation, options.permission)?;
    if !file.domain().declares() && options.inputs.is_some() {
        load::of_kind(&file, Domain::Process)?;
    }
    let reads = file.domain().declares() && (options.inputs.is_some() || options.manifest.is_some());
    if let Some(name) = options.reading.given().filter(|_| !reads) {
        let expected = "a recording that drives the simulation (`--inputs`, or `--manifest` with a model of your own)";
        let (origin, expected, found) = (Origin::Flag, expected.into(), "none".into());
        return Err(tunenet_core::Error::Setting { origin, name, expected, found }.into());
    }
    let observation = match (file.domain(), &options.manifest) {
        (own, Some(_)) if own.declares() => {
            return write_all(options, &inputs, &process::simulated(options, &file, &session)?);
        }
        (_, Some(manifest)) => return write_all(options, &inputs, &scenes::simulated(options, &file, manifest)?),
        (own, None) if own.declares() => process::simulated(options, &file, &session)?.remove(0).1,
        (_, None) => built_in(options, &mut file)?,
    };
    write(options, &options.out, &observation)?;
    Printout::default().show(options.common.json, || described(&options.out, &observation))?;
    Ok(Exit::Done)
}

/// What a recording of a ball or an arm would hold.
fn built_in(options: &Simulate, file: &mut SimulationFile) -> Result<Observation> {
    if file.domain() == Domain::Arm { arm::simulated(options, file) } else { ball(options, file) }
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
        // Where the ball was between its bounces is not in the list.
        warn_all(&ball.formula_notes(&[], &[]));
        tunenet_ball::bounce_times(times)?
    } else {
        let clock = file.record().clock();
        let values = rollout(&seen, &parameters, &nuisances, &clock)?;
        warn_all(&ball.formula_notes(&clock, &values));
        Observation::new(kind, ball.channels().to_vec(), clock, values)?
    })
}
