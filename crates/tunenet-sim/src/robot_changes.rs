//! The numbers of a robot's simulation as changes of its model file.
//!
//! Source of the map: MuJoCo's `<position>` with `kp` = A·c·kp, `kv` = A·kd and `forcerange` = ±A is the servo of the simulation; the
//! braking B is outside `forcerange`, and so part of the joint's `damping` = B + D.

use tunenet_formats::{Error, Result};
use tunenet_models::edit::Left;
use tunenet_models::export::{BamServo, Whole, WholeNumber};
use tunenet_models::{Change, Motion, Quantity};

use crate::SimulationFile;
use crate::arm::{JointKind, Model, model_file};
use crate::observed_robot::{chain, is_slide, model_path, order, rig, roles};
use crate::robot::imperfect::Imperfect;
use crate::robot::numbers::JointNumbers;
use crate::robot::numbers::Number;
use crate::robot::{Drive, StatedMotor, driven_joints, stated_motors};
use crate::scene::JointScene;
use crate::simulation_file::PresentRobotEffect;
use crate::simulation_file::robot_schema::BETWEEN;

/// What a simulation says of a robot that its model file may hold.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotChanges {
    /// Numbers of joints.
    pub changes: Vec<Change>,
    /// Numbers that no format takes: a mechanical property below 0.
    pub left: Vec<Left>,
    /// Effects of the robot as a whole.
    pub whole: Vec<Whole>,
    /// The servo of each joint with a position drive, by the joint's name, without the name of its kind.
    pub servos: Vec<(String, BamServo)>,
    /// What is written in other words than the simulation has it.
    pub notes: Vec<String>,
}

/// The 95 % interval of a number, by the name that a tuning has for it: `elbow__coulomb`, or `load_friction.mu.2` of the second joint.
pub type Intervals<'a> = &'a dyn Fn(&str) -> Option<[f64; 2]>;

/// The numbers of the robot's simulation `file`.
///
/// # Errors
/// As [`robot`](crate::observed_robot::robot).
pub fn robot_changes(file: &SimulationFile, intervals: Intervals) -> Result<RobotChanges> {
    let (whole, described) = model_file::read_driven(&model_path(file)?)?;
    let model = chain(file, &whole)?;
    let order = order(file, &model)?;
    let rig = rig(file, &model)?;
    let parameters = file.parameters()?;
    let present = file.robot_effects()?;
    let mut imperfect = Imperfect::none(order.len());
    for one in &present {
        one.effect.apply(&mut imperfect, &one.values);
    }
    let values: Vec<f64> = parameters.iter().map(|parameter| parameter.value).collect();
    let joints = driven_joints(&rig.joints, &roles(&parameters, &order), &values, &imperfect);
    let motors = described.as_ref().map(stated_motors).unwrap_or_default();
    let names = order.iter().map(|(key, _)| model_file::named(file, &whole, key)).collect::<Result<Vec<&str>>>()?;
    // A motor that is released shows which of both is late.
    let alike = order.iter().all(|(_, scene)| scene.enable.is_none());
    let late_s = if alike { imperfect.reading_delay_s } else { 0.0 };
    let mut found = RobotChanges {
        changes: Vec::new(),
        left: Vec::new(),
        whole: of_whole(&present, late_s != 0.0, intervals),
        servos: Vec::new(),
        notes: Vec::new(),
    };
    if late_s != 0.0 {
        found.notes.push(format!(
            "`{TIME_DELAY}` is written as a delay of the commands of every joint: no recording from rest distinguishes both"
        ));
    }
    let formulas = file.effects().into_iter().filter(|effect| file.candidate(&effect.name).is_some());
    found.notes.extend(formulas.map(|effect| format!("`{}` is a formula, which no model file holds", effect.name)));
    found.changes.extend(extra_load(&model, &present, intervals));
    let kinds = kinds(&model, &order);
    for (place, (name, scene)) in order.iter().enumerate() {
        let is_parameter = |number: &str| parameters.iter().any(|one| one.name == format!("{name}{BETWEEN}{number}"));
        let one = OneJoint {
            name,
            in_model: names[place],
            motion: kinds[place],
            place,
            late_s,
            numbers: &joints[place],
            of_model: &rig.joints[place],
            motor: motors.iter().find(|motor| motor.joint == names[place]),
            intervals,
            is_parameter: &is_parameter,
            present: &present,
        };
        one.motor(&mut found);
        one.friction(&mut found);
        one.effects(&mut found);
        if scene.drive == Drive::Position {
            let servo = BamServo {
                actuator: String::new(),
                supply_v: scene.supply_v,
                firmware_gain: Some(scene.kp),
                // With what the effects of the gain make of it.
                error_gain: Some(joints[place].gain * joints[place].kp / scene.kp).filter(|gain| gain.is_finite()),
            };
            found.servos.push((names[place].to_owned(), servo));
        }
    }
    if found.changes.is_empty() {
        let message = "expected numbers of joints that a model file may hold, found none";
        return Err(Error::file(file.path(), message, "give the joints parameters, such as JOINT__viscous"));
    }
    Ok(found)
}

/// How each of these joints moves.
fn kinds(model: &Model, order: &[(&str, &JointScene)]) -> Vec<Motion> {
    order.iter().map(|(name, _)| if is_slide(model, name) { Motion::Prismatic } else { Motion::Revolute }).collect()
}

/// The effect that is a mass of the last link.
const EXTRA_LOAD: &str = "extra_load";
/// The effect of readings that are late.
const TIME_DELAY: &str = "time_delay";

/// Numbers below this, in SI units, are 0.
const SMALLEST: f64 = 1e-12;

/// A load that the file does not state: it goes with the joint that moves the last link.
fn extra_load(model: &Model, present: &[PresentRobotEffect], intervals: Intervals) -> Option<Change> {
    let one = present.iter().find(|one| one.effect.name == EXTRA_LOAD)?;
    let (last, (c, value)) = (model.bodies.last()?, one.effect.coefficients.iter().zip(&one.values).next()?);
    Some(Change {
        joint: last.joint.name.clone(),
        motion: if last.joint.kind == JointKind::Prismatic { Motion::Prismatic } else { Motion::Revolute },
        quantity: Quantity::ExtraLoad,
        value: *value,
        interval: of_effect(intervals, (EXTRA_LOAD, c.key.as_ref()), 0),
    })
}

/// Effects that no single joint has; `as_commands` says that late readings are written as late commands.
fn of_whole(present: &[PresentRobotEffect], as_commands: bool, intervals: Intervals) -> Vec<Whole> {
    let of_joints = |name: &str| name == EXTRA_LOAD || as_commands && name == TIME_DELAY;
    let whole = present.iter().filter(|one| !one.effect.per_joint && !of_joints(one.effect.name));
    whole
        .map(|one| Whole {
            effect: one.effect.name.to_owned(),
            numbers: one
                .effect
                .coefficients
                .iter()
                .zip(&one.values)
                .map(|(c, value)| WholeNumber {
                    key: c.key.to_string(),
                    value: *value,
                    interval: of_effect(intervals, (one.effect.name, c.key.as_ref()), 0),
                })
                .collect(),
            why: "it belongs to the robot or its readings as a whole, for which the model file has no attribute".into(),
        })
        .collect()
}

/// The interval of an effect's number at a place, from 0: numbered where each joint has its own.
fn of_effect(intervals: Intervals, (effect, key): (&str, &str), place: usize) -> Option<[f64; 2]> {
    let numbered = intervals(&format!("{effect}.{key}.{}", place + 1));
    numbered.or_else(|| intervals(&format!("{effect}.{key}")).filter(|_| place == 0))
}

/// A joint with all that its numbers come from.
struct OneJoint<'a> {
    name: &'a str,
    /// What the model calls it.
    in_model: &'a str,
    motion: Motion,
    place: usize,
    /// By how much its readings are late, where that is written as a delay of its commands, s.
    late_s: f64,
    numbers: &'a JointNumbers,
    /// The numbers before parameters and effects.
    of_model: &'a JointNumbers,
    motor: Option<&'a StatedMotor>,
    intervals: Intervals<'a>,
    is_parameter: &'a dyn Fn(&str) -> bool,
    present: &'a [PresentRobotEffect],
}

impl OneJoint<'_> {
    fn add(&self, found: &mut RobotChanges, quantity: Quantity, value: f64, interval: Option<[f64; 2]>) {
        // A fit that ends at its bound 0 leaves the smallest of numbers there.
        let value = if value.abs() < SMALLEST { 0.0 } else { value };
        let change = Change { joint: self.in_model.to_owned(), motion: self.motion, quantity, value, interval };
        if value < 0.0 && !quantity.signed() {
            let why = "a number below 0 is no property of a mechanism: model files and simulators refuse it".into();
            found.left.push(Left { change, why });
        } else {
            found.changes.push(change);
        }
    }

    /// Gains and the torque limit.
    fn motor(&self, found: &mut RobotChanges) {
        let JointNumbers { drive, stall, gain, kp, kd, duty_max, .. } = *self.numbers;
        let own = (self.intervals)(&format!("{}{BETWEEN}stall_torque", self.name));
        // Gain and limit are known as well as the stall torque that scales them.
        let scaled = |factor: f64| {
            let sure = !self.has("firmware_gain") && !self.has("firmware_damping") && !self.has("duty_limit");
            own.filter(|_| sure).map(|ends| ends.map(|end| end * factor))
        };
        // Of a stall torque that is not tuned, the gain is known as well as the factor that multiplies it.
        let of_gain = self.of("firmware_gain", "factor").filter(|_| own.is_none());
        let multiplied = |value: f64| {
            let factor = self.present.iter().find(|one| one.effect.name == "firmware_gain")?.values.get(self.place)?;
            of_gain.map(|ends| ends.map(|end| value * end / factor))
        };
        let brakes = kd != 0.0 || self.motor.is_some_and(|motor| motor.kd != 0.0);
        match drive {
            Drive::Position => {
                let value = stall * gain * kp;
                self.add(found, Quantity::PositionGain, value, scaled(gain * kp).or_else(|| multiplied(value)));
                if brakes {
                    self.add(found, Quantity::VelocityGain, stall * kd, scaled(kd));
                }
            }
            Drive::Velocity => {
                let value = stall * gain * kp;
                self.add(found, Quantity::VelocityGain, value, scaled(gain * kp).or_else(|| multiplied(value)));
            }
            Drive::Torque | Drive::Voltage => {}
        }
        // What the model does not limit gets a limit only where one was found.
        let limited = duty_max < 1.0 || self.motor.is_none_or(|motor| motor.limited);
        if limited && (drive.has_duty() || drive == Drive::Torque && stall > 0.0) {
            self.add(found, Quantity::TorqueLimit, stall * duty_max, scaled(duty_max));
        }
        if limited && drive.has_duty() {
            self.add(found, Quantity::StallTorque, stall, own);
        }
    }

    /// What brakes, and the rotor's inertia.
    fn friction(&self, found: &mut RobotChanges) {
        let braking = self.numbers.back_emf;
        let all = [
            (Quantity::ViscousFriction, Number::Viscous, "viscous", "viscous_friction", braking != 0.0),
            (Quantity::BackEmf, Number::BackEmf, "back_emf", "", braking != 0.0),
            (Quantity::CoulombFriction, Number::Coulomb, "coulomb", "coulomb_friction", false),
            (Quantity::Armature, Number::Armature, "armature", "armature", false),
        ];
        for (quantity, number, parameter, effect, wanted) in all {
            let (value, old) = (*number.of(&mut self.numbers.clone()), *number.of(&mut self.of_model.clone()));
            let said = (self.is_parameter)(parameter) && quantity != Quantity::BackEmf;
            if wanted || said || value != old {
                let interval = (self.intervals)(&format!("{}{BETWEEN}{parameter}", self.name));
                self.add(found, quantity, value, interval.filter(|_| !self.has(effect)));
            }
        }
    }

    /// What the joint has beyond that.
    fn effects(&self, found: &mut RobotChanges) {
        let n = self.numbers;
        let speed_limit = if n.inverse_speed > 0.0 { n.inverse_speed.recip() } else { 0.0 };
        let turned = |[low, high]: [f64; 2]| [high.recip(), low.recip()];
        // Without the effect, the spring is that of the model.
        let stiffness = if self.has("joint_spring") { n.spring } else { 0.0 };
        let spring = self.of("joint_spring", "nm_rad").map(|ends| ends.map(|end| end + self.of_model.spring));
        let all = [
            (Quantity::CommandDelay, n.command_delay_s + self.late_s, self.delay()),
            (Quantity::CommandLag, n.command_lag_s, self.of("command_lag", "s")),
            (Quantity::ReleaseDelay, n.release_delay_s, self.of("release_delay", "s")),
            (
                Quantity::GoalSpeedLimit,
                speed_limit,
                self.of("speed_limit", "inverse_s_rad").filter(|ends| ends[0] > 0.0).map(turned),
            ),
            (Quantity::CommandOffset, n.command_offset, self.of("command_offset", "rad")),
            (Quantity::DeadBand, n.dead_band, self.of("dead_band", "rad")),
            (Quantity::Backlash, n.gap, self.of("backlash", "gap_rad")),
            (Quantity::LoadFriction, n.load_friction, self.of("load_friction", "mu")),
            (Quantity::StribeckFriction, n.stribeck, self.of("stribeck_friction", "nm")),
            (
                Quantity::StribeckSpeed,
                if n.stribeck == 0.0 { 0.0 } else { n.stribeck_speed },
                self.of("stribeck_friction", "rad_s"),
            ),
            (Quantity::DirectionalFriction, n.directional, self.of("directional_friction", "nm")),
            (Quantity::QuadraticFriction, n.quadratic, self.of("quadratic_friction", "nms2_rad2")),
            (Quantity::Stiffness, stiffness, spring),
            (Quantity::SpringReference, if stiffness == 0.0 { 0.0 } else { n.preload / stiffness }, None),
            (Quantity::Compliance, n.compliance, self.of("joint_elasticity", "rad_nm")),
            (Quantity::VoltageSag, n.sag_ohm, self.of("voltage_sag", "ohm")),
            (Quantity::ReleaseBraking, n.release_braking, self.of("release_braking", "nms_rad")),
            (Quantity::ZeroOffset, -n.zero, self.zero()),
        ];
        for (quantity, value, interval) in all.into_iter().filter(|(_, value, _)| *value != 0.0) {
            self.add(found, quantity, value, interval);
        }
    }

    /// The interval of the delay of its commands, with that of its readings; of both together none is known.
    fn delay(&self) -> Option<[f64; 2]> {
        match (self.has("command_delay"), self.late_s != 0.0) {
            (true, true) => None,
            (false, true) => of_effect(self.intervals, (TIME_DELAY, "delay_s"), 0),
            _ => self.of("command_delay", "s"),
        }
    }

    /// The interval of what the encoder reads too much, which is the other way round than the parameter.
    fn zero(&self) -> Option<[f64; 2]> {
        let own = (self.intervals)(&format!("{}{BETWEEN}zero", self.name)).filter(|_| !self.has("joint_offset"));
        own.map(|[low, high]| [-high, -low])
    }

    fn has(&self, effect: &str) -> bool {
        self.present.iter().any(|one| one.effect.name == effect)
    }

    /// The interval of this joint's number of an effect.
    fn of(&self, effect: &str, key: &str) -> Option<[f64; 2]> {
        of_effect(self.intervals, (effect, key), self.place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: &str = "<mujoco><compiler angle='radian'/><worldbody>\
        <body><joint name='a' damping='0.6' frictionloss='0.05' armature='0.03'/><geom size='0.1'/>\
        <body><joint name='b'/><geom size='0.1'/></body></body></worldbody>\
        <actuator><position joint='a' kp='18' kv='1.5' forcerange='-3 3'/><motor joint='b'/></actuator></mujoco>";
    const FILE: &str = "kind = \"robot\"\n[robot]\nmodel = \"m.xml\"\n[inputs.a_goal_rad]\n[inputs.b_torque_nm]\n\
        [joints.a]\ndrive = \"position\"\ncommand = \"a_goal_rad\"\nobserve = [\"a_rad\"]\nkp = 2.0\nkd = 0.5\ngain_1_rad = 3.0\n\
        [joints.b]\ndrive = \"torque\"\ncommand = \"b_torque_nm\"\nobserve = [\"b_rad\"]\n\
        [effects.speed_limit]\ninverse_s_rad = [0.25, 0.0]\n[effects.time_delay]\ndelay_s = 0.01\n[effects.joint_spring]\nnm_rad = [0.0, -1.0]\n\
        [parameters.a__stall_torque]\nvalue = 4.0\nmin = 0.1\nmax = 9.0\n[parameters.a__back_emf]\nvalue = 0.2\nmin = 0.0\nmax = 9.0\n\
        [parameters.a__zero]\nvalue = 0.1\nmin = -1.0\nmax = 1.0\n[parameters.b__coulomb]\nvalue = 0.4\nmin = 0.0\nmax = 9.0\n";

    #[test]
    fn numbers_are_those_of_the_map() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("m.xml"), MODEL).unwrap();
        let file = SimulationFile::parse(&folder.path().join("robot.toml"), FILE).unwrap();
        let intervals = |name: &str| match name {
            "a__stall_torque" => Some([3.0, 5.0]),
            "a__zero" => Some([0.0, 0.2]),
            "speed_limit.inverse_s_rad.1" => Some([0.2, 0.5]),
            "time_delay.delay_s" => Some([0.009, 0.011]),
            _ => None,
        };
        let late = Some((0.01, Some([0.009, 0.011])));
        let found = robot_changes(&file, &intervals).unwrap();
        let of = |joint: &str, quantity| {
            let one = found.changes.iter().find(|change| change.joint == joint && change.quantity == quantity);
            one.map(|change| (change.value, change.interval))
        };
        // A·c·kp, A·kd, A; the model's damping stays, and the motor's braking comes with it.
        assert_eq!(of("a", Quantity::PositionGain), Some((24.0, Some([18.0, 30.0]))));
        assert_eq!(of("a", Quantity::VelocityGain), Some((2.0, Some([1.5, 2.5]))));
        assert_eq!(of("a", Quantity::TorqueLimit), Some((4.0, Some([3.0, 5.0]))));
        assert_eq!(
            (of("a", Quantity::ViscousFriction), of("a", Quantity::BackEmf)),
            (Some((0.6, None)), Some((0.2, None)))
        );
        assert_eq!((of("a", Quantity::CoulombFriction), of("a", Quantity::Armature)), (None, None));
        assert_eq!(of("a", Quantity::GoalSpeedLimit), Some((4.0, Some([2.0, 5.0]))));
        assert_eq!(of("a", Quantity::ZeroOffset), Some((-0.1, Some([-0.2, 0.0]))));
        assert_eq!(of("b", Quantity::CoulombFriction), Some((0.4, None)));
        assert_eq!(of("b", Quantity::TorqueLimit), None);
        let left: Vec<_> = found.left.iter().map(|left| (left.change.joint.as_str(), left.change.quantity)).collect();
        assert_eq!(left, [("b", Quantity::Stiffness)]);
        assert_eq!(found.servos[0].1.firmware_gain, Some(2.0));
        // Late readings are late commands of every joint, where no motor is released.
        assert_eq!((of("a", Quantity::CommandDelay), of("b", Quantity::CommandDelay)), (late, late));
        assert!(found.whole.is_empty() && found.notes.len() == 1, "{found:?}");
        let released =
            FILE.replace("[joints.a]\n", "[inputs.torque_on]\ndefault = 1.0\n[joints.a]\nenable = \"torque_on\"\n");
        let file = SimulationFile::parse(&folder.path().join("robot.toml"), &released).unwrap();
        let found = robot_changes(&file, &intervals).unwrap();
        assert_eq!(found.whole.iter().map(|whole| whole.effect.as_str()).collect::<Vec<_>>(), ["time_delay"]);
        assert!(found.changes.iter().all(|change| change.quantity != Quantity::CommandDelay));
    }
}
