//! Which effects: forward, the best one at a time, pruned, and what could stand in the place of each.

use super::fit::{Fitted, Normal};
use super::logs::{Logs, Place};
use crate::Result;
use crate::diagnose::hypothesis::information_criterion::{bic_gain, likelihood_gain, p_value};
use crate::diagnose::input::Settings;

/// Fits by which the weights settle.
const WEIGHINGS: usize = 2;
/// Candidates that are fitted to the end at each stage ...
const FITTED: usize = 4;
/// ... of those that are predicted to lie within this of the best: a share of the gain, or so much.
const BEHIND_SHARE: f64 = 0.3;
const BEHIND: f64 = 30.0;
/// Residuals that remember beyond this many values are taken for that.
const MOST_LAGS: usize = 60;
const FORGOTTEN: f64 = 0.05;

/// One candidate beside a model.
pub(super) struct Trial {
    pub entry: usize,
    /// Gain of the criterion: of the fit where there is one, or as the derivatives predict.
    pub gain: f64,
    pub fit: Option<Fitted>,
    /// Twice the gain in logarithmic likelihood.
    pub likelihood: f64,
    pub excluded: Option<String>,
}

/// An effect of the answer.
pub(super) struct Stood {
    pub entry: usize,
    /// What the criterion loses without it.
    pub gain: f64,
    pub p_value: f64,
    /// What could stand in its place, best first, with how far behind it stays.
    pub others: Vec<(usize, f64)>,
}

impl Stood {
    /// What could stand in its place without staying `margin` behind.
    pub fn near(&self, margin: f64) -> impl Iterator<Item = usize> + '_ {
        self.others.iter().filter(move |(_, behind)| *behind < margin).map(|(entry, _)| *entry)
    }

    /// Whether it could as well be something else.
    pub fn doubtful(&self, margin: f64) -> bool {
        self.near(margin).next().is_some()
    }
}

/// What the search found.
pub(super) struct Chosen {
    pub base: Fitted,
    pub best: Fitted,
    pub effects: Vec<Stood>,
    /// Every candidate alone.
    pub alone: Vec<Trial>,
}

impl Logs<'_> {
    /// Weighs channels by what the richest model leaves, where that exceeds the noise, and finds how much of it is independent.
    pub fn weigh(&mut self, base: &Fitted) -> Result<()> {
        for _ in 0..WEIGHINGS {
            let places: Vec<Place> =
                self.tunable().into_iter().chain((0..self.entries.len()).flat_map(|e| self.places(e))).collect();
            let residuals = self.residuals(&base.point)?;
            let columns = self.columns(&base.point, &places)?;
            let normal = Normal::new(&places, &columns, &residuals);
            let (steps, _) = normal.solve(&(0..places.len()).collect::<Vec<_>>());
            let mut left = residuals;
            for (column, step) in columns.iter().zip(&steps).filter(|(_, s)| **s != 0.0) {
                left.iter_mut().zip(column).for_each(|(l, c)| *l -= step * c);
            }
            let width = self.runs[0].width();
            let unknowns = places.len() as f64 / width as f64;
            let mut sums = vec![(0.0, 0.0); width];
            let mut offset = 0;
            for run in self.fitted() {
                for (i, value) in left[offset..offset + run.prepared.seen.values().len()].iter().enumerate() {
                    sums[i % width].0 += (value * run.weight[i % width]).powi(2);
                    sums[i % width].1 += 1.0;
                }
                offset += run.prepared.seen.values().len();
            }
            let spread: Vec<f64> = sums.iter().map(|(s, n)| (s / (n - unknowns).max(1.0)).sqrt()).collect();
            self.independent = independent(self, &left);
            for run in &mut self.runs {
                run.weight = run.noise.iter().zip(&spread).map(|(n, s)| n.max(*s)).collect();
            }
        }
        Ok(())
    }

    pub fn likelihood(&self, before: f64, after: f64) -> f64 {
        self.independent * likelihood_gain(self.count(), before, after)
    }

    /// Fall of the criterion by so many more coefficients.
    pub fn criterion(&self, before: f64, after: f64, coefficients: f64) -> f64 {
        bic_gain(self.likelihood(before, after), self.independent * self.count() as f64, coefficients)
    }

    /// The coefficients of an effect that count: those of which the recordings say something.
    fn worth(&self, normal: &Normal, entry: usize) -> usize {
        normal.at(&self.places(entry)).iter().filter(|&&i| normal.products[(i, i)] > 0.0).count().max(1)
    }

    /// Every effect that `model` lacks, beside it, best first, the excluded last.
    fn stage(&self, model: &Fitted, effects: &[usize]) -> Result<Vec<Trial>> {
        let others: Vec<usize> = (0..self.entries.len()).filter(|e| !effects.contains(e)).collect();
        let mut places = model.active.clone();
        places.extend(others.iter().flat_map(|&e| self.places(e)));
        let normal = Normal::new(&places, &self.columns(&model.point, &places)?, &model.residuals);
        let mut trials: Vec<Trial> = others
            .iter()
            .map(|&entry| {
                let mine = self.places(entry);
                let seen = normal.at(&mine).iter().any(|&i| normal.products[(i, i)] > 0.0);
                let (_, gain) = normal.solve(&normal.at(&[model.active.as_slice(), &mine].concat()));
                let after = (model.square - gain).max(1e-3 * model.square);
                let excluded = (!seen).then(|| "these recordings do not depend on it".to_owned());
                let gain = self.criterion(model.square, after, self.worth(&normal, entry) as f64);
                Trial { entry, gain, fit: None, likelihood: self.likelihood(model.square, after), excluded }
            })
            .collect();
        trials.sort_by(|a, b| a.excluded.is_some().cmp(&b.excluded.is_some()).then(b.gain.total_cmp(&a.gain)));
        let best = trials.first().map_or(0.0, |t| t.gain);
        let least = (best - BEHIND.max(BEHIND_SHARE * best)).max(0.0);
        let hopeful = trials.iter_mut().filter(|t| t.excluded.is_none() && t.gain > least).take(FITTED);
        hopeful.for_each(|trial| self.fit_trial(trial, model, &normal));
        // Where those do not keep what they promised, or cannot be believed, the next in line has its turn.
        loop {
            trials.sort_by(|a, b| a.excluded.is_some().cmp(&b.excluded.is_some()).then(b.gain.total_cmp(&a.gain)));
            let leader = trials.first_mut().filter(|t| t.excluded.is_none() && t.fit.is_none() && t.gain > 0.0);
            let Some(leader) = leader else { break };
            self.fit_trial(leader, model, &normal);
        }
        Ok(trials)
    }

    /// Fits what was only predicted of an effect beside `model`.
    fn fit_trial(&self, trial: &mut Trial, model: &Fitted, normal: &Normal) {
        let active = [model.active.as_slice(), &self.places(trial.entry)].concat();
        match self.fit_from(&model.point, &active, Some(normal)) {
            Ok(fit) => {
                trial.likelihood = self.likelihood(model.square, fit.square);
                trial.gain = self.criterion(model.square, fit.square, self.worth(normal, trial.entry) as f64);
                trial.excluded = self.unbelievable(&fit, trial.entry);
                trial.fit = Some(fit);
            }
            Err(error) => trial.excluded = Some(format!("it cannot be simulated here: {error}")),
        }
    }

    /// Why an effect's numbers cannot be believed: each that matters lies far outside what is physical.
    fn unbelievable(&self, fit: &Fitted, entry: usize) -> Option<String> {
        let one = &self.entries[entry];
        for (object, i) in self.places(entry) {
            let (low, high) = one.effect.plausible[i - one.first];
            let value = fit.point[object][i];
            if value < low - 0.2 * (high - low) || value > high + 0.2 * (high - low) {
                let name = &self.parameter((object, i)).name;
                return Some(format!("`{name}` would be {value:.3e}, outside {low} to {high}"));
            }
        }
        None
    }
}

/// The share of coloured values that counts as independent: 1 / (1 + 2 Σ ρ) over lags until the residual has forgotten.
fn independent(logs: &Logs, left: &[f64]) -> f64 {
    let mut sum = 0.0;
    for lag in 1..=MOST_LAGS {
        let (mut product, mut square, mut offset) = (0.0, 0.0, 0);
        for run in logs.fitted() {
            let (width, size) = (run.width(), run.prepared.seen.values().len());
            let values = &left[offset..offset + size];
            for i in lag * width..size {
                product += values[i] * values[i - lag * width];
            }
            square += values.iter().map(|v| v * v).sum::<f64>() * (1.0 - (lag * width) as f64 / size as f64).max(0.0);
            offset += size;
        }
        let rho = if square > 0.0 { product / square } else { 0.0 };
        if rho < FORGOTTEN {
            break;
        }
        sum += rho;
    }
    1.0 / (1.0 + 2.0 * sum)
}

impl Chosen {
    /// Searches beside `base`, the simulation tuned without any effect.
    pub fn search(logs: &Logs, base: Fitted, settings: &Settings) -> Result<Self> {
        let (mut best, mut effects): (Fitted, Vec<usize>) = (base.clone(), Vec::new());
        let mut alone = Vec::new();
        let candidates = logs.entries.len().max(1) as f64;
        for round in 0..settings.most_effects {
            let trials = logs.stage(&best, &effects)?;
            let leader = trials.first().filter(|t| {
                let chance = p_value(t.likelihood, logs.places(t.entry).len()) * candidates;
                t.excluded.is_none() && t.gain > settings.margin && chance < settings.significance
            });
            let next = leader.and_then(|t| Some((t.entry, t.fit.clone()?)));
            if round == 0 {
                alone = trials;
            }
            let Some((entry, fit)) = next else { break };
            effects.push(entry);
            best = fit;
        }
        // What a later effect has made needless goes.
        loop {
            let mut worst: Option<(f64, usize, Fitted)> = None;
            for (position, &entry) in effects.iter().enumerate().filter(|_| effects.len() > 1) {
                let without = without(logs, &best, &[entry])?;
                let gain = logs.criterion(without.square, best.square, logs.places(entry).len() as f64);
                if gain < settings.margin && worst.as_ref().is_none_or(|w| gain < w.0) {
                    worst = Some((gain, position, without));
                }
            }
            let Some((_, position, fit)) = worst else { break };
            effects.remove(position);
            best = fit;
        }
        let effects = effects.iter().map(|&e| stood(logs, &best, &effects, e)).collect::<Result<Vec<_>>>()?;
        Ok(Self { base, best, effects, alone })
    }
}

/// The model without these effects, fitted anew.
pub(super) fn without(logs: &Logs, model: &Fitted, entries: &[usize]) -> Result<Fitted> {
    let gone: Vec<Place> = entries.iter().flat_map(|&e| logs.places(e)).collect();
    let mut point = model.point.clone();
    for &(object, i) in &gone {
        point[object][i] = logs.parameter((object, i)).value;
    }
    let active: Vec<Place> = model.active.iter().copied().filter(|p| !gone.contains(p)).collect();
    logs.fit_from(&point, &active, None)
}

/// How `entry` stands among the `effects` of `best`.
fn stood(logs: &Logs, best: &Fitted, effects: &[usize], entry: usize) -> Result<Stood> {
    let candidates = logs.entries.len().max(1) as f64;
    let coefficients = logs.places(entry).len();
    let without = without(logs, best, &[entry])?;
    let gain = logs.criterion(without.square, best.square, coefficients as f64);
    let p = (p_value(logs.likelihood(without.square, best.square), coefficients) * candidates).min(1.0);
    let instead: Vec<usize> = effects.iter().copied().filter(|e| *e != entry).collect();
    let mut others: Vec<(usize, f64)> = logs
        .stage(&without, &instead)?
        .into_iter()
        .filter(|t| t.entry != entry && t.excluded.is_none() && t.gain > 0.0)
        .map(|t| (t.entry, gain - t.gain))
        .collect();
    others.sort_by(|a, b| a.1.total_cmp(&b.1));
    Ok(Stood { entry, gain, p_value: p, others })
}
