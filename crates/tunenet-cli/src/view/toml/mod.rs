//! Parts of the simulation files that are written.

pub mod alternatives;
pub(crate) mod diagnose;
pub(crate) mod law;
pub mod provenance;
pub(crate) mod tune;
