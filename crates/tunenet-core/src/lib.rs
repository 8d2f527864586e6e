//! The mathematics and the data of tunenet: what was seen, what could be, what has been learned, what fits.
//!
//! tunenet makes a simulator behave like a measured real thing. This crate holds everything that is the same for every
//! simulator; it knows no physics engine, no camera and no terminal. Five wings, each standing on the ones before it:
//!
//! | wing | question | start reading at |
//! |---|---|---|
//! | [`observation`] | what was seen? | [`observation::Observation`] |
//! | [`simulator`] | what could be? | [`simulator::Simulator`] |
//! | [`network`] | what has been learned? | the two-branch network |
//! | [`tune`] | what fits? | Algorithm 1 |

pub mod error;
pub mod network;
pub mod observation;
pub mod simulator;
pub mod tune;

pub use error::{Error, Result};
