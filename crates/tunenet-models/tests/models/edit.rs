//! Edited models: MuJoCo reads the numbers that were meant, all others are the same, and so is every other byte.

use std::path::{Path, PathBuf};

use quick_xml::Reader;
use quick_xml::events::Event;
use serde_json::Value;
use tunenet_models::edit::{Edited, edit};
use tunenet_models::{Change, Model, Motion, Quantity};

use super::support::{generator, judge, newton_euler, numbers, python_with};

fn change(joint: &str, quantity: Quantity, value: f64) -> Change {
    Change { joint: joint.into(), motion: Motion::Revolute, quantity, value, interval: None }
}

/// What a text is made of: tags with their attributes, and every byte between them.
fn pieces(text: &str) -> Vec<(String, Vec<(String, String)>)> {
    let mut reader = Reader::from_str(text);
    let mut all = Vec::new();
    loop {
        match reader.read_event().unwrap() {
            Event::Eof => return all,
            Event::Start(tag) | Event::Empty(tag) => {
                let attributes = tag.attributes().map(|a| {
                    let a = a.unwrap();
                    (String::from_utf8_lossy(a.key.as_ref()).into_owned(), a.unescape_value().unwrap().into_owned())
                });
                all.push((String::from_utf8_lossy(tag.name().as_ref()).into_owned(), attributes.collect()));
            }
            other => all.push((String::from_utf8_lossy(&other).into_owned(), Vec::new())),
        }
    }
}

/// Only attributes that were written differ between the texts.
fn only_meant(old: &str, edited: &Edited) {
    let new = &edited.files[0].text;
    let (old, new) = (pieces(old), pieces(new));
    assert_eq!(old.len(), new.len());
    let written = |tag: &str, key: &str| {
        edited
            .done
            .iter()
            .any(|done| done.written.starts_with(&format!("<{tag}")) && done.written.contains(&format!(" {key}=")))
    };
    for ((tag, before), (same, after)) in old.iter().zip(&new) {
        assert_eq!(tag, same);
        for (key, value) in after {
            let was = before.iter().find(|(other, _)| other == key).map(|(_, value)| value);
            assert!(was == Some(value) || written(tag, key), "<{tag} {key}> was {was:?} and is {value}");
        }
        for (key, _) in before {
            assert!(after.iter().any(|(other, _)| other == key) || key == "dampratio", "<{tag} {key}> is gone");
        }
    }
}

#[test]
fn the_rest_of_the_text_stays_byte_for_byte() {
    let text = "<?xml version=\"1.0\"?>\r\n<!-- mine -- really -->\n<mujoco>\n\t<default><joint damping='9'/></default>\n<worldbody>\
        <body>\n  <joint\n    name = 'a'   armature= \"0.1\"\n  ></joint><joint name=\"b\" damping='1 2 3'/><geom size='0.1'/></body></worldbody>\n\
        <actuator>\n<position joint='a' dampratio=\"1\" kp='2' /></actuator>\n</mujoco>\n<!-- é -->\n";
    let model = Model::parse_alone(Path::new("m.xml"), text).unwrap();
    let changes = [
        change("a", Quantity::ViscousFriction, 0.5),
        change("a", Quantity::Armature, 1e-7),
        change("b", Quantity::ViscousFriction, 4.0),
        change("a", Quantity::PositionGain, 30.0),
        change("a", Quantity::VelocityGain, 0.25),
        change("a", Quantity::Backlash, 0.01),
    ];
    let edited = edit(&model, &changes).unwrap();
    let expected = text
        .replace("armature= \"0.1\"", "armature= \"1e-7\" damping=\"0.5\"")
        .replace("'1 2 3'", "'4 2 3'")
        .replace(" dampratio=\"1\" kp='2'", " kp='30' kv=\"0.25\"");
    assert_eq!(edited.files[0].text, expected);
    assert_eq!(edited.done.len(), 5);
    assert_eq!(edited.left.len(), 1);
    assert_eq!(edited.notes.len(), 2, "{:?}", edited.notes);
    let nothing = edit(&model, &[]).unwrap();
    assert_eq!(nothing.files[0].text, text);
}

#[test]
fn numbers_of_included_files_come_back_as_those_files() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, arm) = (folder.path().join("scene.xml"), folder.path().join("arm.xml"));
    let (outer, inner) = (
        "<mujoco><include file='arm.xml'/></mujoco>",
        "<mujoco><worldbody><body><joint name='a'/><geom size='0.1'/></body></worldbody></mujoco>",
    );
    std::fs::write(&scene, outer).unwrap();
    std::fs::write(&arm, inner).unwrap();
    let edited = edit(&Model::read(&scene).unwrap(), &[change("a", Quantity::Armature, 0.2)]).unwrap();
    assert_eq!(edited.files[0].text, outer);
    assert_eq!(edited.files[1].path, arm);
    assert_eq!(edited.files[1].text, inner.replace("name='a'", "name='a' armature=\"0.2\""));
    assert!(edited.other_files().unwrap().contains("arm.xml"));
}

#[test]
fn impossible_changes_are_refused_with_a_sentence() {
    let text = "<mujoco><worldbody><body><joint name='a'/><geom size='0.1'/></body></worldbody></mujoco>";
    let model = Model::parse_alone(Path::new("m.xml"), text).unwrap();
    for (joint, value, found) in [
        ("b", 1.0, "expected a joint of the model (`a`), found `b`"),
        ("a", -1.0, "found -1"),
        ("a", f64::NAN, "found NaN"),
    ] {
        let error = edit(&model, &[change(joint, Quantity::Armature, value)]).unwrap_err();
        assert!(error.to_string().contains(found), "{error}");
    }
    let interval = Some([2.0, 1.0]);
    assert!(edit(&model, &[Change { interval, ..change("a", Quantity::Armature, 1.0) }]).is_err());
}

/// Both gains of a general servo stand in `biasprm`: whichever comes first, both are written.
#[test]
fn a_general_servo_gets_both_gains() {
    let text = "<mujoco><worldbody><body><joint name='a'/><geom size='0.1'/></body></worldbody><actuator>\
        <general joint='a' gainprm='60' biastype='affine' biasprm='0 -60 -.5'/></actuator></mujoco>";
    let model = Model::parse_alone(Path::new("m.xml"), text).unwrap();
    let gains = [change("a", Quantity::PositionGain, 29.0), change("a", Quantity::VelocityGain, 0.25)];
    let turned = [gains[1].clone(), gains[0].clone()];
    for changes in [&gains, &turned] {
        let edited = edit(&model, changes).unwrap();
        let expected = text.replace("'60'", "'29'").replace("'0 -60 -.5'", "'0 -29 -0.25'");
        assert_eq!(edited.files[0].text, expected);
    }
    let alone = edit(&model, &gains[1..]).unwrap();
    assert_eq!(alone.files[0].text, text.replace("-.5", "-0.25"));
}

/// Gains and limits are those of the joint, whichever gear the actuator has, gets, or gets with them.
#[test]
fn a_new_gear_counts_for_the_gains_that_come_with_it() {
    let text = "<mujoco><worldbody><body><joint name='a'/><geom size='0.1'/></body></worldbody>\
        <actuator><position name='m' joint='a' gear='2' kp='1'/></actuator></mujoco>";
    let model = Model::parse_alone(Path::new("m.xml"), text).unwrap();
    let changes = [
        change("a", Quantity::PositionGain, 50.0),
        change("a", Quantity::TorqueLimit, 10.0),
        change("a", Quantity::Gear, -5.0),
        change("a", Quantity::VelocityGain, 5.0),
    ];
    let edited = edit(&model, &changes).unwrap();
    let again = Model::parse_alone(Path::new("m.xml"), &edited.files[0].text).unwrap();
    let actuator = &again.robot().actuators[0];
    assert_eq!(
        (actuator.gear, actuator.position_gains(), actuator.force_range),
        (-5.0, Some([2.0, 0.2]), Some([-2.0, 2.0]))
    );
    let none = edit(&model, &[change("a", Quantity::PositionGain, 1.0), change("a", Quantity::Gear, 0.0)]).unwrap();
    assert_eq!(none.left.len(), 1, "{none:?}");
}

#[test]
fn the_same_number_twice_is_refused() {
    let text = "<mujoco><worldbody><body><joint name='a'/><geom size='0.1'/></body></worldbody></mujoco>";
    let model = Model::parse_alone(Path::new("m.xml"), text).unwrap();
    let twice = [change("a", Quantity::Armature, 1.0), change("a", Quantity::Armature, 2.0)];
    let error = edit(&model, &twice).unwrap_err();
    assert!(error.to_string().contains("joint `a`: expected armature once, found it twice"), "{error}");
}

#[test]
fn a_urdf_gets_friction_and_effort_alone() {
    let text = "<robot name='r'>\n  <link name='a'/><link name='b'/><link name='c'/>\n\
        <joint name='j' type='revolute'>\n    <parent link='a'/>\n    <child link='b'/>\n    <limit lower='-1' upper='1' effort='3' velocity='1'/>\n  </joint>\n\
        <joint name='k' type='continuous'><parent link='b'/><child link='c'/><dynamics friction='1'></dynamics></joint>\n\
        <transmission name='t'><joint name='j'><x/></joint></transmission></robot>";
    let model = Model::parse_alone(Path::new("r.urdf"), text).unwrap();
    let changes = [
        change("j", Quantity::ViscousFriction, 0.5),
        change("j", Quantity::CoulombFriction, 0.25),
        change("j", Quantity::TorqueLimit, 8.0),
        change("k", Quantity::ViscousFriction, 2.0),
        change("k", Quantity::TorqueLimit, 2.0),
        change("k", Quantity::Armature, 2.0),
    ];
    let edited = edit(&model, &changes).unwrap();
    let expected = text
        .replace(
            "effort='3' velocity='1'/>",
            "effort='8' velocity='1'/>\n    <dynamics damping=\"0.5\" friction=\"0.25\"/>",
        )
        .replace("<dynamics friction='1'>", "<dynamics friction='1' damping=\"2\">");
    assert_eq!(edited.files[0].text, expected);
    assert_eq!(
        edited.left.iter().map(|left| left.change.quantity).collect::<Vec<_>>(),
        [Quantity::TorqueLimit, Quantity::Armature]
    );
    let again = Model::parse_alone(Path::new("r.urdf"), &expected).unwrap();
    let joint = &again.robot().joints[0];
    assert_eq!((joint.damping, joint.friction, joint.effort_range), (0.5, 0.25, Some([-8.0, 8.0])));
}

/// What was found of a joint holds for those that follow it; by a curve, a joint does not follow in proportion, and keeps its own.
#[test]
fn numbers_of_joints_that_follow_become_zero() {
    let text = "<mujoco><worldbody><body><joint name='a' type='slide'/><geom size='0.1'/></body>\
        <body><joint name='b' type='slide' damping='3' armature='0.05'/><geom size='0.1'/></body>\
        <body><joint name='c' type='slide' damping='2'/><geom size='0.1'/></body></worldbody>\
        <equality><joint joint1='b' joint2='a' polycoef='0 -1 0 0 0'/><joint joint1='c' joint2='b' polycoef='0 1 0.5'/></equality></mujoco>";
    let model = Model::parse_alone(Path::new("m.xml"), text).unwrap();
    let edited = edit(&model, &[change("a", Quantity::ViscousFriction, 6.5)]).unwrap();
    let expected = text.replace("name='a' type='slide'", "name='a' type='slide' damping=\"6.5\"").replace("'3'", "'0'");
    assert_eq!(edited.files[0].text, expected);
    assert_eq!(edited.notes, ["`damping` of `b` is 0 in the copy: what is written of `a` holds for both"]);
}

/// A mass of its own stands where the link and what is fixed to it have their centre of mass.
#[test]
fn an_extra_load_is_a_body_at_the_centre_of_mass() {
    let text = "<mujoco><worldbody><body name='link'><joint name='a'/><inertial pos='0 0 0.125' mass='1' diaginertia='1 1 1'/>\
        <body pos='0 0 0.25'><inertial pos='0 0 0.125' mass='3' diaginertia='1 1 1'/></body></body></worldbody></mujoco>";
    let model = Model::parse_alone(Path::new("m.xml"), text).unwrap();
    let edited = edit(&model, &[change("a", Quantity::ExtraLoad, 0.5)]).unwrap();
    let body = "<body name=\"extra_load\" pos=\"0 0 0.3125\"><inertial pos=\"0 0 0\" mass=\"0.5\" diaginertia=\"1e-9 1e-9 1e-9\"/></body>";
    assert_eq!(edited.files[0].text, text.replace("<joint name='a'/>", &format!("<joint name='a'/>{body}")));
    assert_eq!(edited.done[0].written, body);
    let again = Model::parse_alone(Path::new("m.xml"), &edited.files[0].text).unwrap();
    let link = again.robot().links.iter().position(|link| link.name == "link").unwrap();
    assert_eq!(again.robot().fixed_together(link).mass_kg, 4.5);
    let less = edit(&model, &[change("a", Quantity::ExtraLoad, -0.5)]).unwrap();
    assert!(less.left[0].why.contains("take it from the mass of `link`"), "{:?}", less.left);
    // A URDF has a reason of its own.
    let urdf = "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint></robot>";
    let model = Model::parse_alone(Path::new("r.urdf"), urdf).unwrap();
    let left = edit(&model, &[change("j", Quantity::ExtraLoad, 0.5)]).unwrap().left;
    assert!(left[0].why.contains("add a link of this mass"), "{left:?}");
}

/// Numbers for every joint and actuator of a model.
fn drawn(model: &Model, seed: u64) -> Vec<Change> {
    let mut draw = generator::Draw(seed);
    let mut all = Vec::new();
    for joint in &model.robot().joints {
        for quantity in [
            Quantity::ViscousFriction,
            Quantity::CoulombFriction,
            Quantity::Armature,
            Quantity::Stiffness,
            Quantity::SpringReference,
            Quantity::PositionGain,
            Quantity::VelocityGain,
            Quantity::TorqueLimit,
            Quantity::CommandDelay,
        ] {
            if draw.below(3) == 0 {
                let value =
                    if quantity == Quantity::CommandDelay { draw.between(0.01, 0.1) } else { draw.between(0.1, 3.0) };
                all.push(change(&joint.name, quantity, value));
            }
        }
    }
    all
}

/// What MuJoCo has where this quantity of this joint was written.
fn seen(theirs: &Value, model: &Model, change: &Change) -> f64 {
    let robot = model.robot();
    let joint = robot.joint(&change.joint).unwrap();
    let of_joint = |key: &str| theirs["joints"][joint][key].as_f64().unwrap();
    let actuator = robot.actuators.iter().position(|a| a.target == tunenet_models::Target::Joint(joint));
    let of_actuator = |key: &str| &theirs["actuators"][actuator.unwrap()][key];
    let gear = || of_actuator("gear").as_f64().unwrap().abs();
    match change.quantity {
        Quantity::ViscousFriction => of_joint("damping"),
        Quantity::CoulombFriction => of_joint("friction"),
        Quantity::Armature => of_joint("armature"),
        Quantity::Stiffness => of_joint("stiffness"),
        Quantity::SpringReference => of_joint("springref"),
        Quantity::PositionGain => of_actuator("gain").as_f64().unwrap() * gear().powi(2),
        Quantity::VelocityGain => -numbers(of_actuator("bias"))[2] * gear().powi(2),
        Quantity::TorqueLimit => numbers(of_actuator("force"))[1] * gear(),
        Quantity::CommandDelay => of_actuator("delay").as_f64().unwrap(),
        other => panic!("{other:?}"),
    }
}

/// Paths of bodies, and those numbers of joints and actuators that nothing was written to, are those of the original.
fn others_are_the_same(name: &str, before: &Value, after: &Value, edited: &Edited, model: &Model) {
    assert_eq!(before["bodies"], after["bodies"], "{name}");
    let written = |joint: usize| edited.done.iter().any(|done| model.robot().joint(&done.change.joint) == Some(joint));
    for (i, (old, new)) in
        before["joints"].as_array().unwrap().iter().zip(after["joints"].as_array().unwrap()).enumerate()
    {
        assert!(old == new || written(i), "{name}: {old} {new}");
    }
    for (i, (old, new)) in
        before["actuators"].as_array().unwrap().iter().zip(after["actuators"].as_array().unwrap()).enumerate()
    {
        let target = model.robot().actuators[i].target;
        let own = matches!(target, tunenet_models::Target::Joint(joint) if written(joint));
        // A damping ratio follows the inertias of the tree, which an armature changes.
        let damping = old["bias"][2] != new["bias"][2]
            && edited.done.iter().any(|done| done.change.quantity == Quantity::Armature);
        assert!(old == new || own || damping, "{name}: {old} {new}");
    }
}

/// Forces of motions of the edited model, here and in MuJoCo; how many.
fn forces(name: &str, text: &str, theirs: &Value) -> usize {
    let model = Model::parse_alone(Path::new(name), text).unwrap();
    let motions = theirs["dynamics"].as_array().unwrap();
    if model.robot().joints.iter().any(|joint| joint.motion == tunenet_models::Motion::Free) {
        return 0;
    }
    for motion in motions {
        let [q, v, a, force] = ["q", "v", "a", "force"].map(|key| numbers(&motion[key]));
        let size = force.iter().fold(1e-6_f64, |size, n| size.max(n.abs()));
        for (ours, theirs) in newton_euler::inverse(model.robot(), &q, &v, &a).iter().zip(&force) {
            assert!((ours - theirs).abs() <= 1e-9 * size, "{name}: {ours} here, {theirs} in MuJoCo");
        }
    }
    motions.len()
}

#[test]
fn mujoco_reads_what_was_meant_and_nothing_else() {
    if !python_with("mujoco") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut originals: Vec<(String, String)> =
        (100..140).map(|seed| (format!("drawn_{seed}"), generator::mjcf(seed))).collect();
    if let Some(root) = std::env::var_os("TUNENET_MEASURED").map(PathBuf::from) {
        for (name, file) in [
            ("so101", "so101/so101_new_calib.xml"),
            ("ur5e", "universal_robots_ur5e/ur5e.xml"),
            ("g1", "unitree_g1/g1.xml"),
        ] {
            originals.push((name.into(), std::fs::read_to_string(root.join("models").join(file)).unwrap()));
        }
    }
    let (mut paths, mut edits) = (Vec::new(), Vec::new());
    for (i, (name, text)) in originals.iter().enumerate() {
        let model = Model::parse_alone(Path::new(name), text).unwrap();
        let edited = edit(&model, &drawn(&model, i as u64)).unwrap();
        only_meant(text, &edited);
        let own = folder.path().join(name);
        std::fs::create_dir_all(&own).unwrap();
        for (file, text) in [("before.xml", text), ("after.xml", &edited.files[0].text)] {
            std::fs::write(own.join(file), text).unwrap();
            paths.push(own.join(file));
        }
        edits.push((name, model, edited));
    }
    let answers = judge(&paths);
    let (mut written, mut left, mut motions) = (0, 0, 0);
    for ((name, model, edited), pair) in edits.iter().zip(answers.chunks_exact(2)) {
        let (before, after) = (&pair[0], &pair[1]);
        assert_eq!(after.get("error"), None, "{name}: {}", edited.files[0].text);
        for done in &edited.done {
            let found = seen(after, model, &done.change);
            let meant = done.change.value;
            assert!((found - meant).abs() <= 1e-9 * meant.abs(), "{name}: {done:?}: {found} in MuJoCo");
        }
        others_are_the_same(name, before, after, edited, model);
        motions += forces(name, &edited.files[0].text, after);
        written += edited.done.len();
        left += edited.left.len();
    }
    println!("{} models, {written} numbers written and read by MuJoCo, {left} left, {motions} motions", edits.len());
    assert!(written > 500 && motions > 100, "{written} {motions}");
}

/// The same for a folder of one's choice, whose models name meshes: the edited ones stand in it for as long as MuJoCo reads them.
#[test]
fn mujoco_reads_what_was_meant_in_any_folder_of_models() {
    let Some(root) = std::env::var_os("TUNENET_MODELS").map(PathBuf::from) else {
        println!("skipped: TUNENET_MODELS names no folder");
        return;
    };
    if !python_with("mujoco") {
        return;
    }
    let (mut paths, mut edits) = (Vec::new(), Vec::new());
    for (i, path) in models(&root).into_iter().enumerate() {
        let Ok(model) = Model::read_within(&path, &root) else { continue };
        let edited = edit(&model, &drawn(&model, i as u64)).unwrap();
        // Files that are included would have to be replaced.
        if edited.files.len() > 1 || edited.done.is_empty() {
            continue;
        }
        only_meant(&std::fs::read_to_string(&path).unwrap(), &edited);
        let own = path.with_file_name(format!("tunenet_edited_{i}.xml"));
        std::fs::write(&own, &edited.files[0].text).unwrap();
        paths.extend([path.clone(), own]);
        edits.push((path.display().to_string(), model, edited));
    }
    let answers = judge(&paths);
    paths.iter().skip(1).step_by(2).for_each(|own| std::fs::remove_file(own).unwrap());
    let (mut read, mut written, mut wrong) = (0, 0, Vec::new());
    for ((name, model, edited), pair) in edits.iter().zip(answers.chunks_exact(2)) {
        let (before, after) = (&pair[0], &pair[1]);
        if before.get("error").is_some() {
            continue;
        }
        read += 1;
        if let Some(error) = after.get("error") {
            wrong.push(format!("{name}: {error}"));
            continue;
        }
        for done in &edited.done {
            let (found, meant) = (seen(after, model, &done.change), done.change.value);
            if (found - meant).abs() > 1e-9 * meant.abs() {
                wrong.push(format!("{name}: {done:?}: {found} in MuJoCo"));
            }
            written += 1;
        }
    }
    println!("{read} models, {written} numbers written and read by MuJoCo");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// All MJCFs below a folder, in order.
fn models(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "xml") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
