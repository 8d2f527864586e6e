//! `tunenet simulate` of an arm.

use anyhow::Result;
use tunenet_core::Error;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Simulator, rollout};
use tunenet_sim::{ObservedArm, SimulationFile};

use super::destination::Output;
use super::simulate::write;
use crate::cli::Simulate;
use crate::failure::Exit;
use crate::terminal::{stage, warn};

pub fn run(options: &Simulate, file: &SimulationFile, output: &Output) -> Result<Exit> {
    if options.bounces {
        let (expected, found) = ("`--bounces` with a ball's file only".into(), "an arm's".into());
        return Err(Error::Setting { name: "--bounces", expected, found }.into());
    }
    let arm = ObservedArm::new(file)?;
    arm.notes().iter().for_each(warn);
    let joints: Vec<String> = arm.model().joints().iter().map(|j| format!("`{}`", j.name)).collect();
    stage("joints", &joints.join(", "));
    let parameters: Vec<f64> = arm.parameters().iter().map(|p| p.value).collect();
    let clock = arm.clock(file.record().rate_hz);
    let values = rollout(&arm, &parameters, &[], &clock)?;
    write(options, output, &Observation::new(Kind::Joints, arm.channels().to_vec(), clock, values)?)
}
