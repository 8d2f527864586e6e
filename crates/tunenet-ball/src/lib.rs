//! What recordings of a bouncing ball show: where it flies, where it touches, where it lies, and whether the recording can be
//! used at all; and how such recordings are diagnosed.
//!
//! [`segmentation`] cuts positions into flights and contacts; [`preflight`] checks a recording before anything is tuned to it;
//! [`strategy`] explains flights and contacts separately where whole recordings are not explained.

use tunenet_core::Result;
use tunenet_core::observation::{Channel, Observation};

pub mod findings;
pub mod preflight;
pub mod releases;
pub mod segmentation;
mod shifted;
pub mod strategy;
mod wording;

pub use segmentation::{Arcs, BallSegmentation, Contact, FirstFall, bounces};
pub use strategy::diagnose;
pub use wording::WORDING;

/// Name of the channel of a ball's impact times.
const BOUNCE_TIME: &str = "bounce_time";

/// The channels of a ball's impact times: one, in s.
#[must_use]
pub fn bounce_time_channels() -> Vec<Channel> {
    vec![Channel::new(BOUNCE_TIME, "s")]
}

/// Impact times of a ball, s, numbered from 0.
///
/// # Errors
/// As [`Observation::new`].
pub fn bounce_times(time_s: Vec<f64>) -> Result<Observation> {
    Observation::event_times(BOUNCE_TIME, time_s)
}
