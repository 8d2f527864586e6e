//! Arms: any serial or branched chain of rigid bodies on a fixed base, read from a URDF or an MJCF.
//!
//! | module | what |
//! |---|---|
//! | [`urdf`] | from a URDF to a [`Model`], refusing what no arm can be |
//! | [`model_file`] | the same from an MJCF, or whichever of both a file is |
//! | [`Model`] | the bodies, their joints and frames |
//! | [`Recursion`] | inverse dynamics by Newton and Euler, and what a payload adds to the torques |
//! | [`Kinematics`] | where everything is, and how it moves with the joints |
//! | [`reach`] | inverse kinematics |
//! | [`effects`] | what torques hold beyond those of rigid bodies |
//! | [`Motion`] | the circle of the tool as smooth joint positions |
//! | [`Multibody`] | the arm as Rapier simulates it, driven by torques |
//! | [`ComputedTorque`] | the controller, with its own model of the arm |
//!
//! Everything is in f64 and SI units; world axes, z up, the base at the origin. A vector of joint positions `q` has one
//! number for each joint that mimics none, in the order of the file ([`Model::joints`]).

mod chebyshev;
mod controller;
mod dynamics;
pub mod effects;
mod inertia;
mod kinematics;
mod mass_matrix;
mod model;
pub mod model_file;
mod motion;
mod multibody;
mod payload;
pub mod reach;
pub mod urdf;

pub use controller::ComputedTorque;
pub use dynamics::Recursion;
pub use kinematics::Kinematics;
pub(crate) use mass_matrix::CompositeBodies;
pub use model::{Body, Coordinate, Frame, Joint, JointKind, Limits, Model};
pub use motion::{Circle, Motion};
pub use multibody::Multibody;
pub use payload::{PAYLOAD_NUMBERS, payload_numbers};
pub use tunenet_models::Inertia;

/// A place and an orientation: from the coordinates of one frame to those of another.
pub type Pose = nalgebra::IsometryMatrix3<f64>;

/// Gravity as an acceleration in world axes, m/s², from its size.
#[must_use]
pub fn gravity(m_s2: f64) -> nalgebra::Vector3<f64> {
    nalgebra::Vector3::new(0.0, 0.0, -m_s2)
}
