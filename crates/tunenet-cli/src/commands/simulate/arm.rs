//! `tunenet simulate` of an arm.

use anyhow::Result;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Simulator, rollout};
use tunenet_core::{Error, Origin};
use tunenet_sim::{ObservedArm, SimulationFile};

use crate::args::Simulate;
use crate::view::text::{stage, warn};

/// What a recording of it would hold.
pub fn simulated(options: &Simulate, file: &SimulationFile) -> Result<Observation> {
    if options.bounces {
        let (expected, found) = ("`--bounces` with a ball's file only".into(), "an arm's".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--bounces", expected, found }.into());
    }
    let arm = ObservedArm::new(file)?;
    arm.notes().iter().for_each(warn);
    let joints: Vec<String> = arm.model().joints().iter().map(|j| format!("`{}`", j.name)).collect();
    stage("joints", &joints.join(", "));
    let parameters: Vec<f64> = arm.parameters().iter().map(|p| p.value).collect();
    let clock = arm.clock(file.record().rate_hz);
    let values = rollout(&arm, &parameters, &[], &clock)?;
    Ok(Observation::new(Kind::Joints, arm.channels().to_vec(), clock, values)?)
}
