//! Tuned numbers for other programs: a sidecar for what a model file cannot express, ranges for domain randomisation, BAM's
//! parameters, an actuator configuration for Isaac Lab.

mod bam;
mod isaac_lab;
mod ranges;
mod sidecar;

pub use bam::{Bam, BamServo, bam};
pub use isaac_lab::isaac_lab;
pub use ranges::ranges;
pub use sidecar::{Whole, WholeNumber, is_sidecar, sidecar};
