//! Refinements by which recordings are explained as they are, tried in order: each takes the attempt before it, and returns a
//! better one or the same.

mod attempt;
mod by_name;
mod discrepancy_as_noise;
mod random_contacts;
mod required_effects_first;
mod segment_wise;
mod segments_alone;
mod sign_ambiguous;
mod unmeasured_axes;
mod whole_record;

pub(super) use attempt::{Attempt, Control, Scope};

use crate::Result;
use crate::diagnose::Progress;
use crate::diagnose::hypothesis::context::Context;

/// A way to explain recordings that those before it leave unexplained.
trait Refinement {
    /// Whether it is worth trying after `attempt`.
    fn applies(&self, attempt: &Attempt) -> bool;

    /// What it makes of the recordings; `attempt` itself where that is no better.
    ///
    /// # Errors
    /// Where the simulator refuses.
    fn attempt<'a>(&self, attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>>;
}

/// In the order in which they are tried.
const REFINEMENTS: [&dyn Refinement; 5] = [
    &segment_wise::SegmentWise,
    &whole_record::WholeRecord,
    &discrepancy_as_noise::DiscrepancyAsNoise,
    &required_effects_first::RequiredEffectsFirst,
    &random_contacts::RandomContacts,
];

/// Tunes the simulation as it is, then tries every refinement that applies.
pub(super) fn explain<'a>(context: &Context<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
    progress(Progress::Tuning);
    let mut attempt = Attempt::tuned(context)?;
    for refinement in REFINEMENTS {
        if refinement.applies(&attempt) {
            attempt = refinement.attempt(attempt, progress)?;
        }
    }
    Ok(attempt)
}
