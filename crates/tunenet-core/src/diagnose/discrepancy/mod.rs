//! Diagnosis of a thing whose recordings no simulation follows down to their noise: what is left is a discrepancy that is correlated
//! over long times, so that few values are independent, and held-out recordings decide what is added.
//!
//! | module | what |
//! |---|---|
//! | `scale` | the discrepancy as noise: its size, and how many values count |
//! | `coupling` | whether a rollout shows derivatives by parameters of several joints |
//! | `null` | the simulation without effects, from several starts |
//! | `score` | candidates by a score test with steps of visible size |
//! | `selection_step` | candidates fitted in addition to a hypothesis, and back-substitution |
//! | `wide_search` | candidates from starts across their bounds, where none is found from where they are absent |
//! | `selection` | forward selection with a gate of held-out recordings |
//! | `elimination` | effects that do next to nothing in addition to the others |
//! | `doubt` | what speaks against naming the effects alone |

mod coupling;
mod doubt;
mod elimination;
mod null;
mod scale;
mod score;
mod selection;
mod selection_step;
mod wide_search;

pub(in crate::diagnose) use coupling::with_groups;
pub(in crate::diagnose) use doubt::discrepancy_doubt;
pub(in crate::diagnose) use null::{better_null, fit_null, lower_null};
pub(in crate::diagnose) use scale::is_far_above_noise;
pub(in crate::diagnose) use selection::{Gated, search_gated};
