//! What is certain on its own, where something beside it is not.
//!
//! A real arm has more in it than a catalogue, so that something is left beyond noise whatever is added. An effect that might as
//! well be another then adds a name that may be wrong to those that nothing could replace: it is told, and not added.

use super::choose::{Chosen, stood, without};
use super::experiment;
use super::logs::Logs;
use crate::Result;
use crate::diagnose::answer::{NextExperiment, Verdict};
use crate::diagnose::input::Settings;
use crate::observation::Note;

/// What explains more and cannot be told from something else.
pub(super) struct Further {
    pub note: Note,
    /// What would tell.
    pub experiment: Option<NextExperiment>,
}

impl Chosen {
    /// Leaves out what could as well be something else, where what stays is certain without it and takes the larger part of
    /// the gap away.
    pub fn certain(self, logs: &Logs, settings: &Settings) -> Result<(Self, Option<Further>)> {
        let doubtful: Vec<usize> =
            self.effects.iter().filter(|s| s.doubtful(settings.margin)).map(|s| s.entry).collect();
        let kept: Vec<usize> = self.effects.iter().map(|s| s.entry).filter(|e| !doubtful.contains(e)).collect();
        // Where everything is explained down to noise, the set is part of the explanation.
        if doubtful.is_empty() || kept.is_empty() || logs.judge(&self)?.adequate {
            return Ok((self, None));
        }
        let best = without(logs, &self.best, &doubtful)?;
        let effects = kept.iter().map(|&entry| stood(logs, &best, &kept, entry)).collect::<Result<Vec<_>>>()?;
        let stands = effects.iter().all(|s| s.gain > settings.margin && !s.doubtful(settings.margin));
        let lesser = Self { base: self.base.clone(), best, effects, alone: Vec::new() };
        if !stands || !logs.judge(&lesser)?.practical {
            return Ok((self, None));
        }
        let further = self.further(logs, settings)?;
        Ok((Self { alone: self.alone, ..lesser }, Some(further)))
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
        Ok(Further { note: Note::new("effects.further", text, hint), experiment })
    }
}
