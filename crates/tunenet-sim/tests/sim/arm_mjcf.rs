//! Arms that an MJCF describes: torques as in MuJoCo, the same arm as from a URDF, and what cannot be one.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use nalgebra::Vector3;
use serde_json::Value;
use tunenet_core::simulator::Simulator;
use tunenet_sim::SimulationFile;
use tunenet_sim::arm::model_file::JointFriction;
use tunenet_sim::arm::{Model, Recursion, model_file, urdf};
use tunenet_sim::observed_arm::ObservedArm;

#[path = "../../../tunenet-models/tests/models/support/generator.rs"]
mod generator;

const MJCF: &str = r#"<mujoco model="two">
  <compiler angle="degree"/>
  <default><default class="arm"><joint damping="0.5" frictionloss="0.2" armature="0.01"/></default></default>
  <worldbody>
    <body name="upper" pos="0 0 1" childclass="arm"><joint name="shoulder" axis="0 1 0" range="-90 90"/>
      <inertial pos="0.2 0 0" mass="2" diaginertia="0.01 0.02 0.02"/>
      <body name="fore" pos="0.4 0 0" euler="0 0 90"><joint name="elbow" axis="1 0 0"/>
        <inertial pos="0 0.1 0" quat="1 0 0 1" mass="1" diaginertia="0.001 0.004 0.004"/>
        <body name="grip" pos="0 0.3 0"><geom size="0.05" mass="0.5"/></body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="elbow" gear="50" forcerange="-0.1 0.1"/></actuator>
</mujoco>"#;

const URDF: &str = r#"<robot name="two"><link name="world"/>
  <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="2"/><inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0 0.1 0" rpy="0 0 1.5707963267948966"/><mass value="1"/><inertia ixx="0.001" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="grip"><inertial><mass value="0.5"/><inertia ixx="0.0005" iyy="0.0005" izz="0.0005" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="world"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/>
    <limit lower="-1.5707963267948966" upper="1.5707963267948966" effort="0" velocity="0"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0" rpy="0 0 1.5707963267948966"/><axis xyz="1 0 0"/></joint>
  <joint name="hand" type="fixed"><parent link="fore"/><child link="grip"/><origin xyz="0 0.3 0"/></joint>
</robot>"#;

fn torques(model: &Model, gravity: Vector3<f64>, [q, v, a]: [&[f64]; 3]) -> Vec<f64> {
    let mut torques = vec![0.0; model.degrees()];
    Recursion::new(model, gravity).inverse_dynamics(q, v, a, &mut torques);
    torques
}

#[test]
fn both_formats_describe_the_same_arm() {
    let mjcf = model_file::parse_mjcf(Path::new("two.xml"), MJCF).unwrap().chain_to("grip").unwrap().weighed().unwrap();
    let urdf = urdf::parse(Path::new("two.urdf"), URDF).unwrap().chain_to("grip").unwrap().weighed().unwrap();
    let motion: [&[f64]; 3] = [&[0.3, -0.7], &[1.0, 2.0], &[-3.0, 0.5]];
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    for (a, b) in torques(&mjcf, gravity, motion).iter().zip(torques(&urdf, gravity, motion)) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
    let names: Vec<_> = mjcf.joints().iter().map(|joint| joint.name.clone()).collect();
    assert_eq!(names, ["shoulder", "elbow"]);
    let elbow = mjcf.joints()[1].clone();
    assert_eq!((elbow.damping, elbow.friction, elbow.limits.effort), (0.5, 0.2, 5.0));
    let said = |part: &str| mjcf.notes.iter().any(|note| note.text.contains(part));
    assert!(said("armature (`effects.armature`)") && said("`elbow` 0.01"), "{:?}", mjcf.notes);
}

#[test]
fn friction_goes_into_the_mjcf_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.xml");
    std::fs::write(&path, MJCF).unwrap();
    let found = [JointFriction { joint: "elbow".into(), damping: 0.75, friction: 1.25 }];
    let text = model_file::with_friction(&path, &found).unwrap();
    let elbow = "<joint name=\"elbow\" axis=\"1 0 0\"";
    // With the numbers by which it holds.
    let written = "damping=\"0.75\" frictionloss=\"1.25\" solreffriction=\"0.004 1\" solimpfriction=\"0.9999 0.9999 0.001 0.5 2\"";
    assert_eq!(text, MJCF.replace(elbow, &format!("{elbow} {written}")));
    let scene = folder.path().join("scene.xml");
    std::fs::write(&scene, "<mujoco><include file=\"two.xml\"/></mujoco>").unwrap();
    // The copy needs no other file.
    let joined = model_file::with_friction(&scene, &found).unwrap();
    let model = model_file::parse_mjcf(Path::new("copy.xml"), &joined).unwrap();
    let elbow = model.joints().into_iter().find(|joint| joint.name == "elbow").unwrap();
    assert_eq!((elbow.damping, elbow.friction), (0.75, 1.25));
}

#[test]
fn friction_goes_into_the_joint_of_a_urdf_and_into_no_comment() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.urdf");
    let text = "<robot name='r'><link name='u'/><link name='v'/><!-- <joint name='a' type='fixed'></joint> -->\n\
        <joint\n name='a'\n type='continuous'><parent link='u'/><child link='v'/>\n <dynamics damping='9'></dynamics></joint>\n\
        <transmission name='t'><joint name='a'><x/></joint></transmission></robot>";
    std::fs::write(&path, text).unwrap();
    let found = [JointFriction { joint: "a".into(), damping: 1.0, friction: 2.0 }];
    let written = model_file::with_friction(&path, &found).unwrap();
    assert_eq!(written, text.replace("damping='9'", "damping='1' friction=\"2\""));
    assert!(model_file::with_friction(&path, &[JointFriction { joint: "b".into(), ..found[0].clone() }]).is_err());
}

#[test]
fn what_only_a_mesh_weighs_is_asked_for_and_free_joints_are_held() {
    let body = |inside: &str| format!("<mujoco><worldbody><body name='b'>{inside}</body></worldbody></mujoco>");
    let parse = |text: &str| model_file::parse_mjcf(Path::new("m.xml"), text);
    let mesh = "<joint name='j'/><geom type='mesh' mesh='m'/>";
    let refused = parse(&body(mesh)).unwrap_err();
    assert!(refused.to_string().contains("body `b`, which moves: expected an <inertial>, found none"), "{refused}");
    assert!(refused.hint().is_some());
    // Fixed to the world, nobody needs its mass.
    let solid = "<geom size='0.1'/>";
    let fixed = body(&format!("<geom type='mesh' mesh='m'/><body name='c'><joint name='j'/>{solid}</body>"));
    assert_eq!(parse(&fixed).unwrap().bodies.len(), 1);
    let free = body(&format!("<freejoint name='base'/>{solid}<body name='c'><joint name='j'/>{solid}</body>"));
    let model = parse(&free).unwrap();
    assert_eq!(model.degrees(), 1);
    assert!(model.notes.iter().any(|note| note.text.contains("free joint `base` is held")), "{:?}", model.notes);
    assert!(parse(&body(solid)).unwrap_err().to_string().contains("expected a hinge or a slide"));
}

#[test]
fn followers_move_in_proportion_around_their_references() {
    let text = "<mujoco><compiler angle='radian'/><worldbody>\
        <body name='a'><joint name='one' ref='0.5'/><geom size='0.1'/><body name='b'><joint name='two' ref='-0.25'/><geom size='0.1'/>\
        <body name='c'><joint name='three'/><geom size='0.1'/></body></body></body></worldbody>\
        <equality><joint joint1='two' joint2='one' polycoef='0.1 2'/><joint joint1='three' polycoef='0.3'/></equality></mujoco>";
    let model = model_file::parse_mjcf(Path::new("m.xml"), text).unwrap();
    assert_eq!((model.degrees(), model.bodies.len()), (1, 2));
    // q_two − (−0.25) = 0.1 + 2 · (q_one − 0.5)
    assert!((model.bodies[1].coordinate.position(&[0.8]) - (-0.25 + 0.1 + 2.0 * 0.3)).abs() < 1e-12);
    let circle = text.replace("joint1='three' polycoef='0.3'", "joint1='one' joint2='two'");
    assert!(model_file::parse_mjcf(Path::new("m.xml"), &circle).is_err());
    // The second equality of a joint cannot count as well, and is noted.
    let twice = text.replace("</equality>", "<joint joint1='two' joint2='one' polycoef='0 5'/></equality>");
    let model = model_file::parse_mjcf(Path::new("m.xml"), &twice).unwrap();
    assert_eq!(model.bodies[1].coordinate.multiplier, 2.0);
    assert!(model.notes.iter().any(|note| note.text.contains("`two` follows several others")), "{:?}", model.notes);
    let steep = text.replace("joint1='three' polycoef='0.3'", "joint1='three' joint2='two' polycoef='0 1e300'");
    let steep = steep.replace("'0.1 2'", "'0 1e300'");
    let refused = model_file::parse_mjcf(Path::new("m.xml"), &steep).unwrap_err().to_string();
    assert!(refused.contains("expected to follow by finite numbers"), "{refused}");
}

/// What brakes a joint that follows is felt by the one that it follows.
#[test]
fn a_joint_carries_what_follows_it() {
    let text = "<mujoco><worldbody><body name='a'><joint name='one' damping='1' frictionloss='0.1'/><geom size='0.1'/></body>\
        <body name='b'><joint name='two' damping='3' armature='0.5' frictionloss='0.2'/><geom size='0.1'/></body></worldbody>\
        <equality><joint joint1='two' joint2='one' polycoef='0 -2'/></equality></mujoco>";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.xml");
    std::fs::write(&path, text).unwrap();
    let (driven, _) = model_file::read_driven(&path).unwrap();
    let one = &driven.bodies[0].joint;
    assert_eq!((one.damping, one.armature, one.friction), (13.0, 2.0, 0.1 + 0.4));
    // Torques are measured at the joint itself.
    assert_eq!(model_file::read(&path).unwrap().bodies[0].joint.damping, 1.0);
}

/// MuJoCo's answers, by the judge of the readers' own tests.
fn judge(paths: &[PathBuf]) -> Option<Vec<Value>> {
    let found = Command::new("python3").args(["-c", "import mujoco"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        println!("skipped: no python3 with mujoco");
        return None;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tunenet-models/tests/models/support/judge.py");
    let mut python = Command::new("python3")
        .arg(std::fs::canonicalize(script).unwrap())
        .current_dir(paths[0].parent().unwrap())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut list = python.stdin.take().unwrap();
    for path in paths {
        std::io::Write::write_fmt(&mut list, format_args!("{}\n", path.display())).unwrap();
    }
    drop(list);
    let output = String::from_utf8(python.wait_with_output().unwrap().stdout).unwrap();
    Some(output.lines().map(|line| serde_json::from_str(line).unwrap()).collect())
}

/// Rigid torques of the arm are MuJoCo's, less what armature, springs and damping add.
#[test]
fn torques_are_those_of_mujoco() {
    let folder = tempfile::tempdir().unwrap();
    let mut paths = Vec::new();
    for seed in 200..230 {
        let path = folder.path().join(format!("drawn_{seed}.xml"));
        std::fs::write(&path, generator::mjcf(seed)).unwrap();
        paths.push(path);
    }
    if let Some(root) = std::env::var_os("TUNENET_MEASURED").map(PathBuf::from) {
        for file in ["so101/so101_new_calib.xml", "universal_robots_ur5e/ur5e.xml"] {
            let path = folder.path().join(file.replace('/', "_"));
            std::fs::copy(root.join("models").join(file), &path).unwrap();
            paths.push(path);
        }
    }
    let Some(answers) = judge(&paths) else { return };
    let mut compared = 0;
    for (path, theirs) in paths.iter().zip(&answers) {
        assert_eq!(theirs.get("error"), None, "{}", path.display());
        let described = tunenet_models::Model::read(path).unwrap();
        let robot = described.robot();
        let model = model_file::read(path).unwrap();
        let gravity = Vector3::from(robot.gravity_m_s2.unwrap());
        for motion in theirs["dynamics"].as_array().unwrap() {
            let of = |key: &str| -> Vec<f64> {
                motion[key].as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect()
            };
            let (q, v, a, force) = (of("q"), of("v"), of("a"), of("force"));
            let ours = torques(&model, gravity, [&q, &v, &a]);
            let size = force.iter().fold(1e-6_f64, |size, n| size.max(n.abs()));
            for (j, joint) in robot.joints.iter().enumerate() {
                let more =
                    joint.armature * a[j] + joint.damping * v[j] + joint.stiffness * (q[j] - joint.spring_reference);
                let (ours, theirs) = (ours[j] + more, force[j]);
                assert!((ours - theirs).abs() <= 1e-9 * size, "{}: {ours} here, {theirs} in MuJoCo", path.display());
            }
            compared += 1;
        }
    }
    println!("{} models, {compared} motions", paths.len());
    assert!(compared >= 100, "{compared}");
}

/// The bodies below `parent` as MJCF.
fn bodies(robot: &tunenet_models::Robot, parent: Option<usize>) -> String {
    let list = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let pose = |place: &tunenet_models::Pose| {
        let turn = nalgebra::UnitQuaternion::from_rotation_matrix(&place.rotation);
        format!(
            "pos=\"{}\" quat=\"{}\"",
            list(place.translation.vector.as_slice()),
            list(&[turn.w, turn.i, turn.j, turn.k])
        )
    };
    let children = (0..robot.links.len()).filter(|i| robot.links[*i].parent == parent);
    let texts = children.map(|index| {
        let link = &robot.links[index];
        let joints = link.joints.iter().map(|&j| {
            let joint = &robot.joints[j];
            let range = joint.range.map_or_else(String::new, |range| format!(" range=\"{}\"", list(&range)));
            let effort = joint.effort_range.map_or_else(String::new, |e| format!(" actuatorfrcrange=\"{}\"", list(&e)));
            format!("<joint name=\"{}\" axis=\"{}\"{range}{effort}/>", joint.name, list(joint.axis.as_slice()))
        });
        let i = &link.inertia.about_com_kg_m2;
        let full = list(&[i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]]);
        let inertial = format!(
            "<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{full}\"/>",
            list(link.inertia.com_m.as_slice()),
            link.inertia.mass_kg
        );
        let inertial = if link.inertia.mass_kg > 0.0 { inertial } else { String::new() };
        let (joints, inside) = (joints.collect::<Vec<_>>().concat(), bodies(robot, Some(index)));
        format!("<body name=\"{}\" {}>{joints}{inertial}{inside}</body>\n", link.name, pose(&link.placement))
    });
    texts.collect::<Vec<_>>().concat()
}

/// The arm of the paper, from its URDF and from an MJCF of the same numbers, needs the same torques along its circle.
#[test]
fn a_simulation_file_takes_an_mjcf() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let urdf = tunenet_models::Model::read(&assets.join("jaco_robotiq.urdf")).unwrap();
    let text = format!(
        "<mujoco model=\"jaco\"><compiler angle=\"radian\"/><worldbody>\n{}</worldbody></mujoco>",
        bodies(urdf.robot(), None)
    );
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("jaco.xml"), text).unwrap();
    // MJCF has no limits of speed, which the choice of a posture respects: 0 stands for none.
    let urdf = std::fs::read_to_string(assets.join("jaco_robotiq.urdf")).unwrap();
    let mut pieces = urdf.split("velocity=\"");
    let mut slow = pieces.next().unwrap().to_owned();
    for piece in pieces {
        slow.push_str("velocity=\"0");
        slow.push_str(&piece[piece.find('"').unwrap()..]);
    }
    std::fs::write(folder.path().join("jaco.urdf"), slow).unwrap();
    let scene = std::fs::read_to_string(assets.join("arm.toml")).unwrap();
    assert!(scene.contains("\"jaco_robotiq.urdf\""));
    let [own, other] = ["jaco.xml", "jaco.urdf"].map(|name| {
        let path = folder.path().join(format!("{name}.toml"));
        std::fs::write(&path, scene.replace("jaco_robotiq.urdf", name)).unwrap();
        path
    });
    let clock: Vec<f64> = (0..120).map(|i| f64::from(i) / 240.0).collect();
    let torques = |path: &Path| {
        let arm = ObservedArm::new(&SimulationFile::read(path).unwrap()).unwrap();
        let mut values: Vec<f64> = arm.parameters().iter().map(|p| p.value).collect();
        let mass = arm.parameters().iter().position(|p| p.name == "payload_mass").unwrap();
        values[mass] = 0.8;
        let mut seen = vec![0.0; clock.len() * arm.channels().len()];
        arm.rollout(&values, &[], &clock, &mut seen).unwrap();
        seen
    };
    let (ours, theirs) = (torques(&own), torques(&other));
    let size = theirs.iter().fold(0.0_f64, |size, n| size.max(n.abs()));
    assert!(size > 1.0, "{size} N·m");
    for (a, b) in ours.iter().zip(&theirs) {
        assert!((a - b).abs() <= 1e-6 * size, "{a} N·m from the MJCF, {b} N·m from the URDF");
    }
}
