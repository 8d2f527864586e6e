//! What a simulation file describes, as values with their units and defaults.
//!
//! The file and `--set` fill the same structs; a task file fills [`Task`]. What a value may be stands in the
//! [lists of keys](crate::simulation_file::schema), which also say what is wrong and where; a test holds both together.

mod arm;
mod ball;
mod declared;
mod equations;
mod process;
mod robot;
mod shot;

use serde::Deserialize;

pub use arm::{ArmBody, ArmScene, ArmWorld, Motion, MotionKind};
pub use ball::{BallBody, BallParameters, BallScene, BallWorld, Medium, Release, Surface};
pub use declared::{
    Candidate, CandidateCoefficient, Candidates, First, Hold, Input, Inputs, Start, StartValue, Starts,
};
pub use equations::{EquationsScene, Event, State};
pub use process::{Process, ProcessScene};
pub use robot::{Integrate, JointScene, LoadScene, RobotBody, RobotScene};
pub use shot::{ArmTask, Plane, Task, TaskHoop, TaskKind, TaskRelease};

/// Gravity on earth, m/s².
const GRAVITY_M_S2: f64 = 9.81;

/// What a simulation file describes besides its parameters and effects.
#[derive(Debug, Clone, PartialEq)]
pub enum Scene {
    /// A ball that falls and bounces.
    Ball(BallScene),
    /// An arm that moves a payload.
    Arm(ArmScene),
    /// A model simulated by an external program.
    Process(ProcessScene),
    /// A model whose equations stand in the file.
    Equations(Box<EquationsScene>),
    /// Robot joints that follow commands.
    Robot(Box<RobotScene>),
}

impl Scene {
    /// What is written of a rollout.
    #[must_use]
    pub fn record(&self) -> Record {
        match self {
            Self::Ball(ball) => ball.record,
            Self::Arm(arm) => arm.record,
            Self::Process(process) => process.record,
            Self::Equations(equations) => equations.record,
            Self::Robot(robot) => robot.record,
        }
    }
}

/// What `simulate` and `gen` write.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Record {
    /// Frames per second.
    pub rate_hz: f64,
    /// Number of frames.
    pub frames: usize,
}

impl Record {
    /// The instants of the frames, s, from 0.
    #[must_use]
    pub fn clock(&self) -> Vec<f64> {
        (0..self.frames).map(|i| i as f64 / self.rate_hz).collect()
    }
}

impl Default for Record {
    fn default() -> Self {
        Self { rate_hz: 120.0, frames: 360 }
    }
}
