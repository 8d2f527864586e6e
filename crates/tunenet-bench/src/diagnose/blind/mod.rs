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
pub use hidden::Kind;
pub use set::{Recipe, Set, stream};
pub use world::RADIUS_M;

#[cfg(test)]
pub use ball::Throw;
#[cfg(test)]
pub use camera::seen;
#[cfg(test)]
pub use hidden::Hidden;
#[cfg(test)]
pub use world::World;
