//! A recording made ready for one simulator.

use super::Parameter;
use crate::observation::{LocalEstimate, Note, Observation};

/// The usable part of a recording, with the unknowns that it brings of its own.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The samples to explain.
    pub seen: Observation,
    /// Unknowns of this recording alone (its release, its floor), each with a first guess as `value`.
    pub own: Vec<Parameter>,
    /// For each parameter of the simulator: what the neighbourhood of the events alone says of it, whatever happens in
    /// between. It starts the fit, and stands in for it where the record as a whole cannot be explained.
    pub local: Vec<Option<LocalEstimate>>,
    /// For each parameter of the simulator: why this recording says nothing about it, where that is known beforehand.
    pub silent: Vec<Option<Note>>,
    /// Scales that make the recording dimensionless for a network, where the simulator knows some.
    pub scale: Option<Scale>,
    /// What was noticed.
    pub notes: Vec<Note>,
}

impl Prepared {
    /// `seen` as it is, with no unknowns of its own.
    #[must_use]
    pub fn whole(seen: Observation, parameters: usize) -> Self {
        let (local, silent) = (vec![None; parameters], vec![None; parameters]);
        Self { seen, own: Vec::new(), local, silent, scale: None, notes: Vec::new() }
    }

    /// The first guesses of the own unknowns.
    #[must_use]
    pub fn own_values(&self) -> Vec<f64> {
        self.own.iter().map(|p| p.value).collect()
    }
}

/// The natural scales of one recording: subtracting and dividing by them makes recordings of all sizes alike.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// The value at rest, in the channel's unit (a resting ball's height).
    pub origin: f64,
    /// The natural length, in the channel's unit (the height of fall).
    pub length: f64,
    /// When the event begins, s (the release).
    pub start_s: f64,
    /// The natural time, s (√(h/g)).
    pub time_s: f64,
}

/// What becomes of a recording.
#[derive(Debug, Clone)]
pub enum Preparation {
    /// It can be tuned to.
    Usable(Box<Prepared>),
    /// It cannot, for this reason.
    Rejected(Note),
}
