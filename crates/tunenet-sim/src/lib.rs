//! Simulated worlds on Rapier.

pub mod ball;
