//! Rollouts against closed forms and an independent integrator.

mod chains;
mod closed_forms;
mod fine_steps;
mod formulas;

use nalgebra::Vector3;
use tunenet_core::observation::{Channel, Circumstances, Hold, Input};
use tunenet_core::simulator::{Model as _, Run};

use super::acting::Acting;
use super::effects::RobotEffect;
use super::layout::{Layout, Reading, Start, Wiring};
use super::model::RobotModel;
use super::numbers::{Drive, JointNumbers};
use super::rig::{Mass, Rig};
use super::trajectory::Quantity;
use crate::arm::{Model, urdf};

/// A pendulum about −y: + swings the tip towards +x.
const PENDULUM: &str = r#"<robot name="p"><link name="base"/><link name="rod"><inertial><mass value="0.000001"/>
<inertia ixx="1e-9" iyy="1e-9" izz="1e-9" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 -1 0"/></joint></robot>"#;

/// Two pendulums in a row, each 0.2 m long with 0.5 kg at its end.
const DOUBLE: &str = r#"<robot name="d"><link name="base"/>
<link name="a"><inertial><origin xyz="0 0 -0.2"/><mass value="0.5"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="b"><inertial><origin xyz="0 0 -0.2"/><mass value="0.5"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j1" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 -1 0"/></joint>
<joint name="j2" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0 0 -0.2"/><axis xyz="0 -1 0"/></joint></robot>"#;

fn arm(text: &str) -> Model {
    urdf::parse("arm.urdf".as_ref(), text).unwrap()
}

/// A joint of a servo with the numbers of a small one.
fn servo() -> JointNumbers {
    JointNumbers {
        kp: 16.0,
        gain: 0.166,
        stall: 6.0,
        back_emf: 1.2,
        viscous: 0.02,
        coulomb: 0.12,
        armature: 0.022,
        ..JointNumbers::free(Drive::Position)
    }
}

/// A robot of these joints, observed in all positions, every joint with its own command and all with one switch.
fn robot(model: Model, masses: Vec<Mass>, joints: Vec<JointNumbers>, effects: &[&str], step_s: f64) -> RobotModel {
    let n = joints.len();
    let each = |speed: bool| (0..n).map(move |joint| Start { joint, speed });
    let layout = Layout {
        roles: Vec::new(),
        effects: effects.iter().map(|name| Acting::BuiltIn(RobotEffect::find(name).unwrap())).collect(),
        readings: (0..n).map(|joint| Reading { joint, quantity: Quantity::Position, factor: 1.0 }).collect(),
        starts: each(false).chain(each(true)).collect(),
        wiring: (0..n).map(|joint| Wiring { command: Some(joint), enable: Some(n) }).collect(),
        follows: vec![true; n],
        limits: vec![[f64::NEG_INFINITY, f64::INFINITY]; n],
        zeros: vec![0.0; n],
        command_ranges: vec![None; n],
        model_step_s: 0.0,
        notes: Vec::new(),
    };
    RobotModel::new(vec![Rig::new(model, masses, (9.81, [0.0; 2]), joints, step_s)], layout)
}

/// A pendulum with this mass at this distance below the hinge.
fn pendulum(mass_kg: f64, length_m: f64, joint: JointNumbers, effects: &[&str], step_s: f64) -> RobotModel {
    let model = arm(PENDULUM);
    let link = model.frame("rod").unwrap().clone();
    let mass = Mass { link, mass_kg, position_m: Vector3::new(0.0, 0.0, -length_m) };
    robot(model, vec![mass], vec![joint], effects, step_s)
}

/// A command at 100 Hz on straight lines, for 6 s.
fn command(of: impl Fn(f64) -> f64) -> Input {
    let clock: Vec<f64> = (0..=600).map(|i| f64::from(i) / 100.0).collect();
    let values = clock.iter().map(|t| of(*t)).collect();
    Input::sampled(Channel::new("goal", "rad"), Hold::Linear, clock, values).unwrap()
}

/// A motor that is on until an instant (s).
fn on_until(time_s: f64) -> Input {
    let clock = vec![0.0, time_s, time_s + 1.0];
    Input::sampled(Channel::new("on", "1"), Hold::Previous, clock, vec![1.0, 0.0, 0.0]).unwrap()
}

/// All positions at these instants.
fn rolled(robot: &RobotModel, inputs: Vec<Input>, start: &[f64], coefficients: &[f64], times_s: &[f64]) -> Vec<f64> {
    tried(robot, inputs, start, coefficients, times_s).unwrap()
}

/// The same, or why there are none.
fn tried(
    robot: &RobotModel,
    inputs: Vec<Input>,
    start: &[f64],
    coefficients: &[f64],
    times_s: &[f64],
) -> Result<Vec<f64>, String> {
    let recording = Circumstances::driven_by(inputs);
    let run = Run { numbers: &[], parameters: &[], coefficients, recording: &recording, start, times_s };
    let mut values = vec![0.0; times_s.len() * start.len() / 2];
    robot.simulate(&run, &mut values).map_err(|why| why.to_string())?;
    Ok(values)
}

fn clock(seconds: f64) -> Vec<f64> {
    (0..10_000).map(|i| f64::from(i) / 100.0).take_while(|t| *t <= seconds).collect()
}

fn root_mean_square(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}
