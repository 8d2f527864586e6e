//! A recording made ready for one simulator.

use std::sync::Arc;

use serde::{Serialize, Serializer};

use super::{Parameter, Scale, Segmentation};
use crate::observation::{Check, LocalEstimate, Note, Observation};

/// The usable part of a recording, with its nuisance parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Prepared {
    /// The samples to explain.
    pub seen: Observation,
    /// What drove the thing while it was seen (the motion of an arm), where its simulator predicts from that; on the clock of
    /// `seen`.
    #[serde(serialize_with = "shared")]
    pub input: Option<Arc<Observation>>,
    /// The noise of each channel of `seen`, in its unit, where it is known better than from `seen` itself.
    pub noise: Option<Vec<f64>>,
    /// Scale estimate of each channel's residual, where it exceeds the noise: residuals are divided by it.
    pub residual_scale: Option<Vec<f64>>,
    /// Nuisance parameters of this recording (its release, its floor), each with a first guess as `value`.
    pub nuisances: Vec<Parameter>,
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
    /// Whether a measured input drives it from the first sample to the last, so that it has no start state to fit.
    #[must_use]
    pub fn driven(&self) -> bool {
        self.input.is_some() && self.nuisances.is_empty()
    }

    /// `seen` as it is, without nuisance parameters.
    #[must_use]
    pub fn whole(seen: Observation, parameters: usize) -> Self {
        let (local, silent) = (vec![None; parameters], vec![None; parameters]);
        Self {
            seen,
            input: None,
            noise: None,
            residual_scale: None,
            nuisances: Vec::new(),
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

    /// Whether its simulator predicts from a measured input.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        self.input.is_some()
    }

    /// The first guesses of the nuisance parameters.
    #[must_use]
    pub fn nuisance_values(&self) -> Vec<f64> {
        self.nuisances.iter().map(|p| p.value).collect()
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

/// What drove it, as any other observation.
#[expect(clippy::ref_option, reason = "the form that serde calls")]
fn shared<S: Serializer>(input: &Option<Arc<Observation>>, serializer: S) -> Result<S::Ok, S::Error> {
    input.as_deref().serialize(serializer)
}
