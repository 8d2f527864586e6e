//! Films are followed, tuned to and diagnosed.

pub mod film;
mod films;
mod track;
