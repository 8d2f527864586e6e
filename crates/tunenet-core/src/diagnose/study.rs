//! What all steps of a diagnosis share, and a model as one of them leaves it.

use std::sync::atomic::AtomicUsize;

use super::catalogue::{Entry, SCATTER};
use super::colour;
use super::evidence::{bic_gain, likelihood_gain};
use super::fit::Effort;
use super::joint::{Joint, Outcome, Point, spread};
use super::outliers;
use super::sets::Set;
use super::structure::{Given, Structure};
use super::{Settings, Subject};
use crate::Result;
use crate::tune::huber_cost;

/// A full fit.
pub(super) const FULL: Effort = Effort { steps: 12, tolerance: 0.02, horizon: 1.0 };
/// A bias of the noise's colour below this is left.
const COLOUR_CHANGE: f64 = 0.05;

/// The recordings that are fitted, and what may be missing.
pub(super) struct Study<'a> {
    pub subjects: &'a [Subject<'a>],
    /// The training recordings.
    pub sets: Vec<Set>,
    pub catalogue: Vec<Entry>,
    pub settings: &'a Settings,
    /// Where contacts are subject to chance: the standard deviation of a tilt, rad.
    pub chance: Option<f64>,
    /// The share of the values that counts as independent; 1 where the noise's colour is taken out instead.
    pub independent: f64,
    /// Effects that stand at known values.
    pub given: Vec<Given>,
    /// Whether what has to be there is taken to be there before anything is looked for.
    pub expecting: bool,
    pub rollouts: AtomicUsize,
}

/// A structure and its fit.
pub(super) struct Model<'a> {
    pub structure: Structure<'a>,
    pub fit: Outcome,
}

impl Model<'_> {
    /// The robust sum of squares in units of the noise, losses changing over at 4 times `scale`, with that of the own
    /// unknowns from their guesses.
    pub fn deviance(&self, scale: f64) -> f64 {
        2.0 * (huber_cost(&self.fit.residuals, scale) + self.fit.pull)
    }

    pub fn scale(&self) -> f64 {
        spread(&self.fit.residuals)
    }

    pub fn has(&self, entry: usize) -> bool {
        self.structure.effects.contains(&entry)
    }
}

impl<'a> Study<'a> {
    pub fn joint<'b>(&'b self, structure: &'b Structure<'b>) -> Joint<'b> {
        Joint { structure, sets: &self.sets, rollouts: &self.rollouts }
    }

    pub fn structure(&self, effects: &[usize]) -> Result<Structure<'a>> {
        Structure::new(self.subjects, &self.sets, &self.catalogue, effects, &self.given, self.chance.is_some())
    }

    /// Chance at contacts, where every subject knows it.
    pub fn chance_entry(&self) -> Option<&Entry> {
        self.catalogue.iter().find(|e| e.name == SCATTER)
    }

    /// Whether all that is fitted shows one throw, however often.
    pub fn single(&self) -> bool {
        self.sets.iter().all(|set| set.throw == self.sets[0].throw)
    }

    /// Whether no object shows a second throw, against which the numbers of its own could be held.
    pub fn thin(&self) -> bool {
        let one = |a: &Set| self.sets.iter().all(|b| a.object != b.object || a.throw == b.throw);
        self.sets.iter().all(one)
    }

    /// How many values count.
    pub fn count(&self) -> usize {
        self.sets.iter().map(Set::count).sum()
    }

    /// Twice the gain in logarithmic likelihood between two sums of squares.
    pub fn likelihood(&self, before: f64, after: f64) -> f64 {
        self.independent * likelihood_gain(self.count(), before, after)
    }

    /// The fall of the information criterion by `coefficients` more numbers.
    pub fn criterion(&self, before: f64, after: f64, coefficients: f64) -> f64 {
        bic_gain(self.likelihood(before, after), self.independent * self.count() as f64, coefficients)
    }

    /// A model with these effects, fitted from where `near` stands.
    pub fn fit_near(&self, effects: &[usize], near: &Model) -> Result<Model<'a>> {
        let structure = self.structure(effects)?;
        let point = Point {
            globals: structure.carry(&near.structure, &near.fit.point.globals),
            own: near.fit.point.own.clone(),
        };
        let fit = self.joint(&structure).fit(point, FULL, None)?;
        Ok(Model { structure, fit })
    }

    /// Residuals of a model in units of the noise, not whitened; what is set aside stays 0.
    pub fn weighted(&self, model: &Model) -> Result<Vec<Vec<f64>>> {
        let mut plain = self.joint(&model.structure).plain_residuals(&model.fit.point)?;
        for (set, values) in self.sets.iter().zip(&mut plain) {
            let width = set.width();
            for (i, value) in values.iter_mut().enumerate() {
                *value = if set.keep[i] { *value / set.noise[i % width] } else { 0.0 };
            }
        }
        Ok(plain)
    }

    /// Takes single wild samples and the noise's colour from what `model` leaves. True where anything changed, so that
    /// fits have to be made again.
    pub fn learn_noise(&mut self, model: &Model, before: &mut f64) -> Result<bool> {
        let mut weighted = self.joint(&model.structure).plain_residuals(&model.fit.point)?;
        for (set, values) in self.sets.iter().zip(&mut weighted) {
            let width = set.width();
            values.iter_mut().enumerate().for_each(|(i, v)| *v /= set.noise[i % width]);
        }
        let set_aside = outliers::set_aside(&mut self.sets, &weighted);
        let rho = colour::correlation(&self.sets, &weighted);
        let changed = set_aside > 0 || (rho - *before).abs() > COLOUR_CHANGE;
        if changed {
            self.sets.iter_mut().for_each(|set| set.colour(rho));
            *before = rho;
        }
        Ok(changed)
    }
}
