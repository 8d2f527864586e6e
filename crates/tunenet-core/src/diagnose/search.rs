//! The search for the missing effects: forward, swap, backward, and what else explains as much.

use super::decide::margin;
use super::evidence::p_value;
use super::practical::WORTH;
use super::stage::Trial;
use super::study::{Model, Study};
use super::{Progress, confusable};
use crate::Result;

/// A swap may open the way to another; each is better than the one before.
const MOST_SWAPS: usize = 6;

/// What the search found.
pub(super) struct Found<'a> {
    /// The simulation without any effect.
    pub base: Model<'a>,
    /// Candidates beside it, each alone, best first.
    pub alone: Vec<Trial<'a>>,
    /// The best structure; `None` where no effect earns its place.
    pub best: Option<Model<'a>>,
    /// For each effect of the best: what it is worth and what could stand in its place.
    pub places: Vec<Place>,
}

/// What becomes of a structure whose effects are judged one by one.
enum Judged<'a> {
    /// Each earns its place.
    Stands(Vec<Place>),
    /// This one is better; `None` is the simulation without any effect.
    Yields(Option<Box<Model<'a>>>),
}

/// An effect whose worth was not looked at: it has none.
fn unjudged(entry: usize) -> Place {
    Place { entry, gain: 0.0, p_value: 1.0, others: Vec::new(), equals: Vec::new() }
}

/// One effect of the best structure.
#[derive(Clone)]
pub(super) struct Place {
    /// Position in the catalogue.
    pub entry: usize,
    /// Gain by having it beside the others.
    pub gain: f64,
    /// Probability of that by chance, all candidates counted.
    pub p_value: f64,
    /// Others in its place with how far they fall behind, nearest first; exact twins included.
    pub others: Vec<(usize, f64)>,
    /// Those among them that do as well on recordings that were not fitted, whatever their distance.
    pub equals: Vec<usize>,
}

impl<'a> Study<'a> {
    /// With the effects in, the noise shows more clearly; where it differs from what was taken for it, all is done again.
    pub fn search_again(&mut self, found: Found<'a>, rho: &mut f64, progress: &dyn Fn(Progress)) -> Result<Found<'a>> {
        let Some(best) = &found.best else { return Ok(found) };
        if !self.learn_noise(best, rho)? {
            return Ok(found);
        }
        let base = self.fit_near(&[], &found.base)?;
        self.search(base, progress)
    }

    /// Searches from the tuned simulation.
    pub fn search(&self, base: Model<'a>, progress: &dyn Fn(Progress)) -> Result<Found<'a>> {
        progress(Progress::Scoring { candidates: self.catalogue.len(), effects: 0 });
        let mut alone = self.stage(&base);
        let mut best = match self.expected(&base)? {
            Some(expected) => Some(expected),
            None => self.accepted(&base, &alone)?,
        };
        while let Some(model) = &best
            && model.structure.effects.len() < self.most_effects(model)
        {
            let effects = model.structure.effects.len();
            progress(Progress::Scoring { candidates: self.catalogue.len() - effects, effects });
            let next = self.stage(model);
            let Some(more) = self.accepted(model, &next)? else { break };
            best = Some(more);
        }
        let mut places = Vec::new();
        for _ in 0..MOST_SWAPS {
            let Some(model) = best.take() else { break };
            // With all that may be added and still no fit, there is nothing to compare with.
            let full = model.structure.effects.len() >= self.settings.most_effects.max(2);
            if full && self.independent >= 1.0 && !self.adequacy(&model).iter().all(|t| t.passed) {
                best = Some(model);
                break;
            }
            match self.judge_places(&base, &alone, &model)? {
                Judged::Stands(found) => {
                    (best, places) = (Some(model), found);
                    break;
                }
                Judged::Yields(other) => best = other.map(|model| *model),
            }
        }
        if let (Some(model), true) = (&best, places.is_empty()) {
            places = model.structure.effects.iter().map(|&e| unjudged(e)).collect();
        }
        if let Some(model) = &best {
            self.measure(&mut alone, &base, model.scale());
        }
        Ok(Found { base, alone, best, places })
    }

    /// How many effects a structure like `model` may have. A single throw shows one at most beside what has to be there
    /// anyhow: more would fit whatever it holds.
    fn most_effects(&self, model: &Model) -> usize {
        let certain = model.structure.effects.iter().filter(|&&entry| self.certain(entry)).count();
        let most = if self.single() { certain + 1 } else { self.settings.most_effects };
        most.min(self.settings.most_effects)
    }

    /// Gains of candidates beside the simulation without any, all measured as that of the best structure is.
    fn measure(&self, alone: &mut [Trial<'a>], base: &Model<'a>, scale: f64) {
        for trial in alone.iter_mut() {
            if let Some(model) = &trial.model {
                trial.gain = self.gain(base, model, scale);
            }
        }
        alone.sort_by(Trial::order);
    }

    /// The best trial of a stage as a model of its own, where it earns its place.
    fn accepted(&self, before: &Model<'a>, trials: &[Trial<'a>]) -> Result<Option<Model<'a>>> {
        let first = self.only_expected(before);
        let least = if first { self.settings.margin } else { margin(self) };
        let fitted = || trials.iter().filter(|t| t.excluded.is_none()).filter_map(|t| Some((t, t.model.as_ref()?)));
        let earns = |(trial, model): &(&Trial<'a>, &Model<'a>)| {
            trial.gain > least && self.significant(self.worth(before, model).1) && self.matters(before, model)
        };
        // What has to be there anyhow comes first, so that nothing else is taken for it.
        let certain = fitted().filter(|(trial, _)| self.certain(trial.entry)).find(earns);
        let Some((_, model)) = certain.or_else(|| fitted().next().filter(earns)) else { return Ok(None) };
        let structure = self.structure(&model.structure.effects)?;
        Ok(Some(Model { structure, fit: model.fit.clone() }))
    }

    /// Whether a gain is no chance. One throw in which something is expected leaves a choice at most, for which a clear gain
    /// of the information criterion does; so few independent values as a slow misfit has would never do for a name.
    fn significant(&self, p_value: f64) -> bool {
        self.expecting || p_value <= self.settings.significance
    }

    /// Whether an effect takes away enough to be worth a name where all that is left counts as noise.
    fn matters(&self, before: &Model, after: &Model) -> bool {
        let scale = after.scale();
        self.independent >= 1.0 || before.deviance(scale) >= WORTH * after.deviance(scale)
    }

    /// Gain of the information criterion and the probability of it by chance, all candidates counted.
    fn worth(&self, before: &Model, after: &Model) -> (f64, f64) {
        let scale = after.scale();
        let coefficients = after.structure.globals.len() - before.structure.globals.len();
        let gain = self.likelihood(before.deviance(scale), after.deviance(scale));
        let p = p_value(gain, coefficients) * self.catalogue.len() as f64;
        (self.gain(before, after, scale), p.min(1.0))
    }

    /// For each effect: what it is worth, and what explains as much in its place; or a better structure, one swapped or
    /// dropped.
    fn judge_places(&self, base: &Model<'a>, alone: &[Trial<'a>], model: &Model<'a>) -> Result<Judged<'a>> {
        let effects = model.structure.effects.clone();
        let mut places = Vec::new();
        for &entry in &effects {
            let others: Vec<usize> = effects.iter().copied().filter(|&e| e != entry).collect();
            let made;
            let (without, trials);
            if others.is_empty() {
                (without, trials) = (base, alone);
            } else {
                let fitted = self.fit_near(&others, model)?;
                let stage = self.stage(&fitted);
                made = (fitted, stage);
                (without, trials) = (&made.0, made.1.as_slice());
            }
            let (gain, p_value) = self.worth(without, model);
            let earned = gain >= self.settings.margin && self.significant(p_value) && self.matters(without, model);
            if !earned && !self.unasked(entry) {
                let fitted = if others.is_empty() { None } else { Some(self.fit_near(&others, model)?) };
                return Ok(Judged::Yields(fitted.map(Box::new)));
            }
            let others = confusable::others(self, without, model, entry, trials);
            let firm = |other: usize| self.certain(entry) && !self.certain(other);
            if let Some(better) = others.iter().find(|(other, gap)| *gap < -1.0 && !firm(*other))
                && effects.len() > 1
            {
                let found = trials.iter().find(|t| t.entry == better.0).and_then(|t| t.model.as_ref());
                if let Some(found) = found {
                    let structure = self.structure(&found.structure.effects)?;
                    return Ok(Judged::Yields(Some(Box::new(Model { structure, fit: found.fit.clone() }))));
                }
            }
            places.push(Place { entry, gain, p_value, others, equals: Vec::new() });
        }
        Ok(Judged::Stands(places))
    }
}
