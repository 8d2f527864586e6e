//! What an MJCF says of the motors of its joints, as numbers of a simulation file; and a URDF of their commands.
//!
//! Source of the map: a servo's torque is A·clip(c·kp·e − kd·w, ±1) − B·w, and the position actuator of MuJoCo makes
//! clip(kp'·e − kv'·w, ±F): F = A, kp' = A·c·kp, kv' = A·kd. The braking B is outside the limit, and so part of the joint's damping.
//!
//! With a gear g, the joint gets g times the force of the actuator, whose length is g·q (MuJoCo, Computation, Transmission): a servo has
//! g·kp'·(u − g·q) − g²·kv'·w = g²·kp'·(u/g − q) − g²·kv'·w, so that its goal is u/g; a drive of a speed likewise; a torque is g·gain·u.

use tunenet_core::observation::Note;
use tunenet_core::text::visible;
use tunenet_models::urdf::{Commanded, Commands, Interface};
use tunenet_models::{Actuator, Filter, Joint, Law, Motion, Robot, Target};

use super::numbers::Drive;
use crate::findings;

/// The error at which a servo without a limit would be at full duty: more rad or m than any joint is away from its goal, and more
/// rad/s or m/s.
const UNLIMITED: f64 = 10.0;
const UNLIMITED_SPEED: f64 = 100.0;

/// The motor of a joint, of which the model states at least something. SI units; of a sliding joint N for N·m and m for rad.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedMotor {
    /// Name of the joint.
    pub joint: String,
    /// What its commands mean.
    pub drive: Drive,
    /// Duty for each rad (of a velocity drive, rad/s) of error: `gain_1_rad` where the gain of the firmware is 1. `None` of a torque
    /// drive, and where the model has no such actuator.
    pub gain: Option<f64>,
    /// Duty for each rad/s within the firmware.
    pub kd: f64,
    /// Torque at full duty and rest, N·m; of a servo without a limit, that of an error that no joint has. `None` of a torque drive
    /// that the model does not limit.
    pub stall_torque: Option<f64>,
    /// Whether the model limits the torque.
    pub limited: bool,
    /// What a command of the model is multiplied by to be the goal of the joint, or its torque: by the gear and the gain.
    pub command_scale: f64,
    /// Least and greatest command after that, in the unit of the joint; `None` where it is not limited.
    pub command_range: Option<[f64; 2]>,
    /// Time constant of a first-order filter between command and force, s; 0 without one.
    pub command_lag_s: f64,
    /// How late commands act, s.
    pub command_delay_s: f64,
    /// Viscous friction with the braking by the motor, N·m·s/rad.
    pub damping: f64,
    /// Coulomb friction, N·m.
    pub friction: f64,
    /// Inertia of the rotor behind the gear, kg·m².
    pub armature: f64,
}

/// What the commands to a joint mean by a URDF, which states neither gains nor limits of a motor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatedDrive {
    /// Name of the joint.
    pub joint: String,
    /// What its commands mean.
    pub drive: Drive,
}

/// The drives of the joints whose commands are known: of several kinds, a position counts before a speed, and that before a torque.
#[must_use]
pub fn stated_drives(commands: &Commands) -> Vec<StatedDrive> {
    let one = |joint: &Commanded| {
        let drive = match joint.interfaces.first()? {
            Interface::Position => Drive::Position,
            Interface::Velocity => Drive::Velocity,
            Interface::Effort => Drive::Torque,
        };
        Some(StatedDrive { joint: joint.joint.clone(), drive })
    };
    commands.joints.iter().filter_map(one).collect()
}

/// The motors of all hinges and slides.
#[must_use]
pub fn stated_motors(robot: &Robot) -> Vec<StatedMotor> {
    let scalar = |joint: &Joint| matches!(joint.motion, Motion::Revolute | Motion::Prismatic);
    let joints = robot.joints.iter().enumerate().filter(|(_, joint)| scalar(joint));
    joints.map(|(index, _)| motor(robot, index, &robot.with_followers(index))).collect()
}

fn motor(robot: &Robot, index: usize, joint: &Joint) -> StatedMotor {
    let mut own = robot.actuators.iter().filter(|actuator| actuator.target == Target::Joint(index));
    // Several actuators of one joint are no single motor.
    let actuator = match (own.next(), own.next()) {
        (Some(only), None) if only.gear != 0.0 => Some(only),
        _ => None,
    };
    let mut motor = StatedMotor {
        joint: joint.name.clone(),
        drive: Drive::Position,
        gain: None,
        kd: 0.0,
        stall_torque: joint.effort_range.map(largest).filter(|torque| *torque > 0.0),
        limited: true,
        command_scale: 1.0,
        command_range: None,
        command_lag_s: 0.0,
        command_delay_s: 0.0,
        damping: joint.damping,
        friction: joint.friction,
        armature: joint.armature,
    };
    let Some(actuator) = actuator else { return motor };
    let gear = actuator.gear;
    let limit = actuator.force_range.map(|range| largest(range) * gear.abs()).filter(|torque| *torque > 0.0);
    motor.stall_torque = match (motor.stall_torque, limit) {
        (Some(of_joint), Some(own)) => Some(of_joint.min(own)),
        (of_joint, own) => of_joint.or(own),
    };
    motor.limited = motor.stall_torque.is_some();
    let Some(law) = motor_law(actuator) else { return motor };
    motor.command_delay_s = actuator.delay_s;
    if let Filter::LowPass { time_constant_s } = actuator.filter {
        motor.command_lag_s = time_constant_s;
    }
    motor.command_scale = match law {
        MotorLaw::Position { .. } | MotorLaw::Velocity { .. } => gear.recip(),
        MotorLaw::Torque { gain } => gain * gear,
    };
    motor.command_range = actuator.command_range.map(|range| ordered(range.map(|end| end * motor.command_scale)));
    match law {
        MotorLaw::Position { kp, kv } => {
            let stall = *motor.stall_torque.get_or_insert(UNLIMITED * kp * gear * gear);
            motor.gain = Some(kp * gear * gear / stall);
            motor.kd = kv * gear * gear / stall;
        }
        MotorLaw::Velocity { gain } => {
            motor.drive = Drive::Velocity;
            let stall = *motor.stall_torque.get_or_insert(UNLIMITED_SPEED * gain * gear * gear);
            motor.gain = Some(gain * gear * gear / stall);
        }
        MotorLaw::Torque { .. } => {
            motor.drive = Drive::Torque;
            motor.stall_torque = motor.stall_torque.or(motor.command_range.map(largest));
        }
    }
    motor
}

/// That gears and gains multiply the commands of these motors.
#[must_use]
pub fn scaled_commands(motors: &[StatedMotor]) -> Option<Note> {
    let scaled = motors.iter().filter(|motor| motor.command_scale != 1.0);
    let one = |motor: &StatedMotor| format!("`{}` by {}", visible(&motor.joint), rounded(motor.command_scale));
    let all: Vec<String> = scaled.map(one).collect();
    let text = || format!("gears and gains of the model multiply the commands of joints: {}", all.join(", "));
    let remedy = "write `command_scale = 1.0` where commands were recorded in the unit of the joint";
    (!all.is_empty()).then(|| Note::new(findings::MODEL_COMMAND_SCALE, text(), remedy))
}

/// To four digits, for people to read.
fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// The force of an actuator before its gear, where it is that of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum MotorLaw {
    /// kp · (command − length) − kv · speed.
    Position { kp: f64, kv: f64 },
    /// gain · (command − speed).
    Velocity { gain: f64 },
    /// gain · command.
    Torque { gain: f64 },
}

/// The law of an actuator, where it is that of a servo, of a drive of a speed or of a torque.
pub(crate) fn motor_law(actuator: &Actuator) -> Option<MotorLaw> {
    let Law::Affine { gain, bias } = actuator.law else { return None };
    if let Some([kp, kv]) = actuator.position_gains() {
        return Some(MotorLaw::Position { kp, kv });
    }
    let [constant, by_length, by_speed] = bias;
    if (constant, by_length) != (0.0, 0.0) {
        return None;
    }
    match by_speed {
        0.0 if gain != 0.0 => Some(MotorLaw::Torque { gain }),
        _ if gain > 0.0 && by_speed == -gain => Some(MotorLaw::Velocity { gain }),
        _ => None,
    }
}

fn largest([lower, upper]: [f64; 2]) -> f64 {
    lower.abs().max(upper.abs())
}

fn ordered([one, other]: [f64; 2]) -> [f64; 2] {
    [one.min(other), one.max(other)]
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::numbers::{Command, JointNumbers};
    use super::*;

    fn motors(actuators: &str) -> Vec<StatedMotor> {
        let text = format!(
            "<mujoco><compiler angle='radian'/><worldbody><body><joint name='a' damping='0.6' frictionloss='0.05' armature='0.03'/>\
             <geom size='0.1'/><body><joint name='b' actuatorfrcrange='-2 2'/><geom size='0.1'/></body></body></worldbody>\
             <actuator>{actuators}</actuator></mujoco>"
        );
        let model = tunenet_models::Model::parse_alone(Path::new("m.xml"), &text).unwrap();
        stated_motors(model.robot())
    }

    #[test]
    fn interfaces_of_a_urdf_are_drives() {
        let joint =
            |name: &str, interfaces: &[Interface]| Commanded { joint: name.into(), interfaces: interfaces.into() };
        let joints = vec![
            joint("a", &[Interface::Position, Interface::Velocity]),
            joint("b", &[Interface::Velocity]),
            joint("c", &[Interface::Effort]),
            joint("d", &[]),
        ];
        let drives = stated_drives(&Commands { joints, reductions: 0 });
        let drives: Vec<_> = drives.iter().map(|one| (one.joint.as_str(), one.drive)).collect();
        assert_eq!(drives, [("a", Drive::Position), ("b", Drive::Velocity), ("c", Drive::Torque)]);
    }

    #[test]
    fn a_position_actuator_is_a_servo() {
        let all = motors("<position joint='a' kp='18' kv='1.5' forcerange='-3 3' ctrlrange='-1 2'/>");
        let one = &all[0];
        assert_eq!((one.drive, one.gain, one.kd, one.stall_torque), (Drive::Position, Some(6.0), 0.5, Some(3.0)));
        assert_eq!((one.command_range, one.damping, one.friction, one.armature), (Some([-1.0, 2.0]), 0.6, 0.05, 0.03));
        assert_eq!((all[1].gain, all[1].stall_torque), (None, Some(2.0)));
    }

    #[test]
    fn gears_count_and_what_is_unlimited_never_saturates() {
        let all = motors(
            "<position joint='a' kp='2' gear='-3' ctrlrange='-1 2'/><position joint='b' kp='10' forcerange='-5 5'/>",
        );
        assert_eq!((all[0].gain, all[0].stall_torque, all[0].limited), (Some(0.1), Some(180.0), false));
        assert_eq!(all[0].command_range, Some([-2.0 / 3.0, 1.0 / 3.0]));
        // The lesser of both limits.
        assert_eq!((all[1].gain, all[1].stall_torque, all[1].limited), (Some(5.0), Some(2.0), true));
    }

    /// The torque on the joint by MuJoCo's formula, g·(gain·u + b1·g·q + b2·g·w), and as the numbers of a simulation file have it.
    #[test]
    fn a_command_through_a_gear_gives_the_torque_of_the_formula() {
        let (command, position, speed) = (0.7, 0.3, -0.4);
        for gear in [2.0, -1.0, 0.5] {
            let of = |force: f64| gear * force;
            let cases = [
                ("position", "kp='30' kv='1.5'", of(30.0 * (command - gear * position) - 1.5 * gear * speed)),
                ("velocity", "kv='3'", of(3.0 * (command - gear * speed))),
                ("motor", "", of(command)),
                ("general", "gainprm='-4'", of(-4.0 * command)),
                (
                    "general",
                    "gainprm='30' biastype='affine' biasprm='0 -30 -1.5'",
                    of(30.0 * (command - gear * position) - 1.5 * gear * speed),
                ),
            ];
            for (tag, rest, expected) in cases {
                let motor = &motors(&format!("<{tag} joint='a' gear='{gear}' {rest}/>"))[0];
                let joint = JointNumbers {
                    kd: motor.kd,
                    gain: motor.gain.unwrap_or(0.0),
                    stall: motor.stall_torque.unwrap_or(0.0),
                    command_scale: motor.command_scale,
                    ..JointNumbers::free(motor.drive)
                };
                let goal = joint.commanded(command);
                let driven = joint.unlimited(Command { goal, on: 1.0 }, joint.demand(goal, position), speed);
                let found = driven.torque - driven.braking * speed;
                assert!((found - expected).abs() < 1e-12, "{tag} {rest} gear {gear}: {found} {expected}");
            }
        }
    }

    #[test]
    fn what_multiplies_commands_is_said() {
        let all = motors("<position joint='a' kp='2' gear='-3'/><motor joint='b' gear='10'/>");
        let text = "gears and gains of the model multiply the commands of joints: `a` by -0.3333, `b` by 10";
        assert_eq!(scaled_commands(&all).unwrap().text, text);
        assert_eq!(scaled_commands(&motors("<position joint='a' kp='2'/>")), None);
    }

    #[test]
    fn velocity_and_torque_drives_are_distinguished() {
        let all = motors("<velocity joint='a' kv='4' forcerange='-2 2'/><motor joint='b' gear='10' ctrlrange='-1 1'/>");
        assert_eq!((all[0].drive, all[0].gain, all[0].stall_torque), (Drive::Velocity, Some(2.0), Some(2.0)));
        assert_eq!((all[1].drive, all[1].gain, all[1].stall_torque), (Drive::Torque, None, Some(2.0)));
        assert_eq!(all[1].command_range, Some([-10.0, 10.0]));
        let odd = motors("<general joint='a' gainprm='3' biasprm='0 -2 0' biastype='affine'/>");
        assert_eq!((odd[0].drive, odd[0].gain), (Drive::Position, None));
        let two = motors("<motor joint='a'/><position joint='a' kp='3'/>");
        assert_eq!((two[0].drive, two[0].gain), (Drive::Position, None));
    }
}
