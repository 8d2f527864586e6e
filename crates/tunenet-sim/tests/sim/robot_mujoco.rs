//! A servo's pendulum against MuJoCo, where Python has it.

use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::{Value, json};
use tunenet_core::observation::{Channel, Circumstances, Hold, Input};
use tunenet_core::simulator::Simulator;
use tunenet_sim::SimulationFile;
use tunenet_sim::observed_robot::robot;

const SCRIPT: &str = include_str!("robot_mujoco.py");
const MODEL: &str = r#"<robot name="p"><link name="base"/><link name="rod"><inertial><mass value="1e-9"/>
<inertia ixx="1e-9" iyy="1e-9" izz="1e-9" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 -1 0"/></joint></robot>"#;

/// Firmware gain, its damping, mass in kg and length in m.
const CASES: [[f64; 4]; 4] =
    [[4.0, 0.0, 0.5, 0.1], [16.0, 0.0, 1.2, 0.15], [32.0, 0.05, 0.5, 0.15], [12.0, 0.1, 1.2, 0.1]];
const STALL: f64 = 6.0;
const BACK_EMF: f64 = 1.2;
const VISCOUS: f64 = 0.02;
const COULOMB: f64 = 0.12;
const ARMATURE: f64 = 0.025;

fn goal(case: usize, t: f64) -> f64 {
    match case {
        0 | 2 if (1.5..4.0).contains(&t) => 1.5,
        0 | 2 => 0.0,
        _ => 0.9 * (t * t).sin(),
    }
}

/// MuJoCo's positions; why not, where there is none.
fn by_mujoco(cases: &Value) -> Result<Vec<Vec<f64>>, String> {
    let mut child = Command::new("python3")
        .args(["-c", SCRIPT])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("no python3: {error}"))?;
    let mut input = child.stdin.take().ok_or("no standard input")?;
    let text = cases.to_string();
    // A Python without the module ends before it reads.
    let _ = input.write_all(text.as_bytes());
    drop(input);
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default().to_owned();
        return Err(said);
    }
    serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())
}

#[test]
fn validate_servo_against_mujoco_within_a_milliradian() {
    let clock: Vec<f64> = (0..=600).map(|i| f64::from(i) / 100.0).collect();
    let goals: Vec<Vec<f64>> =
        (0..CASES.len()).map(|case| clock.iter().map(|t| goal(case, *t)).chain([goal(case, 6.0)]).collect()).collect();
    let cases: Vec<Value> = CASES
        .iter()
        .zip(&goals)
        .map(|([kp, kd, mass, length], goals)| {
            json!({ "kp": STALL * 0.166 * kp, "kv": STALL * kd, "stall": STALL, "damping": BACK_EMF + VISCOUS,
                    "coulomb": COULOMB, "armature": ARMATURE, "mass": mass, "length": length, "goals": goals })
        })
        .collect();
    let theirs = match by_mujoco(&Value::from(cases)) {
        Ok(theirs) => theirs,
        Err(why) => {
            eprintln!("skipped: {why}");
            return;
        }
    };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("arm.urdf"), MODEL).unwrap();
    for (([kp, kd, mass, length], goals), theirs) in CASES.iter().zip(&goals).zip(theirs) {
        let parameters = [
            ("stall_torque", STALL, 20.0),
            ("back_emf", BACK_EMF, 5.0),
            ("viscous", VISCOUS, 1.0),
            ("coulomb", COULOMB, 1.0),
            ("armature", ARMATURE, 1.0),
        ];
        let parameters: Vec<String> = parameters
            .iter()
            .map(|(name, value, max)| format!("[parameters.hinge__{name}]\nvalue = {value}\nmin = 0.0\nmax = {max}\n"))
            .collect();
        let text = format!(
            "kind = \"robot\"\n[robot]\nmodel = \"arm.urdf\"\n[inputs.goal_rad]\n[joints.hinge]\ndrive = \"position\"\n\
             command = \"goal_rad\"\nobserve = [\"hinge_rad\"]\nkp = {kp}\nkd = {kd}\ngain_1_rad = 0.166\n\
             [loads.tip]\nlink = \"rod\"\nmass_kg = {mass}\nposition_m = [0.0, 0.0, -{length}]\n{}",
            parameters.concat()
        );
        let file = SimulationFile::parse(&folder.path().join("robot.toml"), &text).unwrap();
        let simulator = robot(&[&file]).unwrap();
        let input =
            Input::sampled(Channel::new("goal", "rad"), Hold::Linear, clock.clone(), goals[..601].to_vec()).unwrap();
        let driven = Circumstances { start: vec![0.0, 0.0], ..Circumstances::driven_by(vec![input]) };
        let values: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let mut ours = vec![0.0; clock.len()];
        simulator.rollout_driven(&values, &[], &driven, &clock, &mut ours).unwrap();
        let squares: f64 = ours.iter().zip(&theirs).map(|(a, b)| (a - b).powi(2)).sum();
        let error = (squares / ours.len() as f64).sqrt();
        assert!(error < 1e-3, "kp {kp}, kd {kd}: {error} rad");
    }
}
