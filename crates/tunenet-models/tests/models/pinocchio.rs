//! Pinocchio and this reader make the same of the same URDF, edited or not.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::Value;
use tunenet_models::edit::edit;
use tunenet_models::{Change, Model, Motion, Quantity, Robot};

use super::support::generator::Draw;
use super::support::{ask, newton_euler, python_with};

/// A tree of links with every kind of joint that Pinocchio has a number for.
fn urdf(seed: u64) -> String {
    let mut draw = Draw(seed);
    let mut text = String::from("<?xml version=\"1.0\"?>\n<robot name=\"drawn\">\n  <link name=\"base\"/>\n");
    let count = 3 + draw.below(6);
    for i in 0..count {
        let parent = if i == 0 { "base".to_owned() } else { format!("link{}", draw.below(i)) };
        let mut numbers =
            |n: usize, size: f64| (0..n).map(|_| draw.between(-size, size).to_string()).collect::<Vec<_>>().join(" ");
        let (place, turn, axis, com, tilt) =
            (numbers(3, 0.5), numbers(3, 3.0), numbers(3, 1.0), numbers(3, 0.1), numbers(3, 3.0));
        let mass = draw.between(0.1, 4.0);
        let [a, b, c] = [0, 1, 2].map(|_| draw.between(0.01, 0.05) * mass);
        let [xy, xz, yz] = [0, 1, 2].map(|_| draw.between(-1e-4, 1e-4));
        let _ = writeln!(
            text,
            "  <link name=\"link{i}\"><inertial><origin xyz=\"{com}\" rpy=\"{tilt}\"/><mass value=\"{mass}\"/>\
             <inertia ixx=\"{}\" iyy=\"{}\" izz=\"{}\" ixy=\"{xy}\" ixz=\"{xz}\" iyz=\"{yz}\"/></inertial></link>",
            b + c,
            a + c,
            a + b
        );
        let kind = ["revolute", "continuous", "prismatic", "fixed"][draw.below(4)];
        let dynamics = if draw.below(2) == 0 { "<dynamics damping=\"0.5\" friction=\"0.2\"/>" } else { "" };
        let _ = writeln!(
            text,
            "  <joint name=\"joint{i}\" type=\"{kind}\">\n    <parent link=\"{parent}\"/><child link=\"link{i}\"/>\n    \
             <origin xyz=\"{place}\" rpy=\"{turn}\"/><axis xyz=\"{axis}\"/>\n    \
             <limit lower=\"-2\" upper=\"2\" effort=\"30\" velocity=\"3\"/>{dynamics}\n  </joint>"
        );
    }
    text + "</robot>\n"
}

fn compare(name: &str, robot: &Robot, theirs: &Value) -> usize {
    assert_eq!(theirs.get("error"), None, "{name}");
    let moved: f64 = (0..robot.links.len()).filter(|i| robot.moves(*i)).map(|i| robot.links[i].inertia.mass_kg).sum();
    let mass = theirs["mass"].as_f64().unwrap();
    assert!((moved - mass).abs() <= 1e-9 * mass.max(1e-12), "{name}: {moved} kg here, {mass} kg in Pinocchio");
    let joints = theirs["joints"].as_object().unwrap();
    assert_eq!(joints.len(), robot.joints.len(), "{name}");
    for joint in &robot.joints {
        let other = &joints[&joint.name];
        for (key, ours) in [("damping", joint.damping), ("friction", joint.friction)] {
            if let Some(number) = other[key].as_f64() {
                assert_eq!(number, ours, "{name}: {key} of {}", joint.name);
            }
        }
    }
    let motions = theirs["dynamics"].as_array().unwrap();
    // Pinocchio's inverse dynamics leave friction to the caller.
    let mut frictionless = robot.clone();
    frictionless.joints.iter_mut().for_each(|joint| joint.damping = 0.0);
    for motion in motions {
        let of = |key: &str| -> Vec<f64> {
            robot.joints.iter().map(|joint| motion[key][&joint.name].as_f64().unwrap()).collect()
        };
        let (q, v, a, force) = (of("q"), of("v"), of("a"), of("force"));
        let ours = newton_euler::inverse(&frictionless, &q, &v, &a);
        let size = force.iter().fold(1e-12_f64, |size, n| size.max(n.abs()));
        for (ours, theirs) in ours.iter().zip(&force) {
            assert!((ours - theirs).abs() <= 1e-9 * size, "{name}: {ours} here, {theirs} in Pinocchio");
        }
    }
    motions.len()
}

fn measured() -> Vec<PathBuf> {
    let Some(root) = std::env::var_os("TUNENET_MEASURED").map(PathBuf::from) else {
        println!("without robots of others: TUNENET_MEASURED is not set");
        return Vec::new();
    };
    let files = [
        "urdf-kinova/j2s7s300_standalone_expanded.urdf",
        "urdf-kinova/j2s7s300_orsula_expanded.urdf",
        "urdf-robotiq/robotiq_2f_85.urdf",
        "servo-sts3215/pendulum.urdf",
        "models/so101/so101_new_calib.urdf",
    ];
    files.iter().map(|file| root.join(file)).collect()
}

#[test]
fn urdfs_are_the_same_in_pinocchio() {
    if !python_with("pinocchio") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut texts: Vec<(String, String)> = (0..40).map(|seed| (format!("drawn_{seed}"), urdf(seed))).collect();
    for path in measured() {
        texts.push((path.display().to_string().replace('/', "_"), std::fs::read_to_string(&path).unwrap()));
    }
    let (mut paths, mut robots) = (Vec::new(), Vec::new());
    for (name, text) in &texts {
        let model = Model::parse_alone(Path::new(name), text).unwrap_or_else(|error| panic!("{error}"));
        let change = |joint: &str, quantity, value| Change {
            joint: joint.into(),
            motion: Motion::Revolute,
            quantity,
            value,
            interval: None,
        };
        let changes: Vec<Change> = model
            .robot()
            .joints
            .iter()
            .flat_map(|joint| {
                [
                    change(&joint.name, Quantity::ViscousFriction, 0.125),
                    change(&joint.name, Quantity::CoulombFriction, 0.375),
                ]
            })
            .collect();
        let edited = edit(&model, &changes).unwrap().files.remove(0).text;
        for (ending, text) in [("before", text), ("after", &edited)] {
            let path = folder.path().join(format!("{name}_{ending}.urdf"));
            std::fs::write(&path, text).unwrap();
            robots.push(Model::read(&path).unwrap());
            paths.push(path);
        }
        let after = robots.last().unwrap().robot();
        assert!(after.joints.iter().all(|joint| joint.damping == 0.125 && joint.friction == 0.375), "{name}");
    }
    let mut motions = 0;
    for ((path, model), theirs) in paths.iter().zip(&robots).zip(ask("pinocchio_judge.py", &paths)) {
        assert!(model.robot().joints.iter().all(|joint| joint.motion != Motion::Free));
        motions += compare(&path.display().to_string(), model.robot(), &theirs);
    }
    println!("{} URDFs, {motions} motions", paths.len());
    assert!(motions >= 300, "{motions}");
}
