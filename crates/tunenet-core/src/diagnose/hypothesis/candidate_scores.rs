//! Scores of every candidate by Frisch–Waugh projection (Frisch and Waugh 1933); the best are fitted jointly.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::Result;
use crate::diagnose::hypothesis::context::{COMPARED, Context, FULL, Hypothesis};
use crate::diagnose::hypothesis::joint::{Effort, Joint, Known, Point, Which};
use crate::diagnose::hypothesis::multistart::{best_shapes, first_samples_show_more, fit_from_first_samples};
use crate::diagnose::hypothesis::plausibility::{Exclusion, Influence, implausible, influence, refusal};
use crate::diagnose::hypothesis::structure::{SharedParameter, Structure};
use crate::diagnose::hypothesis::wording::done_already;
use crate::estimate::canonical_correlation::canonical_correlation;
use crate::estimate::huber::huber_cost;
use crate::estimate::jacobian::Columns;
use crate::estimate::projection::{Projector, orthonormal};
use crate::statistics::dot;

/// One step with derivatives that are known already.
const ONE_STEP: Effort = Effort { steps: 1, ..FULL };
const FEW_STEPS: Effort = Effort { steps: 5, derivatives: 3, ..COMPARED };
/// A few steps from derivatives that were measured at a point nearby.
const NEAR_STEPS: Effort = Effort { steps: 6, derivatives: 2, ..FEW_STEPS };
/// ... nor one of which parameters and start states can do all but this share (of squares).
pub(in crate::diagnose) const LEFT_OVER: f64 = 1e-6;
/// Of derivatives that share rollouts, which are off by a tenth at most, so large a share is left by none that parameters do.
pub(in crate::diagnose) const CLEARLY_LEFT: f64 = 0.05;
/// Candidates this far behind the best after one step, as a share of the gain and at least so many units, are not fitted.
const BEHIND_SHARE: f64 = 0.25;
const BEHIND: f64 = 30.0;
/// Most candidates that are fitted at once before the others are looked at again, and how often they are.
const FIRST: usize = 3;
const ROUNDS: usize = 4;
/// Candidates that share this much with the best (squared canonical correlation) are always fitted.
const ALIKE: f64 = 0.97;
/// A fit that keeps less than this share of the gain predicted has met something strongly bent, and is tried again from so
/// many times the typical size.
const KEPT: f64 = 0.9;
const LARGER: [f64; 2] = [6.0, 20.0];
/// Of free motions, derivatives of a fit that is compared are measured so many times at most.
const BENT: usize = 7;

/// One candidate of a selection step.
pub(in crate::diagnose) struct CandidateFit<'a> {
    /// Its position in the catalogue.
    pub entry: usize,
    /// Gain of the information criterion over the hypothesis of this step: of the joint fit, or as predicted.
    pub gain: f64,
    /// The same by the linear prediction.
    pub predicted: f64,
    /// The joint fit.
    pub model: Option<Hypothesis<'a>>,
    /// Why it cannot be the answer.
    pub excluded: Option<Exclusion>,
    /// Orthonormal projected columns, stacked.
    pub span: Vec<Vec<f64>>,
}

impl CandidateFit<'_> {
    /// A candidate that was fitted in another search.
    pub fn unfitted(entry: usize, gain: f64) -> Self {
        Self { entry, gain, predicted: gain, model: None, excluded: None, span: Vec::new() }
    }

    /// Best first, the excluded last.
    pub fn order(a: &Self, b: &Self) -> Ordering {
        a.excluded.is_some().cmp(&b.excluded.is_some()).then(b.gain.total_cmp(&a.gain)).then(a.entry.cmp(&b.entry))
    }
}

/// A candidate's columns.
struct Scored {
    entry: usize,
    columns: Vec<Columns>,
    span: Vec<Vec<f64>>,
    predicted: f64,
    /// What the linear prediction gains under the robust loss: less than `predicted` where residuals are far beyond noise.
    expected: f64,
    excluded: Option<Exclusion>,
    /// The values of its coefficients at which its columns are.
    start: Vec<f64>,
    /// Others at which fits may begin, where some only shape the effect.
    others: Vec<Vec<f64>>,
}

/// Every candidate in addition to `model`, best first. Those that were fitted `before` in addition to the same effects, with noise of another
/// size or correlation, are fitted from there, and from nowhere else unless that is no better than one step.
pub(in crate::diagnose) fn score_candidates<'a>(
    context: &Context<'a>,
    model: &Hypothesis<'a>,
    before: &[CandidateFit<'a>],
) -> Vec<CandidateFit<'a>> {
    let joint = context.joint(&model.structure);
    let (point, residuals) = (&model.fit.point, &model.fit.residuals);
    let base = joint.columns(point, residuals, Which::ALL);
    let entries: Vec<usize> =
        (0..context.catalogue.len()).filter(|&e| !model.has(e) && !context.catalogue[e].is_random_effect()).collect();
    let lengths: Vec<usize> = residuals.iter().map(Vec::len).collect();
    let projector = Projector::new(&base, &lengths, model.structure.shared.len());
    let mut left: Vec<f64> = residuals.concat();
    projector.project(&mut left);
    let scored: Vec<Scored> =
        entries.par_iter().map(|&entry| score(context, entry, model, &projector, &left)).collect();
    let mut candidates: Vec<CandidateFit> = scored
        .par_iter()
        .map(|one| {
            let mut candidate = CandidateFit {
                entry: one.entry,
                gain: one.predicted,
                predicted: one.predicted,
                model: None,
                excluded: one.excluded.clone(),
                span: one.span.clone(),
            };
            if candidate.excluded.is_none() && one.predicted > 0.0 {
                match (Extension { model, base: &base, scored: one }).fit(context, ONE_STEP) {
                    Ok(fitted) => {
                        candidate.gain = gain(context, model, &fitted, model.scale());
                        candidate.model = Some(fitted);
                    }
                    Err(error) => candidate.excluded = Some(Exclusion::refused(&error)),
                }
            }
            candidate
        })
        .collect();
    let fitted = |entry: usize| before.iter().find(|one| one.entry == entry).and_then(|one| one.model.as_ref());
    let fitted: Vec<Option<&Hypothesis>> = scored.iter().map(|one| fitted(one.entry)).collect();
    fit_best(context, &mut candidates, &fitted, |i| Extension { model, base: &base, scored: &scored[i] });
    if first_samples_show_more(context, model) {
        for (candidate, one) in candidates.iter_mut().zip(&scored) {
            if candidate.excluded.is_none() && !context.catalogue[one.entry].shared() && !one.start.is_empty() {
                let fitted = fit_from_first_samples(context, model, (one.entry, &one.start));
                let better = fitted.filter(|found| gain(context, model, found, model.scale()) > candidate.gain);
                take(context, candidate, model, better);
            }
        }
    }
    candidates.sort_by(CandidateFit::order);
    candidates
}

fn score(context: &Context<'_>, entry: usize, model: &Hypothesis, projector: &Projector, left: &[f64]) -> Scored {
    let (columns, span, none) = (Vec::new(), Vec::new(), f64::NEG_INFINITY);
    let (start, others) = (Vec::new(), Vec::new());
    let mut scored = Scored { entry, columns, span, predicted: none, expected: none, excluded: None, start, others };
    if let Err(error) = try_score(context, &mut scored, model, projector, left) {
        scored.excluded = Some(Exclusion::refused(&error));
    }
    scored
}

fn try_score(
    context: &Context<'_>,
    scored: &mut Scored,
    model: &Hypothesis,
    projector: &Projector,
    left: &[f64],
) -> Result<()> {
    let known = model.structure.shared.len();
    if model.structure.repeats(&context.catalogue[scored.entry]) {
        scored.excluded = Some(Exclusion::Redundant(done_already(context)));
        return Ok(());
    }
    let structure = context.structure(&[model.structure.effects.as_slice(), &[scored.entry]].concat())?;
    let joint = context.joint(&structure);
    let parameters = structure.carry(&model.structure, &model.fit.point.parameters);
    let mut point = Point { parameters, nuisances: model.fit.point.nuisances.clone() };
    let shapes = best_shapes(&joint, &model.fit.residuals, &point, known, projector, left);
    if let Some(best) = shapes.first() {
        point.parameters[known..].copy_from_slice(best);
    }
    scored.others = shapes.into_iter().skip(1).collect();
    scored.start = point.parameters[known..].to_vec();
    let own = |joint: &Joint| influence(context, scored.entry, (joint, &point, known), model, projector);
    let mut found = own(&joint);
    // Derivatives that share rollouts do not show whether parameters do all of it.
    if joint.separable && found.rest <= CLEARLY_LEFT * found.whole {
        found = own(&Joint { separable: false, ..joint });
    }
    let Influence { columns, projected, whole, rest, seen } = found;
    scored.columns = columns;
    if whole <= 0.0 {
        let refused = refusal(&joint, &point, known);
        scored.excluded = Some(refused.map_or(Exclusion::NoInfluence, |error| Exclusion::refused(&error)));
    } else if rest <= LEFT_OVER * whole {
        scored.excluded = Some(Exclusion::Redundant(done_already(context)));
    } else if !seen {
        scored.excluded = Some(Exclusion::BelowNoise);
    }
    scored.span = orthonormal(projected);
    let explained: f64 = scored.span.iter().map(|direction| dot(direction, left).powi(2)).sum();
    let before = model.deviance(model.scale());
    let coefficients = (structure.shared.len() - known) as f64;
    scored.predicted = context.criterion(before, (before - explained).max(1e-3 * before), coefficients);
    let mut rest = left.to_vec();
    for direction in &scored.span {
        let along = dot(direction, left);
        rest.iter_mut().zip(direction).for_each(|(rest, direction)| *rest -= along * direction);
    }
    let after = 2.0 * (huber_cost(&[rest], model.scale()) + model.fit.prior_part);
    scored.expected = context.criterion(before, after.max(1e-3 * before), coefficients);
    Ok(())
}

/// A hypothesis and one of its candidates, linearised about the fit of the hypothesis.
#[derive(Clone, Copy)]
struct Extension<'s, 'a> {
    model: &'s Hypothesis<'a>,
    /// Derivatives by the model's own parameters.
    base: &'s [Columns],
    scored: &'s Scored,
}

impl<'a> Extension<'_, 'a> {
    fn structure(&self, context: &Context<'a>) -> Result<Structure<'a>> {
        context.structure(&[self.model.structure.effects.as_slice(), &[self.scored.entry]].concat())
    }

    /// The joint fit from the values of the hypothesis, with the derivatives that are known: a step takes one rollout of each
    /// recording.
    fn fit(&self, context: &Context<'a>, effort: Effort) -> Result<Hypothesis<'a>> {
        let structure = self.structure(context)?;
        let point = self.with(self.scored.start.iter().copied());
        let first: Vec<Columns> =
            self.base.iter().zip(&self.scored.columns).map(|(base, new)| base.with(new)).collect();
        let fit = context.joint(&structure).fit_from(
            point,
            self.model.fit.residuals.clone(),
            effort,
            Some(Known::measured(&first)),
        )?;
        Ok(Hypothesis { structure, fit })
    }

    /// The values of the hypothesis with these of the candidate's coefficients, whose positions are the last.
    fn with(&self, coefficients: impl Iterator<Item = f64>) -> Point {
        let parameters = self.model.fit.point.parameters.iter().copied().chain(coefficients).collect();
        Point { parameters, nuisances: self.model.fit.point.nuisances.clone() }
    }

    /// The effort of a fit that is compared: of free motions, it ends where it stays far behind this gain.
    fn effort(&self, context: &Context, gain: f64) -> Effort {
        if !context.shows_free_motions() {
            return COMPARED;
        }
        let before = self.model.deviance(self.model.scale());
        let deviance = context.sum_of_squares(before, gain, self.scored.start.len() as f64);
        let derivatives = if self.scored.others.is_empty() { BENT } else { COMPARED.derivatives };
        Effort { derivatives, hopeless: 0.5 * deviance, ..COMPARED }
    }

    /// The joint fit from `start` with derivatives by the hypothesis's own parameters that are nearly known.
    fn fit_at(&self, context: &Context<'a>, start: Point, effort: Effort) -> Result<Hypothesis<'a>> {
        let structure = self.structure(context)?;
        let known = self.model.structure.shared.len();
        let fit = context.joint(&structure).fit_extended(start, (self.base, known), effort)?;
        Ok(Hypothesis { structure, fit })
    }
}

/// Fits the best jointly to the end, then others that may still overtake them, and those that do nearly the same as the
/// best; each from several starts where one does not keep what was predicted, or from where it was fitted `before`.
fn fit_best<'s, 'a: 's>(
    context: &Context<'a>,
    candidates: &mut [CandidateFit<'a>],
    before: &[Option<&Hypothesis<'a>>],
    extension: impl Fn(usize) -> Extension<'s, 'a> + Sync,
) {
    let mut done = vec![false; candidates.len()];
    for round in 0.. {
        let best = leader(candidates);
        let limit = best.map_or(0.0, |b| candidates[b].gain - BEHIND.max(BEHIND_SHARE * candidates[b].gain));
        // Slopes at absence may differ where the effects as they are do not: what is mistaken for the best of a mechanism is fitted too.
        let mistaken = |b: usize, i: usize| {
            let effect = |i: usize| &context.catalogue[candidates[i].entry].of[0];
            context.evidence.discrepancy() && effect(b).mistaken_for.contains(&effect(i).name)
        };
        let same = |b: usize, i: usize| canonical_correlation(&candidates[b].span, &candidates[i].span) > ALIKE;
        let alike = |i: usize| best.is_some_and(|b| done[b] && (same(b, i) || mistaken(b, i)));
        let hopeful = |i: &usize| {
            let one = &candidates[*i];
            let promising = one.gain.max(extension(*i).scored.expected.min(limit + BEHIND)) > limit;
            !done[*i] && one.excluded.is_none() && one.predicted > 0.0 && (promising || alike(*i))
        };
        let mut open: Vec<usize> = (0..candidates.len()).filter(hopeful).collect();
        open.sort_by(|a, b| candidates[*b].gain.total_cmp(&candidates[*a].gain));
        open.sort_by_key(|&i| !alike(i));
        open.truncate(FIRST);
        if open.is_empty() || round == ROUNDS {
            break;
        }
        let compared = |&i: &usize| {
            let extension = extension(i);
            let effort = extension.effort(context, if alike(i) { f64::NEG_INFINITY } else { limit });
            let near = before[i].and_then(|near| extension.fit_at(context, near.fit.point.clone(), effort).ok());
            let leads =
                |near: &Hypothesis| gain(context, extension.model, near, extension.model.scale()) >= candidates[i].gain;
            match near.filter(leads) {
                Some(near) => (Some(near), true),
                None => (extension.fit(context, effort).ok(), false),
            }
        };
        let fits: Vec<_> = open.par_iter().map(compared).collect();
        let mut tried = vec![false; candidates.len()];
        for (&i, (fitted, was_near)) in open.iter().zip(fits) {
            (done[i], tried[i]) = (true, was_near);
            take(context, &mut candidates[i], extension(i).model, fitted);
        }
        open.retain(|&i| !tried[i]);
        let shaped: Vec<usize> = open.iter().copied().filter(|&i| !extension(i).scored.others.is_empty()).collect();
        let fits: Vec<_> = shaped.par_iter().map(|&i| fit_from_shapes(context, &candidates[i], extension(i))).collect();
        for (&i, fitted) in shaped.iter().zip(fits) {
            take(context, &mut candidates[i], extension(i).model, fitted);
        }
        // What fell short of the prediction, and could still come near the best.
        let limit =
            leader(candidates).map_or(0.0, |b| candidates[b].gain - BEHIND.max(BEHIND_SHARE * candidates[b].gain));
        let expected = |i: &usize| extension(*i).scored.expected;
        // Of free motions, what stays at its bound is what larger coefficients would take away.
        let moved = |i: &usize| {
            let known = extension(*i).model.structure.shared.len();
            let fitted = candidates[*i].model.as_ref().map(|model| &model.fit.point.parameters[known..]);
            !context.shows_free_motions() || fitted.is_some_and(|fitted| fitted != extension(*i).scored.start)
        };
        open.retain(|i| expected(i) > limit && candidates[*i].gain <= KEPT * expected(i) && moved(i));
        open.sort_by(|a, b| expected(b).total_cmp(&expected(a)));
        open.truncate(if context.shows_free_motions() { 1 } else { FIRST });
        let fits: Vec<_> = open.par_iter().map(|&i| fit_from_larger(context, &candidates[i], extension(i))).collect();
        for (&i, fitted) in open.iter().zip(fits) {
            take(context, &mut candidates[i], extension(i).model, fitted);
        }
    }
    if let Some(best) = leader(candidates).filter(|_| context.shows_free_motions()) {
        let leading = candidates[best].model.as_ref();
        let mistaken = &context.catalogue[candidates[best].entry].of[0].mistaken_for;
        let is_mistaken = |&i: &usize| {
            let one = &candidates[i];
            let effect = &context.catalogue[one.entry].of[0].name;
            one.excluded.is_none() && mistaken.contains(effect) && extension(i).scored.others.is_empty()
        };
        let mistaken: Vec<usize> = (0..candidates.len()).filter(is_mistaken).collect();
        let from_leading = |&i: &usize| fit_from_leading(context, &candidates[i], leading?, extension(i));
        let fits: Vec<_> = mistaken.par_iter().map(from_leading).collect();
        for (&i, fitted) in mistaken.iter().zip(fits) {
            done[i] |= fitted.is_some();
            take(context, &mut candidates[i], extension(i).model, fitted);
        }
    }
    // What was not fitted to the end keeps what one step gained, and no model.
    for (candidate, done) in candidates.iter_mut().zip(done) {
        if !done {
            candidate.model = None;
        }
    }
}

/// A candidate as it was fitted, if it was.
fn take<'a>(
    context: &Context<'a>,
    candidate: &mut CandidateFit<'a>,
    model: &Hypothesis<'a>,
    fitted: Option<Hypothesis<'a>>,
) {
    let Some(fitted) = fitted else { return };
    candidate.gain = gain(context, model, &fitted, model.scale());
    candidate.excluded = implausible(context, &fitted).map(Exclusion::Implausible);
    candidate.model = Some(fitted);
}

/// The candidate that gains most so far.
fn leader(candidates: &[CandidateFit]) -> Option<usize> {
    let fitted = (0..candidates.len()).filter(|&i| candidates[i].excluded.is_none() && candidates[i].model.is_some());
    fitted.max_by(|a, b| candidates[*a].gain.total_cmp(&candidates[*b].gain))
}

/// From other values of the coefficients that only shape an effect. `None` where none leads farther than `candidate`.
fn fit_from_shapes<'a>(
    context: &Context<'a>,
    candidate: &CandidateFit<'a>,
    extension: Extension<'_, 'a>,
) -> Option<Hypothesis<'a>> {
    let model = extension.model;
    let mut best: Option<(f64, Hypothesis)> = None;
    for other in &extension.scored.others {
        let structure = extension.structure(context).ok()?;
        let start = extension.with(other.iter().copied());
        let tried = if context.shows_free_motions() {
            extension.fit_at(context, start, NEAR_STEPS)
        } else {
            context.joint(&structure).fit(start, FEW_STEPS).map(|fit| Hypothesis { structure, fit })
        };
        let Ok(tried) = tried else { continue };
        let reached = gain(context, model, &tried, model.scale());
        if best.as_ref().is_none_or(|(most, _)| reached > *most) {
            best = Some((reached, tried));
        }
    }
    let hopeful =
        |(reached, _): &(f64, Hypothesis)| !context.shows_free_motions() || *reached > candidate.gain - BEHIND;
    let (_, tried) = best.filter(hopeful)?;
    let fit = context.joint(&tried.structure).fit(tried.fit.point, COMPARED).ok()?;
    let found = Hypothesis { structure: tried.structure, fit };
    (gain(context, model, &found, model.scale()) > candidate.gain).then_some(found)
}

/// From larger coefficients than those to which one step leads: friction that grips is not reached from friction that hardly
/// is. `None` where that is no better than `candidate`.
fn fit_from_larger<'a>(
    context: &Context<'a>,
    candidate: &CandidateFit<'a>,
    extension: Extension<'_, 'a>,
) -> Option<Hypothesis<'a>> {
    let (model, near) = (extension.model, candidate.model.as_ref()?);
    let mut best: Option<Hypothesis> = None;
    for size in LARGER {
        let larger = |((shared, value), start): ((&SharedParameter, &f64), &f64)| {
            if shared.shape {
                return *start;
            }
            let (absent, typical) = shared.absent.unwrap_or((0.0, 0.0));
            let side = if *value < absent { -1.0 } else { 1.0 };
            (absent + size * typical * side).clamp(shared.parameter.min, shared.parameter.max)
        };
        let fitted = near.structure.shared.iter().zip(&near.fit.point.parameters).skip(model.structure.shared.len());
        let start = extension.with(fitted.zip(&extension.scored.start).map(larger));
        // A few steps show whether this local minimum is a better one.
        let Ok(tried) = extension.fit_at(context, start, NEAR_STEPS) else { continue };
        let reached = best.as_ref().map_or(candidate.gain, |best| gain(context, model, best, model.scale()));
        if gain(context, model, &tried, model.scale()) > reached {
            let fit = context.joint(&tried.structure).fit(tried.fit.point, COMPARED).ok()?;
            best = Some(Hypothesis { structure: tried.structure, fit });
        }
    }
    best
}

/// From larger coefficients of an effect for which the `leading` one can be mistaken, with the other values that this one has: an effect
/// that saturates, as friction that grips, has no slope there, and a fit from small coefficients ends at other values. `None` where that is no
/// better than `candidate`.
fn fit_from_leading<'a>(
    context: &Context<'a>,
    candidate: &CandidateFit<'a>,
    leading: &Hypothesis<'a>,
    extension: Extension<'_, 'a>,
) -> Option<Hypothesis<'a>> {
    let (model, known) = (extension.model, extension.model.structure.shared.len());
    let (structure, scale) = (extension.structure(context).ok()?, model.scale());
    let joint = context.joint(&structure);
    let starts = LARGER.iter().filter_map(|size| {
        let larger = |shared: &SharedParameter| {
            let (absent, typical) = shared.absent.unwrap_or((0.0, 0.0));
            (absent + size * typical).clamp(shared.parameter.min, shared.parameter.max)
        };
        let own = leading.fit.point.parameters[..known].iter().copied();
        let parameters = own.chain(structure.shared[known..].iter().map(larger)).collect();
        let start = Point { parameters, nuisances: leading.fit.point.nuisances.clone() };
        let deviance = 2.0 * (huber_cost(&joint.residuals(&start, 1.0).ok()?, scale) + leading.fit.prior_part);
        let coefficients = (structure.shared.len() - known) as f64;
        Some((context.criterion(model.deviance(scale), deviance, coefficients), start))
    });
    let (reached, start) = starts.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let fitted = if reached > candidate.gain { joint.fit(start, COMPARED).ok()? } else { return None };
    let found = Hypothesis { structure, fit: fitted };
    (gain(context, model, &found, scale) > candidate.gain).then_some(found)
}

/// Gain of the information criterion from `before` to `after`, losses changing over at 4 times `scale`.
pub(in crate::diagnose) fn gain(context: &Context<'_>, before: &Hypothesis, after: &Hypothesis, scale: f64) -> f64 {
    let coefficients = after.structure.shared.len() as f64 - before.structure.shared.len() as f64;
    context.criterion(before.deviance(scale), after.deviance(scale), coefficients)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};

    #[test]
    fn the_missing_effect_leads_and_what_changes_nothing_new_is_excluded() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let candidates = score_candidates(context, &base, &[]);
            assert_eq!(context.catalogue[candidates[0].entry].name, "viscous_friction");
            assert!(candidates[0].gain > 100.0 && candidates[0].model.is_some(), "{}", candidates[0].gain);
            // Another unit of the angle is another start.
            let scale = candidates.iter().find(|c| c.entry == entry(context, "length_scale")).unwrap();
            assert!(scale.excluded.is_some());
            assert!(candidates.is_sorted_by(|a, b| CandidateFit::order(a, b).is_le()));
        });
    }
}
