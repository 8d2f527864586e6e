//! Strategies by which recordings are explained, tried in order: each takes the attempt before it, and returns a better one
//! or the same.

mod attempt;
mod by_name;
pub(in crate::diagnose) mod contacts_only;
mod detrended_flights;
mod discrepancy_as_noise;
pub(in crate::diagnose) mod flights_only;
pub(in crate::diagnose) mod linear;
mod random_contacts;
mod required_effects_first;
mod segment_wise;
mod segments_alone;
mod whole_record;

pub(super) use attempt::{Attempt, Control, Scope};

use crate::Result;
use crate::diagnose::Progress;
use crate::diagnose::hypothesis::context::Context;

/// A way to explain recordings that those before it leave unexplained.
trait Strategy {
    /// Whether it is worth trying after `attempt`.
    fn applies(&self, attempt: &Attempt) -> bool;

    /// What it makes of the recordings; `attempt` itself where that is no better.
    ///
    /// # Errors
    /// Where the simulator refuses.
    fn attempt<'a>(&self, attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>>;
}

/// In the order in which they are tried.
const STRATEGIES: [&dyn Strategy; 5] = [
    &segment_wise::SegmentWise,
    &whole_record::WholeRecord,
    &discrepancy_as_noise::DiscrepancyAsNoise,
    &required_effects_first::RequiredEffectsFirst,
    &random_contacts::RandomContacts,
];

/// Tunes the simulation as it is, then tries every strategy that applies.
pub(super) fn explain<'a>(context: &Context<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
    progress(Progress::Tuning);
    let mut attempt = Attempt::tuned(context)?;
    for strategy in STRATEGIES {
        if strategy.applies(&attempt) {
            attempt = strategy.attempt(attempt, progress)?;
        }
    }
    Ok(attempt)
}
