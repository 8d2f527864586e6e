//! From a URDF to a tuned joint.

use super::{commands, folder};

#[test]
fn init_writes_every_joint_of_a_urdf() {
    let folder = folder();
    folder.run("init robot --urdf arm.urdf --out own.toml").ends(0);
    let text = folder.text("own.toml");
    for part in ["model = \"arm.urdf\"", "[joints.hinge]", "[inputs.hinge_goal_rad]", "[parameters.hinge__coulomb]"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    folder.run("inspect own.toml").ends(0);
    folder.run("init ball --urdf arm.urdf --out ball.toml").ends(2);
}

/// Simulated with other numbers than the file's, tuned from the file's.
#[test]
fn a_simulated_swing_is_tuned_back() {
    let folder = folder();
    folder.write("step.csv", commands(|t| if (0.5..2.0).contains(&t) { 1.4 } else { 0.0 }));
    folder.write("swing.csv", commands(|t| 0.9 * (t * t * 1.5).sin()));
    let truth = "--set parameters.hinge__stall_torque.value=5.0 --set parameters.hinge__coulomb.value=0.2 \
                 --set record.frames=400";
    for name in ["step", "swing"] {
        folder.run(&format!("simulate --sim robot.toml --inputs {name}.csv {truth} --out {name}_seen.csv")).ends(0);
    }
    let tuned = folder.run("tune --sim robot.toml step_seen.csv swing_seen.csv --out tuned.toml --json").ends(0).json();
    let value = |name: &str| tuned["parameters"][name]["value"].as_f64().unwrap_or_else(|| panic!("{tuned:#}"));
    assert!((value("hinge__stall_torque") - 5.0).abs() < 0.05, "{tuned}");
    assert!((value("hinge__coulomb") - 0.2).abs() < 0.004, "{tuned}");
    assert!(folder.text("tuned.toml").contains("[provenance]"));
}
