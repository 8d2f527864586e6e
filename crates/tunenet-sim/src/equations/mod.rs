//! Simulators that stand in the simulation file itself: differential equations, events and outputs as formulas.
//!
//! ```text
//! scene → System (programs over one array of values) → Motion (derivatives, sides, supports) → Rollout (steps, switches, events)
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `system` | names, units and completeness of the equations |
//! | `body` | which states are positions, and coordinates of one body |
//! | `valid` | ranges in which candidates were seen to hold |
//! | `parts` | what they are made of |
//! | `lower` | `sign` and `delay` as names of their own |
//! | `runge_kutta` | adaptive steps of order 5 with dense output |
//! | `smoothness` | where right-hand sides bend, and what tolerance that needs |
//! | `signal` | inputs as pieces at whose ends steps end |
//! | `motion` | derivatives, also where something sticks or rests |
//! | `switching` | which side of a switching surface, or between both |
//! | `event` | impacts, and when they have come to rest |
//! | `crossing` | where within a step something crosses zero |
//! | `law` | terms of a law that is searched, evaluated natively |
//! | `rate` | how fast a formula changes along the motion |
//! | `rollout` | from the start to the last instant |
//! | `model` | as a simulator that core tunes and diagnoses |
//!
//! The integrator is our own. `diffsol` 0.18 (`tsit45`, the pendulum as compiled closures) follows a smooth swing of 216 samples in 38 µs,
//! as fast as these formulas (40 µs), and an input that jumps at each of these samples in 1,395 µs, where this takes 80 µs: it begins
//! anew after every jump. It has no motion that stays on a surface either.
//!
//! Instants before the first stamp of a recording, which a fit of a late clock asks for, have the state at that stamp.

pub(crate) mod body;
mod crossing;
mod event;
pub(crate) mod law;
mod lower;
mod model;
mod motion;
mod parts;
mod rate;
mod rollout;
mod runge_kutta;
mod signal;
mod smoothness;
mod switching;
mod system;
#[cfg(test)]
mod tests;
pub(crate) mod valid;

use std::ops::Range;

use tunenet_formula::FormulaError;

pub use model::EquationsModel;
pub use rollout::rollout;
pub use system::{Declared, System};

/// What is wrong with the equations of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Misfit {
    /// The key: `derivatives.rate_rad_s`.
    pub path: String,
    /// The place within the text of that key, in bytes, where it has one.
    pub place: Option<Range<usize>>,
    /// What could stand there.
    pub expected: String,
    /// What stands there.
    pub found: String,
}

impl Misfit {
    fn new(path: &str, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self { path: path.into(), place: None, expected: expected.into(), found: found.into() }
    }

    fn within(path: &str, error: FormulaError) -> Self {
        Self { path: path.into(), place: Some(error.place), expected: error.expected, found: error.found }
    }
}
