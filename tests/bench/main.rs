//! `tunenet-bench` as a process.

mod blind;
mod diagnose;
mod paper;
#[path = "../regress/pinned.rs"]
mod pinned;
#[cfg(feature = "video")]
mod shot;
mod tuning;
