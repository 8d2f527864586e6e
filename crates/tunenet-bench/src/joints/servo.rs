//! What is true of one joint: its motor, what is hidden in it, and what drives and loads it in one run.

use serde::Serialize;

/// The numbers that are tuned, in the order of [`Motor::NAMES`].
pub const NUMBERS: usize = 6;

/// A motor with its gear; the numbers of a small servo are its centre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Motor {
    /// Torque at full duty and rest, N·m.
    pub stall: f64,
    /// N·m·s/rad, while it is on.
    pub back_emf: f64,
    /// N·m·s/rad.
    pub viscous: f64,
    /// N·m.
    pub coulomb: f64,
    /// kg·m².
    pub armature: f64,
    /// True less measured position, rad.
    pub zero: f64,
}

impl Motor {
    /// Around which motors are drawn.
    pub const CENTRE: Self =
        Self { stall: 6.0, back_emf: 1.2, viscous: 0.02, coulomb: 0.12, armature: 0.022, zero: 0.0 };
    /// As a simulation file names them, with bounds and unit.
    pub const NAMES: [(&'static str, f64, f64, &'static str); NUMBERS] = [
        ("stall_torque", 0.5, 20.0, "N·m"),
        ("back_emf", 0.0, 5.0, "N·m·s/rad"),
        ("viscous", 0.0, 1.0, "N·m·s/rad"),
        ("coulomb", 0.0, 1.0, "N·m"),
        ("armature", 0.001, 0.1, "kg·m²"),
        ("zero", -0.3, 0.3, "rad"),
    ];

    pub fn numbers(&self) -> [f64; NUMBERS] {
        [self.stall, self.back_emf, self.viscous, self.coulomb, self.armature, self.zero]
    }

    pub fn of([stall, back_emf, viscous, coulomb, armature, zero]: [f64; NUMBERS]) -> Self {
        Self { stall, back_emf, viscous, coulomb, armature, zero }
    }

    /// The nearest numbers within the bounds of the file.
    pub fn limited(numbers: [f64; NUMBERS]) -> [f64; NUMBERS] {
        std::array::from_fn(|i| numbers[i].clamp(Self::NAMES[i].1, Self::NAMES[i].2))
    }
}

/// Duty by gain and error, 1/rad, and the voltage of the supply: both are stated in the file.
pub const GAIN_1_RAD: f64 = 0.166;
pub const SUPPLY_V: f64 = 12.0;
pub const GRAVITY_M_S2: f64 = 9.81;

/// Everything that may be hidden in one joint, each absent at 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Secrets {
    pub inverse_speed_s_rad: f64,
    pub command_delay_s: f64,
    /// Time constant.
    pub command_lag_s: f64,
    pub reading_delay_s: f64,
    pub release_delay_s: f64,
    /// Friction by the torque that the gear carries.
    pub load_friction: f64,
    pub directional_nm: f64,
    pub quadratic_nms2_rad2: f64,
    pub stribeck_nm: f64,
    pub stribeck_rad_s: f64,
    pub goal_offset_rad: f64,
    pub dead_band_rad: f64,
    pub gap_rad: f64,
    pub compliance_rad_nm: f64,
    /// The share of the duty that is missing.
    pub duty_less: f64,
    /// Natural logarithm of the factor of the gain.
    pub log_gain: f64,
    pub kd_s_rad: f64,
    pub sag_ohm: f64,
    pub release_braking_nms_rad: f64,
    pub load_offset_m: f64,
    /// A mass next to the load that the file does not state.
    pub extra_kg: f64,
    pub latch_s: f64,
    pub spring_nm_rad: f64,
    /// Of the load, sideways and along the link, m.
    pub com_m: [f64; 2],
}

impl Secrets {
    pub const NONE: Self = Self {
        inverse_speed_s_rad: 0.0,
        command_delay_s: 0.0,
        command_lag_s: 0.0,
        reading_delay_s: 0.0,
        release_delay_s: 0.0,
        load_friction: 0.0,
        directional_nm: 0.0,
        quadratic_nms2_rad2: 0.0,
        stribeck_nm: 0.0,
        stribeck_rad_s: 0.1,
        goal_offset_rad: 0.0,
        dead_band_rad: 0.0,
        gap_rad: 0.0,
        compliance_rad_nm: 0.0,
        duty_less: 0.0,
        log_gain: 0.0,
        kd_s_rad: 0.0,
        sag_ohm: 0.0,
        release_braking_nms_rad: 0.0,
        load_offset_m: 0.0,
        extra_kg: 0.0,
        latch_s: 0.0,
        spring_nm_rad: 0.0,
        com_m: [0.0; 2],
    };
}

/// What an effect is drawn with next to its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    pub sign: f64,
    /// From 0 to 1: where a width or a direction lies in its range.
    pub share: f64,
}

/// An effect of the catalogue that a single joint can show.
#[derive(Debug, Clone, Copy)]
pub struct Secret {
    /// As the tool calls it.
    pub name: &'static str,
    /// The greatest size that is physical.
    pub greatest: f64,
    /// Sets it to a size.
    pub act: fn(&mut Secrets, f64, Shape),
}

const fn secret(name: &'static str, greatest: f64, act: fn(&mut Secrets, f64, Shape)) -> Secret {
    Secret { name, greatest, act }
}

/// Every effect of the catalogue that one joint shows and that its parameters do not hold already.
pub const SECRETS: [Secret; 23] = [
    secret("speed_limit", 1.0, |s, size, _| s.inverse_speed_s_rad = size),
    secret("command_delay", 0.15, |s, size, _| s.command_delay_s = size),
    secret("command_lag", 0.15, |s, size, _| s.command_lag_s = size),
    secret("time_delay", 0.15, |s, size, _| s.reading_delay_s = size),
    secret("release_delay", 0.15, |s, size, _| s.release_delay_s = size),
    secret("load_friction", 0.5, |s, size, _| s.load_friction = size),
    secret("directional_friction", 0.1, |s, size, shape| s.directional_nm = shape.sign * size),
    secret("quadratic_friction", 2.0, |s, size, _| s.quadratic_nms2_rad2 = size),
    secret("stribeck_friction", 0.5, |s, size, shape| {
        (s.stribeck_nm, s.stribeck_rad_s) = (size, 0.05 * 10_f64.powf(shape.share));
    }),
    secret("command_offset", 0.3, |s, size, shape| s.goal_offset_rad = shape.sign * size),
    secret("dead_band", 0.1, |s, size, _| s.dead_band_rad = size),
    secret("backlash", 0.15, |s, size, _| s.gap_rad = size),
    secret("joint_elasticity", 0.09, |s, size, _| s.compliance_rad_nm = size),
    secret("duty_limit", 0.85, |s, size, _| s.duty_less = size),
    secret("firmware_gain", 1.4, |s, size, shape| s.log_gain = shape.sign * size),
    secret("firmware_damping", 0.5, |s, size, _| s.kd_s_rad = size),
    secret("voltage_sag", 10.0, |s, size, _| s.sag_ohm = size),
    secret("release_braking", 1.0, |s, size, _| s.release_braking_nms_rad = size),
    secret("load_offset", 0.045, |s, size, shape| s.load_offset_m = shape.sign * size),
    secret("extra_load", 1.0, |s, size, _| s.extra_kg = size),
    secret("position_latch", 0.045, |s, size, _| s.latch_s = size),
    secret("joint_spring", 3.0, |s, size, shape| s.spring_nm_rad = shape.sign * size),
    secret("payload_com_offset", 0.045, |s, size, shape| {
        let direction = std::f64::consts::TAU * shape.share;
        s.com_m = [size * direction.cos(), size * direction.sin()];
    }),
];

/// Names that no recording of a joint from rest distinguishes, as this bench knows them: of the gain only one side, `true` where it is
/// larger than stated.
pub fn are_twins(one: &str, other: &str, gain_above: bool) -> bool {
    match (one, other) {
        ("command_delay", "time_delay") | ("time_delay", "command_delay") | ("duty_limit", "firmware_gain") => true,
        ("firmware_gain", "duty_limit") => gain_above,
        _ => one == other,
    }
}

/// One run: gain, load, and what was commanded.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    pub kp: f64,
    pub mass_kg: f64,
    pub length_m: f64,
    pub clock: Vec<f64>,
    pub goal: Vec<f64>,
    /// The sample from which on the motor is off.
    pub off_from: Option<usize>,
    /// Where the clock that latches readings stands at 0 s, as a share of its period.
    pub latch_phase: f64,
}

impl Run {
    /// The goal on straight lines between its samples.
    pub fn goal_at(&self, time_s: f64, near: &mut usize) -> f64 {
        let last = self.clock.len() - 1;
        while *near < last && self.clock[*near + 1] <= time_s {
            *near += 1;
        }
        let at = *near;
        if at == last || time_s <= self.clock[0] {
            return self.goal[if time_s <= self.clock[0] { 0 } else { last }];
        }
        let share = (time_s - self.clock[at]) / (self.clock[at + 1] - self.clock[at]);
        self.goal[at] + share * (self.goal[at + 1] - self.goal[at])
    }

    /// Until when the motor is on, s.
    pub fn off_s(&self) -> f64 {
        self.off_from.map_or(f64::INFINITY, |at| self.clock[at])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_secret_changes_something_and_nothing_at_size_0() {
        for one in &SECRETS {
            let with = |size: f64| {
                let mut secrets = Secrets::NONE;
                (one.act)(&mut secrets, size, Shape { sign: 1.0, share: 0.37 });
                secrets
            };
            assert_ne!(with(one.greatest), Secrets::NONE, "{}", one.name);
            let Secrets { stribeck_rad_s, .. } = Secrets::NONE;
            assert_eq!(Secrets { stribeck_rad_s, ..with(0.0) }, Secrets::NONE, "{}", one.name);
        }
    }

    #[test]
    fn a_gain_is_a_twin_of_the_duty_on_one_side_only() {
        assert!(are_twins("firmware_gain", "duty_limit", true) && !are_twins("firmware_gain", "duty_limit", false));
        assert!(are_twins("duty_limit", "firmware_gain", false) && !are_twins("duty_limit", "dead_band", true));
    }

    #[test]
    fn a_goal_is_a_line_between_samples_and_held_outside() {
        let run = Run {
            kp: 1.0,
            mass_kg: 1.0,
            length_m: 1.0,
            clock: vec![0.0, 1.0, 3.0],
            goal: vec![1.0, 2.0, 6.0],
            off_from: Some(2),
            latch_phase: 0.0,
        };
        let mut near = 0;
        let found = [-1.0, 0.5, 1.0, 2.0, 9.0].map(|t| run.goal_at(t, &mut near));
        assert_eq!((found, run.off_s()), ([1.0, 1.5, 2.0, 4.0, 6.0], 3.0));
    }
}
