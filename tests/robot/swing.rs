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

/// A recording of commands in degrees under other names is one of the same commands in radians.
#[test]
fn commands_in_another_unit_are_converted() {
    let folder = folder();
    folder.write("commands.csv", commands(|t| 0.9 * (t * t * 1.5).sin()));
    let truth = "--set parameters.hinge__stall_torque.value=5.0 --set record.frames=400";
    folder.run(&format!("simulate --sim robot.toml --inputs commands.csv {truth} --out seen.csv")).ends(0);
    let seen = folder.text("seen.csv");
    let mut rows = seen.lines();
    let names: Vec<&str> = rows.next().unwrap().split(',').collect();
    let place = |name: &str| names.iter().position(|other| *other == name).unwrap_or_else(|| panic!("{names:?}"));
    let places = ["t_s", "hinge_rad", "hinge_goal_rad"].map(place);
    let in_degrees = rows.map(|row| {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [t, angle, goal] = places.map(|place| cells[place]);
        format!("{t},{angle},{}\n", goal.to_degrees())
    });
    folder.write("plain.csv", std::iter::once("time,pos,cmd\n".to_owned()).chain(in_degrees).collect::<String>());
    let tuned = |line: &str| {
        let json = folder.run(&format!("tune --sim robot.toml --quick --json {line}")).json();
        json["parameters"]["hinge__stall_torque"]["value"].as_f64().unwrap_or_else(|| panic!("{json:#}"))
    };
    let own = tuned("seen.csv");
    let mapped = tuned("plain.csv --columns t_s=time,hinge_rad=pos,hinge_goal_deg=cmd");
    assert!((own - 5.0).abs() < 0.1 && (mapped - own).abs() < 1e-4, "{own} {mapped}");
    // Where the input has no default.
    folder.run("init robot --urdf arm.urdf --out own.toml").ends(0);
    let refused = folder.run("tune --sim own.toml plain.csv --columns t_s=time,hinge_rad=pos").ends(1);
    let said = "where another unit is meant, write it into our name: `hinge_goal_deg`";
    assert!(refused.stderr.contains(said), "{}", refused.stderr);
}

/// What is written to another folder is a simulation file there.
#[test]
fn a_file_in_another_folder_finds_its_model() {
    let folder = folder();
    std::fs::create_dir(folder.path("results")).unwrap();
    folder.write("step.csv", commands(|t| if (0.5..2.0).contains(&t) { 1.4 } else { 0.0 }));
    folder.write("swing.csv", commands(|t| 0.9 * (t * t * 1.5).sin()));
    let simulated = |sim: &str, inputs: &str, out: &str| {
        let truth = "--set parameters.hinge__stall_torque.value=5.0 --set record.frames=400";
        folder.run(&format!("simulate --sim {sim} --inputs {inputs}.csv {truth} --out {out}.csv")).ends(0);
    };
    simulated("robot.toml", "step", "step_seen");
    simulated("robot.toml", "swing", "swing_seen");
    folder.run("tune --sim robot.toml step_seen.csv swing_seen.csv --out results/tuned.toml").ends(0);
    folder.run("init robot --urdf arm.urdf --out results/own.toml").ends(0);
    for name in ["results/tuned.toml", "results/own.toml"] {
        let text = folder.text(name);
        assert!(text.contains("\nmodel = \"../arm.urdf\"\n"), "{text}");
        simulated(name, "swing", name.trim_end_matches(".toml"));
    }
}
