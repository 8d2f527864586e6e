//! Robots whose URDF states what the commands to their joints mean, and which joints follow others.

use super::folder;
use crate::common::Folder;

/// A hinge that carries two more, with the elements that state commands.
fn written(elements: &str) -> (Folder, String, String) {
    let folder = folder();
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"1\"/>\
             <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        )
    };
    let joint = |name: &str, [parent, child]: [&str; 2]| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"5\" velocity=\"4\"/></joint>"
        )
    };
    let links = ["base", "one", "two", "three"].map(link).concat();
    let joints = [("yaw", ["base", "one"]), ("elev", ["one", "two"]), ("roll", ["two", "three"])];
    let joints: String = joints.map(|(name, links)| joint(name, links)).concat();
    folder.write("turret.urdf", format!("<robot name=\"turret\">{links}{joints}{elements}</robot>"));
    let ran = folder.run("init robot --urdf turret.urdf --out turret.toml").ends(0);
    let text = folder.text("turret.toml");
    (folder, text, ran.stderr)
}

/// The drive, the command and the gain of a joint's table.
fn table<'t>(text: &'t str, joint: &str) -> &'t str {
    text.split(&format!("[joints.{joint}]\n")).nth(1).unwrap().split("\n[").next().unwrap()
}

fn transmission(joint: &str, of_joint: &str, of_actuator: &str) -> String {
    let interface = |name: &str| match name {
        "" => String::new(),
        name => format!("<hardwareInterface>{name}</hardwareInterface>"),
    };
    format!(
        "<transmission name=\"t_{joint}\"><type>transmission_interface/SimpleTransmission</type>\
         <joint name=\"{joint}\">{}</joint><actuator name=\"m_{joint}\">{}<mechanicalReduction>50</mechanicalReduction></actuator>\
         </transmission>",
        interface(of_joint),
        interface(of_actuator)
    )
}

#[test]
fn transmissions_state_the_drive_of_each_joint() {
    let all = transmission("yaw", "hardware_interface/VelocityJointInterface", "")
        + &transmission("elev", "PositionJointInterface", "")
        + &transmission("roll", "", "hardware_interface/EffortJointInterface");
    let (folder, text, said) = written(&all);
    let yaw = table(&text, "yaw");
    assert!(yaw.contains("drive = \"velocity\"\ncommand = \"yaw_rate_rad_s\""), "{yaw}");
    assert!(yaw.contains("kp = 16.0\ngain_1_rad = 0.166"), "{yaw}");
    assert!(table(&text, "elev").contains("drive = \"position\"\ncommand = \"elev_goal_rad\""), "{text}");
    let roll = table(&text, "roll");
    assert!(roll.contains("drive = \"torque\"\ncommand = \"roll_torque_nm\"") && !roll.contains("gain"), "{roll}");
    assert!(
        said.contains("the URDF's 3 reductions of transmissions (armature and friction count behind the gear)"),
        "{said}"
    );
    assert!(!said.contains("3 transmissions"), "{said}");
    let shown = folder.run("inspect turret.toml --json").ends(0).json();
    assert_eq!(shown["usable"], true, "{shown}");
}

#[test]
fn command_interfaces_of_ros2_control_state_it_where_no_transmission_does() {
    let joint = |name: &str, interfaces: &[&str]| {
        let all: Vec<String> = interfaces.iter().map(|one| format!("<command_interface name=\"{one}\"/>")).collect();
        format!("<joint name=\"{name}\">{}<state_interface name=\"position\"/></joint>", all.concat())
    };
    let control = [joint("yaw", &["velocity"]), joint("elev", &["velocity", "position"]), joint("roll", &["effort"])];
    let all = format!(
        "{}<ros2_control name=\"c\" type=\"system\">{}</ros2_control>",
        transmission("roll", "VelocityJointInterface", ""),
        control.concat()
    );
    let (_, text, said) = written(&all);
    let drives = ["yaw", "elev", "roll"].map(|joint| table(&text, joint).lines().next().unwrap().to_owned());
    assert_eq!(drives, ["drive = \"velocity\"", "drive = \"position\"", "drive = \"velocity\""]);
    assert!(said.contains("of which the first counts: `elev` (position, velocity)"), "{said}");
    let (_, text, said) = written(&format!("<ros2_control name=\"c\">{}</ros2_control>", joint("yaw", &["gripper"])));
    assert!(table(&text, "yaw").contains("drive = \"position\""), "{text}");
    assert!(said.contains("no position, velocity or effort by the URDF: `yaw`"), "{said}");
}

/// A joint that mimics another one moves with it; what it has of its own does not count, and is named.
#[test]
fn a_joint_that_mimics_another_one_has_no_table_and_is_named() {
    let folder = folder();
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"1\"/>\
             <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        )
    };
    let joint = |name: &str, [parent, child]: [&str; 2], more: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{more}</joint>"
        )
    };
    let mimic = "<mimic joint=\"left\" multiplier=\"-1\"/><dynamics damping=\"0.2\"/>";
    let text = ["base", "one", "two"].map(link).concat()
        + &joint("left", ["base", "one"], "")
        + &joint("right", ["base", "two"], mimic);
    folder.write("gripper.urdf", format!("<robot name=\"gripper\">{text}</robot>"));
    let ran = folder.run("init robot --urdf gripper.urdf --out gripper.toml").ends(0);
    let text = folder.text("gripper.toml");
    assert!(text.contains("# No table for `right`: it follows `left`"), "{text}");
    assert!(text.contains("[joints.left]") && !text.contains("[joints.right]"), "{text}");
    assert!(ran.stderr.contains("joints that follow others, whose own friction") && ran.stderr.contains("`right`"));
}
