//! Strategies for recordings of a bouncing ball that are not explained as they are.
//!
//! | strategy | what it explains | what it leaves open |
//! |---|---|---|
//! | [`FlightsOnly`] | the flights between contacts, each with a start and a spin of its own | the contacts |
//! | [`ContactsOnly`] | the speed along the surface that contacts take, the flights de-trended | the flights |
//!
//! They are tried in this order, after the recordings as they are. Both need a simulator that is
//! [`Segmented`](tunenet_core::simulator::Segmented): its free segments are flights, its events contacts, its hidden state
//! the spin.

mod contacts_only;
mod detrended_flights;
mod flights_only;

pub use contacts_only::ContactsOnly;
pub use flights_only::FlightsOnly;

use tunenet_core::Result;
use tunenet_core::diagnose::{Diagnosis, Problem, Progress, Recording, Settings, Strategy, Subject, diagnose_with};
use tunenet_core::simulator::{Segmented, Simulator};

use crate::wording::WORDING;

/// In the order in which they are tried.
pub const STRATEGIES: [&dyn Strategy; 2] = [&FlightsOnly, &ContactsOnly];

/// As [`tunenet_core::diagnose::diagnose`], with [`STRATEGIES`] for recordings of a bouncing ball, and its [`WORDING`] instead of that
/// of `settings`. Recordings of anything without flights and contacts get the same answer as there.
///
/// # Errors
/// As [`tunenet_core::diagnose::diagnose`].
pub fn diagnose(
    subjects: &[Subject],
    recordings: &[Recording],
    settings: &Settings,
    progress: &dyn Fn(Progress),
) -> Result<Diagnosis> {
    let settings = Settings { wording: &WORDING, ..settings.clone() };
    diagnose_with(&STRATEGIES, subjects, recordings, &settings, progress)
}

/// The simulators of all subjects as `of` changes them; `None` where one of them has no such variant.
fn variants(
    problem: &Problem,
    of: impl Fn(&dyn Segmented) -> Option<Box<dyn Simulator>>,
) -> Option<Vec<Box<dyn Simulator>>> {
    problem.subjects().iter().map(|subject| of(subject.simulator.segmented()?)).collect()
}
