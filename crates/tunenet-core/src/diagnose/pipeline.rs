//! The pipeline: evidence → attempt by refinements → judgement → diagnosis, and strategies for what that leaves in doubt.

use super::answer::assemble::assemble;
use super::answer::insufficient::too_little;
use super::answer::judgement::Judgement;
use super::answer::notes::{add_notes, note_contradiction, note_copies};
use super::answer::{Diagnosis, Use};
use super::evidence::Evidence;
use super::evidence::recording::PreparedRecording;
use super::hypothesis::catalogue::catalogue;
use super::hypothesis::context::Context;
use super::input::{Progress, Recording, Settings, Subject};
use super::strategy::explain;
use crate::Result;
use crate::estimate::RolloutLog;
use crate::observation::Note;
use crate::simulator::{Effect, Simulator};

/// A way to explain recordings that are not explained as they are: it makes other recordings of them (their free segments,
/// say), lets [`Problem::explain`] explain these, and says what of that answer holds for the recordings as they are.
///
/// Strategies are tried in the order of their list, each after the best explanation so far.
pub trait Strategy: Sync {
    /// Whether it is worth trying after `so_far`.
    fn applies(&self, problem: &Problem, so_far: &Explanation) -> bool;

    /// Its explanation, which replaces `so_far`; `None` where it has none.
    ///
    /// # Errors
    /// Where a simulator refuses.
    fn attempt(&self, problem: &Problem, so_far: &Explanation) -> Result<Option<Explanation>>;
}

/// What is to be diagnosed.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    subjects: &'a [Subject<'a>],
    given: &'a [Recording<'a>],
    settings: &'a Settings,
    progress: &'a dyn Fn(Progress),
    recordings: &'a [PreparedRecording],
    preparations: &'a Preparations,
    /// Counts the rollouts of all explanations, also of those that lead to nothing.
    rollouts: &'a RolloutLog,
}

/// What became of the recordings before anything was fitted.
#[derive(Clone)]
pub(super) struct Preparations {
    pub uses: Vec<Use>,
    pub notes: Vec<Note>,
}

/// A diagnosis, and what only the next strategy has to know of it.
pub struct Explanation {
    /// The answer.
    pub diagnosis: Diagnosis,
    /// Whether what lies between events is explained, and the events are not.
    pub events_open: bool,
    /// The one recording that disagrees with all others: its position among the recordings given.
    pub odd: Option<usize>,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        (subjects, given): (&'a [Subject<'a>], &'a [Recording<'a>]),
        (settings, progress): (&'a Settings, &'a dyn Fn(Progress)),
        (recordings, preparations): (&'a [PreparedRecording], &'a Preparations),
        rollouts: &'a RolloutLog,
    ) -> Self {
        Self { subjects, given, settings, progress, recordings, preparations, rollouts }
    }

    /// What the recordings were made of.
    #[must_use]
    pub fn subjects(&self) -> &'a [Subject<'a>] {
        self.subjects
    }

    /// How to diagnose.
    #[must_use]
    pub fn settings(&self) -> &'a Settings {
        self.settings
    }

    /// The recordings that can be used, ready to be fitted.
    #[must_use]
    pub fn recordings(&self) -> &'a [PreparedRecording] {
        self.recordings
    }

    /// The explanation of the recordings as they are.
    pub(super) fn as_recorded(&self) -> Result<Explanation> {
        self.among(self.recordings.to_vec(), &|_| true)
    }

    /// The explanation of all recordings but the one at this position among those given.
    pub(super) fn without(&self, index: usize) -> Result<Explanation> {
        self.among(self.recordings.iter().filter(|one| one.index != index).cloned().collect(), &|_| true)
    }

    /// The explanation of `recordings` by `simulators`, one of each subject in its place, where only effects that `may` be
    /// missing are looked for.
    ///
    /// # Errors
    /// Where a simulator refuses.
    ///
    /// # Panics
    /// Where there are fewer simulators than subjects with recordings.
    pub fn explain(
        &self,
        simulators: &[Box<dyn Simulator>],
        recordings: Vec<PreparedRecording>,
        settings: &Settings,
        may: &dyn Fn(&Effect) -> bool,
    ) -> Result<Explanation> {
        let named = self.subjects.iter().zip(simulators);
        let subjects: Vec<Subject> =
            named.map(|(s, simulator)| Subject { name: s.name.clone(), simulator: simulator.as_ref() }).collect();
        Problem { subjects: &subjects, settings, ..*self }.among(recordings, may)
    }

    fn among(&self, recordings: Vec<PreparedRecording>, may: &dyn Fn(&Effect) -> bool) -> Result<Explanation> {
        let mut catalogue = catalogue(self.subjects);
        catalogue.retain(|entry| may(&entry.of[0]));
        let context = Context::new(self.subjects, Evidence::new(recordings), catalogue, self.settings, self.rollouts);
        let Preparations { uses, mut notes } = self.preparations.clone();
        if let Some(diagnosis) = too_little(&context, &uses, &notes) {
            return Ok(Explanation { diagnosis, events_open: false, odd: None });
        }
        note_copies(&context, &mut notes);
        let attempt = explain(&context, self.progress)?;
        (self.progress)(Progress::Judging);
        let judged = Judgement::new(attempt)?;
        add_notes(&judged, &mut notes);
        note_contradiction(&judged, &uses, &mut notes);
        let (events_open, odd) = (judged.events_open(), judged.odd);
        Ok(Explanation { diagnosis: assemble(&judged, self.given, uses, notes)?, events_open, odd })
    }
}
