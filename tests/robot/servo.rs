//! Real runs of a servo, where `TUNENET_MEASURED` names a folder that holds them.

use crate::common::{Folder, recorded};

const FILE: &str = "kind = \"robot\"
[robot]
model = \"pendulum.urdf\"
[inputs.hinge_goal_rad]
column = \"goal_rad\"
hold = \"linear\"
[inputs.torque_on]
default = 1.0
[joints.hinge]
drive = \"position\"
command = \"hinge_goal_rad\"
enable = \"torque_on\"
observe = [\"position_rad\"]
gain_1_rad = 0.166
[loads.tip]
link = \"pendulum\"
mass_kg = 0.5
position_m = [0.0, 0.0, -0.1]
";
const PARAMETERS: [(&str, f64, f64, f64); 6] = [
    ("stall_torque", 6.0, 0.5, 20.0),
    ("back_emf", 1.0, 0.0, 5.0),
    ("viscous", 0.02, 0.0, 1.0),
    ("coulomb", 0.1, 0.0, 1.0),
    ("armature", 0.02, 0.001, 0.1),
    ("zero", 0.0, -0.3, 0.3),
];

/// Ten runs fitted and ten held out, with other loads at each gain: the speed limit and the delay are named.
#[test]
fn a_servo_has_a_speed_limit_and_a_delay() {
    let Some(runs) = recorded::measured("servo-sts3215") else { return };
    let folder = Folder::new();
    folder.write("pendulum.urdf", std::fs::read(runs.join("pendulum.urdf")).unwrap());
    let parameters = PARAMETERS.map(|(name, value, min, max)| {
        format!("[parameters.hinge__{name}]\nvalue = {value}\nmin = {min}\nmax = {max}\n")
    });
    folder.write("servo.toml", format!("{FILE}{}", parameters.concat()));
    let manifest = std::fs::read_to_string(runs.join("runs.toml")).unwrap();
    let place = format!("file = \"{}/", runs.display());
    folder.write("runs.toml", manifest.replace("file = \"", &place));
    let answer = folder.run("diagnose --sim servo.toml --manifest runs.toml --json").ends(3).json();
    let names: Vec<&str> =
        answer["effects"].as_array().unwrap().iter().map(|effect| effect["name"].as_str().unwrap()).collect();
    for name in ["speed_limit", "command_delay", "load_friction"] {
        assert!(names.contains(&name), "{names:?}");
    }
    assert_eq!(names.len(), 3, "{names:?}");
    assert!(answer["rollouts"].as_u64().unwrap() <= 60_000, "{}", answer["rollouts"]);
}
