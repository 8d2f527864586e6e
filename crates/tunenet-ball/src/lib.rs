//! What recordings of a bouncing ball show: where it flies, where it touches, where it lies, and whether the recording can be
//! used at all.
//!
//! [`segmentation`] cuts positions into flights and contacts; [`preflight`] checks a recording before anything is tuned to it.

pub mod findings;
pub mod preflight;
pub mod segmentation;

pub use segmentation::{Arcs, BallSegmentation, Contact, FirstFall, bounces};
