//! Blind sets: drops with something hidden in them, made by physics of their own.
//!
//! ```text
//! hidden → world → ball → camera → set
//! ```
//!
//! Nothing here is shared with the simulator that is fitted or with the effects that it is fitted with; what leaves this
//! module for the code under test are observations alone.

mod ball;
mod camera;
mod hidden;
mod set;
mod vector;
mod world;

pub use camera::Noise;
pub use hidden::EffectKind;
pub use set::{BlindSet, Recipe, Trouble, stream};
pub use world::RADIUS_M;

#[cfg(test)]
pub use ball::BlindThrow;
#[cfg(test)]
pub use camera::seen;
#[cfg(test)]
pub use hidden::HiddenEffect;
#[cfg(test)]
pub use world::BallWorld;
