//! A step of the selection: candidates fitted in addition to a hypothesis, and back-substitution. What a candidate gains only by
//! leading out of a local minimum is not its own, so the hypothesis is fitted again from the values that the candidate leads to.

use rayon::prelude::*;

use super::scale::{BRIEF, FINISH, left_of_noise};
use super::score::{Scored, score};
use crate::diagnose::hypothesis::candidate_scores::{CandidateFit, gain};
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::joint::Point;
use crate::diagnose::hypothesis::plausibility::{Exclusion, implausible};
use crate::diagnose::hypothesis::structure::Structure;

/// Candidates that are fitted, most promising first.
const FITTED: usize = 7;
/// The best of them that are fitted to the end, and from which the hypothesis is fitted again.
const FINISHED: usize = 2;
/// What is left is large where its root mean square is this many times the noise of the recordings.
const LARGE: f64 = 3.0;

/// A hypothesis, and every candidate in addition to it, best first.
pub(super) struct DiscrepancyStep<'a> {
    pub model: Hypothesis<'a>,
    pub candidates: Vec<CandidateFit<'a>>,
}

/// Fits the most promising candidates in addition to `model`; the model improves where a candidate leads it to.
pub(super) fn selection_step<'a>(context: &Context<'a>, model: Hypothesis<'a>) -> DiscrepancyStep<'a> {
    finish(context, brief_step(context, model, FITTED))
}

/// The best candidates of a step fitted to the end, and the hypothesis again from the values that they lead to.
pub(super) fn finish<'a>(context: &Context<'a>, step: DiscrepancyStep<'a>) -> DiscrepancyStep<'a> {
    let DiscrepancyStep { mut model, mut candidates } = step;
    order(context, &model, &mut candidates);
    let leading = candidates.iter().filter(|candidate| candidate.model.is_some()).take(FINISHED).count();
    candidates[..leading].par_iter_mut().for_each(|candidate| {
        let Some(near) = &candidate.model else { return };
        if let Ok(finished) = context.fit_near_with(&near.structure.effects, near, FINISH) {
            candidate.model = Some(finished);
        }
    });
    for candidate in &candidates[..leading] {
        let Some(found) = candidate.model.as_ref().and_then(|near| stripped(context, &model, near)) else { continue };
        if found.fit.cost < model.fit.cost {
            model = found;
        }
    }
    order(context, &model, &mut candidates);
    DiscrepancyStep { model, candidates }
}

/// The `most` most promising candidates in addition to `model`, fitted briefly.
pub(super) fn brief_step<'a>(context: &Context<'a>, model: Hypothesis<'a>, most: usize) -> DiscrepancyStep<'a> {
    let mut scored = score(context, &model);
    let base = model.structure.effects.is_empty();
    let large = left_of_noise(context, &model) > LARGE;
    if base && large {
        score_as_given(context, &model, &mut scored);
    }
    // Without any effect a linear prediction may be worth nothing, so that the first in rank are fitted however little they promise.
    let promising = scored.iter().filter(|one| one.has_start() && (base || one.predicted > 0.0)).take(most);
    let promising: Vec<&Scored> = promising.collect();
    let brief = |one: &&Scored| if large { fit_far(context, &model, one) } else { fit_near(context, &model, one) };
    let fitted: Vec<Option<Hypothesis>> = promising.par_iter().map(brief).collect();
    let mut candidates: Vec<CandidateFit> = scored.iter().map(unfitted).collect();
    for (one, fitted) in promising.iter().zip(fitted) {
        if let Some(candidate) = candidates.iter_mut().find(|candidate| candidate.entry == one.entry) {
            candidate.model = fitted;
        }
    }
    order(context, &model, &mut candidates);
    DiscrepancyStep { model, candidates }
}

/// Scores candidates at the values of the files as well: where something large is missing, the fit without it may be far from all that
/// is true.
fn score_as_given<'a>(context: &Context<'a>, model: &Hypothesis<'a>, scored: &mut [Scored]) {
    let given = model.structure.shared.iter().map(|shared| shared.parameter.value).collect();
    let point = Point { parameters: given, nuisances: model.fit.point.nuisances.clone() };
    let Ok(structure) = context.structure(&[]) else { return };
    let Ok(fit) = context.joint(&structure).evaluate(point) else { return };
    let before = model.deviance(model.scale());
    for mut one in score(context, &Hypothesis { structure, fit }) {
        one.predicted = context.criterion(before, one.left, one.start.len() as f64);
        let known = scored.iter_mut().find(|known| known.entry == one.entry);
        if let Some(known) = known.filter(|known| one.has_start() && one.predicted > known.predicted) {
            *known = one;
        }
    }
    scored.sort_by(|a, b| b.predicted.total_cmp(&a.predicted).then(a.entry.cmp(&b.entry)));
}

/// A candidate as it was scored.
fn unfitted<'a>(one: &Scored) -> CandidateFit<'a> {
    // What was not fitted is no better than nothing.
    let predicted = one.predicted;
    let mut candidate = CandidateFit::unfitted(one.entry, predicted.min(0.0));
    (candidate.predicted, candidate.excluded, candidate.span) = (predicted, one.excluded.clone(), one.span.clone());
    candidate
}

/// The candidate fitted briefly from where it was scored, by the derivatives of the hypothesis there: little is left, so that the step to
/// the start changes them little.
fn fit_near<'a>(context: &Context<'a>, model: &Hypothesis<'a>, one: &Scored) -> Option<Hypothesis<'a>> {
    let (structure, start) = start(context, model, (one, &one.at.parameters))?;
    let known = model.structure.shared.len();
    let fit = context.joint(&structure).fit_extended(start, (&one.at.columns, known), BRIEF).ok()?;
    Some(Hypothesis { structure, fit })
}

/// The candidate fitted briefly from where it was scored, and without other effects from the values of the files as well.
fn fit_far<'a>(context: &Context<'a>, model: &Hypothesis<'a>, one: &Scored) -> Option<Hypothesis<'a>> {
    let given: Vec<f64> = model.structure.shared.iter().map(|shared| shared.parameter.value).collect();
    let also = Some(&given).filter(|given| model.structure.effects.is_empty() && **given != one.at.parameters);
    let fitted = std::iter::once(&one.at.parameters).chain(also).filter_map(|at| {
        let (structure, start) = start(context, model, (one, at))?;
        let fit = context.joint(&structure).fit(start, BRIEF).ok()?;
        Some(Hypothesis { structure, fit })
    });
    fitted.min_by(|a, b| a.fit.cost.total_cmp(&b.fit.cost))
}

/// The structure of a candidate in addition to `model`, and where its fit begins: at these values of the parameters of the model.
fn start<'a>(
    context: &Context<'a>,
    model: &Hypothesis<'a>,
    (one, at): (&Scored, &[f64]),
) -> Option<(Structure<'a>, Point)> {
    let structure = context.structure(&[model.structure.effects.as_slice(), &[one.entry]].concat()).ok()?;
    let mut parameters = structure.carry(&model.structure, at);
    parameters[model.structure.shared.len()..].copy_from_slice(&one.start);
    Some((structure, Point { parameters, nuisances: model.fit.point.nuisances.clone() }))
}

/// The hypothesis `model`, fitted from the values of a candidate in addition to it, without the candidate's own effect.
fn stripped<'a>(context: &Context<'a>, model: &Hypothesis<'a>, near: &Hypothesis<'a>) -> Option<Hypothesis<'a>> {
    let structure = context.structure(&model.structure.effects).ok()?;
    let parameters = near.fit.point.parameters[..structure.shared.len()].to_vec();
    let start = Point { parameters, nuisances: near.fit.point.nuisances.clone() };
    let joint = context.joint(&structure);
    let brief = joint.fit(start, BRIEF).ok()?;
    let fit = if brief.cost < model.fit.cost { joint.fit(brief.point, FINISH).ok()? } else { brief };
    Some(Hypothesis { structure, fit })
}

/// Gains over `model` as it is fitted now, best first.
fn order<'a>(context: &Context<'a>, model: &Hypothesis<'a>, candidates: &mut [CandidateFit<'a>]) {
    for candidate in candidates.iter_mut() {
        // A fit that ends above the hypothesis itself sits in another local minimum, and says nothing.
        candidate.model = candidate.model.take().filter(|fitted| fitted.fit.cost <= model.fit.cost);
        if let Some(fitted) = &candidate.model {
            candidate.gain = gain(context, model, fitted, model.scale());
            candidate.excluded = implausible(context, fitted).map(Exclusion::Implausible);
        }
    }
    candidates.sort_by(|a, b| b.model.is_some().cmp(&a.model.is_some()).then(CandidateFit::order(a, b)));
}

#[cfg(test)]
mod tests {
    use super::super::null::fit_null;
    use super::super::scale::rescaled;
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};

    #[test]
    fn the_effect_that_is_missing_gains_most() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let step = selection_step(context, fit_null(context).unwrap());
            assert_eq!(step.candidates[0].entry, entry(context, "viscous_friction"));
            assert!(step.candidates[0].gain > context.settings.margin && step.model.structure.effects.is_empty());
        });
    }

    /// Derivatives of the hypothesis lead to the same fit as derivatives at the start, by fewer rollouts.
    #[test]
    fn a_near_fit_ends_where_a_far_one_does() {
        in_swings(&[(FRICTION, 0.02)], 3, 0, |context| {
            let (context, model) = rescaled(context, &fit_null(context).unwrap()).unwrap();
            let scored = score(&context, &model);
            let one = scored.iter().find(|one| one.entry == entry(&context, "viscous_friction")).unwrap();
            let value = |found: Option<Hypothesis>| found.unwrap().fit.point.parameters[1];
            let begin = context.rollouts.count();
            let near = value(fit_near(&context, &model, one));
            let between = context.rollouts.count();
            let far = value(fit_far(&context, &model, one));
            let (near, far) = ((near, between - begin), (far, context.rollouts.count() - between));
            assert!((near.0 - 0.02).abs() < 2e-3 && (far.0 - 0.02).abs() < 2e-3, "{near:?} {far:?}");
            assert!(near.1 < far.1, "{near:?} {far:?}");
        });
    }

    #[test]
    fn what_promises_nothing_has_no_start() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let model = fit_null(context).unwrap();
            for one in score(context, &model) {
                assert_eq!(one.has_start(), one.predicted.is_finite(), "{}", context.catalogue[one.entry].name);
            }
        });
    }
}
