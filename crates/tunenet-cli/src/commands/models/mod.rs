//! Models with tuned numbers: a copy of the user's own file, BAM's parameters, a configuration for Isaac Lab.

mod format;
mod robot;
mod sidecar;

use std::collections::HashMap;
use std::path::Path;

use anyhow::Result;
use tunenet_core::simulator::Simulator;
use tunenet_core::{Error, Origin};
use tunenet_formats::{shown_path, write_atomically};
use tunenet_sim::SimulationFile;
use tunenet_sim::arm::model_file::with_friction;
use tunenet_sim::observed_arm::urdf_path;
use tunenet_sim::observed_robot::model_path;
use tunenet_sim::replayed_arm::{ReplayedArm, replays};
use tunenet_sim::robot::Drive;
use tunenet_sim::simulation_file::Domain;

use crate::args::Models;
use crate::files::destination::{Output, Product};
use crate::files::names;
use crate::view::text::stage;

/// 95 % intervals of numbers, by the names that a tuning has for them: `elbow__coulomb`, `load_friction.mu.2`.
pub type Intervals = HashMap<String, [f64; 2]>;

/// Refuses, before anything is spent, models of what has none.
///
/// # Errors
/// [`Error::Setting`] where the simulation is no robot (or, for joint friction, no arm with replayed logs), or of several objects.
pub fn check(options: &Models, file: &SimulationFile, objects: usize) -> Result<()> {
    let refuse = |name: &'static str, expected: &str, found: String| {
        Err(Error::Setting { origin: Origin::Flag, name, expected: expected.into(), found }.into())
    };
    let robot = file.domain() == Domain::Robot;
    if let Some(flag) = options.of_robots().filter(|_| !robot) {
        return refuse(flag, "`kind = \"robot\"`", format!("`kind = \"{}\"`", file.domain().name()));
    }
    if options.out_model.is_some() && !robot && !replays(file) {
        let expected = "`kind = \"robot\"`, or an arm with `motion.kind = \"replay\"`";
        return refuse("--out-model", expected, "another simulation".into());
    }
    if let Some(out) = &options.out_model {
        format::check(out, &if robot { model_path(file)? } else { urdf_path(file)? })?;
    }
    if options.out_bam.is_some() && !file.robot()?.joints.values().any(|joint| joint.drive == Drive::Position) {
        let expected = "a joint with `drive = \"position\"`, since BAM's servos follow positions";
        return refuse("--out-bam", expected, "none".into());
    }
    if options.asked() && objects > 1 {
        let flag = if options.out_model.is_some() { "--out-model" } else { options.of_robots().unwrap_or("--out-bam") };
        return refuse(flag, "recordings of one object", format!("{objects} objects"));
    }
    Ok(())
}

/// What is written.
///
/// # Errors
/// Where a name has another ending than its contents.
pub fn outputs(options: &Models) -> Result<Vec<Output>> {
    let all = [
        (options.out_model.clone(), "--out-model", ["urdf", "xml", "xacro"].as_slice()),
        (options.sidecar(), "--out-model", &["toml"]),
        (options.out_bam.clone(), "--out-bam", &["json"]),
        (options.out_isaac.clone(), "--out-isaac", &["py"]),
    ];
    let named = all.into_iter().filter_map(|(path, flag, endings)| Some((path?, flag, endings)));
    named
        .map(|(path, flag, endings)| {
            names::require_ending(&path, flag, endings)?;
            Ok(Output::new(&path, flag, Product::Unmarked))
        })
        .collect()
}

/// Writes the models that are asked for, with the numbers of the tuned simulation `file`.
///
/// # Errors
/// Where the model of the simulation cannot be read or edited, or a file cannot be written.
pub fn write(options: &Models, file: &SimulationFile, intervals: &Intervals) -> Result<()> {
    if !options.asked() {
        return Ok(());
    }
    if file.domain() != Domain::Robot {
        return write_friction(options, file);
    }
    robot::write(options, file, &|name| intervals.get(name).copied())
}

/// The joint friction of an arm whose logs are replayed.
fn write_friction(options: &Models, file: &SimulationFile) -> Result<()> {
    let Some(out) = &options.out_model else { return Ok(()) };
    let arm = ReplayedArm::from_file(file)?;
    let values: Vec<f64> = arm.parameters().iter().map(|p| p.value).collect();
    let friction = arm.friction(&values);
    if friction.iter().all(|joint| joint.damping == 0.0 && joint.friction == 0.0) {
        stage("model", "not written: the simulation has no joint friction");
        return Ok(());
    }
    put(out, &with_friction(&urdf_path(file)?, &friction)?)?;
    stage("model", &shown_path(out));
    Ok(())
}

fn put(path: &Path, text: &str) -> Result<()> {
    Ok(write_atomically(path, |out| out.write_all(text.as_bytes()))?)
}
