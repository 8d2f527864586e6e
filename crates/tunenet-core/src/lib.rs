//! Observations, simulators, networks, estimation and diagnosis: the part of the tool that is the same for every simulator.
//!
//! It knows no physics engine, no video and no terminal. Seven modules, each importing only those above it:
//!
//! | module | question | start reading at |
//! |---|---|---|
//! | [`observation`] | what was measured? | [`observation::Observation`] |
//! | [`simulator`] | which simulator, with which parameters? | [`simulator::Simulator`] |
//! | [`network`] | which parameter error do residuals show? | the two-branch network |
//! | [`estimate`] | which values fit best, and how surely? | [`estimate::Problem`] |
//! | [`tune`] | what fits? | Algorithm 1 |
//! | [`diagnose`] | what is missing? | [`diagnose::diagnose`] |
//! | [`law`] | which formula is missing, where no known effect is? | [`law::search`] |
//!
//! # A simulator of your own
//!
//! 1. Implement [`Simulator`](simulator::Simulator): its parameters with bounds and units, its channels, and a
//!    [`rollout`](simulator::Simulator::rollout) that writes a prediction for every instant of a clock.
//! 2. Put what was measured into an [`Observation`](observation::Observation).
//! 3. Call [`tune::tune`]; it returns each parameter with its interval, and a verdict.
//!
//! This is `examples/pendulum.rs`, all of it; it prints `length = 0.6200 m` and `damping = 0.2400 1/s`:
//!
//! ```
#![doc = include_str!("../examples/pendulum.rs")]
//! ```

pub mod camera;
pub mod diagnose;
pub mod error;
pub mod estimate;
pub mod finding;
pub mod findings;
pub mod law;
pub mod network;
pub mod observation;
pub mod simulator;
pub mod statistics;
pub mod testing;
pub mod text;
pub mod tune;

pub use error::{Action, Error, Origin, Result};
