//! A recording made ready for an arm that draws a circle: its torques, on the clock of the motion.

use tunenet_core::Result;
use tunenet_core::observation::{Kind, Note, Observation};
use tunenet_core::simulator::{Preparation, Prepared, Rejected};

use super::ObservedArm;
use crate::findings;

/// Fewest samples that are worth a fit; fewer do not distinguish noise from misfit.
const FEWEST: usize = 20;

impl ObservedArm {
    /// # Errors
    /// [`tunenet_core::Error::Observation`] where torques are not numbers, which the observation's constructor excludes.
    pub(super) fn prepared(&self, seen: &Observation) -> Result<Preparation> {
        let reject = |text: String, remedy: &str| {
            let note = Note::new(findings::ARM_UNUSABLE, text, remedy);
            Ok(Preparation::Rejected(Box::new(Rejected { note, checks: Vec::new() })))
        };
        let place = |name: &str| seen.channels().iter().position(|c| c.name == name);
        let columns: Vec<Option<usize>> = self.channels.iter().map(|c| place(&c.name)).collect();
        let torques = seen.channels().iter().filter(|c| c.name.starts_with("tau")).count();
        let joints = self.channels.len();
        if seen.kind() != Kind::Joints || torques == 0 {
            let text = format!("expected torques of {joints} joints, found none");
            return reject(text, "record the efforts too; name them tau1_nm and on, or map them by --columns");
        }
        if columns.contains(&None) || torques != joints {
            let text = format!("expected torques of the {joints} joints between base and payload, found {torques}");
            return reject(text, "name an `arm.payload_link` behind the joints that were recorded");
        }
        let mut notes = Vec::new();
        let duration = self.motion.duration_s();
        // Stamps may count from anywhere; a record of the motion begins with it.
        let within = |clock: &[f64]| clock[0] >= 0.0 && clock[0] < duration;
        let moved = (!within(seen.clock())).then(|| seen.from_zero());
        if moved.is_some() {
            let text = "the clock does not begin with the motion: its first sample is taken for the motion's start";
            notes.push(Note::new(findings::ARM_CLOCK, text, "let the clock count from the start of the motion"));
        }
        let seen = moved.as_ref().unwrap_or(seen);
        let kept = seen.clock().partition_point(|t| *t <= duration + 1e-9);
        if kept < FEWEST {
            let text = format!("expected {FEWEST} samples or more within the motion's {duration} s, found {kept}");
            return reject(text, "record the whole motion, more often; too few samples say nothing of their noise");
        }
        if kept < seen.len() {
            let text = format!("{} samples after the motion's {duration} s are left out", seen.len() - kept);
            notes.push(Note::new(findings::ARM_LONGER, text, "raise `motion.duration_s` if the motion continued"));
        }
        let values = (0..kept).flat_map(|i| columns.iter().flatten().map(move |c| seen.row(i)[*c])).collect();
        let clock = seen.clock()[..kept].to_vec();
        let torques = Observation::new(Kind::Joints, self.channels.clone(), clock, values)?;
        let mut prepared = Prepared::whole(torques, self.parameters.len());
        prepared.notes = notes;
        Ok(Preparation::Usable(Box::new(prepared)))
    }
}
