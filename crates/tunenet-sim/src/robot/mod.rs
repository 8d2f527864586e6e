//! Robot joints from commands: motors with a firmware, gears and loads, rolled out forward.
//!
//! ```text
//! recorded command → delay, speed limit (wiring) → firmware and motor (numbers) → friction, weight, inertia → positions → readings
//! ```
//!
//! | module | what |
//! |---|---|
//! | `signal` | a sampled command: its exact mean over a step |
//! | `piece`, `rate_limiter` | straight pieces of a command, and a command that may change by no more than a rate |
//! | `wiring` | how a command reaches the motor |
//! | `numbers` | a joint with its motor: duty, torque, friction |
//! | `near_sine` | the sine of an angle that moves little from step to step |
//! | `friction_cone` | a step of a mass with dry friction, exact where it sticks |
//! | `one_joint`, `two_masses`, `chain` | the integration of one joint, of one with a gap or a compliant gear, of several |
//! | `trajectory` | a rollout on its grid, and how it is read |
//! | `acting` | effects of the catalogue, and formulas of a user |
//! | `layout` | what parameters, channels and inputs mean |
//! | `limits` | positions and commands against the limits of the model: another unit, stops, clipped commands |
//! | `rig` | the chain with its loads |
//! | `observable_scale` | which joints show how large their torques are |
//! | `observable_zero` | which joints show where their zero is |
//! | `stated_gravity` | the gravity of an MJCF |
//! | `stated_motor` | what an MJCF says of the motors of its joints, and a URDF of their commands |
//! | `start` | where the joints of a recording start |
//! | `examine` | what is wrong with a recording |
//! | [`effects`] | what a driven joint may have beyond its simulation |
//! | [`RobotModel`] | all of it as rollouts |
//!
//! A joint between the stops of its model moves freely; stops are not simulated.

mod acting;
mod chain;
pub mod effects;
mod examine;
mod friction_cone;
pub(crate) mod imperfect;
pub(crate) mod layout;
mod limits;
mod model;
mod near_sine;
pub(crate) mod numbers;
mod observable_scale;
mod observable_zero;
mod one_joint;
mod piece;
mod rate_limiter;
pub(crate) mod rig;
mod signal;
mod start;
mod stated_gravity;
mod stated_motor;
mod step_error;
pub(crate) mod trajectory;
mod two_masses;
mod wiring;

#[cfg(test)]
mod tests;

pub(crate) use acting::Acting;
pub use examine::rare_samples;
pub use model::RobotModel;
pub(crate) use model::driven_joints;
pub use numbers::Drive;
pub use observable_scale::observable_scales;
pub use observable_zero::observable_zeros;
pub use stated_gravity::{StatedGravity, stated_gravity};
pub(crate) use stated_motor::motor_law;
pub use stated_motor::{StatedDrive, StatedMotor, scaled_commands, stated_drives, stated_motors};
