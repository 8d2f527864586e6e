//! Arms: logs that are replayed, payloads that are weighed, faults that are named.

mod faults;
pub mod pendulum;
mod replay;
mod scenes;
mod weighing;
