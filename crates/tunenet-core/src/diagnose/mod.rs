//! What is missing: where simulation and measurement disagree, and which effect would make them agree.
//!
//! ```text
//! recordings → prepare → tune → score every candidate → fit the best → what else explains as much? → is the rest noise?
//! ```
//!
//! [`diagnose`] runs the whole chain. A smaller residual does not prove a name, since any further coefficient shrinks it; so
//! an effect is named only where the information criterion gains clearly, its coefficients are physical, nothing else of the
//! catalogue does as well, and what is left looks like noise. Otherwise the answer says which of these failed.

mod adequacy;
mod aloft;
mod answer;
mod apart;
mod assemble;
mod base;
mod believed;
mod between;
mod by_name;
mod by_object;
mod catalogue;
mod chance;
mod colour;
mod columns;
mod confusable;
mod contacts;
mod control;
mod decide;
mod derivatives;
mod driven;
mod equations;
mod evidence;
mod expected;
mod experiment;
mod fit;
mod flights;
mod held_out;
mod hidden;
mod input;
mod insufficient;
mod intervals;
mod joint;
mod likely;
mod memory;
mod mirrored;
mod nameless;
mod outliers;
mod pieces;
mod practical;
mod prune;
mod rest;
mod scatter;
mod scores;
mod search;
mod sets;
mod stage;
mod steady;
mod straight;
mod structure;
mod study;
mod throws;
mod unknown;
mod unmeasured;
mod verdict;
mod words;

#[cfg(test)]
mod tests;

pub use answer::{
    Candidate, Change, Diagnosis, Evidence, Explained, Fitted, Gap, GapOf, NamedEffect, NextExperiment, OfObject,
    OwnEffect, Test, Tuned, Use, Value, Verdict,
};
pub use input::{Progress, Recording, Settings, Subject};

use std::sync::atomic::AtomicUsize;

use crate::observation::{Kind, Note};
use crate::simulator::Preparation;
use crate::{Error, Result};
use catalogue::Entry;
use sets::Set;
use study::Study;

/// Finds which effects are missing from the simulators of `subjects`, given what was seen of them.
///
/// All recordings of one object share its parameters and the coefficients of physical effects; all objects share which
/// effects there are, and the coefficients of measurement effects.
///
/// # Errors
/// [`Error::Setting`] where a setting is out of range or a recording names no subject; [`Error::Observation`] where a
/// recording is of another kind than its simulator predicts; whatever a simulator refuses with every start.
pub fn diagnose(
    subjects: &[Subject],
    recordings: &[Recording],
    settings: &Settings,
    progress: &dyn Fn(Progress),
) -> Result<Diagnosis> {
    settings.check()?;
    if let Some(lost) = recordings.iter().find(|r| r.object >= subjects.len()) {
        let (expected, found) =
            (format!("one of {} subjects", subjects.len()), format!("{} of {}", lost.object, lost.name));
        return Err(Error::Setting { name: "object", expected, found });
    }
    if !subjects.is_empty()
        && subjects.iter().all(|s| s.simulator.kind() == Kind::Joints && !s.simulator.effects().is_empty())
    {
        return driven::diagnose(subjects, recordings, settings, progress);
    }
    let mut uses = Vec::new();
    let mut sets = Vec::new();
    for (i, recording) in recordings.iter().enumerate() {
        let mut one = Use { name: recording.name.clone(), used: true, held_out: recording.held_out, notes: Vec::new() };
        match subjects[recording.object].simulator.prepare(recording.seen)? {
            Preparation::Usable(prepared) => {
                one.notes.clone_from(&prepared.notes);
                sets.push(Set::new(i, recording.object, recording.held_out, *prepared));
            }
            Preparation::Rejected(rejected) => {
                one.used = false;
                progress(Progress::NotUsed { name: &recording.name, why: &rejected.note });
                one.notes.push(rejected.note);
            }
        }
        uses.push(one);
    }
    throws::label(&mut sets);
    let mut notes = Vec::new();
    if settings.set_aside && !sets.iter().any(|s| s.held_out) {
        let objects: Vec<usize> = sets.iter().map(|s| s.object).collect();
        for i in held_out::set_aside(&objects, settings.seed) {
            sets[i].held_out = true;
            uses[sets[i].recording].held_out = true;
        }
        let names: Vec<&str> = uses.iter().filter(|u| u.held_out).map(|u| u.name.as_str()).collect();
        if !names.is_empty() {
            notes.push(Note::new("held_out.chosen", format!("set aside to judge by: {}", names.join(", ")), ""));
        }
    }
    let asked = Asked { subjects, recordings, settings, progress };
    let known = Answered { uses, notes };
    let whole = asked.judge(sets.clone(), known.clone())?;
    let open = whole.notes.iter().any(|note| note.code == verdict::CONTACT_OPEN);
    // Where several effects together are but a guess, as of one throw with a contact, fewer of the flights are better.
    let crowded = whole.verdict == Verdict::OneOf && whole.effects.len() > 1;
    let crowded = crowded && sets.iter().any(|set| !set.contacts.is_empty());
    if (whole.verdict == Verdict::Unknown || open || crowded)
        && let Some(flights) = asked.flights_alone(&sets, &known, &whole)?
    {
        return Ok(flights);
    }
    let doubtful = crowded || whole.verdict == Verdict::Unknown || !whole.adequacy.iter().all(|test| test.passed);
    if doubtful && let Some(contacts) = asked.contacts_alone(&sets, &known, &whole)? {
        return Ok(contacts);
    }
    Ok(whole)
}

/// What [`diagnose`] was asked.
#[derive(Clone, Copy)]
struct Asked<'a> {
    subjects: &'a [Subject<'a>],
    recordings: &'a [Recording<'a>],
    settings: &'a Settings,
    progress: &'a dyn Fn(Progress),
}

impl Asked<'_> {
    /// The answer of these recordings, ready.
    fn judge(&self, sets: Vec<Set>, known: Answered) -> Result<Diagnosis> {
        self.judge_among(sets, known, &|_| true)
    }

    /// The same, where only these effects may be missing.
    fn judge_among(&self, sets: Vec<Set>, known: Answered, may: &dyn Fn(&Entry) -> bool) -> Result<Diagnosis> {
        let mut catalogue = catalogue::catalogue(self.subjects);
        catalogue.retain(may);
        let (held_out, sets): (Vec<Set>, Vec<Set>) = sets.into_iter().partition(|s| s.held_out);
        let study = Study {
            subjects: self.subjects,
            sets,
            catalogue,
            settings: self.settings,
            chance: None,
            independent: 1.0,
            given: Vec::new(),
            expecting: false,
            rollouts: AtomicUsize::new(0),
        };
        verdict::judge(study, held_out, self.recordings, known, self.progress)
    }
}

/// What is known of the answer before anything is fitted.
#[derive(Clone)]
struct Answered {
    uses: Vec<Use>,
    notes: Vec<Note>,
}
