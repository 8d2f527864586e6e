//! Where a recording can be cut into segments between events.

use std::fmt::Debug;

use crate::observation::Observation;

/// What a simulator knows of the events of its recordings (impacts, steps): between them the motion is smooth, and each
/// segment can be explained alone.
pub trait Segmentation: Debug + Send + Sync {
    /// How many samples come before the rest in which `seen` ends; all of them where it does not end so. `noise` is the
    /// standard deviation of each channel.
    fn moving(&self, seen: &Observation, noise: &[f64]) -> usize;

    /// The instants of the events, on the clock of `seen`.
    fn events(&self, seen: &Observation) -> Vec<f64>;

    /// The acceleration of the last channel in a free segment of the base model, in its unit per s²: −9.81 m/s² of a height under
    /// gravity. `None` where that is not constant or not known.
    fn free_acceleration(&self) -> Option<f64> {
        None
    }
}
