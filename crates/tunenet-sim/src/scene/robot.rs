//! The scene of robot joints that follow commands.

use std::path::PathBuf;

use indexmap::IndexMap;
use serde::Deserialize;

use super::{ArmWorld, Candidates, Inputs, Record, Starts};
use crate::robot::Drive;

/// Robot joints that follow commands.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct RobotScene {
    /// The robot itself.
    pub robot: RobotBody,
    /// Gravity.
    #[serde(default)]
    pub world: ArmWorld,
    /// `[joints.NAME]`, by the names of the model.
    pub joints: IndexMap<String, JointScene>,
    /// `[loads.NAME]`.
    #[serde(default)]
    pub loads: IndexMap<String, LoadScene>,
    /// How it is integrated.
    #[serde(default)]
    pub integrate: Integrate,
    /// What is written of it.
    #[serde(default)]
    pub record: Record,
    /// What drives it.
    #[serde(default)]
    pub inputs: Inputs,
    /// Where its joints start.
    #[serde(default)]
    pub start: Starts,
    /// Effects that it may lack, as formulas.
    #[serde(default)]
    pub candidates: Candidates,
}

impl RobotScene {
    /// What it predicts: what is observed of its joints, in the order of the file.
    #[must_use]
    pub fn headers(&self) -> Vec<String> {
        self.joints.values().flat_map(|joint| joint.observe.iter().cloned()).collect()
    }
}

/// The robot itself.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotBody {
    /// Its URDF or MJCF, from the folder of the file.
    pub model: PathBuf,
    /// Turn of the base about x, then about y of the world, rad.
    #[serde(default)]
    pub base_tilt_rad: [f64; 2],
}

/// `[joints.NAME]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointScene {
    /// What a command means.
    pub drive: Drive,
    /// The input that holds its commands.
    pub command: String,
    /// What a recorded command is multiplied by to be the goal of the joint, or its torque.
    #[serde(default = "one")]
    pub command_scale: f64,
    /// Between which goals or torques the robot clips commands.
    #[serde(default)]
    pub command_range: Option<[f64; 2]>,
    /// The input that switches its motor: 0 releases it.
    #[serde(default)]
    pub enable: Option<String>,
    /// Channels: position, speed, torque and current of the joint, by their units.
    pub observe: Vec<String>,
    /// Gain of the firmware.
    #[serde(default = "one")]
    pub kp: f64,
    /// Damping of the firmware, duty for each rad/s.
    #[serde(default)]
    pub kd: f64,
    /// Duty for each unit of `kp` and rad of error.
    #[serde(default)]
    pub gain_1_rad: Option<f64>,
    /// Force of a prismatic joint for each volt, N/V.
    #[serde(default)]
    pub n_v: Option<f64>,
    /// Torque for each volt, N·m/V.
    #[serde(default)]
    pub nm_v: Option<f64>,
    /// Torque for each ampere, N·m/A, where a current is observed.
    #[serde(default)]
    pub nm_a: Option<f64>,
    /// Greatest duty.
    #[serde(default = "one")]
    pub duty_max: f64,
    /// Supply voltage, V.
    #[serde(default = "twelve")]
    pub supply_v: f64,
}

/// `[loads.NAME]`: a mass on a link.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadScene {
    /// The link.
    pub link: String,
    /// Its mass, kg.
    pub mass_kg: f64,
    /// Where it is, in the axes of the link, m.
    #[serde(default)]
    pub position_m: [f64; 3],
}

/// `[integrate]`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Integrate {
    /// The step, s.
    pub step_s: f64,
}

impl Default for Integrate {
    fn default() -> Self {
        Self { step_s: 0.001 }
    }
}

fn one() -> f64 {
    1.0
}

fn twelve() -> f64 {
    12.0
}
