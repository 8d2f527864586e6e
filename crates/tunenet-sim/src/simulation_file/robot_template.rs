//! A simulation file to start from for the joints of a model file.

use nalgebra::Vector3;
use tunenet_core::observation::{Channel, plain};
use tunenet_core::text::visible;

use super::domain::Domain;
use super::robot_schema::{BETWEEN, SAMPLES};
use super::robot_values::{near_stated, states_inertia, value, zero_of_a_log};
use super::schema::{Definition, is_name};
use super::stated_effects::{with_stated, with_tuned_gains, with_tuned_offsets};
use super::template::{keys, line, parameter};
use crate::arm::effects::Imperfections;
use crate::arm::{Body, Joint, JointKind, Model};
use crate::robot::effects::unit_of_slide;
use crate::robot::{Drive, StatedDrive, StatedGravity, StatedMotor, observable_scales, observable_zeros};

/// Where a log has the numbers of a joint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointColumns {
    /// Name of the joint in the model.
    pub joint: String,
    /// The channel of its positions.
    pub channel: String,
    /// The column of its commands.
    pub command: LogColumn,
}

/// A column of a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogColumn {
    /// Its name.
    pub column: String,
    /// The topic of a log that it stands in.
    pub topic: Option<String>,
}

impl LogColumn {
    /// The keys by which an input names it.
    fn keys(&self) -> String {
        let topic = self.topic.iter().map(|topic| line(&format!("topic = {}", toml_edit::value(topic))));
        topic.chain([line(&format!("column = {}", toml_edit::value(&self.column)))]).collect()
    }
}

/// What the file starts from besides the joints and links of the model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RobotStart {
    /// What the model states of motors.
    pub motors: Vec<StatedMotor>,
    /// What the model states of commands, where it states no motors.
    pub drives: Vec<StatedDrive>,
    /// What the model states of gravity; 9.81 m/s² downwards where it does not.
    pub gravity: Option<StatedGravity>,
    /// The joints that a log has, and where; `None` without a log. Other joints are held.
    pub columns: Option<Vec<JointColumns>>,
    /// The column of a log that says whether motors are on; without one, no motor is ever released.
    pub switch: Option<LogColumn>,
    /// Rows of the log per second, where that is known.
    pub rate_hz: Option<f64>,
}

impl RobotStart {
    /// The motor of a joint, where the model has one.
    #[must_use]
    pub fn motor(&self, joint: &str) -> Option<&StatedMotor> {
        self.motors.iter().find(|motor| motor.joint == joint)
    }

    /// What the commands to a joint mean: a position where the model does not say.
    #[must_use]
    pub fn drive(&self, joint: &str) -> Drive {
        let of_commands = || self.drives.iter().find(|one| one.joint == joint).map(|one| one.drive);
        self.motor(joint).map(|motor| motor.drive).or_else(of_commands).unwrap_or(Drive::Position)
    }

    /// Whether the model states motors, and none for this joint, or several.
    #[must_use]
    pub fn lacks_actuator(&self, joint: &str) -> bool {
        self.motor(joint).is_some_and(|motor| motor.gain.is_none() && motor.drive == Drive::Position)
    }

    /// Whether motors may be released: by a column of the log, or by an input where there is no log.
    fn releases(&self) -> bool {
        self.columns.is_none() || self.switch.is_some()
    }

    fn columns(&self, joint: &str) -> Option<&JointColumns> {
        self.columns.as_ref()?.iter().find(|columns| columns.joint == joint)
    }
}

/// The channel of a joint's positions: by the name of the log's column, so that it is found there, or of the joint where the column's
/// own is none.
#[must_use]
pub fn position_channel(joint: &Joint, column: Option<&str>) -> String {
    let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
    let own = column.filter(|column| plain(column) == **column && Channel::from_header(column).is_none());
    format!("{}_{unit}", own.map_or_else(|| plain(&joint.name), str::to_owned))
}

/// The input of the commands to a joint, by its name and the unit of what is commanded: `elbow_goal_rad`.
#[must_use]
pub fn command_input(joint: &Joint, drive: Drive) -> String {
    let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
    let ending = match drive {
        Drive::Velocity => format!("rate_{unit}_s"),
        Drive::Torque if unit == "m" => "force_n".to_owned(),
        Drive::Torque => "torque_nm".to_owned(),
        Drive::Position | Drive::Voltage => format!("goal_{unit}"),
    };
    format!("{}_{ending}", plain(&joint.name))
}

/// A commented simulation file for the robot of `model`, whose file is at `path` as seen from the simulation file: every joint with its
/// own commands and parameters, which start at what the model states. Joints whose names are no keys are left out, and so held.
#[must_use]
pub fn robot_template(path: &str, model: &Model, start: &RobotStart) -> String {
    let joints = model.joints();
    let kept =
        |joint: &&Joint| is_name(&joint.name) && (start.columns.is_none() || start.columns(&joint.name).is_some());
    let named: Vec<&Joint> = joints.into_iter().filter(kept).collect();
    let mut own = String::new();
    if start.releases() {
        own = format!("{SWITCH}{}default = 1.0\n", start.switch.as_ref().map_or_else(String::new, LogColumn::keys));
    }
    for joint in &named {
        tables(&mut own, joint, start);
    }
    own.push_str(&followers(model));
    let mut text = keys(Domain::Robot, &own).replacen("\"arm.urdf\"", &toml_edit::value(path).to_string(), 1);
    if let Some(StatedGravity { size_m_s2, base_tilt_rad: [x, y] }) = start.gravity {
        text = text.replacen("gravity_m_s2 = 9.81\n", &format!("gravity_m_s2 = {size_m_s2:?}\n"), 1);
        if [x, y] != [0.0; 2] {
            text = text.replacen("# base_tilt_rad = [0.0, 0.0]\n", &format!("base_tilt_rad = [{x:?}, {y:?}]\n"), 1);
        }
    }
    if let Some(rate_hz) = start.rate_hz {
        text = text.replacen("step_s = 0.001\n", &format!("step_s = {:?}\n", step_s(rate_hz)), 1);
    }
    let drive = |joint: &&Joint| start.drive(&joint.name);
    // A log has one gain, and a model states the limit next to it.
    let states_limit = |joint: &&Joint| start.motor(&joint.name).is_some_and(|motor| motor.stall_torque.is_some());
    let stated = start.columns.is_some() || named.iter().all(states_limit);
    let one_gain = stated && !named.is_empty() && named.iter().all(|joint| drive(joint).has_duty());
    if one_gain {
        text = with_tuned_gains(text);
    }
    let goes_to = |joint: &&Joint| drive(joint) == Drive::Position;
    if start.columns.is_some() && !named.is_empty() && named.iter().all(goes_to) {
        text = with_tuned_offsets(text);
    }
    let of_motors = |of: fn(&StatedMotor) -> f64| -> Vec<f64> {
        named.iter().map(|joint| start.motor(&joint.name).map_or(0.0, of)).collect()
    };
    text = with_stated(text, ("command_lag", "s", "timeconst"), &of_motors(|motor| motor.command_lag_s));
    text = with_stated(text, ("command_delay", "s", "delay"), &of_motors(|motor| motor.command_delay_s));
    let shown = showing(model, start, observable_zeros);
    let scaled = showing(model, start, observable_scales);
    for joint in &named {
        let motor = start.motor(&joint.name);
        for known in SAMPLES {
            let number = known.name.rsplit_once(BETWEEN).map_or(known.name, |(_, number)| number);
            let effort = Some(joint.limits.effort).filter(|effort| effort.is_finite());
            let of_torques = drive(joint) == Drive::Torque;
            let greatest = motor.map_or(effort, |motor| motor.stall_torque);
            // A torque drive without a limit has no greatest torque.
            if number == "stall_torque" && of_torques && greatest.is_none() {
                continue;
            }
            let mut default = value(number, known.default, motor, (joint, effort));
            match number {
                "zero" if start.columns.is_some() => default = zero_of_a_log(joint),
                // Such a log shows both brakings as one, which is tuned as `viscous`; and a torque is that of the joint.
                "back_emf" if !start.releases() || of_torques => default[0] = 0.0,
                "armature" if one_gain && states_inertia(motor, joint) => default = near_stated(default[0]),
                _ => {}
            }
            // A model has one number for both brakings, and only a released motor separates them.
            let together = motor.is_some() || !start.releases() || of_torques;
            // Of a servo without weight, only ratios of torques and inertias show: its inertia is taken for known.
            let hidden = match number {
                "zero" => !shown.contains(&joint.name.as_str()),
                "armature" => !of_torques && !scaled.contains(&joint.name.as_str()),
                _ => false,
            };
            // No recording shows a limit that a torque drive does not reach.
            let limit = number == "stall_torque" && (one_gain || of_torques);
            let held = (number == "back_emf" && together) || limit || hidden;
            let tune = known.tune && !held;
            let own = Definition { unit: unit_of(joint, known.unit), ..*known };
            parameter(&mut text, (&format!("{}{BETWEEN}{number}", joint.name), default, tune), &own);
        }
    }
    text
}

/// The joints that show something by their dynamics: where their zero is, how large their torques are.
fn showing<'m>(model: &'m Model, start: &RobotStart, what: fn(&Model, Vector3<f64>) -> Vec<bool>) -> Vec<&'m str> {
    let stated = start.gravity.unwrap_or(StatedGravity { size_m_s2: 9.81, base_tilt_rad: [0.0; 2] });
    let base = Imperfections { tilt_rad: stated.base_tilt_rad, ..Imperfections::none(0) };
    let shows = what(model, base.gravity(stated.size_m_s2));
    model.joints().into_iter().zip(shows).filter_map(|(joint, shows)| shows.then_some(joint.name.as_str())).collect()
}

/// The unit of a hinge's number for this joint.
fn unit_of(joint: &Joint, of_a_hinge: &'static str) -> &'static str {
    if joint.kind == JointKind::Prismatic { unit_of_slide(of_a_hinge) } else { of_a_hinge }
}

/// An eighth of the period of a log, in whole ms from 1 to 4. At 4 ms, the error of a servo's rollout is 0.5 to 2 mrad, a few steps of an encoder
/// with 4096 counts a turn, and a rollout takes a quarter of the time that it takes at 1 ms.
fn step_s(rate_hz: f64) -> f64 {
    (0.125e3 / rate_hz).clamp(1.0, 4.0).floor() / 1e3
}

/// That joints follow others, and so have no table.
fn followers(model: &Model) -> String {
    let joints = model.joints();
    let following = model.bodies.iter().filter(|body| !body.coordinate.own);
    let one = |body: &Body| {
        let (name, followed) = (visible(&body.joint.name), visible(&joints[body.coordinate.index].name));
        line(&format!("# No table for `{name}`: it follows `{followed}`, as the model says."))
    };
    let all: String = following.map(one).collect();
    if all.is_empty() { all } else { format!("\n{all}") }
}

/// The input and the table of a joint.
fn tables(text: &mut String, joint: &Joint, start: &RobotStart) {
    let name = &joint.name;
    let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
    let (motor, columns) = (start.motor(name), start.columns(name));
    let drive = start.drive(name);
    let word = match drive {
        Drive::Velocity => "velocity",
        Drive::Torque => "torque",
        Drive::Position | Drive::Voltage => "position",
    };
    let command = command_input(joint, drive);
    text.push_str(&line(&format!("\n[inputs.{command}]")));
    if let Some(columns) = columns {
        text.push_str(&columns.command.keys());
    }
    text.push_str(&line(&format!("\n[joints.{name}]\ndrive = \"{word}\"\ncommand = \"{command}\"")));
    if start.releases() {
        text.push_str("enable = \"torque_on\"\n");
    }
    let channel = columns.map_or_else(|| position_channel(joint, None), |columns| columns.channel.clone());
    text.push_str(&line(&format!("observe = [{}]", toml_edit::value(channel))));
    if let Some([lower, upper]) = joint.shown_range() {
        text.push_str(&line(&format!(
            "# The model stops this joint at {lower} and {upper} {unit}; the simulation has no stops."
        )));
    }
    if let Some(motor) = motor {
        commands(text, motor, unit);
    }
    match motor.and_then(|motor| Some((motor, motor.gain?))) {
        Some((motor, gain)) => {
            text.push_str("# Of the model: gain / torque limit. With another `kp`, `gain_1_rad` is that over `kp`.\n");
            text.push_str(&line(&format!("kp = 1.0\ngain_1_rad = {gain:?}")));
            if motor.kd != 0.0 {
                text.push_str(&line(&format!("kd = {:?}", motor.kd)));
            }
            if !motor.limited {
                text.push_str(
                    "# The model states no torque limit: `stall_torque` is never reached. Write that of the motor where it is known.\n",
                );
            }
        }
        None if drive == Drive::Torque => {}
        None => text.push_str("kp = 16.0\ngain_1_rad = 0.166\n"),
    }
}

/// What the model does with the commands of a joint before they are its goals or torques.
fn commands(text: &mut String, motor: &StatedMotor, unit: &str) {
    let unit = match motor.drive {
        Drive::Velocity => format!("{unit}/s"),
        Drive::Torque if unit == "m" => "N".to_owned(),
        Drive::Torque => "N·m".to_owned(),
        Drive::Position | Drive::Voltage => unit.to_owned(),
    };
    if motor.command_scale != 1.0 {
        text.push_str(&line(&format!(
            "# Of the gear and the gain in the model: what its commands are multiplied by. Write 1.0 where they were recorded in {unit}.\n\
             command_scale = {:?}",
            motor.command_scale
        )));
    }
    if let Some([lower, upper]) = motor.command_range {
        let or_limit = if motor.drive == Drive::Torque { ", and at `stall_torque`" } else { "" };
        text.push_str(&line(&format!(
            "# The model clips commands to this range ({unit}); the simulation does so only where this key stands{or_limit}.\n\
             # command_range = [{lower:?}, {upper:?}]"
        )));
    }
}

/// The input that switches all motors.
const SWITCH: &str = "
[inputs.torque_on]
# Whether motors are on: 0 releases them.
";

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::SimulationFile;
    use crate::robot::stated_motors;

    const MODEL: &str = "<mujoco><compiler angle='radian'/><worldbody>\
        <body><joint name='Lift' damping='0.6' frictionloss='0.05' armature='0.03'/><geom size='0.1'/>\
        <body><joint name='reach' type='slide'/><geom size='0.1'/></body></body></worldbody>\
        <actuator><position joint='Lift' kp='18' kv='1.5' forcerange='-3 3' ctrlrange='-1 2'/><motor joint='reach'/></actuator></mujoco>";

    fn written(columns: Option<Vec<JointColumns>>) -> SimulationFile {
        switched(columns, None)
    }

    fn switched(columns: Option<Vec<JointColumns>>, switch: Option<LogColumn>) -> SimulationFile {
        let path = Path::new("m.xml");
        let robot = tunenet_models::Model::parse_alone(path, MODEL).unwrap();
        let rate_hz = columns.is_some().then_some(30.0);
        let start =
            RobotStart { motors: stated_motors(robot.robot()), columns, switch, rate_hz, ..RobotStart::default() };
        let model = crate::arm::model_file::parse_mjcf(path, MODEL).unwrap();
        let text = robot_template("m \"x\".xml", &model, &start);
        SimulationFile::parse(Path::new("robot.toml"), &text).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    #[test]
    fn it_starts_at_what_the_model_states() {
        let file = written(None);
        let robot = file.robot().unwrap();
        assert_eq!(robot.robot.model, Path::new("m \"x\".xml"));
        let lift = &robot.joints["Lift"];
        assert_eq!((lift.drive, lift.kp, lift.gain_1_rad, lift.kd), (Drive::Position, 1.0, Some(6.0), 0.5));
        let reach = &robot.joints["reach"];
        assert_eq!((reach.drive, reach.command.as_str()), (Drive::Torque, "reach_force_n"));
        let parameters = file.parameters().unwrap();
        let of = |name: &str| parameters.iter().find(|p| p.name == name).map(|p| p.value);
        let names = ["stall_torque", "back_emf", "viscous", "coulomb", "armature"];
        let lift: Vec<Option<f64>> = names.iter().map(|name| of(&format!("Lift__{name}"))).collect();
        assert_eq!(lift, [Some(3.0), Some(0.0), Some(0.6), Some(0.05), Some(0.03)]);
        assert_eq!(of("reach__stall_torque"), None);
    }

    /// A gear of 2 halves goals and doubles torques; a range is a line to remove the mark from.
    #[test]
    fn gears_and_ranges_of_commands_are_keys() {
        let of = |actuator: &str| {
            let text = format!(
                "<mujoco><compiler angle='radian'/><worldbody><body><joint name='a'/><geom size='0.1'/></body></worldbody>\
                 <actuator>{actuator}</actuator></mujoco>"
            );
            let path = Path::new("m.xml");
            let robot = tunenet_models::Model::parse_alone(path, &text).unwrap();
            let start = RobotStart { motors: stated_motors(robot.robot()), ..RobotStart::default() };
            robot_template("m.xml", &crate::arm::model_file::parse_mjcf(path, &text).unwrap(), &start)
        };
        let joint = |text: &str| {
            let file = SimulationFile::parse(Path::new("robot.toml"), text).unwrap_or_else(|e| panic!("{e}\n{text}"));
            file.robot().unwrap().joints["a"].clone()
        };
        let servo = of("<position joint='a' kp='30' gear='2' ctrlrange='-1 0.5'/>");
        assert_eq!((joint(&servo).command_scale, joint(&servo).command_range), (0.5, None), "{servo}");
        assert!(servo.contains("Write that of the motor"), "{servo}");
        let clipped = joint(&servo.replacen("# command_range", "command_range", 1));
        assert_eq!(clipped.command_range, Some([-0.5, 0.25]));
        assert_eq!(joint(&of("<motor joint='a' gear='-2'/>")).command_scale, -2.0);
        assert_eq!(joint(&of("<velocity joint='a' kv='3' gear='-1'/>")).command_scale, -1.0);
        let plain = of("<position joint='a' kp='30' forcerange='-3 3'/>");
        assert!(
            !plain.contains("command_scale")
                && !plain.contains("command_range")
                && !plain.contains("Write that of the motor")
        );
        // What turns commands into nothing, or has no room, is refused.
        for (from, to, expected) in [
            ("command_scale = 0.5", "command_scale = 0.0", "`joints.a.command_scale`: expected a number other than 0"),
            (
                "# command_range = [-0.5,",
                "command_range = [0.5,",
                "`joints.a.command_range`: expected the smaller number first",
            ),
        ] {
            let refused =
                SimulationFile::parse(Path::new("robot.toml"), &servo.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(refused.contains(expected), "{refused}");
        }
    }

    #[test]
    fn stops_and_followers_of_the_model_are_said_in_the_file() {
        let urdf = "<robot name='r'><link name='l0'/><link name='l1'/><link name='l2'/>\
            <joint name='a' type='revolute'><parent link='l0'/><child link='l1'/><limit lower='-1' upper='1.25' effort='1' velocity='1'/></joint>\
            <joint name='b' type='continuous'><parent link='l1'/><child link='l2'/><mimic joint='a' multiplier='2'/></joint></robot>";
        let model = crate::arm::urdf::parse(Path::new("r.urdf"), urdf).unwrap();
        let text = robot_template("r.urdf", &model, &RobotStart::default());
        SimulationFile::parse(Path::new("robot.toml"), &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(text.matches("# The model stops this joint at -1 and 1.25 rad;").count(), 1, "{text}");
        assert!(text.contains("# No table for `b`: it follows `a`") && !text.contains("[joints.b]"), "{text}");
    }

    /// A URDF states what commands mean, and no gain; a torque drive without effort limit has no greatest torque.
    #[test]
    fn drives_of_a_urdf_keep_the_gains_of_the_template() {
        let urdf = "<robot name='r'><link name='l0'/><link name='l1'/><link name='l2'/>\
            <joint name='a' type='continuous'><parent link='l0'/><child link='l1'/></joint>\
            <joint name='b' type='continuous'><parent link='l1'/><child link='l2'/></joint></robot>";
        let model = crate::arm::urdf::parse(Path::new("r.urdf"), urdf).unwrap();
        let drives = [("a", Drive::Velocity), ("b", Drive::Torque)];
        let drives = drives.map(|(joint, drive)| StatedDrive { joint: joint.into(), drive }).to_vec();
        let text = robot_template("r.urdf", &model, &RobotStart { drives, ..RobotStart::default() });
        let file =
            SimulationFile::parse(Path::new("robot.toml"), &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let joints = &file.robot().unwrap().joints;
        let a = &joints["a"];
        assert_eq!(
            (a.drive, a.command.as_str(), a.kp, a.gain_1_rad),
            (Drive::Velocity, "a_rate_rad_s", 16.0, Some(0.166))
        );
        let b = &joints["b"];
        assert_eq!((b.drive, b.command.as_str(), b.gain_1_rad), (Drive::Torque, "b_torque_nm", None));
        let parameters = file.parameters().unwrap();
        let of = |name: &str| parameters.iter().find(|p| p.name == name).map(|p| (p.value, p.tune));
        assert_eq!((of("b__stall_torque"), of("b__back_emf")), (None, Some((0.0, false))));
        assert_eq!(of("a__stall_torque").map(|(_, tune)| tune), Some(true));
    }

    #[test]
    fn a_column_of_a_log_releases_all_motors() {
        let column = |name: &str| LogColumn { column: name.into(), topic: Some("/state".into()) };
        let lift = JointColumns { joint: "Lift".into(), channel: "lift_rad".into(), command: column("goal") };
        let file = switched(Some(vec![lift]), Some(column("motor_on")));
        let robot = file.robot().unwrap();
        assert_eq!(robot.joints["Lift"].enable.as_deref(), Some("torque_on"));
        let input = &robot.inputs["torque_on"];
        assert_eq!((input.column.as_deref(), input.topic.as_deref()), (Some("motor_on"), Some("/state")));
    }

    #[test]
    fn a_log_says_which_joints_move_and_where_their_numbers_are() {
        let one = JointColumns {
            joint: "Lift".into(),
            channel: "lift_rad".into(),
            command: LogColumn { column: "action.lift".into(), topic: None },
        };
        let file = written(Some(vec![one]));
        let robot = file.robot().unwrap();
        assert_eq!(robot.joints.keys().collect::<Vec<_>>(), ["Lift"]);
        assert_eq!(
            (robot.joints["Lift"].observe.as_slice(), &robot.joints["Lift"].enable),
            (&["lift_rad".to_owned()][..], &None)
        );
        assert_eq!(robot.inputs["lift_goal_rad"].column.as_deref(), Some("action.lift"));
        assert!(!file.parameters().unwrap().iter().find(|p| p.name == "Lift__back_emf").unwrap().tune);
        let parameters = file.parameters().unwrap();
        assert_eq!(parameters.iter().find(|p| p.name == "Lift__zero").map(|p| (p.min, p.max)), Some((-1.6, 1.6)));
        let limit = parameters.iter().find(|p| p.name == "Lift__stall_torque").unwrap();
        assert_eq!((limit.value, limit.tune), (3.0, false));
        let rotor = parameters.iter().find(|p| p.name == "Lift__armature").unwrap();
        assert!((rotor.min - 0.01).abs() < 1e-12 && (rotor.max - 0.09).abs() < 1e-12, "{} {}", rotor.min, rotor.max);
        let effects = file.robot_effects().unwrap();
        let tuned: Vec<(&str, &[f64])> =
            effects.iter().filter(|one| one.tune).map(|one| (one.effect.name, one.values.as_slice())).collect();
        assert_eq!(tuned, [("command_offset", &[0.0][..]), ("firmware_gain", &[1.0])]);
        assert_eq!(robot.integrate.step_s, 0.004);
        assert_eq!([200.0, 50.0, 10.0].map(step_s), [0.001, 0.002, 0.004]);
    }

    #[test]
    fn a_column_whose_name_is_no_channel_is_mapped() {
        let model = crate::arm::model_file::parse_mjcf(Path::new("m.xml"), MODEL).unwrap();
        let lift = model.joints()[0];
        assert_eq!(position_channel(lift, Some("elbow_flex")), "elbow_flex_rad");
        assert_eq!(position_channel(lift, Some("obs.joint_pos.2")), "lift_rad");
        assert_eq!(position_channel(lift, Some("q_deg")), "lift_rad");
    }
}
