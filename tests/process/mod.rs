//! Simulators that are programs of their own.

mod cartpole;
mod checkpoint;
pub mod driven;
pub mod failing;
mod failures;
mod input_files;
mod program;
pub mod programs;
mod ray_script;
mod warnings;
