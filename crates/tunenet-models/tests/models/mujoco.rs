//! MuJoCo and this reader make the same of the same file: masses, inertias, joints, actuators, forces.

use std::path::{Path, PathBuf};

use nalgebra::Matrix3;
use serde_json::Value;
use tunenet_models::{Changes, Filter, Law, Model, Motion, Robot, Target, Weight, read_file};

use super::support::{generator, judge, newton_euler, numbers, python_with};

/// Relative to the largest number of its kind.
const SAME: f64 = 1e-9;

fn close(what: &str, ours: &[f64], theirs: &[f64], scale: f64) {
    assert_eq!(ours.len(), theirs.len(), "{what}");
    let size = theirs.iter().fold(scale, |size, n| size.max(n.abs()));
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a - b).abs() <= SAME * size, "{what}: {ours:?} here, {theirs:?} in MuJoCo");
    }
}

fn same(name: &str, robot: &Robot, theirs: &Value) {
    let bodies = theirs["bodies"].as_array().unwrap();
    assert_eq!(robot.links.len(), bodies.len(), "{name}");
    for (link, body) in robot.links.iter().zip(bodies) {
        let named = body["name"].as_str().unwrap();
        assert!(named.is_empty() || named == link.name, "{name}: {} {named}", link.name);
        let what = format!("{name}: body {}", link.name);
        if matches!(link.weight, Weight::Mesh(_)) {
            continue;
        }
        let mass = body["mass"].as_f64().unwrap();
        close(&format!("{what}: mass"), &[link.inertia.mass_kg], &[mass], 0.0);
        if mass > 0.0 {
            close(&format!("{what}: centre of mass"), link.inertia.com_m.as_slice(), &numbers(&body["com"]), 1e-3);
        }
        let rows: Vec<f64> = body["tensor"].as_array().unwrap().iter().flat_map(numbers).collect();
        let tensor: Matrix3<f64> = Matrix3::from_row_slice(&rows);
        close(&format!("{what}: inertia"), link.inertia.about_com_kg_m2.as_slice(), tensor.as_slice(), 0.0);
    }
    let joints = theirs["joints"].as_array().unwrap();
    assert_eq!(robot.joints.len(), joints.len(), "{name}");
    for (joint, other) in robot.joints.iter().zip(joints) {
        let what = format!("{name}: joint {}", joint.name);
        let kinds = [Motion::Free, Motion::Ball, Motion::Prismatic, Motion::Revolute];
        let kind = kinds[usize::try_from(other["type"].as_u64().unwrap()).unwrap()];
        assert_eq!(joint.motion, kind, "{what}");
        let number = |key: &str| other[key].as_f64().unwrap();
        close(&what, &[joint.armature, joint.friction], &["armature", "friction"].map(number), 0.0);
        if !robot.unused.iter().any(|left| left.attribute.as_deref() == Some("springdamper")) {
            close(&what, &[joint.damping, joint.stiffness], &["damping", "stiffness"].map(number), 0.0);
        }
        if matches!(joint.motion, Motion::Free | Motion::Ball) {
            continue;
        }
        close(
            &format!("{what}: references"),
            &[joint.reference, joint.spring_reference],
            &["ref", "springref"].map(number),
            1e-3,
        );
        close(&format!("{what}: axis"), joint.axis.as_slice(), &numbers(&other["axis"]), 1.0);
        close(&format!("{what}: anchor"), joint.anchor_m.as_slice(), &numbers(&other["pos"]), 1e-3);
        range(&format!("{what}: range"), joint.range, &other["range"]);
        range(&format!("{what}: effort"), joint.effort_range, &other["effort"]);
    }
    let actuators = theirs["actuators"].as_array().unwrap();
    assert_eq!(robot.actuators.len(), actuators.len(), "{name}");
    for (actuator, other) in robot.actuators.iter().zip(actuators) {
        let what = format!("{name}: actuator {}", actuator.name);
        let number = |key: &str| other[key].as_f64().unwrap();
        if let Law::Affine { gain, bias } = actuator.law {
            assert_eq!(number("gaintype"), 0.0, "{what}");
            close(&format!("{what}: gain"), &[gain], &[number("gain")], 0.0);
            let theirs = if number("biastype") == 0.0 { vec![0.0; 3] } else { numbers(&other["bias"]) };
            close(&format!("{what}: bias"), &bias, &theirs, 0.0);
        } else {
            let plain = number("gaintype") == 0.0 && number("biastype") < 2.0 && number("dyntype") < 4.0;
            assert!(!plain || actuator.target == Target::Other, "{what}: an affine actuator was not taken on");
        }
        let filter = match (number("dyntype"), number("dyn")) {
            (1.0, _) => Filter::Integrator,
            (2.0 | 3.0, time_constant_s) if time_constant_s > 0.0 => Filter::LowPass { time_constant_s },
            _ => Filter::None,
        };
        if actuator.law != Law::Other {
            assert_eq!(actuator.filter, filter, "{what}");
        }
        close(&format!("{what}: gear"), &[actuator.gear, actuator.delay_s], &[number("gear"), number("delay")], 0.0);
        range(&format!("{what}: commands"), actuator.command_range, &other["ctrl"]);
        range(&format!("{what}: forces"), actuator.force_range, &other["force"]);
    }
}

fn range(what: &str, ours: Option<[f64; 2]>, theirs: &Value) {
    assert_eq!(ours.is_some(), !theirs.is_null(), "{what}: {ours:?} here, {theirs} in MuJoCo");
    if let Some(ours) = ours {
        close(what, &ours, &numbers(theirs), 0.0);
    }
}

/// Forces of motions, where no joint is a ball or free; how many were compared.
fn forces(name: &str, robot: &Robot, theirs: &Value) -> usize {
    let dynamics = theirs["dynamics"].as_array().unwrap();
    let mesh = robot.links.iter().any(|link| matches!(link.weight, Weight::Mesh(_)));
    if mesh || robot.joints.iter().any(|joint| matches!(joint.motion, Motion::Ball | Motion::Free)) {
        return 0;
    }
    for motion in dynamics {
        let [q, v, a] = ["q", "v", "a"].map(|key| numbers(&motion[key]));
        let ours = newton_euler::inverse(robot, &q, &v, &a);
        close(&format!("{name}: forces"), &ours, &numbers(&motion["force"]), 1e-6);
    }
    dynamics.len()
}

#[test]
fn drawn_robots_are_the_same_in_mujoco() {
    if !python_with("mujoco") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = (0..60)
        .map(|seed| {
            let path = folder.path().join(format!("drawn_{seed}.xml"));
            std::fs::write(&path, generator::mjcf(seed)).unwrap();
            path
        })
        .collect();
    let mut compared = 0;
    for (path, theirs) in paths.iter().zip(judge(&paths)) {
        let name = path.file_name().unwrap().to_string_lossy();
        let ours = Model::read(path);
        if let Some(error) = theirs.get("error") {
            panic!("{name}: MuJoCo refuses a drawn robot: {error}\n{}", std::fs::read_to_string(path).unwrap());
        }
        let ours = ours.unwrap_or_else(|error| panic!("{name}: {error}"));
        same(&name, ours.robot(), &theirs);
        compared += forces(&name, ours.robot(), &theirs);
    }
    println!("{} robots, {compared} motions", paths.len());
    assert!(compared >= 200, "{compared}");
}

/// Copies a folder's XML files, as the judge adds meshes.
fn copied(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "xml") {
            std::fs::copy(&path, to.join(path.file_name().unwrap())).unwrap();
        }
    }
}

#[test]
fn robots_of_others_are_the_same_in_mujoco() {
    let Some(root) = std::env::var_os("TUNENET_MEASURED").map(PathBuf::from) else {
        println!("skipped: TUNENET_MEASURED is not set");
        return;
    };
    if !python_with("mujoco") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut paths = Vec::new();
    for (robot, file) in [
        ("so101", "so101_new_calib.xml"),
        ("universal_robots_ur5e", "ur5e.xml"),
        ("unitree_g1", "g1.xml"),
        ("unitree_g1", "scene.xml"),
    ] {
        let own = folder.path().join(robot);
        std::fs::create_dir_all(&own).unwrap();
        copied(&root.join("models").join(robot), &own);
        paths.push(own.join(file));
    }
    let mut compared = 0;
    for (path, theirs) in paths.iter().zip(judge(&paths)) {
        let name = path.display().to_string();
        assert_eq!(theirs.get("error"), None, "{name}");
        let ours = Model::read(path).unwrap_or_else(|error| panic!("{error}"));
        same(&name, ours.robot(), &theirs);
        compared += forces(&name, ours.robot(), &theirs);
    }
    assert_eq!(compared, 8, "the two arms without free joints");
}

/// All models below a folder.
fn models(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            models(&path, found);
        } else if path.extension().is_some_and(|e| e == "xml")
            && read_file(&path).is_ok_and(|text| text.contains("<mujoco"))
        {
            found.push(path);
        }
    }
}

/// Every model of a folder of one's choice; the judge may write meshes that are missing into it.
#[test]
fn any_folder_of_models_is_the_same_in_mujoco() {
    let Some(root) = std::env::var_os("TUNENET_MODELS").map(PathBuf::from) else {
        println!("skipped: TUNENET_MODELS names no folder");
        return;
    };
    if !python_with("mujoco") {
        return;
    }
    let mut paths = Vec::new();
    models(&root, &mut paths);
    paths.sort();
    let (mut compared, mut refused, mut wrong) = (0, 0, Vec::new());
    for (path, theirs) in paths.iter().zip(judge(&paths)) {
        let name = path.display().to_string();
        if let Some(error) = theirs.get("error") {
            println!("MuJoCo refuses {name}: {error}");
            refused += 1;
            continue;
        }
        // A part of a model, without bodies.
        if theirs["bodies"].as_array().unwrap().is_empty() {
            assert!(Model::read_within(path, &root).is_err(), "{name}");
            continue;
        }
        match Model::read_within(path, &root) {
            Err(error) => wrong.push(error.to_string()),
            Ok(ours) => {
                // MuJoCo takes the file, so its elements and attributes are known.
                let unknown = ours.robot().unused.iter().filter(|left| left.changes == Changes::Unknown);
                wrong.extend(unknown.map(|left| format!("{name}: {left}")));
                let named = ours.robot().unused.iter().any(|left| left.changes <= Changes::Dynamics);
                let all = std::panic::catch_unwind(|| {
                    same(&name, ours.robot(), &theirs);
                    if named { 0 } else { forces(&name, ours.robot(), &theirs) }
                });
                match all {
                    Ok(motions) => compared += motions,
                    Err(why) => wrong.push(why.downcast_ref::<String>().cloned().unwrap_or_default()),
                }
            }
        }
    }
    println!(
        "{} models, {refused} refused by MuJoCo, {compared} motions compared, {} differ",
        paths.len(),
        wrong.len()
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
