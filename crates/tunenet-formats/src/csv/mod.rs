//! Text tables.

pub(crate) mod bounces;
pub(crate) mod columns;
pub(crate) mod dates;
pub(crate) mod guess;
pub(crate) mod guess_joints;
pub(crate) mod lines;
pub(crate) mod numbers;
pub(crate) mod own_columns;
pub(crate) mod scan;
pub(crate) mod series;
pub(crate) mod write;
