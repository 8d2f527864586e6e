//! Observations, simulators, networks, estimation and diagnosis: the part of the tool that is the same for every simulator.
//!
//! It knows no physics engine, no video and no terminal. All its modules are public. Eight of them answer a question each, and
//! each imports only those above it:
//!
//! | module | question | start reading at |
//! |---|---|---|
//! | [`observation`] | what was measured? | [`observation::Observation`] |
//! | [`simulator`] | which simulator, with which parameters? | [`simulator::Simulator`] |
//! | [`camera`] | where does a camera see a point? | [`camera::Pinhole`] |
//! | [`network`] | which parameter error do residuals show? | [`network::Model`] |
//! | [`estimate`] | which values fit best, and how uncertain are they? | [`estimate::Problem`] |
//! | [`tune`] | which parameters fit? | [`tune::tune`] |
//! | [`diagnose`] | which effect is missing? | [`diagnose::diagnose`] |
//! | [`law`] | which formula is missing, where no known effect explains? | [`law::search`] |
//!
//! Every module may use four small ones: [`error`] (which names two types of [`network`]), [`finding`], [`findings`] and
//! [`statistics`]. [`testing`] has simulators in closed form, made of [`observation`], [`simulator`] and [`network`], and
//! [`text`] makes text of untrusted files safe to print; apart from unit tests no other module imports either.
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
