//! Whatever a file holds is either read, and then changes the robot, or named with its line and what it would change.

use std::path::Path;

use tunenet_models::{Changes, Model, Robot};

const MODEL: &str = r#"<mujoco model="m">
  <compiler angle="radian"/>
  <default><default class="c"><joint damping="1"/><position kp="4"/><geom density="900"/></default></default>
  <worldbody>
    <body name="b" pos="0 0 1" quat="1 0 0 0" childclass="c">
      <joint name="j" type="hinge" pos="0 0 0.1" axis="0 0 1" range="-1 1" ref="0.1" springref="0.2" stiffness="3" armature="0.1" frictionloss="0.2" actuatorfrcrange="-5 5"/>
      <inertial pos="0 0 0.1" mass="2" diaginertia="1 1 1.5" euler="0.1 0 0"/>
      <body name="d"><frame pos="0 0.1 0"><geom type="box" size="0.1 0.2 0.3" pos="0 0 1" group="1"/></frame><joint name="k" class="c"/></body>
    </body>
  </worldbody>
  <equality><joint joint1="j" joint2="k" polycoef="0 1"/></equality>
  <tendon><fixed name="t"><joint joint="j" coef="2"/></fixed></tendon>
  <actuator>
    <position name="p" joint="j" kp="5" kv="0.5" gear="2" forcerange="-3 3" ctrlrange="-1 1" delay="0.1" timeconst="0.2"/>
    <general name="g" tendon="t" gainprm="7" biastype="affine" biasprm="1 2 3" dyntype="filter" dynprm="0.3"/>
  </actuator>
</mujoco>"#;

fn robot(text: &str) -> Robot {
    Model::parse_alone(Path::new("m.xml"), text).unwrap_or_else(|error| panic!("{error}\n{text}")).robot().clone()
}

/// Every attribute that counts as read makes another robot where it has another value.
#[test]
fn what_counts_as_read_changes_the_robot() {
    let original = robot(MODEL);
    let changes = [
        ("angle=\"radian\"", "angle=\"degree\""),
        ("angle=\"radian\"", "angle=\"radian\" boundmass=\"3\""),
        ("angle=\"radian\"", "angle=\"radian\" boundinertia=\"2\""),
        ("angle=\"radian\"", "angle=\"radian\" settotalmass=\"3\""),
        ("angle=\"radian\"", "angle=\"radian\" inertiafromgeom=\"true\""),
        ("angle=\"radian\"", "angle=\"radian\" inertiagrouprange=\"2 3\""),
        ("angle=\"radian\"", "angle=\"radian\" autolimits=\"false\""),
        ("damping=\"1\"", "damping=\"2\""),
        ("ctrlrange=\"-1 1\"", "inheritrange=\"0.5\""),
        ("density=\"900\"", "density=\"800\""),
        ("pos=\"0 0 1\" quat", "pos=\"0 0 2\" quat"),
        ("quat=\"1 0 0 0\"", "quat=\"1 1 0 0\""),
        (" childclass=\"c\"", ""),
        ("type=\"hinge\"", "type=\"slide\""),
        ("pos=\"0 0 0.1\" axis", "pos=\"0 0 0.2\" axis"),
        ("axis=\"0 0 1\"", "axis=\"0 1 1\""),
        ("range=\"-1 1\" ref", "range=\"-1 2\" ref"),
        ("range=\"-1 1\" ref", "range=\"-1 1\" limited=\"false\" ref"),
        (" ref=\"0.1\"", " ref=\"0.3\""),
        ("springref=\"0.2\"", "springref=\"0.3\""),
        ("stiffness=\"3\"", "stiffness=\"4\""),
        ("armature=\"0.1\"", "armature=\"0.2\""),
        ("frictionloss=\"0.2\"", "frictionloss=\"0.3\""),
        ("actuatorfrcrange=\"-5 5\"", "actuatorfrcrange=\"-5 6\""),
        ("mass=\"2\"", "mass=\"3\""),
        ("diaginertia=\"1 1 1.5\"", "diaginertia=\"1 1 1.4\""),
        ("diaginertia=\"1 1 1.5\" euler=\"0.1 0 0\"", "fullinertia=\"1 1 1.5 0 0 0.1\""),
        ("euler=\"0.1 0 0\"", "euler=\"0.2 0 0\""),
        ("<frame pos=\"0 0.1 0\">", "<frame pos=\"0 0.2 0\">"),
        ("type=\"box\"", "type=\"ellipsoid\""),
        ("size=\"0.1 0.2 0.3\"", "size=\"0.1 0.2 0.4\""),
        ("pos=\"0 0 1\" group", "pos=\"0 0 2\" group"),
        (" group=\"1\"", " group=\"9\""),
        (" group=\"1\"", " mass=\"1\""),
        (" group=\"1\"", " mesh=\"m\""),
        (" group=\"1\"", " shellinertia=\"true\""),
        (" class=\"c\"/></body>", " class=\"main\"/></body>"),
        ("polycoef=\"0 1\"", "polycoef=\"0 2\""),
        ("polycoef=\"0 1\"", "active=\"false\""),
        ("coef=\"2\"", "coef=\"3\""),
        ("kp=\"5\"", "kp=\"6\""),
        ("kv=\"0.5\"", "kv=\"0.6\""),
        ("kv=\"0.5\"", "dampratio=\"1\""),
        ("gear=\"2\"", "gear=\"3\""),
        ("forcerange=\"-3 3\"", "forcerange=\"-3 4\""),
        ("forcerange=\"-3 3\"", "forcerange=\"-3 3\" forcelimited=\"false\""),
        ("ctrlrange=\"-1 1\"", "ctrlrange=\"-1 2\""),
        ("ctrlrange=\"-1 1\"", "ctrlrange=\"-1 1\" ctrllimited=\"false\""),
        ("delay=\"0.1\"", "delay=\"0.2\""),
        ("timeconst=\"0.2\"", "timeconst=\"0.3\""),
        ("tendon=\"t\"", "joint=\"k\""),
        ("gainprm=\"7\"", "gainprm=\"8\""),
        ("biastype=\"affine\"", "biastype=\"none\""),
        ("biasprm=\"1 2 3\"", "biasprm=\"1 2 4\""),
        ("dyntype=\"filter\"", "dyntype=\"none\""),
        ("dynprm=\"0.3\"", "dynprm=\"0.4\""),
    ];
    for (from, to) in changes {
        assert_eq!(MODEL.matches(from).count(), 1, "{from}");
        let other = robot(&MODEL.replace(from, to));
        let differs = original.links != other.links
            || original.joints != other.joints
            || original.actuators != other.actuators
            || original.couplings != other.couplings
            || original.tendons != other.tendons;
        assert!(differs, "{from} → {to} changes nothing");
    }
}

/// Everything else is named at its line.
#[test]
fn what_is_not_read_is_named_with_its_line() {
    assert!(robot(MODEL).unused.is_empty(), "{:?}", robot(MODEL).unused);
    let cases = [
        (
            "<joint name=\"j\"",
            "<joint springdamper=\"1 1\" name=\"j\"",
            "joint",
            Some("springdamper"),
            6,
            Changes::Dynamics,
        ),
        (
            "<joint name=\"j\"",
            "<joint solreflimit=\"1 1\" name=\"j\"",
            "joint",
            Some("solreflimit"),
            6,
            Changes::Contact,
        ),
        ("<joint name=\"j\"", "<joint damping=\"1 2\" name=\"j\"", "joint", Some("damping"), 6, Changes::Dynamics),
        ("<joint name=\"j\"", "<joint mystery=\"1\" name=\"j\"", "joint", Some("mystery"), 6, Changes::Unknown),
        ("<joint damping=\"1\"/>", "<joint damping=\"1\" margin=\"1\"/>", "joint", Some("margin"), 3, Changes::Contact),
        ("<body name=\"d\">", "<body name=\"d\" gravcomp=\"1\">", "body", Some("gravcomp"), 8, Changes::Dynamics),
        ("<body name=\"d\">", "<body name=\"d\" mocap=\"true\">", "body", Some("mocap"), 8, Changes::Structure),
        (
            "<body name=\"d\">",
            "<replicate count=\"3\"><body/></replicate><body name=\"d\">",
            "replicate",
            None,
            8,
            Changes::Structure,
        ),
        ("<body name=\"d\">", "<attach model=\"x\"/><body name=\"d\">", "attach", None, 8, Changes::Structure),
        ("<worldbody>", "<option viscosity=\"1\"/><worldbody>", "option", Some("viscosity"), 4, Changes::Dynamics),
        ("<worldbody>", "<option integrator=\"RK4\"/><worldbody>", "option", Some("integrator"), 4, Changes::Solver),
        ("<worldbody>", "<option><flag gravity=\"disable\"/></option><worldbody>", "flag", None, 4, Changes::Dynamics),
        ("<worldbody>", "<sensor><gyro site=\"s\"/></sensor><worldbody>", "sensor", None, 4, Changes::Readings),
        (
            "<worldbody>",
            "<contact><exclude body1=\"b\" body2=\"d\"/></contact><worldbody>",
            "contact",
            None,
            4,
            Changes::Contact,
        ),
        ("<worldbody>", "<magic/><x y=\"1\"/><worldbody>", "x", None, 4, Changes::Unknown),
        ("<fixed name=\"t\">", "<fixed name=\"t\" stiffness=\"2\">", "fixed", Some("stiffness"), 12, Changes::Dynamics),
        ("<equality>", "<equality><connect body1=\"b\" anchor=\"0 0 0\"/>", "connect", None, 11, Changes::Structure),
        (
            "<actuator>",
            "<actuator><damper joint=\"j\" kv=\"1\" ctrlrange=\"0 1\"/>",
            "damper",
            None,
            13,
            Changes::Dynamics,
        ),
        ("<actuator>", "<actuator><motor site=\"s\"/>", "motor", Some("site"), 13, Changes::Dynamics),
        ("dyntype=\"filter\"", "dyntype=\"user\"", "general", None, 15, Changes::Dynamics),
        ("delay=\"0.1\"", "delay=\"0.1\" nsample=\"9\"", "position", Some("nsample"), 14, Changes::Solver),
    ];
    for (from, to, element, attribute, line, changes) in cases {
        let unused = robot(&MODEL.replacen(from, to, 1)).unused;
        let found = unused.iter().find(|left| left.element == element && left.attribute.as_deref() == attribute);
        let found = found.unwrap_or_else(|| panic!("{to}: not among {unused:?}"));
        assert_eq!((found.line, found.changes), (line, changes), "{to}: {found}");
        assert!(!found.what.is_empty());
    }
}

#[test]
fn a_urdf_names_its_drives_and_settings() {
    let text = "<robot name='r'>\n<link name='a'/><link name='b'><visual/></link>\n\
        <joint name='j' type='continuous'><parent link='a'/><child link='b'/><safety_controller k_velocity='1'/></joint>\n\
        <transmission name='t'><type>simple</type><joint name='j'/><actuator name='m'><mechanicalReduction>50</mechanicalReduction></actuator></transmission>\n\
        <ros2_control name='s' type='system'><joint name='j'><command_interface name='position'><param name='min'>-2</param><param name='max'>2</param></command_interface></joint></ros2_control>\n\
        <mujoco><compiler angle='radian' balanceinertia='true'/></mujoco>\n<gazebo reference='b'/>\n</robot>";
    let robot = robot(text);
    let named: Vec<_> = robot.unused.iter().map(|left| (left.element.as_str(), left.line)).collect();
    for expected in [
        ("transmission", 4),
        ("ros2_control", 5),
        ("mujoco", 6),
        ("compiler", 6),
        ("gazebo", 7),
        ("visual", 2),
        ("safety_controller", 3),
    ] {
        assert!(named.contains(&expected), "{expected:?} is not among {named:?}");
    }
    assert_eq!((robot.actuators[0].name.as_str(), robot.actuators[0].gear), ("t", 50.0));
    assert_eq!((robot.actuators[1].name.as_str(), robot.actuators[1].command_range), ("j/position", Some([-2.0, 2.0])));
}

/// A damping ratio at a gear of 0, or of numbers too large, is no number.
#[test]
fn damping_ratios_that_are_no_numbers_are_left_open() {
    for attributes in ["gear='0' kp='1'", "kp='1e308'"] {
        let text = format!(
            "<mujoco><worldbody><body><joint name='a' armature='1e300'/><geom size='0.1'/></body></worldbody>\
             <actuator><position joint='a' dampratio='1' {attributes}/></actuator></mujoco>"
        );
        let model = Model::parse_alone(Path::new("m.xml"), &text).unwrap();
        assert_eq!(model.robot().actuators[0].law, tunenet_models::Law::Other, "{attributes}");
        assert!(model.robot().unused.iter().any(|left| left.attribute.as_deref() == Some("dampratio")), "{attributes}");
    }
}

#[test]
fn a_command_that_is_not_limited_inherits_no_range() {
    let range = |attributes: &str| {
        let text = format!(
            "<mujoco><compiler angle='radian'/><worldbody><body><joint name='a' range='-1 3'/><geom size='0.1'/></body></worldbody>\
             <actuator><position joint='a' inheritrange='0.5' {attributes}/></actuator></mujoco>"
        );
        Model::parse_alone(Path::new("m.xml"), &text).unwrap().robot().actuators[0].command_range
    };
    assert_eq!(range(""), Some([0.0, 2.0]));
    assert_eq!(range("ctrllimited='false'"), None);
}

#[test]
fn a_transmission_states_its_ratio_once() {
    let of = |inside: &str| {
        let text = format!(
            "<robot name='r'><link name='u'/><link name='v'/><joint name='j' type='continuous'><parent link='u'/><child link='v'/></joint>\
             <transmission name='t'>{inside}</transmission></robot>"
        );
        let model = Model::parse_alone(Path::new("r.urdf"), &text).unwrap();
        let actuator = &model.robot().actuators[0];
        (actuator.gear, actuator.law == tunenet_models::Law::Other)
    };
    let motor =
        |name: &str| format!("<actuator name='{name}'><mechanicalReduction>50</mechanicalReduction></actuator>");
    let joint = "<joint name='j'><mechanical_reduction>30</mechanical_reduction></joint>";
    assert_eq!(of(&format!("<joint name='j'/>{}", motor("m"))), (50.0, false));
    assert_eq!(of(&format!("{joint}<actuator name='m'/>")), (30.0, false));
    assert_eq!(of(&format!("{joint}{}", motor("m"))), (30.0, false));
    // Two motors of one joint: a differential gear, whose ratio is none of its own.
    assert_eq!(of(&format!("<joint name='j'/>{}{}", motor("m"), motor("n"))), (1.0, true));
}
