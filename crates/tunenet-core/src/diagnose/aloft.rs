//! Flights alone: every piece between two contacts as a recording of its own, whose start is unknown.
//!
//! A contact that no entry of the catalogue describes spoils every prediction of what comes after it. Cut apart, flights
//! know nothing of it: what acts on them, and how they were seen, shows as clearly as if the contact were understood; and
//! one recording brings several of them, so that one can be held out to judge by.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::by_name::ByName;
use super::catalogue::{Entry, catalogue};
use super::decide::margin;
use super::pieces::pieces;
use super::practical::practically;
use super::search::Found;
use super::sets::Set;
use super::stage::Trial;
use super::structure::Given;
use super::study::{Model, Study};
use super::{Progress, Subject, Test};
use crate::Result;
use crate::simulator::{Phase, Preparation, Simulator};

/// Of so many flights of an object one is held out: the second, so that others are faster, and others slower.
const ENOUGH: usize = 3;
const HELD_OUT: usize = 1;
/// Less than this share of the noise's variance is nothing to explain.
const SMALL: f64 = 0.3;

/// What flights say.
pub(super) struct Aloft {
    /// The effects that act on them, or on how they were seen, with the values found.
    pub given: Vec<Given>,
    /// For each of them: its worth, and what could stand in its place.
    pub places: Vec<ByName>,
    /// How far behind an explanation is left.
    pub margin: f64,
    pub tests: Vec<Test>,
    /// Every candidate as it stood alone.
    pub alone: Vec<Alone>,
}

/// A candidate beside flights or contacts alone.
pub(super) struct Alone {
    pub name: &'static str,
    pub gain: f64,
    pub excluded: Option<String>,
}

impl Study<'_> {
    /// What the flights of all recordings say; `None` where they are too few, or nothing explains them either.
    pub fn aloft(&self, progress: &dyn Fn(Progress)) -> Result<Option<Aloft>> {
        let simulators: Option<Vec<Box<dyn Simulator>>> =
            self.subjects.iter().map(|s| s.simulator.in_flight()).collect();
        let Some(simulators) = simulators else { return Ok(None) };
        let named = self.subjects.iter().zip(&simulators);
        let subjects: Vec<Subject> =
            named.map(|(s, simulator)| Subject { name: s.name.clone(), simulator: simulator.as_ref() }).collect();
        let (mut held_out, sets) = flights(&subjects, &self.sets)?;
        if sets.len() < ENOUGH {
            return Ok(None);
        }
        let mut catalogue = catalogue(&subjects);
        catalogue.retain(|entry| entry.of[0].phase != Phase::Contact);
        let mut study = Study {
            subjects: &subjects,
            sets,
            catalogue,
            settings: self.settings,
            chance: None,
            independent: 1.0,
            given: Vec::new(),
            expecting: false,
            rollouts: AtomicUsize::new(0),
        };
        let found = study.understood(&mut held_out, progress);
        self.rollouts.fetch_add(study.rollouts.load(Ordering::Relaxed), Ordering::Relaxed);
        let Some((found, tests)) = found? else { return Ok(None) };
        Ok(Some(study.told(&found, tests)))
    }
}

impl<'a> Study<'a> {
    /// The search, and the tests that its answer passes; `None` where it fails some.
    fn understood(
        &mut self,
        held_out: &mut [Set],
        progress: &dyn Fn(Progress),
    ) -> Result<Option<(Found<'a>, Vec<Test>)>> {
        let base = self.base()?;
        self.leave_out_unmeasured(&base, held_out)?;
        let found = self.search(base, progress)?;
        let best = found.best.as_ref().unwrap_or(&found.base);
        let tests = self.adequacy(best);
        // Rounding has a pattern of its own, far below the noise.
        let small = best.deviance(best.scale()) < SMALL * self.count() as f64;
        let adequate = small || tests.iter().all(|t| t.passed);
        if found.best.is_none() {
            let tests = if small { Vec::new() } else { tests };
            return Ok(adequate.then_some((found, tests)));
        }
        // The least that takes the large part away, where unseen flights confirm it.
        if !held_out.is_empty() {
            let (sets, floor) = (self.sets.clone(), self.floor());
            let mut second = practically(self, &found, held_out, floor, progress)?;
            self.prune(&mut second.found)?;
            if second.found.best.is_some() && second.tests.iter().all(|t| t.passed) {
                return Ok(Some((second.found, second.tests)));
            }
            (self.sets, self.independent) = (sets, 1.0);
        }
        Ok(adequate.then_some((found, tests)))
    }

    /// The candidates by name.
    pub fn alone(&self, found: &Found) -> Vec<Alone> {
        let name = |entry: usize| self.catalogue[entry].name;
        let one = |t: &Trial| Alone { name: name(t.entry), gain: t.gain, excluded: t.excluded.clone() };
        found.alone.iter().map(one).collect()
    }

    fn told(&self, found: &Found, tests: Vec<Test>) -> Aloft {
        let objects = self.subjects.len();
        let given = |model: &Model| -> Vec<Given> {
            let each = model.structure.effects.iter().enumerate();
            each.map(|(position, &entry)| {
                let entry = &self.catalogue[entry];
                let values = (0..objects).map(|object| values(model, position, entry, object)).collect();
                Given { entry: entry.clone(), values }
            })
            .collect()
        };
        let ordered = found.best.iter().flat_map(|model| &model.structure.effects);
        let place = |entry: &usize| found.places.iter().find(|p| p.entry == *entry);
        let places = ordered.filter_map(place).map(|place| ByName::of(self, place)).collect();
        Aloft {
            given: found.best.as_ref().map_or_else(Vec::new, given),
            places,
            margin: margin(self),
            tests,
            alone: self.alone(found),
        }
    }
}

/// The coefficients of one object's effect; absent where it has no flight.
fn values(model: &Model, position: usize, entry: &Entry, object: usize) -> Vec<f64> {
    let globals = &model.structure.globals;
    let of = |k: usize| {
        let mine = |g: &usize| {
            globals[*g].effect == Some((position, k)) && globals[*g].object.is_none_or(|owner| owner == object)
        };
        (0..globals.len()).find(mine).map(|g| model.fit.point.globals[g])
    };
    entry.of[object].coefficients.iter().enumerate().map(|(k, c)| of(k).unwrap_or(c.absent)).collect()
}

/// Every flight as a recording: those held out, and those to fit.
fn flights(subjects: &[Subject], sets: &[Set]) -> Result<(Vec<Set>, Vec<Set>)> {
    let mut all: Vec<Set> = Vec::new();
    for set in sets {
        // What follows the last contact may hold more of them, too small to be found.
        let flights = pieces(set.clock(), &set.contacts).into_iter().take(set.contacts.len().max(1));
        for range in flights.flatten() {
            let Ok(seen) = set.prepared.seen.slice(range.clone()) else { continue };
            if let Preparation::Usable(prepared) = subjects[set.object].simulator.prepare(&seen)? {
                // Flights of one recording differ as throws do: the first are fast, the last are slow.
                all.push(Set { throw: all.len(), ..set.piece(range, *prepared) });
            }
        }
    }
    for object in 0..subjects.len() {
        let mine: Vec<usize> = (0..all.len()).filter(|&i| all[i].object == object).collect();
        if mine.len() >= ENOUGH {
            all[mine[HELD_OUT]].held_out = true;
        }
    }
    Ok(all.into_iter().partition(|s| s.held_out))
}
