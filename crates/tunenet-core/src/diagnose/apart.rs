//! Flights and contacts judged apart, where no model of both together leaves noise alone.
//!
//! ```text
//! flights alone → what acts on them → held there → contacts: what takes the large part away → do hidden flights agree?
//! ```

use std::sync::atomic::{AtomicUsize, Ordering};

use super::aloft::{Aloft, Alone};
use super::by_name::ByName;
use super::catalogue::catalogue;
use super::joint::Point;
use super::practical::{CONFIRMED, CONTROL, LEFT_SHARE};
use super::search::{Found, Place};
use super::sets::Set;
use super::stage::Trial;
use super::structure::Given;
use super::study::{Model, Study};
use super::{Progress, Test};
use crate::Result;
use crate::simulator::Phase;

/// What flights and contacts say.
pub(super) struct Apart<'a> {
    /// All effects together, where they stand; `None` where the flights need none and contacts show none.
    pub best: Option<Model<'a>>,
    pub places: Vec<Place>,
    /// Every candidate as it stood alone, beside flights or beside contacts.
    pub alone: Vec<Trial<'a>>,
    pub tests: Vec<Test>,
    /// Whether contacts leave something that nothing takes away.
    pub open: bool,
}

/// What contacts say, the flights understood.
struct Contacts {
    point: Point,
    /// The effects' positions in the catalogue of contacts are told by name.
    names: Vec<&'static str>,
    /// Free numbers: object, name, value.
    values: Vec<(Option<usize>, String, f64)>,
    places: Vec<ByName>,
    tests: Vec<Test>,
    confirmed: bool,
    alone: Vec<Alone>,
}

/// A fit that leaves this many times the noise is not mended by any effect that is as good as exact.
const HOPELESS: f64 = 50.0;

impl<'a> Study<'a> {
    /// Whether what `model` leaves is so far beyond noise that whole recordings need not be searched first.
    pub fn hopeless(&self, model: &Model) -> bool {
        model.deviance(f64::MAX) > HOPELESS * HOPELESS * self.count() as f64
    }

    /// Judges flights and contacts apart. `None` where the flights are not understood.
    pub fn apart(&self, progress: &dyn Fn(Progress)) -> Result<Option<Apart<'a>>> {
        let Some(aloft) = self.aloft(progress)? else { return Ok(None) };
        let contacts = self.contacts(&aloft.given, progress)?;
        let mut names: Vec<&'static str> = aloft.given.iter().map(|g| g.entry.name).collect();
        if contacts.confirmed {
            names.extend(&contacts.names);
        }
        let entry = |name: &str| self.catalogue.iter().position(|e| e.name == name);
        let effects: Vec<usize> = names.iter().filter_map(|name| entry(name)).collect();
        let trial = |alone: &Alone| {
            Some(Trial { excluded: alone.excluded.clone(), ..Trial::unfitted(entry(alone.name)?, alone.gain) })
        };
        let mut alone: Vec<Trial> = aloft.alone.iter().chain(&contacts.alone).filter_map(trial).collect();
        alone.sort_by(|a, b| a.excluded.is_some().cmp(&b.excluded.is_some()).then(b.gain.total_cmp(&a.gain)));
        if effects.is_empty() {
            return Ok(Some(Apart { best: None, places: Vec::new(), alone, tests: Vec::new(), open: true }));
        }
        let structure = self.structure(&effects)?;
        let globals = structure.globals.iter().map(|g| {
            let found =
                contacts.values.iter().find(|(object, name, _)| *object == g.object && *name == g.parameter.name);
            found.map(|f| f.2).or_else(|| stands(&aloft, g.object, &g.parameter.name)).unwrap_or(g.parameter.value)
        });
        let point = Point { globals: globals.collect(), own: contacts.point.own };
        let fit = self.joint(&structure).stand(point)?;
        // What flights alone tell apart is told apart.
        let flying = aloft.places.into_iter().map(|place| place.within(aloft.margin));
        let mut places: Vec<Place> = flying.filter_map(|place| place.place(&self.catalogue)).collect();
        let mut tests = aloft.tests;
        if contacts.confirmed {
            tests.extend(contacts.tests);
            places.extend(contacts.places.iter().filter_map(|place| place.place(&self.catalogue)));
        }
        let best = Some(Model { structure, fit });
        Ok(Some(Apart { best, places, alone, tests, open: !contacts.confirmed }))
    }

    /// What contacts leave, with what acts on flights held where it was found.
    fn contacts(&self, given: &[Given], progress: &dyn Fn(Progress)) -> Result<Contacts> {
        let mut catalogue = catalogue(self.subjects);
        catalogue.retain(|entry| entry.of[0].phase == Phase::Contact);
        let mut study = Study {
            subjects: self.subjects,
            sets: self.sets.clone(),
            catalogue,
            settings: self.settings,
            chance: None,
            independent: 1.0,
            given: given.to_vec(),
            expecting: false,
            rollouts: AtomicUsize::new(0),
        };
        let contacts = study.at_contact(progress);
        self.rollouts.fetch_add(study.rollouts.load(Ordering::Relaxed), Ordering::Relaxed);
        contacts
    }

    fn at_contact(&mut self, progress: &dyn Fn(Progress)) -> Result<Contacts> {
        self.sets.iter_mut().for_each(Set::hold_still);
        let base = self.base()?;
        let first = self.search(base, progress)?;
        let mut found = self.search_practically(&first, &mut [], progress)?;
        self.prune(&mut found)?;
        let (tests, confirmed) = self.confirmed(&found)?;
        let best = found.best.as_ref().filter(|_| confirmed).unwrap_or(&found.base);
        let globals = best.structure.globals.iter().zip(&best.fit.point.globals);
        let of = |entry: &usize| found.places.iter().find(|p| p.entry == *entry);
        let places = best.structure.effects.iter().filter_map(of).map(|place| ByName::of(self, place));
        Ok(Contacts {
            point: best.fit.point.clone(),
            names: best.structure.effects.iter().map(|&e| self.catalogue[e].name).collect(),
            values: globals.map(|(g, value)| (g.object, g.parameter.name.clone(), *value)).collect(),
            places: places.collect(),
            tests,
            confirmed,
            alone: self.alone(&found),
        })
    }

    /// Whether flights that were hidden from the fit bear out what was found at contacts, and no wrong effect as well.
    fn confirmed(&self, found: &Found) -> Result<(Vec<Test>, bool)> {
        let Some(best) = &found.best else { return Ok((Vec::new(), false)) };
        let (Some(before), Some(after)) = (self.hidden(&found.base)?, self.hidden(best)?) else {
            return Ok((Vec::new(), false));
        };
        let wrong = |t: &&Trial| t.excluded.is_none() && !best.structure.effects.contains(&t.entry);
        let control = match found.alone.iter().rev().find(wrong) {
            Some(trial) => self.hidden(&self.fit_near(&[trial.entry], &found.base)?)?,
            None => None,
        };
        let (whole, left) = (found.base.deviance(f64::MAX), best.deviance(f64::MAX));
        let test = |name, value, threshold| Test { name, value, threshold, passed: value <= threshold };
        let mut tests = vec![
            test("left over taken away", left / (whole - left).max(f64::MIN_POSITIVE), LEFT_SHARE),
            test("hidden flights' residual after over before", after / before, CONFIRMED),
        ];
        tests.extend(
            control.map(|c| test("hidden flights' residual over that of a wrong effect", after / c, CONTROL.recip())),
        );
        let passed = tests.iter().all(|t| t.passed);
        Ok((tests, passed))
    }
}

fn stands(aloft: &Aloft, object: Option<usize>, name: &str) -> Option<f64> {
    aloft.given.iter().find_map(|g| g.value(object.unwrap_or(0), name))
}
