//! Everything that effects may change of a robot: what every arm may have, and what drives may have.

use crate::arm::effects::Imperfections;

/// What the drive of one joint has beyond its simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DriveEffects {
    pub inverse_speed_s_rad: f64,
    pub command_delay_s: f64,
    /// Time constant.
    pub command_lag_s: f64,
    pub command_offset_rad: f64,
    pub release_delay_s: f64,
    pub load_friction: f64,
    pub directional_nm: f64,
    pub quadratic_nms2_rad2: f64,
    pub dead_band_rad: f64,
    pub gap_rad: f64,
    /// Factor of the greatest duty.
    pub duty_fraction: f64,
    /// Factor of the gain.
    pub gain_factor: f64,
    /// Added to the damping of the firmware.
    pub kd: f64,
    pub sag_ohm: f64,
    pub release_braking_nms_rad: f64,
}

impl DriveEffects {
    /// A drive that is as its simulation says.
    pub const NONE: Self = Self {
        inverse_speed_s_rad: 0.0,
        command_delay_s: 0.0,
        command_lag_s: 0.0,
        command_offset_rad: 0.0,
        release_delay_s: 0.0,
        load_friction: 0.0,
        directional_nm: 0.0,
        quadratic_nms2_rad2: 0.0,
        dead_band_rad: 0.0,
        gap_rad: 0.0,
        duty_fraction: 1.0,
        gain_factor: 1.0,
        kd: 0.0,
        sag_ohm: 0.0,
        release_braking_nms_rad: 0.0,
    };
}

/// What a robot has beyond its simulation.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Imperfect {
    pub arm: Imperfections,
    /// One for each joint.
    pub drives: Vec<DriveEffects>,
    /// How much farther than stated loads are from the origin of their link, m.
    pub load_offset_m: f64,
    /// A mass at the centre of mass of the last link that no file states.
    pub extra_load_kg: f64,
    /// How late positions are read, s.
    pub reading_delay_s: f64,
    /// Period of the clock that latches readings, s.
    pub latch_s: f64,
}

impl Imperfect {
    /// Nothing.
    pub fn none(joints: usize) -> Self {
        Self {
            arm: Imperfections::none(joints),
            drives: vec![DriveEffects::NONE; joints],
            load_offset_m: 0.0,
            extra_load_kg: 0.0,
            reading_delay_s: 0.0,
            latch_s: 0.0,
        }
    }
}
