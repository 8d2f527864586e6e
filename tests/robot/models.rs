//! Robots whose model is an MJCF: what the file starts from, and what is written back into it.

use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use crate::common::{Folder, recorded};

/// Two hinges with position actuators, in steps that are short enough for MuJoCo's own error to be small.
pub const MODEL: &str = r#"<mujoco model="two">
  <compiler angle="radian"/>
  <option timestep="0.0005" integrator="implicitfast"><flag contact="disable"/></option>
  <default><default class="servo"><joint damping="0.4" frictionloss="0.05" armature="0.02"/></default></default>
  <worldbody>
    <!-- the upper arm -->
    <body name="upper" pos="0 0 1"><joint name="shoulder" axis="0 1 0" class="servo"/>
      <inertial pos="0 0 -0.1" mass="0.4" diaginertia="0.002 0.002 0.0002"/>
      <body name="fore" pos="0 0 -0.2"><joint name="elbow" axis="0 1 0" class="servo"/>
        <inertial pos="0 0 -0.08" mass="0.3" diaginertia="0.001 0.001 0.0001"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="one" joint="shoulder" kp="15" forcerange="-3 3" ctrlrange="-2 2"/>
    <position name="two" joint="elbow" kp="12" kv="1.5" forcerange="-3 3"/>
  </actuator>
</mujoco>
"#;

/// Commands of both joints for 3 s.
pub fn commands() -> String {
    let rows = (0..300).map(|i| f64::from(i) / 100.0).map(|t| {
        let step = if (0.5..2.0).contains(&t) { 0.8 } else { 0.0 };
        format!("{t},{},{}\n", 0.6 * (t * t * 2.0).sin(), step)
    });
    std::iter::once("t_s,shoulder_goal_rad,elbow_goal_rad\n".to_owned()).chain(rows).collect()
}

/// A folder with the model, its simulation file and commands.
pub fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("two.xml", MODEL);
    folder.write("commands.csv", commands());
    folder.run("init robot --model two.xml --out robot.toml").ends(0);
    folder
}

/// Names with other characters are usual where a model is put together from others.
#[test]
fn joints_are_called_by_the_nearest_key_and_written_under_their_own_name() {
    let folder = Folder::new();
    folder.write("two.xml", MODEL.replace("\"shoulder\"", "\"left/shoulder-1\""));
    folder.run("init robot --model two.xml --out robot.toml").ends(0);
    let text = folder.text("robot.toml");
    assert!(
        text.contains("[joints.left_shoulder_1]") && text.contains("[parameters.left_shoulder_1__viscous]"),
        "{text}"
    );
    folder.write("commands.csv", commands().replacen("shoulder_goal_rad", "left_shoulder_1_goal_rad", 1));
    folder.run("simulate --sim robot.toml --inputs commands.csv --set record.frames=300 --set parameters.elbow__viscous.value=0.5 \
                --out seen.csv").ends(0);
    folder.run("tune --sim robot.toml seen.csv --quick --out-model tuned.xml").ends(0);
    let model = folder.text("tuned.xml");
    assert!(model.contains("name=\"left/shoulder-1\"") && model.contains("joint=\"left/shoulder-1\""), "{model}");
}

#[test]
fn init_starts_at_what_the_mjcf_states() {
    let folder = folder();
    let text = folder.text("robot.toml");
    for part in
        ["model = \"two.xml\"", "[joints.elbow]", "gain_1_rad = 4.0", "kd = 0.5", "# command_range = [-2.0, 2.0]"]
    {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let shown = folder.run("inspect robot.toml --json").ends(0).json();
    assert_eq!(shown["usable"], true, "{shown}");
    let table = |name: &str| text.split(&format!("[parameters.{name}]")).nth(1).unwrap().to_owned();
    for (name, value) in [("shoulder__stall_torque", "3.0"), ("shoulder__viscous", "0.4"), ("elbow__armature", "0.02")]
    {
        assert!(table(name).contains(&format!("value = {value} ")), "{name}");
    }
}

/// A recorded command is the goal times the gear. That it goes beyond the range of the model is said until the file clips it as well.
#[test]
fn commands_are_those_of_the_actuator() {
    let folder = Folder::new();
    folder.write("two.xml", MODEL.replacen("ctrlrange=\"-2 2\"", "gear=\"-2\" ctrlrange=\"-0.5 0.5\"", 1));
    folder.write("commands.csv", commands());
    let ran = folder.run("init robot --model two.xml --out robot.toml").ends(0);
    assert!(ran.stderr.contains("model.command_scale") && ran.stderr.contains("`shoulder` by -0.5"), "{}", ran.stderr);
    let text = folder.text("robot.toml");
    assert!(text.contains("command_scale = -0.5\n") && text.matches("command_scale = ").count() == 1, "{text}");
    folder.run("simulate --sim robot.toml --inputs commands.csv --set record.frames=300 --out seen.csv").ends(0);
    let beyond = folder.run("tune --sim robot.toml seen.csv --quick").stderr;
    assert!(beyond.contains("robot.command_range") && beyond.contains("-0.250 to 0.250"), "{beyond}");
    folder.write("clipped.toml", text.replacen("# command_range", "command_range", 1));
    let clipped = folder.run("tune --sim clipped.toml seen.csv --quick").stderr;
    assert!(!clipped.contains("robot.command_range"), "{clipped}");
}

/// Tuned from what the model states to what was simulated; the copy of the model has the tuned numbers, and nothing else changed.
#[test]
fn tuned_numbers_go_into_a_copy_of_the_model() {
    let folder = folder();
    let truth = "--set parameters.shoulder__stall_torque.value=2.5 --set parameters.elbow__coulomb.value=0.1 --set record.frames=300 \
                 --set effects.speed_limit.inverse_s_rad=[0.3,0.0]";
    folder.run(&format!("simulate --sim robot.toml --inputs commands.csv {truth} --out seen.csv")).ends(0);
    let own = format!("{}\n[effects.speed_limit]\ninverse_s_rad = [0.3, 0.0]\n", folder.text("robot.toml"));
    folder.write("limited.toml", own);
    let ran = folder
        .run(
            "tune --sim limited.toml seen.csv --quick --set effects.firmware_gain.tune=false \
             --set parameters.shoulder__stall_torque.tune=true --set parameters.elbow__stall_torque.tune=true \
             --out tuned.toml --out-model tuned.xml --out-bam servos.json --bam-actuator sts3215 --out-isaac actuators.py",
        )
        .ends(0);
    let text = folder.text("tuned.xml");
    assert!(
        text.contains("<!-- the upper arm -->") && text.contains("<joint damping=\"0.4\" frictionloss=\"0.05\""),
        "{text}"
    );
    let number = |element: &str, key: &str| -> f64 {
        let tail = text.split(element).nth(1).unwrap().split('>').next().unwrap();
        let value = tail.split(&format!("{key}=\"")).nth(1).unwrap_or_else(|| panic!("{key}: {tail}"));
        value.split(['"', ' ']).next().unwrap().parse().unwrap()
    };
    let tuned: toml_edit::DocumentMut = folder.text("tuned.toml").parse().unwrap();
    let parameter = |name: &str| tuned["parameters"][name]["value"].as_float().unwrap();
    let stall = parameter("shoulder__stall_torque");
    assert!((stall - 2.5).abs() < 0.05, "{stall}");
    // kp = A·c·kp, forcerange = ±A, damping = B + D, frictionloss = Fc.
    assert!((number("name=\"one\"", "kp") - 5.0 * stall).abs() < 1e-9);
    assert!((number("name=\"one\"", "forcerange") + stall).abs() < 1e-9);
    let braking = parameter("shoulder__viscous") + parameter("shoulder__back_emf");
    assert!((number("name=\"shoulder\"", "damping") - braking).abs() < 1e-9);
    assert!((number("name=\"elbow\"", "frictionloss") - parameter("elbow__coulomb")).abs() < 1e-12);
    // What MJCF has no attribute for is next to it, and named.
    let rest: toml_edit::DocumentMut = folder.text("tuned.effects.toml").parse().unwrap();
    let limit = rest["joints"]["shoulder"]["speed_limit"]["value"].as_float().unwrap();
    assert!((limit - 1.0 / 0.3).abs() < 1e-9, "{limit}");
    assert!(ran.stderr.contains("speed_limit of `shoulder`"), "{}", ran.stderr);
    let servos: Value = serde_json::from_slice(&folder.read("servos.json")).unwrap();
    assert_eq!(servos["elbow"]["actuator"], "sts3215");
    assert!(folder.text("actuators.py").contains("ImplicitActuatorCfg"));
    // A file that is there is nobody's to replace, and the model itself least of all.
    folder.run("tune --sim limited.toml seen.csv --quick --out-model tuned.xml").ends(1);
    folder.run("tune --sim limited.toml seen.csv --quick --out-model two.xml --overwrite").ends(1);
    assert_eq!(folder.text("two.xml"), MODEL);
}

#[test]
fn models_of_other_simulations_are_refused() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", "t_s,z_m\n0,1\n0.1,0.95\n0.2,0.8\n0.3,0.56\n");
    let ran = folder.run("tune --sim scene.toml drop.csv --out-model a.xml").ends(2);
    assert!(ran.stderr.contains("`--out-model`: expected `kind = \"robot\"`"), "{}", ran.stderr);
    let ran = folder.run("tune --sim scene.toml drop.csv --out-isaac a.py").ends(2);
    assert!(ran.stderr.contains("`--out-isaac`: expected `kind = \"robot\"`"), "{}", ran.stderr);
    folder.run("tune --sim scene.toml drop.csv --out-bam a.json").ends(2);
}

/// Masks of geoms concern forces where they enable contacts; where they do not, they are listed with what has no effect.
#[test]
fn contacts_are_named_once_where_the_model_states_them() {
    let folder = folder();
    let own = "<inertial pos=\"0 0 -0.1\"";
    let with = |mask: &str, flag: &str| {
        let geom = format!("<geom size=\"0.02\" contype=\"{mask}\" conaffinity=\"{mask}\"/>{own}");
        MODEL.replacen(own, &geom, 1).replacen("<flag contact=\"disable\"/>", flag, 1)
    };
    let said = |text: String| {
        folder.write("touching.xml", text);
        folder.run("init robot --model touching.xml --out touching.toml --overwrite").ends(0).stderr
    };
    let touching = said(with("1", ""));
    assert_eq!(touching.matches("contacts between geoms").count(), 1, "{touching}");
    assert!(!touching.contains("contype"), "{touching}");
    let free = said(with("0", ""));
    assert!(free.contains("<geom contype>") && !free.contains("contacts between geoms"), "{free}");
    assert!(!said(MODEL.replacen("<flag contact=\"disable\"/>", "", 1)).contains("contacts between geoms"));
    assert!(!said(with("1", "<flag contact=\"disable\"/>")).contains("contacts between geoms"));
}

#[test]
fn inspect_lists_the_joints_of_a_model_and_the_next_step() {
    let folder = folder();
    let ranged = MODEL.replacen("axis=\"0 1 0\"", "axis=\"0 1 0\" range=\"-1 1.5\"", 1);
    folder.write(
        "ranged.xml",
        ranged.replacen(
            "<position name=\"two\" joint=\"elbow\" kp=\"12\"",
            "<velocity name=\"two\" joint=\"elbow\"",
            1,
        ),
    );
    let ran = folder.run("inspect ranged.xml").ends(0);
    for part in ["MJCF of a robot with 2 joints", "-1 to 1.5 rad", "no limits", "tunenet init robot --model ranged.xml"]
    {
        assert!(ran.stdout.contains(part), "{part}\n{}", ran.stdout);
    }
    let json = folder.run("inspect ranged.xml --json").ends(0).json();
    let joints = json["joints"].as_array().unwrap();
    assert_eq!((&joints[0]["max"], &joints[0]["drive"]), (&json!(1.5), &json!("position")));
    assert_eq!(
        (&joints[1]["max"], &joints[1]["drive"], &json["usable"]),
        (&Value::Null, &json!("velocity"), &json!(true))
    );
}

/// The copy is of the model's own format.
#[test]
fn a_copy_that_bears_the_ending_of_another_format_is_refused_before_the_run() {
    let folder = folder();
    folder.write("seen.csv", "t_s,shoulder_rad,elbow_rad\n0,0,0\n");
    let ran = folder.run("tune --sim robot.toml seen.csv --out-model tuned.urdf").ends(2);
    assert!(ran.stderr.contains("`--out-model`: expected a name that ends in .xml"), "{}", ran.stderr);
    assert!(ran.stderr.contains("two.xml is an MJCF, found tuned.urdf"), "{}", ran.stderr);
    folder.write("arm.urdf", super::MODEL);
    folder.run("init robot --urdf arm.urdf --out hinge.toml").ends(0);
    let ran = folder.run("tune --sim hinge.toml seen.csv --out-model tuned.xml").ends(2);
    assert!(ran.stderr.contains("expected a name that ends in .urdf"), "{}", ran.stderr);
    // A model that bears that ending itself may keep it.
    folder.write("arm.xml", super::MODEL);
    folder.run("init robot --urdf arm.xml --out own.toml").ends(0);
    let ran = folder.run("tune --sim own.toml seen.csv --out-model tuned.xml");
    assert!(!ran.stderr.contains("expected a name that ends"), "{}", ran.stderr);
}

/// Rolls out a model file in MuJoCo: positions every 10 ms. Its dry friction, which creeps by default, is as stiff as its steps allow.
const ROLLOUT: &str = r#"
import json, sys
import mujoco
case = json.load(sys.stdin)
model = mujoco.MjModel.from_xml_path(case["model"])
step = model.opt.timestep
data = mujoco.MjData(model)
each = round(0.01 / step)
seen = [list(map(float, data.qpos))]
for goals in case["goals"][:-1]:
    data.ctrl[:] = goals
    for _ in range(each):
        mujoco.mj_step(model, data)
    seen.append(list(map(float, data.qpos)))
json.dump(seen, sys.stdout)
"#;

/// MuJoCo's positions; why not, where there are none.
fn by_mujoco(folder: &Folder, case: &Value) -> Result<Vec<Vec<f64>>, String> {
    let mut child = Command::new("python3")
        .args(["-c", ROLLOUT])
        .current_dir(folder.path("."))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("no python3: {error}"))?;
    let mut input = child.stdin.take().ok_or("no standard input")?;
    let text = case.to_string();
    // A Python without the module ends before it reads.
    let _ = input.write_all(text.as_bytes());
    drop(input);
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if said.contains("No module named 'mujoco'") {
        return Err("python3 has no mujoco".into());
    }
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())
}

/// MuJoCo reads the written model and swings as the tuned simulation does, effects that MJCF can express and springs of the model
/// included.
#[test]
fn validate_a_written_model_against_mujoco_within_a_milliradian() {
    let folder = folder();
    let sprung = MODEL
        .replace("name=\"shoulder\"", "name=\"shoulder\" stiffness=\"0.9\" springref=\"0.3\"")
        .replace("name=\"elbow\"", "name=\"elbow\" stiffness=\"0.3\" springref=\"-0.4\"");
    folder.write("two.xml", sprung);
    // Effects that MJCF can express, in the simulation only; the model gets them by being written.
    let effects = "\n[effects.command_delay]\ns = [0.03, 0.0]\n[effects.quadratic_friction]\nnms2_rad2 = [0.02, 0.0]\n\
                   [effects.joint_spring]\nnm_rad = [0.0, 0.5]\n";
    let text = folder.text("robot.toml").replacen("\nfactor = 1.0", "\nfactor = [0.8, 1.2]", 1);
    assert!(text.contains("factor = [0.8, 1.2]"), "{text}");
    // Numbers other than the model's own.
    let other = |text: &str, name: &str, value: f64| {
        let (before, table) = text.split_once(&format!("[parameters.{name}]")).unwrap();
        let (comment, rest) = table.split_once("value = ").unwrap();
        let rest = rest.split_once(' ').unwrap().1;
        format!("{before}[parameters.{name}]{comment}value = {value} {rest}")
    };
    let mut text = text;
    for (name, value) in [
        ("shoulder__back_emf", 0.3),
        ("shoulder__stall_torque", 2.2),
        ("elbow__coulomb", 0.11),
        ("elbow__armature", 0.03),
    ] {
        text = other(&text, name, value);
    }
    folder.write("other.toml", format!("{text}{effects}"));
    folder.run("simulate --sim other.toml --inputs commands.csv --set record.frames=300 --out seen.csv").ends(0);
    folder.run("tune --sim other.toml seen.csv --quick --out tuned.toml --out-model tuned.xml").ends(0);
    folder.run("simulate --sim tuned.toml --inputs commands.csv --set record.frames=300 --out ours.csv").ends(0);
    assert!(!folder.path("tuned.effects.toml").exists(), "{}", folder.text("tuned.effects.toml"));
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let text = folder.text(name);
        let numbers = |line: &str| line.split(',').map(|word| word.parse().unwrap()).collect();
        text.lines().skip(1).map(numbers).collect()
    };
    let goals: Vec<Vec<f64>> = rows("commands.csv").iter().map(|row| row[1..].to_vec()).collect();
    let theirs = match by_mujoco(&folder, &json!({ "model": "tuned.xml", "goals": goals })) {
        Ok(theirs) => theirs,
        Err(why) => {
            println!("skipped: {why}");
            return;
        }
    };
    let ours = rows("ours.csv");
    assert_eq!(ours.len(), theirs.len());
    let moved = theirs.iter().map(|row| row[0].abs()).fold(0.0, f64::max);
    assert!(moved > 0.3, "{moved} rad");
    for joint in 0..2 {
        let squares: f64 = ours.iter().zip(&theirs).map(|(a, b)| (a[1 + joint] - b[joint]).powi(2)).sum();
        let error = (squares / ours.len() as f64).sqrt();
        println!("joint {joint}: {:.2} mrad RMS from MuJoCo", 1e3 * error);
        assert!(error < 1e-3, "joint {joint}: {error} rad");
    }
}

/// A folder with the published model of an arm, and the path of a data set that such an arm recorded; `None` where they are not there.
fn so101() -> Option<(Folder, String)> {
    let (data, models) = (recorded::measured("lerobot-v3-so101")?, recorded::measured("models/so101")?);
    let folder = Folder::new();
    folder.write("so101.xml", std::fs::read(models.join("so101_new_calib.xml")).unwrap());
    Some((folder, data.display().to_string()))
}

/// From a public data set and a public model to a file that the readers of both accept; units are asked for, never guessed.
#[test]
fn a_data_set_names_the_joints_of_its_robot() {
    let Some((folder, data)) = so101() else { return };
    let ran = folder.call(&["init", "robot", "--model", "so101.xml", "--from", &data]).ends(0);
    let text = folder.text("robot.toml");
    for part in ["[joints.gripper]", "column = \"action.shoulder_pan\"", "observe = [\"elbow_flex_rad\"]"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(!text.contains("torque_on"), "{text}");
    assert!(
        ran.stderr.contains("--units 'shoulder_pan=1.1") || ran.stderr.contains("--units shoulder_pan=1.1"),
        "{}",
        ran.stderr
    );
    let ran = folder.call(&["tune", "--sim", "robot.toml", &data]).ends(1);
    assert!(ran.stderr.contains("--units"), "{}", ran.stderr);
    // Joints that bear other names are mapped, and what is left is held.
    let one =
        ["init", "robot", "--model", "so101.xml", "--from", &data, "--overwrite", "--joints", "wrist_roll=elbow_flex"];
    folder.call(&one).ends(0);
    assert!(folder.text("robot.toml").contains(
        "[joints.wrist_roll]\ndrive = \"position\"\ncommand = \"wrist_roll_goal_rad\"\nobserve = [\"elbow_flex_rad\"]"
    ));
    folder
        .call(&[
            "init",
            "robot",
            "--model",
            "so101.xml",
            "--from",
            &data,
            "--overwrite",
            "--joints",
            "wrist=elbow_flex",
        ])
        .ends(2);
}

/// Tuning a real arm by one episode: the noise is that of its encoders, the gains of the published model, which are far too large, are
/// tuned, and the model gets them.
#[test]
fn a_real_arm_is_tuned_by_an_episode() {
    let Some((folder, data)) = so101() else { return };
    folder.call(&["init", "robot", "--model", "so101.xml", "--from", &data]).ends(0);
    // Two joints, the others held: a rollout of all takes ten times as long.
    let others = ["shoulder_lift", "elbow_flex", "wrist_flex", "gripper"];
    let of_others = |part: &&str| {
        let starts = |other: &str| {
            [format!("inputs.{other}_"), format!("joints.{other}]"), format!("parameters.{other}__")]
                .iter()
                .any(|head| part.starts_with(head.as_str()))
        };
        others.iter().any(|other| starts(other))
    };
    let text = folder.text("robot.toml").replace("factor = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]", "factor = [1.0, 1.0]");
    let kept: Vec<&str> = text.split("\n[").filter(|part| !of_others(part)).collect();
    folder.write("robot.toml", kept.join("\n["));
    let units = "shoulder_pan=1.1202deg,wrist_roll=1.6853deg";
    let line = ["tune", "--quick", "--sim", "robot.toml", &data, "--episodes", "0", "--units", units, "--json"];
    let json = folder.call(&[&line[..], &["--out-model", "tuned.xml"]].concat()).ends(3).json();
    for gap in json["gaps"].as_array().unwrap() {
        let of = |key: &str| gap[key].as_f64().unwrap();
        // 4096 counts a turn, uniform between two.
        assert!((of("noise_floor") / (std::f64::consts::TAU / 4096.0 / 12f64.sqrt()) - 1.0).abs() < 0.2, "{gap}");
        assert!(of("after") < 0.35 * of("before") && of("after") < 0.01, "{gap}");
    }
    let factor = json["parameters"]["firmware_gain.factor.1"]["value"].as_f64().unwrap();
    assert!(factor < 0.2, "{json:#}");
    assert_ne!(folder.text("tuned.xml"), folder.text("so101.xml"));
}
