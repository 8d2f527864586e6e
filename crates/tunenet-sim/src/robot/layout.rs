//! What parameters, channels, initial states and inputs of a robot's recordings mean.

use tunenet_core::observation::{Circumstances, Note};

use super::acting::Acting;
use super::numbers::{JointNumbers, Number};
use super::trajectory::Quantity;

/// A parameter: which number of which joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Role {
    pub joint: usize,
    pub number: Number,
}

/// A channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reading {
    pub joint: usize,
    pub quantity: Quantity,
    /// What is read for each unit of the quantity: the reciprocal of N·m/A for a current.
    pub factor: f64,
}

/// A number of the initial state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Start {
    pub joint: usize,
    pub speed: bool,
}

/// Which inputs of a recording drive a joint: its command, and what switches its motor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Wiring {
    pub command: Option<usize>,
    pub enable: Option<usize>,
}

/// What is the same in all setups.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub roles: Vec<Role>,
    pub effects: Vec<Acting>,
    pub readings: Vec<Reading>,
    pub starts: Vec<Start>,
    pub wiring: Vec<Wiring>,
    /// Whether each joint is to follow its commands: a position drive.
    pub follows: Vec<bool>,
    /// Between which positions the model lets each joint move, rad or m; infinite where it does not say.
    pub limits: Vec<[f64; 2]>,
    /// Where the file has the zero of each joint: true less measured position, rad or m.
    pub zeros: Vec<f64>,
    /// Between which goals or torques a copy of the model clips the commands of each joint, where its simulation does not.
    pub command_ranges: Vec<Option<[f64; 2]>>,
    /// The step of the simulation that the model states, s; 0 where it states none.
    pub model_step_s: f64,
    /// What is to be said of every recording.
    pub notes: Vec<Note>,
}

/// The goal or the torque of a joint by time, as its motor gets it; `None` where nothing commands the joint.
pub(super) fn goals<'a>(
    layout: &Layout,
    joints: &'a [JointNumbers],
    known: &'a Circumstances,
    joint: usize,
) -> Option<impl Fn(f64) -> f64 + Copy + 'a> {
    let command = layout.wiring.get(joint)?.command.and_then(|place| known.inputs.get(place))?;
    let numbers = joints.get(joint)?;
    Some(move |time_s: f64| numbers.commanded(command.at(0, time_s)))
}
