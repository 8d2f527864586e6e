//! A two-joint robot in rapier3d, driven by recorded motor torques: a payload, a damping, and a motor that may be weaker than stated.
use std::path::Path;

use tunenet_core::Result;
use tunenet_core::diagnose::{Diagnosis, Recording, Settings, Subject, diagnose};
use tunenet_core::observation::{Channel, Circumstances, Hold, Input, Kind, Observation};
use tunenet_core::simulator::{
    Coefficient, Effect, FnSimulator, Parameter, Phase, Preparation, Simulator, StartState, StartValue, predict,
};
use tunenet_sim::arm::{Inertia, Multibody, gravity, urdf};

const STEP_S: f64 = 0.004;
const ROBOT: &str = r#"<robot name="two"><link name="base"/><link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="1.2"/>
<inertia ixx="0.016" iyy="0.016" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="lower"><inertial>
<origin xyz="0 0 -0.15"/><mass value="0.8"/><inertia ixx="0.006" iyy="0.006" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="tip"/><joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/></joint>
<joint name="end" type="fixed"><parent link="lower"/><child link="tip"/><origin xyz="0 0 -0.3"/></joint></robot>"#;

fn robot() -> std::result::Result<impl Simulator, Box<dyn std::error::Error>> {
    let arm = urdf::parse(Path::new("two.urdf"), ROBOT)?.chain_to("tip")?.weighed()?;
    let known =
        vec![Parameter::new("payload", "kg", 0.2, 0.0, 2.0)?, Parameter::new("damping", "N·m·s", 0.1, 0.0, 2.0)?];
    let channels = vec![Channel::new("shoulder", "rad"), Channel::new("elbow", "rad")];
    let robot = FnSimulator::new(known, channels, move |p, run, clock, out| {
        let [payload_kg, damping, gain] = *p else { return Err("expected three numbers".into()) };
        let tip = arm.frame("tip").map_err(|error| error.to_string())?;
        let loaded = arm.loaded(tip, &Inertia::cube(payload_kg, nalgebra::Vector3::zeros(), 0.05));
        let (mut q, mut dq) = ([run.start[0], run.start[1]], [0.0; 2]);
        let mut world = Multibody::new(&loaded, gravity(9.81), STEP_S, &q, &dq)?;
        let (mut t, mut before) = (run.recording.start_s, q);
        for (&time, row) in clock.iter().zip(out.chunks_exact_mut(2)) {
            while t < time {
                before = q;
                world.step(&[0, 1].map(|j| gain * run.input(j, t) - damping * dq[j]));
                world.state(&mut q, &mut dq);
                t += STEP_S;
            }
            let share = ((time - t) / STEP_S + 1.0).clamp(0.0, 1.0); // between the last two steps
            (0..2).for_each(|j| {
                row[j] = if t > run.recording.start_s { before[j] + share * (q[j] - before[j]) } else { q[j] }
            });
        }
        Ok(())
    });
    let gain = Coefficient::new("factor", "1", 1.0, (0.5, 1.5), 0.02);
    Ok(robot
        .start(StartState::new("shoulder", "rad", StartValue::Number(0.3)))
        .start(StartState::new("elbow", "rad", StartValue::Number(-0.2)))
        .candidate(Effect::new(
            "motor_gain",
            Phase::Actuator,
            "the motors are weaker or stronger than stated",
            vec![gain],
        )))
}

/// Recordings of a robot with 0.5 kg in its hand and this gain of its motors; a sensor's quantum stands in for its noise.
fn recordings(robot: &dyn Simulator, gain: f64) -> Result<Vec<Observation>> {
    let real = robot.with_effects(&["motor_gain"])?;
    let one = |k: u32| {
        let torque = |j: u32, t: f64| 3.0 * ((1.3 + 0.7 * f64::from(k) + f64::from(j)) * t + f64::from(k * j)).sin();
        let clock: Vec<f64> = (0..150).map(|i| f64::from(i) * 0.0133).collect();
        let input = |j: u32| {
            let values = clock.iter().map(|t| torque(j, *t)).collect();
            Input::sampled(Channel::new(format!("tau{j}"), "N·m"), Hold::Linear, clock.clone(), values)
        };
        let blank = Observation::new(Kind::Other, robot.channels().to_vec(), clock.clone(), vec![0.0; 300])?;
        let blank = blank.under(Circumstances::driven_by(vec![input(0)?, input(1)?]));
        let Preparation::Usable(ready) = real.prepare(&blank)? else { return Ok(blank) };
        let seen = predict(&real, &ready, &[0.5, 0.2, gain], &[], &clock)?;
        blank.with_values(seen.into_iter().map(|angle| (angle / 1e-3).round() * 1e-3).collect())
    };
    (0..4).map(one).collect()
}

pub(crate) fn diagnosed(gain: f64) -> std::result::Result<Diagnosis, Box<dyn std::error::Error>> {
    let robot = robot()?;
    let seen = recordings(&robot, gain)?;
    let one = |(i, seen)| Recording { name: format!("run {i}"), object: 0, held_out: i == 3, seen };
    let all: Vec<Recording> = seen.iter().enumerate().map(one).collect();
    Ok(diagnose(&[Subject { name: "robot".into(), simulator: &robot }], &all, &Settings::default(), &|_| {})?)
}

pub(crate) fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let found = diagnosed(0.9)?;
    println!("{:?}: {}, {} rollouts", found.verdict(), found.names().join(", "), found.rollouts);
    Ok(())
}
