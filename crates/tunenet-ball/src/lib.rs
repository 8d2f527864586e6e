//! What recordings of a bouncing ball show: where it flies, where it touches, where it lies, and whether the recording can be
//! used at all; and how such recordings are diagnosed.
//!
//! [`segmentation`] cuts positions into flights and contacts; [`preflight`] checks a recording before anything is tuned to it;
//! [`strategy`] explains flights and contacts apart where recordings as they are stay unexplained.

pub mod preflight;
pub mod segmentation;
pub mod strategy;
mod wording;

pub use segmentation::{Arcs, BallSegmentation, Contact, FirstFall, bounces};
pub use strategy::diagnose;
pub use wording::WORDING;
