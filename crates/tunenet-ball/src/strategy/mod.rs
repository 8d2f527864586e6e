//! Strategies for recordings of a bouncing ball that are not explained as they are.
//!
//! | strategy | what it explains | what it leaves open |
//! |---|---|---|
//! | [`FlightsOnly`] | the flights between contacts, each with a start and a spin of its own | the contacts |
//! | [`ContactsOnly`] | the speed along the surface that contacts take, the flights de-trended | the flights |
//!
//! They are tried in this order, after the recordings as they are and without an odd one. Both need a simulator that is
//! [`Segmented`]: its free segments are flights, its events contacts, its hidden state
//! the spin.

mod contacts_only;
mod detrended_flights;
mod flights_only;

pub use contacts_only::ContactsOnly;
pub use flights_only::FlightsOnly;

use tunenet_core::Result;
use tunenet_core::diagnose::{
    Diagnosis, OddRecording, Problem, Progress, Recording, Settings, Strategy, Subject, diagnose_with,
};
use tunenet_core::simulator::{Segmented, Simulator};

use crate::shifted::shifted;
use crate::wording::WORDING;

/// In the order in which they are tried.
pub const STRATEGIES: [&dyn Strategy; 3] = [&OddRecording, &FlightsOnly, &ContactsOnly];

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
    let mut diagnosis = diagnose_with(&STRATEGIES, subjects, recordings, &settings, progress)?;
    let notes = shifted(&diagnosis);
    diagnosis.notes.extend(notes);
    Ok(diagnosis)
}

/// The simulators of all subjects as `of` changes them; `None` where one of them has no such variant.
fn variants(
    problem: &Problem,
    of: impl Fn(&dyn Segmented) -> Option<Box<dyn Simulator>>,
) -> Option<Vec<Box<dyn Simulator>>> {
    problem.subjects().iter().map(|subject| of(subject.simulator.segmented()?)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::diagnose::Verdict;
    use tunenet_core::testing::{Exact, Pendulum, Shuttle};

    /// Answers without and with the strategies of a ball.
    fn both(simulator: &dyn Simulator, seen: &[tunenet_core::observation::Observation]) -> [Diagnosis; 2] {
        let subjects = [Subject { name: "it".into(), simulator }];
        let one = |seen| Recording { name: "one".into(), object: 0, held_out: false, seen };
        let recordings: Vec<Recording> = seen.iter().map(one).collect();
        let settings = Settings::default();
        let plain = tunenet_core::diagnose::diagnose(&subjects, &recordings, &settings, &|_| {}).unwrap();
        [plain, diagnose(&subjects, &recordings, &settings, &|_| {}).unwrap()]
    }

    pub(super) const FRICTION: &str = "viscous_friction.rate_1_s";

    /// The answer of so many swings of a pendulum with these true values.
    pub(super) fn swings(truth: &[(&str, f64)], count: u32) -> Diagnosis {
        let pendulum = Exact::new(Pendulum);
        let start = |k: u32| [0.1 + 0.05 * f64::from(k), 0.3 * f64::from(k)];
        let seen: Vec<_> =
            (0..count).map(|k| pendulum.observe(truth, &start(k), 1e-3, u64::from(k)).unwrap()).collect();
        let [plain, _] = both(&pendulum, &seen);
        plain
    }

    #[test]
    fn what_has_no_hidden_state_gets_the_answer_of_its_recordings_as_they_are() {
        let shuttle = Exact::new(Shuttle::default());
        let seen = [[0.0, 1.5], [0.1, -2.0]]
            .map(|start| shuttle.observe(&[("kick.speed_m_s", 0.3), ("slip.step_m", 0.05)], &start, 1e-3, 1).unwrap());
        let [plain, ball] = both(&shuttle, &seen);
        assert_eq!((plain.verdict(), plain.names(), plain.rollouts), (ball.verdict(), ball.names(), ball.rollouts));
        assert!(variants_of(&shuttle).is_none());
    }

    #[test]
    fn a_pendulum_is_described_in_general_words() {
        let pendulum = Exact::new(Pendulum);
        let seen = [pendulum.observe(&[(FRICTION, 0.2)], &[0.2, 0.0], 1e-3, 1).unwrap()];
        let [plain, ball] = both(&pendulum, &seen);
        assert_eq!(plain.verdict(), Verdict::OneOf);
        assert_eq!(plain.next_experiment, ball.next_experiment);
        assert_eq!(plain.conclusion.doubt(), ball.conclusion.doubt());
    }

    fn variants_of(simulator: &dyn Simulator) -> Option<Box<dyn Simulator>> {
        simulator.segmented()?.with_hidden_state()
    }
}
