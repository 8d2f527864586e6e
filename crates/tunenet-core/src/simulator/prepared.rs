//! A recording made ready for one simulator.

use std::iter::repeat_n;
use std::sync::Arc;

use serde::Serialize;

use super::{Parameter, Scale, Segmentation};
use crate::observation::{Check, Circumstances, Kind, LocalEstimate, Note, Observation};

/// The usable part of a recording, with its nuisance parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Prepared {
    /// The samples to explain.
    pub seen: Observation,
    /// What its simulator is given with every rollout: what drove the thing, where it started.
    #[serde(skip)]
    pub circumstances: Option<Arc<Circumstances>>,
    /// Whether every prediction follows from the inputs near that instant alone, as torques follow from a motion: there is no
    /// initial state, and no error that adds up.
    pub memoryless: bool,
    /// Whether real recordings of such a thing never follow its simulation down to their noise, and what is left is a discrepancy of
    /// the simulation that is correlated over long times: [`diagnose`](crate::diagnose::diagnose) then counts few independent values.
    pub discrepancy: bool,
    /// The noise of each channel of `seen`, in its unit, where it is known better than from `seen` itself.
    pub noise: Option<Vec<f64>>,
    /// Scale estimate of each channel's residual, where it exceeds the noise: residuals are divided by it.
    pub residual_scale: Option<Vec<f64>>,
    /// What another step of the integration changes in each channel, root mean square, where that is known: effects that do less are not
    /// named alone.
    pub step_error: Option<Vec<f64>>,
    /// Nuisance parameters of this recording (its initial state, the height of a surface), each with a first guess as `value`.
    pub nuisances: Vec<Parameter>,
    /// Where the estimate of each nuisance parameter begins, in their order, where that is better known than by its first guess, which is
    /// the mean of its prior; of one that is missing here, at that guess.
    pub begin: Vec<Option<f64>>,
    /// Standard deviations of the priors of the nuisance parameters around their first guesses, in their order; of one that is
    /// missing here the prior is as wide as its bounds.
    pub prior_sd: Vec<f64>,
    /// Initial states that are known and not estimated, each with its position in [`Circumstances::start`] and its name, where the simulator
    /// cannot say whether it knows a state of that name.
    #[serde(skip)]
    pub known_states: Vec<(usize, String)>,
    /// For each parameter of the simulator: what the samples near the events say of it, independent of what happens in
    /// between. It starts the fit, and stands in for it where the record as a whole cannot be explained.
    pub local: Vec<Option<LocalEstimate>>,
    /// For each parameter of the simulator: why this recording says nothing about it, where that is known beforehand.
    pub silent: Vec<Option<Note>>,
    /// The picture that `seen` was read back from, sample for sample, channels `u` and `v` in px; where there was one.
    pub video: Option<Observation>,
    /// Scales that make the recording dimensionless for a network, where the simulator knows some.
    pub scale: Option<Scale>,
    /// When something sudden happened to the thing (impacts), on the clock of `seen`; empty where that is not known.
    pub events: Vec<f64>,
    /// How it is cut into segments between events, where its simulator knows any.
    #[serde(skip)]
    pub segmentation: Option<Arc<dyn Segmentation>>,
    /// Every check that was made of it.
    pub checks: Vec<Check>,
    /// What was noticed.
    pub notes: Vec<Note>,
}

impl Prepared {
    /// Whether measured inputs alone decide what is predicted, without an initial state or another nuisance parameter.
    #[must_use]
    pub fn driven(&self) -> bool {
        self.memoryless && self.nuisances.is_empty()
    }

    /// Whether measured inputs act on what is simulated.
    #[must_use]
    pub fn has_inputs(&self) -> bool {
        self.circumstances.as_ref().is_some_and(|known| !known.inputs.is_empty())
    }

    /// The same recording for a simulator with so many further parameters, of which it knows nothing beforehand.
    pub(crate) fn with_parameters(&self, more: usize) -> Self {
        let mut prepared = self.clone();
        prepared.local.extend(repeat_n(None, more));
        prepared.silent.extend(repeat_n(None, more));
        prepared
    }

    /// The standard deviation of the prior of nuisance parameter `i`.
    #[must_use]
    pub fn prior_sd(&self, i: usize) -> f64 {
        self.prior_sd.get(i).copied().unwrap_or_else(|| self.nuisances[i].span())
    }

    /// `seen` as it is, in its circumstances, without nuisance parameters.
    #[must_use]
    pub fn whole(seen: Observation, parameters: usize) -> Self {
        let (local, silent) = (vec![None; parameters], vec![None; parameters]);
        Self {
            circumstances: seen.circumstances().cloned(),
            memoryless: false,
            discrepancy: false,
            seen,
            noise: None,
            residual_scale: None,
            step_error: None,
            nuisances: Vec::new(),
            begin: Vec::new(),
            prior_sd: Vec::new(),
            known_states: Vec::new(),
            local,
            silent,
            video: None,
            scale: None,
            events: Vec::new(),
            segmentation: None,
            checks: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Whether something sudden happens in it, so that the misfit has kinks and may have several local minima.
    #[must_use]
    pub fn has_events(&self) -> bool {
        !self.events.is_empty() || self.seen.kind() == Kind::EventTimes || self.local.iter().any(Option::is_some)
    }

    /// Where the estimates of the nuisance parameters begin.
    #[must_use]
    pub fn nuisance_values(&self) -> Vec<f64> {
        let begin = |i: usize| self.begin.get(i).copied().flatten();
        self.nuisances.iter().enumerate().map(|(i, p)| begin(i).unwrap_or(p.value)).collect()
    }
}

/// What becomes of a recording.
#[derive(Debug, Clone)]
pub enum Preparation {
    /// It can be tuned to.
    Usable(Box<Prepared>),
    /// It cannot.
    Rejected(Box<Rejected>),
}

/// A recording that cannot be used.
#[derive(Debug, Clone)]
pub struct Rejected {
    /// Why.
    pub note: Note,
    /// Every check that was made of it.
    pub checks: Vec<Check>,
}
