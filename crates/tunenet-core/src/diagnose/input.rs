//! What a diagnosis starts from.

use super::hypothesis::wording::{GENERAL, Wording};
use crate::observation::{Note, Observation};
use crate::simulator::Simulator;
use crate::{Error, Origin, Result};

/// One object: what all its recordings share.
pub struct Subject<'a> {
    /// A name for people.
    pub name: String,
    /// Its simulator, with the parameters that may be tuned.
    pub simulator: &'a dyn Simulator,
}

/// One recording.
pub struct Recording<'a> {
    /// A name for people, usually the file's.
    pub name: String,
    /// The position of its object among the subjects.
    pub object: usize,
    /// Whether it is only to judge by, not to fit to.
    pub held_out: bool,
    /// What was seen.
    pub seen: &'a Observation,
}

/// How to diagnose.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Decides which recordings are set aside where none is given.
    pub seed: u64,
    /// Greatest probability of an effect by chance, all candidates together.
    pub significance: f64,
    /// How much the information criterion has to gain for an effect, and how far apart two explanations have to lie to be
    /// distinguished: 6 is odds of twenty to one.
    pub margin: f64,
    /// Most effects added.
    pub most_effects: usize,
    /// Whether recordings may be set aside to judge by where none is given.
    pub set_aside: bool,
    /// Most rollouts; a search that takes more has no answer.
    pub max_rollouts: Option<usize>,
    /// Whether the first explanation is the answer, without further refinements, strategies and a next experiment.
    pub quick: bool,
    /// What texts say of things whose motion may have segments between events.
    pub wording: &'static Wording,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 0,
            significance: 0.002,
            margin: 6.0,
            most_effects: 3,
            set_aside: true,
            max_rollouts: None,
            quick: false,
            wording: &GENERAL,
        }
    }
}

impl Settings {
    pub(super) fn check(&self) -> Result<()> {
        let refuse = |name, expected: &str, found: f64| {
            Err(Error::Setting { origin: Origin::Caller, name, expected: expected.into(), found: found.to_string() })
        };
        if !(self.significance > 0.0 && self.significance < 1.0) {
            return refuse("significance", "more than 0 and less than 1", self.significance);
        }
        if !(self.margin > 0.0 && self.margin.is_finite()) {
            return refuse("margin", "more than 0", self.margin);
        }
        Ok(())
    }
}

/// What a diagnosis is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress<'a> {
    /// A recording is not used.
    NotUsed {
        /// Its name.
        name: &'a str,
        /// Why.
        why: &'a Note,
    },
    /// Something was noticed before the search.
    Noticed(&'a Note),
    /// Tuning the simulation as it is.
    Tuning,
    /// Scoring this many candidates in addition to as many effects as are already in.
    Scoring {
        /// Candidates.
        candidates: usize,
        /// Effects already in.
        effects: usize,
        /// Rollouts so far.
        rollouts: usize,
        /// What is left with these effects, in multiples of the noise that the search uses.
        left: f64,
    },
    /// Fitting one candidate jointly.
    Fitting(&'a str),
    /// Judging what is left, and held-out recordings.
    Judging,
}
