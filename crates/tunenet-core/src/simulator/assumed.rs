//! A constant that a simulator takes for granted although only its usual value is known, as the local gravity.

use super::Simulator;

/// A setting that stands at a usual value, and what it may really be.
pub struct Assumed {
    /// The setting's name in the simulation file: `world.gravity_m_s2`.
    pub setting: &'static str,
    /// What the simulator takes it to be.
    pub value: f64,
    /// Between which values it lies where nobody measured it.
    pub range: (f64, f64),
    /// Its unit: `m/s²`.
    pub unit: &'static str,
    /// The same simulator with the setting at the upper end of `range`.
    pub at_upper: Box<dyn Simulator>,
}
