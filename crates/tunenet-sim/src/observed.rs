//! From a simulation file to the simulator that it describes.

use tunenet_core::observation::Kind;
use tunenet_core::simulator::{Measured, Setups, Simulator, measurement_effects};
use tunenet_formats::kind_name;
use tunenet_formats::{Error, Result};

use crate::observed_equations::equations;
use crate::observed_robot::robot;
use crate::process::{Session, start_setups};
use crate::replayed_arm::{replayed, replays};
use crate::simulation_file::Domain;
use crate::{ObservedArm, ObservedBall, SimulationFile, VideoBall};

/// The simulator that `file` describes, observed as `kind`: its physical effects in the world, its effects of the
/// measurement around it. Those that this kind of observation cannot show are passed over. A program of the user's runs within
/// `session`; for a ball and an arm the default one will do.
///
/// # Errors
/// [`Error::File`] where what the file describes is not observed so; as [`ObservedBall::new`], [`ObservedArm::new`] and
/// [`process::start`](crate::process::start).
pub fn simulator(file: &SimulationFile, kind: Kind, session: &Session) -> Result<Box<dyn Simulator>> {
    match (file.domain(), kind) {
        (Domain::Arm, Kind::Joints) if replays(file) => return replayed(file),
        (Domain::Arm, Kind::Joints) => return Ok(Box::new(ObservedArm::new(file)?)),
        (Domain::Process | Domain::Equations | Domain::Robot, Kind::Other) => return own(&[file], session),
        (Domain::Arm | Domain::Process | Domain::Equations | Domain::Robot, _)
        | (Domain::Ball, Kind::Joints | Kind::Other) => {
            let (is, other) = match file.domain() {
                Domain::Arm => ("joint series of an arm", "give recordings of its joints, or a ball's simulation file"),
                Domain::Process | Domain::Equations | Domain::Robot => {
                    ("a series on its own channels", "read recordings with the channels of the file")
                }
                Domain::Ball => (
                    "positions or bounces of a ball",
                    "give an arm's simulation file: `tunenet init arm` writes one to start from",
                ),
            };
            let message = format!("expected {is}, which the file describes, found {}", kind_name(kind));
            return Err(Error::file(file.path(), message, other));
        }
        (Domain::Ball, _) => {}
    }
    if kind == Kind::Pixels {
        return Ok(Box::new(VideoBall::new(file)?));
    }
    around(file, ObservedBall::new(file, kind)?.with_tuned_effects(file)?)
}

/// The simulator of recordings in several setups, a file for each: files that differ in keys of the scene alone.
///
/// # Errors
/// As [`simulator`]; [`Error::File`] where files differ in what all recordings of one object share.
pub fn in_setups(files: &[&SimulationFile], kind: Kind, session: &Session) -> Result<Box<dyn Simulator>> {
    match files {
        [file] => simulator(file, kind, session),
        [first, ..] if first.domain().declares() && kind == Kind::Other => own(files, session),
        _ => together(files, files.iter().map(|file| simulator(file, kind, session)).collect::<Result<_>>()?),
    }
}

/// One simulator of those that were made of `files`, a setup each.
///
/// # Errors
/// [`Error::File`] where they differ in what all recordings of one object share.
pub fn together(files: &[&SimulationFile], each: Vec<Box<dyn Simulator>>) -> Result<Box<dyn Simulator>> {
    Setups::of(each).map_err(|error| match (error, files.first()) {
        (tunenet_core::Error::Setting { expected, found, .. }, Some(file)) => {
            let message = format!("recordings of one object: expected {expected}, found {found}");
            Error::file(file.path(), message, "give recordings that differ in it another `object`")
        }
        (other, _) => other.into(),
    })
}

/// The simulator of a user's own model, a program or equations, whose recordings have several setups: files that differ in their
/// settings, constants and initial states alone. Coefficients that the file lets `tune` change are its parameters too.
///
/// # Errors
/// As [`bare`] and [`Measured::fixed`].
///
/// # Panics
/// Where `files` is empty.
pub fn own(files: &[&SimulationFile], session: &Session) -> Result<Box<dyn Simulator>> {
    let (file, started) = (files[0], bare(files, session)?);
    let tuned: Vec<String> =
        file.effects().into_iter().filter(|effect| effect.tune).map(|effect| effect.name).collect();
    let tuned: Vec<&str> = tuned.iter().map(String::as_str).collect();
    let simulator = if tuned.is_empty() { started } else { started.with_effects(&tuned)? };
    if measured(file, Kind::Other).is_empty() { Ok(simulator) } else { Ok(Box::new(seen(file, simulator)?)) }
}

/// The same without effects of the measurement.
///
/// # Errors
/// As [`process::start_setups`](crate::process::start_setups) and [`observed_equations::equations`](equations).
///
/// # Panics
/// Where `files` is empty.
pub fn bare(files: &[&SimulationFile], session: &Session) -> Result<Box<dyn Simulator>> {
    Ok(match files[0].domain() {
        Domain::Equations => Box::new(equations(files)?),
        Domain::Robot => Box::new(robot(files)?),
        _ => Box::new(start_setups(files, session)?),
    })
}

/// As [`simulator`], around a ball of `file` that was made before.
///
/// # Errors
/// As [`Measured::fixed`].
pub fn around(file: &SimulationFile, ball: ObservedBall) -> Result<Box<dyn Simulator>> {
    if measured(file, ball.kind()).is_empty() {
        return Ok(Box::new(ball));
    }
    Ok(Box::new(seen(file, ball)?))
}

/// `simulator` as the file's effects of the measurement make it look.
///
/// # Errors
/// As [`Measured::fixed`].
pub fn seen<S: Simulator>(file: &SimulationFile, simulator: S) -> tunenet_core::Result<Measured<S>> {
    let present = measured(file, simulator.kind());
    present.iter().try_fold(Measured::new(simulator, &[])?, |measured, (name, values)| measured.fixed(name, values))
}

/// The file's effects of the measurement that show in this kind of observation.
fn measured(file: &SimulationFile, kind: Kind) -> Vec<(String, Vec<f64>)> {
    let known = measurement_effects(kind);
    let present = file.effects().into_iter().filter(|e| known.iter().any(|k| k.name == e.name));
    present.map(|e| (e.name, e.values)).collect()
}
