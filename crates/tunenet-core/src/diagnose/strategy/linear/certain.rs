//! What is certain on its own, where something beside it is not.
//!
//! A real arm has more in it than a catalogue, so that something is left beyond noise whatever is added. An effect that might as
//! well be another then adds a name that may be wrong to those that nothing could replace: it is reported, and not added.

use super::choose::{Chosen, Stood, without};
use super::experiment;
use super::logs::Logs;
use crate::Result;
use crate::diagnose::answer::{NextExperiment, Verdict};
use crate::diagnose::input::Settings;
use crate::findings;
use crate::observation::Note;

/// What explains more and cannot be distinguished from something else.
pub(super) struct Further {
    pub note: Note,
    /// What would tell.
    pub experiment: Option<NextExperiment>,
}

impl Chosen {
    /// Leaves out what could as well be something else, where nothing could stand in the place of the others beside it, and
    /// they take the larger part of the gap away without it.
    pub fn certain(mut self, logs: &Logs, settings: &Settings) -> Result<(Self, Option<Further>)> {
        let doubtful: Vec<usize> =
            self.effects.iter().filter(|s| s.doubtful(settings.margin)).map(|s| s.entry).collect();
        // Where everything is explained down to noise, the set is part of the explanation.
        if doubtful.is_empty() || doubtful.len() == self.effects.len() || logs.judge(&self)?.adequate {
            return Ok((self, None));
        }
        let further = self.further(logs, settings)?;
        let lesser = without(logs, &self.best, &doubtful)?;
        let (best, effects) = (std::mem::replace(&mut self.best, lesser), std::mem::take(&mut self.effects));
        let (open, certain): (Vec<Stood>, Vec<Stood>) = effects.into_iter().partition(|s| s.doubtful(settings.margin));
        self.effects = certain;
        if logs.judge(&self)?.practical {
            return Ok((self, Some(further)));
        }
        self.best = best;
        self.effects.extend(open);
        Ok((self, None))
    }

    fn further(&self, logs: &Logs, settings: &Settings) -> Result<Further> {
        let mut names = Vec::new();
        for stood in self.effects.iter().filter(|s| s.doubtful(settings.margin)) {
            names.push(logs.entries[stood.entry].effect.name);
            names.extend(stood.near(settings.margin).map(|entry| logs.entries[entry].effect.name));
        }
        names.sort_unstable();
        names.dedup();
        let experiment = experiment::next(logs, self, Verdict::OneOf, &names, settings.margin)?;
        let text = format!(
            "{} would explain more, and these recordings cannot tell which: it is not added",
            names.join(" or ")
        );
        let hint = experiment.as_ref().map_or(String::new(), |e| e.text.clone());
        Ok(Further { note: Note::new(findings::EFFECTS_FURTHER, text, hint), experiment })
    }
}
