//! Numbers that identification found, joint by joint.

use crate::Motion;

/// What a number is. SI units; of a sliding joint N for N·m and m for rad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Quantity {
    /// Viscous friction, N·m·s/rad.
    ViscousFriction,
    /// Coulomb friction, N·m.
    CoulombFriction,
    /// Inertia of the rotor as the joint feels it, kg·m².
    Armature,
    /// Spring of the joint, N·m/rad.
    Stiffness,
    /// Where that spring is at rest, rad.
    SpringReference,
    /// Gain of the position error, N·m/rad.
    PositionGain,
    /// Gain of the speed within the actuator, N·m·s/rad.
    VelocityGain,
    /// Greatest torque of the actuator in both directions, N·m.
    TorqueLimit,
    /// Transmission ratio, 1.
    Gear,
    /// How much later a command arrives, s.
    CommandDelay,
    /// Time constant of a first-order lag of the command, s.
    CommandLag,
    /// How much later a reading arrives, s.
    ReadingDelay,
    /// How much later the motor is released, s.
    ReleaseDelay,
    /// Greatest speed of the internal goal, rad/s.
    GoalSpeedLimit,
    /// Error of the position below which the motor does nothing, rad.
    DeadBand,
    /// How much above its command the motor goes, rad.
    CommandOffset,
    /// Width of the gap in the gear, rad.
    Backlash,
    /// Friction per torque in the gear, 1.
    LoadFriction,
    /// Additional friction near rest, N·m.
    StribeckFriction,
    /// Speed at which that has fallen to 1/e, rad/s.
    StribeckSpeed,
    /// How much larger Coulomb friction is at positive speed, and smaller at negative speed, N·m.
    DirectionalFriction,
    /// Friction that grows with the square of the speed, N·m·s²/rad².
    QuadraticFriction,
    /// Torsion of the gear under torque, rad/(N·m).
    Compliance,
    /// What the encoder reads too much, rad.
    ZeroOffset,
    /// Constant torque, N·m.
    TorqueBias,
    /// What a torque command is multiplied by, 1.
    TorqueFactor,
    /// Torque of the stalled motor at full duty, N·m.
    StallTorque,
    /// Braking by the motor's own voltage at full duty, N·m·s/rad.
    BackEmf,
    /// Resistance that lowers the supply under load, Ω.
    VoltageSag,
    /// Braking of the released motor, N·m·s/rad.
    ReleaseBraking,
    /// Period after which the servo renews its reading, s.
    PositionLatch,
    /// Mass at the centre of mass of what the joint moves, kg.
    ExtraLoad,
}

impl Quantity {
    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// Its unit; empty for a plain number.
    #[must_use]
    pub fn unit(self) -> &'static str {
        self.row().1
    }

    /// Whether it may be below 0.
    #[must_use]
    pub fn signed(self) -> bool {
        matches!(
            self,
            Self::SpringReference
                | Self::Gear
                | Self::DirectionalFriction
                | Self::ZeroOffset
                | Self::TorqueBias
                | Self::ExtraLoad
        )
    }

    fn row(self) -> (&'static str, &'static str) {
        match self {
            Self::ViscousFriction => ("viscous_friction", "N·m·s/rad"),
            Self::CoulombFriction => ("coulomb_friction", "N·m"),
            Self::Armature => ("armature", "kg·m²"),
            Self::Stiffness => ("joint_spring", "N·m/rad"),
            Self::SpringReference => ("spring_reference", "rad"),
            Self::PositionGain => ("position_gain", "N·m/rad"),
            Self::VelocityGain => ("velocity_gain", "N·m·s/rad"),
            Self::TorqueLimit => ("torque_limit", "N·m"),
            Self::Gear => ("gear", ""),
            Self::CommandDelay => ("command_delay", "s"),
            Self::CommandLag => ("command_lag", "s"),
            Self::ReadingDelay => ("time_delay", "s"),
            Self::ReleaseDelay => ("release_delay", "s"),
            Self::GoalSpeedLimit => ("speed_limit", "rad/s"),
            Self::CommandOffset => ("command_offset", "rad"),
            Self::DeadBand => ("dead_band", "rad"),
            Self::Backlash => ("backlash", "rad"),
            Self::LoadFriction => ("load_friction", ""),
            Self::StribeckFriction => ("stribeck_friction", "N·m"),
            Self::StribeckSpeed => ("stribeck_speed", "rad/s"),
            Self::DirectionalFriction => ("directional_friction", "N·m"),
            Self::QuadraticFriction => ("quadratic_friction", "N·m·s²/rad²"),
            Self::Compliance => ("joint_elasticity", "rad/(N·m)"),
            Self::ZeroOffset => ("encoder_offset", "rad"),
            Self::TorqueBias => ("torque_bias", "N·m"),
            Self::TorqueFactor => ("torque_gain", ""),
            Self::StallTorque => ("stall_torque", "N·m"),
            Self::BackEmf => ("back_emf", "N·m·s/rad"),
            Self::VoltageSag => ("voltage_sag", "Ω"),
            Self::ReleaseBraking => ("release_braking", "N·m·s/rad"),
            Self::PositionLatch => ("position_latch", "s"),
            Self::ExtraLoad => ("extra_load", "kg"),
        }
    }
}

/// A number that a model is to have.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Name of the joint in the model.
    pub joint: String,
    /// How that joint moves; what does not turn has units of a slide.
    pub motion: Motion,
    /// What the number is.
    pub quantity: Quantity,
    /// The number, in [`Self::unit`].
    pub value: f64,
    /// Its 95 % interval, in the same unit; `None` where it is not known.
    pub interval: Option<[f64; 2]>,
}

impl Change {
    /// The unit of the number: that of the quantity, of a slide in m and N.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match (self.motion, self.quantity.unit()) {
            (Motion::Prismatic, "rad") => "m",
            (Motion::Prismatic, "rad/s") => "m/s",
            (Motion::Prismatic, "N·m") => "N",
            (Motion::Prismatic, "N·m/rad") => "N/m",
            (Motion::Prismatic, "rad/(N·m)") => "m/N",
            (Motion::Prismatic, "N·m·s/rad") => "N·s/m",
            (Motion::Prismatic, "N·m·s²/rad²") => "N·s²/m²",
            (Motion::Prismatic, "kg·m²") => "kg",
            (_, unit) => unit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_a_slide_are_in_metres_and_newtons() {
        let unit =
            |motion, quantity| Change { joint: "lift".into(), motion, quantity, value: 0.1, interval: None }.unit();
        assert_eq!(unit(Motion::Prismatic, Quantity::VelocityGain), "N·s/m");
        assert_eq!(unit(Motion::Prismatic, Quantity::Armature), "kg");
        assert_eq!(unit(Motion::Prismatic, Quantity::CommandDelay), "s");
        assert_eq!(unit(Motion::Revolute, Quantity::VelocityGain), "N·m·s/rad");
    }
}
