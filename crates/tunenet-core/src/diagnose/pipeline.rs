//! The pipeline: evidence → attempt by strategies → judgement → diagnosis.

use super::answer::assemble::assemble;
use super::answer::insufficient::too_little;
use super::answer::notes::{add_notes, note_copies};
use super::answer::{Diagnosis, Use};
use super::evidence::Evidence;
use super::evidence::recording::Set;
use super::hypothesis::catalogue::{Entry, catalogue};
use super::hypothesis::context::Context;
use super::input::{Progress, Recording, Settings, Subject};
use super::judge::judgement::Judgement;
use super::strategy::explain;
use crate::Result;
use crate::observation::Note;

/// What is to be diagnosed.
#[derive(Clone, Copy)]
pub(super) struct Problem<'a> {
    pub subjects: &'a [Subject<'a>],
    pub recordings: &'a [Recording<'a>],
    pub settings: &'a Settings,
    pub progress: &'a dyn Fn(Progress),
}

/// What became of the recordings before anything was fitted.
#[derive(Clone)]
pub(super) struct Preparations {
    pub uses: Vec<Use>,
    pub notes: Vec<Note>,
}

/// A diagnosis, and what only the next strategy has to know of it.
pub(super) struct Outcome {
    pub diagnosis: Diagnosis,
    /// Whether what lies between events is explained, and the events are not.
    pub events_open: bool,
}

impl Problem<'_> {
    /// The diagnosis of these recordings.
    pub fn run(&self, sets: Vec<Set>, preparations: Preparations) -> Result<Outcome> {
        self.run_among(sets, preparations, &|_| true)
    }

    /// The same, where only these effects may be missing.
    pub fn run_among(
        &self,
        sets: Vec<Set>,
        preparations: Preparations,
        may: &dyn Fn(&Entry) -> bool,
    ) -> Result<Outcome> {
        let mut catalogue = catalogue(self.subjects);
        catalogue.retain(may);
        let context = Context::new(self.subjects, Evidence::new(sets), catalogue, self.settings);
        let Preparations { uses, mut notes } = preparations;
        if let Some(diagnosis) = too_little(&context, &uses, &notes) {
            return Ok(Outcome { diagnosis, events_open: false });
        }
        note_copies(&context, &mut notes);
        let attempt = explain(&context, self.progress)?;
        (self.progress)(Progress::Judging);
        let judged = Judgement::new(attempt)?;
        add_notes(&judged, &mut notes);
        let events_open = judged.events_open();
        Ok(Outcome { diagnosis: assemble(&judged, self.recordings, uses, notes)?, events_open })
    }
}
