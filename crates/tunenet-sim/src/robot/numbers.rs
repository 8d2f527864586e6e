//! The numbers of a driven joint, as one rollout has them.

use serde::Deserialize;

/// What a command of a joint means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Drive {
    /// A position: a controller turns the error into the duty of the motor.
    Position,
    /// A speed: a controller turns the error into the duty of the motor.
    Velocity,
    /// The torque of the motor.
    Torque,
    /// A voltage, to which the force of the motor is proportional.
    Voltage,
}

impl Drive {
    /// As a file has it.
    pub const WORDS: &'static [&'static str] = &["position", "velocity", "torque", "voltage"];

    /// The unit of the command of a joint that turns, or that slides.
    #[must_use]
    pub fn command_unit(self, slides: bool) -> &'static str {
        match (self, slides) {
            (Self::Position, false) => "rad",
            (Self::Position, true) => "m",
            (Self::Velocity, false) => "rad/s",
            (Self::Velocity, true) => "m/s",
            (Self::Torque, false) => "N·m",
            (Self::Torque, true) => "N",
            (Self::Voltage, _) => "V",
        }
    }

    /// Whether a controller of the firmware sets the duty.
    #[must_use]
    pub fn has_duty(self) -> bool {
        matches!(self, Self::Position | Self::Velocity)
    }
}

/// A joint with its motor. Torques are in N·m and angles in rad; of a prismatic joint in N and m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JointNumbers {
    pub drive: Drive,
    /// Gain of the firmware.
    pub kp: f64,
    /// Damping of the firmware, duty by speed.
    pub kd: f64,
    /// Duty by kp and error, 1/rad; force by volt for a voltage drive.
    pub gain: f64,
    pub duty_max: f64,
    /// Supply voltage, V.
    pub supply_v: f64,
    /// Torque at full duty and rest; no limit of a torque drive where it is 0.
    pub stall: f64,
    /// Braking by the speed while the motor is on.
    pub back_emf: f64,
    pub viscous: f64,
    pub coulomb: f64,
    pub armature: f64,
    /// True less measured position.
    pub zero: f64,
    /// What a recorded command is multiplied by to be the goal of the joint, or its torque.
    pub command_scale: f64,
    /// Between which goals or torques the robot clips its commands; infinite where it does not.
    pub command_range: [f64; 2],
    pub stribeck: f64,
    pub stribeck_speed: f64,
    /// Stiffness of the spring between link and carrier.
    pub spring: f64,
    /// Torque of that spring at position 0: stiffness times position at rest.
    pub preload: f64,
    /// Twist between motor and link by torque.
    pub compliance: f64,
    /// Whole width of the gap between motor and link.
    pub gap: f64,
    /// Reciprocal of the greatest speed of the internal goal; 0 without a limit.
    pub inverse_speed: f64,
    pub command_delay_s: f64,
    /// Time constant of the lag behind its commands.
    pub command_lag_s: f64,
    /// How much above its command the motor goes.
    pub command_offset: f64,
    /// Delay of switching the motor on or off.
    pub release_delay_s: f64,
    /// Friction by the torque that the gear carries.
    pub load_friction: f64,
    /// Half the difference between the friction of both directions.
    pub directional: f64,
    /// Braking by the square of the speed.
    pub quadratic: f64,
    pub dead_band: f64,
    /// Resistance of the supply, Ohm.
    pub sag_ohm: f64,
    /// Braking by the speed while the motor is off.
    pub release_braking: f64,
}

/// What drives a joint during one step: the mean of its command, and the share of the step that the motor is on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Command {
    pub goal: f64,
    pub on: f64,
}

/// What a motor does in one step, with speeds taken at the middle of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motor {
    /// Torque besides what is proportional to the speed.
    pub torque: f64,
    /// What is proportional to the speed, braking counted positive.
    pub braking: f64,
    /// The part of [`braking`](Self::braking) that is no motor torque: bearings, or a released motor.
    pub passive: f64,
}

/// The range of commands that nothing clips.
pub(crate) const NO_RANGE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

impl JointNumbers {
    /// A joint without motor, friction and effects.
    pub const fn free(drive: Drive) -> Self {
        Self {
            drive,
            kp: 1.0,
            kd: 0.0,
            gain: 0.0,
            duty_max: 1.0,
            supply_v: 12.0,
            stall: 0.0,
            back_emf: 0.0,
            viscous: 0.0,
            coulomb: 0.0,
            armature: 0.0,
            zero: 0.0,
            command_scale: 1.0,
            command_range: NO_RANGE,
            stribeck: 0.0,
            stribeck_speed: 1.0,
            spring: 0.0,
            preload: 0.0,
            compliance: 0.0,
            gap: 0.0,
            inverse_speed: 0.0,
            command_delay_s: 0.0,
            command_lag_s: 0.0,
            command_offset: 0.0,
            release_delay_s: 0.0,
            load_friction: 0.0,
            directional: 0.0,
            quadratic: 0.0,
            dead_band: 0.0,
            sag_ohm: 0.0,
            release_braking: 0.0,
        }
    }

    /// The same driven to positions, without what few joints have and what takes time in every step.
    #[inline]
    pub(super) const fn plain(self) -> Self {
        Self { drive: Drive::Position, kd: 0.0, dead_band: 0.0, stribeck: 0.0, quadratic: 0.0, sag_ohm: 0.0, ..self }
    }

    /// The goal or the torque that a recorded command stands for.
    #[inline]
    pub fn commanded(&self, recorded: f64) -> f64 {
        let [least, greatest] = self.command_range;
        // No `clamp`: it would panic where the ends are not in order.
        (self.command_scale * recorded).max(least).min(greatest)
    }

    /// What the controller asks for at this measured position, before its speed counts: duty, torque or force.
    #[expect(clippy::inline_always, reason = "every step calls it, which slows rollouts down")]
    #[inline(always)]
    pub(super) fn demand(&self, goal: f64, position: f64) -> f64 {
        match self.drive {
            Drive::Position => {
                let error = goal + self.command_offset - position;
                let idle = if self.dead_band == 0.0 { 0.0 } else { error.clamp(-self.dead_band, self.dead_band) };
                self.gain * self.kp * (error - idle)
            }
            Drive::Velocity => self.gain * self.kp * goal,
            Drive::Torque => {
                let most = if self.stall > 0.0 { self.stall * self.duty_max } else { f64::INFINITY };
                goal.clamp(-most, most)
            }
            Drive::Voltage => self.gain * goal,
        }
    }

    /// Duty by speed.
    #[inline]
    pub(super) fn duty_by_speed(&self) -> f64 {
        if self.drive == Drive::Velocity { self.kd + self.gain * self.kp } else { self.kd }
    }

    /// The share of its torque that the motor keeps while the supply sags under this duty: a source of resistance `r` behind a
    /// converter, R/(R + r duty²), the motor's own resistance R being B·U²/A². Without back-EMF that resistance is not known, and nothing sags.
    #[inline]
    fn supplied(&self, duty: f64) -> f64 {
        if self.sag_ohm == 0.0 || self.back_emf == 0.0 {
            return 1.0;
        }
        let motor_ohm = self.back_emf * (self.supply_v / self.stall).powi(2);
        motor_ohm / (motor_ohm + self.sag_ohm * duty * duty)
    }

    /// The motor where `demand` is asked for and its duty is not limited.
    #[expect(clippy::inline_always, reason = "every step calls it, which slows rollouts down")]
    #[inline(always)]
    pub(super) fn unlimited(&self, command: Command, demand: f64, speed: f64) -> Motor {
        if self.drive.has_duty() {
            let by_speed = self.duty_by_speed();
            let share = command.on * self.supplied((demand - by_speed * speed).clamp(-self.duty_max, self.duty_max));
            self.motor(command, share * self.stall * demand, share * (self.back_emf + self.stall * by_speed), speed)
        } else {
            self.motor(command, command.on * demand, command.on * self.back_emf, speed)
        }
    }

    /// The motor at the greatest duty in the direction of `sign`.
    #[inline]
    pub(super) fn limited(&self, command: Command, sign: f64, speed: f64) -> Motor {
        let share = command.on * self.supplied(self.duty_max);
        self.motor(command, share * self.stall * self.duty_max * sign, share * self.back_emf, speed)
    }

    #[inline]
    fn motor(&self, command: Command, torque: f64, braking: f64, speed: f64) -> Motor {
        let passive = self.viscous + self.quadratic * speed.abs() + (1.0 - command.on) * self.release_braking;
        Motor { torque, braking: braking + passive, passive }
    }

    /// The greatest friction in the direction of positive speed and of negative speed, where the gear carries this torque and formulas add
    /// this much.
    #[inline]
    pub(super) fn friction(&self, speed: f64, carried: f64, added: f64) -> (f64, f64) {
        let mut level = self.coulomb + added;
        if self.stribeck != 0.0 {
            level += self.stribeck * (-(speed / self.stribeck_speed).powi(2)).exp();
        }
        let by_load = self.load_friction * carried.abs();
        (((level + self.directional) + by_load).max(0.0), ((level - self.directional) + by_load).max(0.0))
    }
}

/// What a parameter of a joint is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Number {
    StallTorque,
    BackEmf,
    Viscous,
    Coulomb,
    Armature,
    Zero,
}

impl Number {
    /// Every one, by its name in `[parameters.JOINT__NAME]`.
    pub const ALL: [(&'static str, Self); 6] = [
        ("stall_torque", Self::StallTorque),
        ("back_emf", Self::BackEmf),
        ("viscous", Self::Viscous),
        ("coulomb", Self::Coulomb),
        ("armature", Self::Armature),
        ("zero", Self::Zero),
    ];

    /// The parameter that it is of a joint.
    pub fn parameter_of(self, joint: &str) -> String {
        let name = Self::ALL.iter().find(|(_, number)| *number == self).map_or("", |(name, _)| name);
        format!("{joint}__{name}")
    }

    /// Its place in a joint.
    pub fn of(self, joint: &mut JointNumbers) -> &mut f64 {
        match self {
            Self::StallTorque => &mut joint.stall,
            Self::BackEmf => &mut joint.back_emf,
            Self::Viscous => &mut joint.viscous,
            Self::Coulomb => &mut joint.coulomb,
            Self::Armature => &mut joint.armature,
            Self::Zero => &mut joint.zero,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sagging_supply_is_a_divider_of_both_resistances() {
        // A = 6 N·m, B = 1.5 N·m·s/rad at 12 V: the motor has 1.5 · 4 = 6 Ohm; 2 Ohm of the supply leave 6/8 at full duty.
        let joint = JointNumbers { stall: 6.0, back_emf: 1.5, sag_ohm: 2.0, ..JointNumbers::free(Drive::Position) };
        assert_eq!(joint.limited(Command { goal: 0.0, on: 1.0 }, 1.0, 0.0).torque, 4.5);
        assert_eq!(joint.limited(Command { goal: 0.0, on: 0.0 }, 1.0, 0.0).torque, 0.0);
        let unknown = JointNumbers { back_emf: 0.0, ..joint };
        for duty in [0.0, 0.5, 1.0] {
            assert_eq!(unknown.limited(Command { goal: 0.0, on: 1.0 }, duty, 0.0).torque, 6.0 * duty);
        }
    }

    #[test]
    fn friction_differs_by_direction_and_grows_with_the_load() {
        let joint =
            JointNumbers { coulomb: 0.2, directional: 0.05, load_friction: 0.1, ..JointNumbers::free(Drive::Torque) };
        let (forward, backward) = joint.friction(0.0, -2.0, 0.0);
        assert!((forward - 0.45).abs() < 1e-15 && (backward - 0.35).abs() < 1e-15);
    }

    #[test]
    fn an_error_inside_the_dead_band_asks_for_nothing() {
        let joint = JointNumbers { gain: 0.5, kp: 4.0, dead_band: 0.01, ..JointNumbers::free(Drive::Position) };
        assert_eq!((joint.demand(0.009, 0.0), joint.demand(0.03, 0.0)), (0.0, 2.0 * (0.03 - 0.01)));
    }
}
