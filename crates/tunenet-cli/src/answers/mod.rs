//! What the answers of commands say, before anything is rendered.

pub(crate) mod diagnose;
pub(crate) mod improved;
pub(crate) mod law;
pub(crate) mod motion;
pub(crate) mod plan;
pub mod tune;
