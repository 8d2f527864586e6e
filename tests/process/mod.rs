//! Simulators that are programs of their own.

mod cartpole;
mod checkpoint;
mod driven;
pub mod failing;
mod failures;
mod program;
pub mod programs;
mod ray_script;
mod warnings;
