//! Forward selection with swaps and backward elimination by the Bayesian information criterion (Schwarz 1978).

use crate::diagnose::Progress;
use crate::diagnose::hypothesis::candidate_scores::CandidateFit;
use crate::diagnose::hypothesis::candidate_scores::{gain, score_candidates};
use crate::diagnose::hypothesis::confusable_set;
use crate::diagnose::hypothesis::context::{COMPARED, Context, Hypothesis, SINGLE_MOTION_MARGIN};
use crate::diagnose::hypothesis::plausibility::{OutOfRange, is_required};
use crate::diagnose::hypothesis::plausibility::{holds_only_required, needs_no_evidence, required_model};
use crate::diagnose::hypothesis::structure::SharedParameter;
use crate::estimate::information_criterion::p_value;
use crate::{Error, Result};

/// A swap may open the way to another; each is better than the one before.
const MOST_SWAPS: usize = 6;

/// Each of several effects has to gain this many times what a single one has to: a second effect takes up what the first leaves of
/// outliers and of autocorrelated noise.
const ONE_OF_SEVERAL: f64 = 2.0;

/// What gains a smaller share than this of what effects do is the same simulation without them.
const SAME: f64 = 0.01;

/// If the lag-1 correlation of the noise falls by this much, a search finds effects that it did not find before.
const HIDDEN: f64 = 0.3;

/// An effect has to reduce the mean square by this factor to be worth a name.
const WORTH: f64 = 1.3;

/// What the search found.
pub(in crate::diagnose) struct Selection<'a> {
    /// The simulation without any effect.
    pub base: Hypothesis<'a>,
    /// Candidates in addition to it, each alone, best first.
    pub alone: Vec<CandidateFit<'a>>,
    /// The best structure; `None` where no effect gains enough.
    pub best: Option<Hypothesis<'a>>,
    /// For each effect of the best: its gain, and what else could be in its place.
    pub selected: Vec<SelectedEffect>,
}

impl<'a> Selection<'a> {
    /// Before any search: the simulation as it was tuned.
    pub fn tuned(base: Hypothesis<'a>) -> Self {
        Self { base, alone: Vec::new(), best: None, selected: Vec::new() }
    }

    /// The same with `tuned` as the simulation without effects, and gains over it.
    pub fn over(mut self, context: &Context, tuned: Hypothesis<'a>) -> Self {
        let scale = self.best.as_ref().map_or(tuned.scale(), Hypothesis::scale);
        let less = gain(context, &self.base, &tuned, scale);
        self.alone.iter_mut().for_each(|one| one.gain -= less);
        if let [one] = self.selected.as_mut_slice() {
            one.gain -= less;
        }
        Self { base: tuned, ..self }
    }
}

/// A step of the selection: a hypothesis with every candidate in addition to it.
struct SelectionStep<'a> {
    model: Hypothesis<'a>,
    candidates: Vec<CandidateFit<'a>>,
}

impl<'a> SelectionStep<'a> {
    /// The step of these effects among `known`. If there is none, it is fitted from the values of `near` and added there.
    fn of<'s>(
        context: &Context<'a>,
        known: &'s mut Vec<Self>,
        effects: &[usize],
        near: &Hypothesis<'a>,
    ) -> Result<&'s Self> {
        let same = |step: &Self| {
            let of = &step.model.structure.effects;
            of.len() == effects.len() && effects.iter().all(|entry| of.contains(entry))
        };
        if let Some(position) = known.iter().position(same) {
            return Ok(&known[position]);
        }
        let model = context.fit_near(effects, near)?;
        let candidates = score_candidates(context, &model, &[]);
        known.push(Self { model, candidates });
        Ok(&known[known.len() - 1])
    }
}

/// What becomes of a hypothesis whose effects are judged one by one.
enum Revision<'a> {
    /// Every effect gains enough.
    Retained(Vec<SelectedEffect>),
    /// This one is better; `None` is the simulation without any effect.
    Replaced(Option<Box<Hypothesis<'a>>>),
}

/// An effect whose worth was not looked at: it has none.
fn unjudged(entry: usize) -> SelectedEffect {
    SelectedEffect { entry, gain: 0.0, p_value: 1.0, others: Vec::new(), equals: Vec::new(), excluded: None }
}

/// One effect of the best structure.
#[derive(Clone)]
pub(in crate::diagnose) struct SelectedEffect {
    /// Position in the catalogue.
    pub entry: usize,
    /// Gain by having it in addition to the others.
    pub gain: f64,
    /// Probability of that by chance, all candidates counted.
    pub p_value: f64,
    /// Others in its place with how far they fall behind, nearest first; exact twins included.
    pub others: Vec<(usize, f64)>,
    /// Those among them that do as well on recordings that were not fitted, whatever their distance.
    pub equals: Vec<usize>,
    /// What would explain far more in its place, with a coefficient that is not physical.
    pub excluded: Option<OutOfRange>,
}

/// Whether what a hypothesis leaves looks like noise.
pub(in crate::diagnose) type IsAdequate = fn(&Context, &Hypothesis) -> bool;

/// With the effects in, the noise shows more clearly; where it differs from what was taken for it, the search is repeated. It is not
/// repeated if the effects are inadequate with both noise models, unless the first one hid much.
pub(in crate::diagnose) fn search_again<'a>(
    context: Context<'a>,
    found: Selection<'a>,
    is_adequate: IsAdequate,
    progress: &dyn Fn(Progress),
) -> Result<(Context<'a>, Selection<'a>)> {
    let Some(best) = &found.best else { return Ok((context, found)) };
    let Some(evidence) = context.learn_noise(best)? else { return Ok((context, found)) };
    let hidden = context.evidence.noise.lag1() - evidence.noise.lag1();
    let learned = context.with_evidence(evidence);
    if context.shows_free_motions() && hidden < HIDDEN && !is_adequate(&context, best) {
        let best = learned.fit_near_with(&best.structure.effects, best, COMPARED)?;
        if !is_adequate(&learned, &best) {
            return Ok((context, found));
        }
    }
    let base = learned.fit_near(&[], &found.base)?;
    let near = known_base(&learned, &base, &found.base, best)?;
    let before = if context.shows_free_motions() && hidden < HIDDEN { found.alone.as_slice() } else { &[] };
    let found = search_near(&learned, near, before, is_adequate, progress)?.over(&learned, base);
    Ok((learned, found))
}

/// The simulation without any effect from which a second search begins. Of free motions it keeps the values from `before`, about which rollouts
/// are known, unless the `tuned` values gain more than a small share of what the effects of `best` do.
pub(in crate::diagnose) fn known_base<'a>(
    context: &Context<'a>,
    tuned: &Hypothesis<'a>,
    before: &Hypothesis<'a>,
    best: &Hypothesis<'a>,
) -> Result<Hypothesis<'a>> {
    if context.shows_free_motions() {
        let (kept, best) = (context.evaluated(before)?, context.evaluated(best)?);
        if gain(context, &kept, tuned, best.scale()) < SAME * gain(context, &kept, &best, best.scale()) {
            return Ok(kept);
        }
    }
    tuned.again(context)
}

/// Candidates are scored in addition to `model`.
pub(in crate::diagnose) fn scoring<'p>(context: &Context, model: &Hypothesis) -> Progress<'p> {
    let effects = model.structure.effects.len();
    let candidates = context.catalogue.len() - effects;
    Progress::Scoring { candidates, effects, rollouts: context.rollouts.count(), left: model.scale() }
}

/// Searches from the tuned simulation.
pub(in crate::diagnose) fn search<'a>(
    context: &Context<'a>,
    base: Hypothesis<'a>,
    is_adequate: IsAdequate,
    progress: &dyn Fn(Progress),
) -> Result<Selection<'a>> {
    search_near(context, base, &[], is_adequate, progress)
}

/// The same, where candidates alone were fitted `before` with noise of another size.
pub(in crate::diagnose) fn search_near<'a>(
    context: &Context<'a>,
    base: Hypothesis<'a>,
    before: &[CandidateFit<'a>],
    is_adequate: IsAdequate,
    progress: &dyn Fn(Progress),
) -> Result<Selection<'a>> {
    context.rollouts.trim();
    progress(scoring(context, &base));
    let mut alone = score_candidates(context, &base, before);
    let mut best = match required_model(context, &base)? {
        Some(expected) => Some(expected),
        None => accepted(context, &base, &alone)?,
    };
    let mut steps = Vec::new();
    while let Some(model) = best.take_if(|model| model.structure.effects.len() < most_effects(context, model)) {
        progress(scoring(context, &model));
        let candidates = score_candidates(context, &model, &[]);
        let Some(more) = accepted(context, &model, &candidates)? else {
            best = Some(model);
            break;
        };
        steps.push(SelectionStep { model, candidates });
        best = Some(more);
    }
    if let Some(better) = best.as_ref().map(|model| surpassing(context, &alone, model)).transpose()?.flatten() {
        best = Some(better);
    }
    let mut selected = Vec::new();
    for _ in 0..MOST_SWAPS {
        let Some(model) = best.take() else { break };
        // With all that may be added and still no fit, there is nothing to compare with.
        let full = model.structure.effects.len() >= context.settings.most_effects.max(2);
        if full && context.effective_fraction() >= 1.0 && !is_adequate(context, &model) {
            best = Some(model);
            break;
        }
        match judge_selected(context, (&base, &alone), &mut steps, &model)? {
            Revision::Retained(found) => {
                (best, selected) = (Some(model), found);
                break;
            }
            Revision::Replaced(other) => best = other.map(|model| *model),
        }
    }
    // Candidates were fitted only to be compared; the answer needs measured derivatives.
    best = best.map(|model| context.fit_near(&model.structure.effects, &model)).transpose()?;
    if let (Some(model), true) = (&best, selected.is_empty()) {
        selected = model.structure.effects.iter().map(|&e| unjudged(e)).collect();
    }
    if let Some(model) = &best {
        measure_alike(context, &mut alone, &base, model.scale());
        if let (Some(first), true) = (selected.first_mut(), model.structure.effects.len() > 1) {
            let whole = confusable_set::excluded_rival(context, &base, model, &alone);
            first.excluded = first.excluded.take().or(whole);
        }
    }
    Ok(Selection { base, alone, best, selected })
}

/// The effect that explains far more than required effects, if these are all that was found. Nothing was added to them because with it
/// their coefficients would not be physical or its gain would be too small; they are present, but they need not be what is seen.
fn surpassing<'a>(
    context: &Context<'a>,
    alone: &[CandidateFit<'a>],
    model: &Hypothesis<'a>,
) -> Result<Option<Hypothesis<'a>>> {
    let effects = &model.structure.effects;
    if context.required_first || !effects.iter().all(|&entry| is_required(context, entry)) {
        return Ok(None);
    }
    let far = SINGLE_MOTION_MARGIN * context.settings.margin;
    let mut others = alone.iter().filter(|other| other.excluded.is_none() && !effects.contains(&other.entry));
    let found = others.find_map(|other| other.model.as_ref());
    let ahead = |other: &&Hypothesis<'a>| gain(context, model, other, model.scale()) > far;
    found.filter(ahead).map(|other| other.again(context)).transpose()
}

/// How many effects a structure like `model` may have. A single motion shows one at most in addition to what has to be
/// there: more would fit anything.
fn most_effects(context: &Context<'_>, model: &Hypothesis) -> usize {
    let certain = model.structure.effects.iter().filter(|&&entry| is_required(context, entry)).count();
    let most = if context.evidence.shows_one_motion() { certain + 1 } else { context.settings.most_effects };
    most.min(context.settings.most_effects)
}

/// Gains of candidates over the simulation without any, all measured as that of the best structure is.
fn measure_alike<'a>(context: &Context<'a>, alone: &mut [CandidateFit<'a>], base: &Hypothesis<'a>, scale: f64) {
    for candidate in alone.iter_mut() {
        if let Some(model) = &candidate.model {
            candidate.gain = gain(context, base, model, scale);
        }
    }
    alone.sort_by(CandidateFit::order);
}

/// The best of the `candidates` in addition to `before`, as a hypothesis of its own; `None` where it does not gain enough.
fn accepted<'a>(
    context: &Context<'a>,
    before: &Hypothesis<'a>,
    candidates: &[CandidateFit<'a>],
) -> Result<Option<Hypothesis<'a>>> {
    let first = holds_only_required(context, before);
    let least = if first { context.settings.margin } else { context.margin().max(least_gain(context, 2)) };
    let fitted = || candidates.iter().filter(|c| c.excluded.is_none()).filter_map(|c| Some((c, c.model.as_ref()?)));
    let earns = |(candidate, model): &(&CandidateFit<'a>, &Hypothesis<'a>)| {
        candidate.gain > least
            && is_significant(context, worth(context, before, model).1)
            && is_material(context, before, model)
    };
    // What has to be there in any case comes first, so that nothing else is taken for it.
    let certain = fitted().filter(|(candidate, _)| is_required(context, candidate.entry)).find(earns);
    let Some((_, model)) = certain.or_else(|| fitted().next().filter(earns)) else { return Ok(None) };
    model.again(context).map(Some)
}

/// What each of so many effects has to gain.
fn least_gain(context: &Context<'_>, effects: usize) -> f64 {
    context.settings.margin * if effects > 1 { ONE_OF_SEVERAL } else { 1.0 }
}

/// Whether a gain is no chance. One motion in which something is expected leaves a choice at most, for which a clear gain
/// of the information criterion does; so few independent values as a slow misfit has would never do for a name.
fn is_significant(context: &Context<'_>, p_value: f64) -> bool {
    context.required_first || p_value <= context.settings.significance
}

/// Whether an effect takes away enough to be worth a name where all that is left counts as noise.
fn is_material(context: &Context<'_>, before: &Hypothesis, after: &Hypothesis) -> bool {
    let scale = after.scale();
    context.effective_fraction() >= 1.0 || before.deviance(scale) >= WORTH * after.deviance(scale)
}

/// Whether every coefficient of an effect is within twice its standard deviation of its absence.
fn is_idle(model: &Hypothesis, entry: usize) -> bool {
    let effects = &model.structure.effects;
    let is_size = |shared: &SharedParameter| !shared.shape && shared.effect.is_some_and(|(of, _)| effects[of] == entry);
    let mut sizes = model.structure.shared.iter().enumerate().filter(|(_, shared)| is_size(shared));
    sizes.all(|(column, shared)| {
        let way = model.fit.point.parameters[column] - shared.absent.map_or(0.0, |(absent, _)| absent);
        way * way <= 4.0 * model.fit.covariance[(column, column)]
    })
}

/// Gain of the information criterion and the probability of it by chance, all candidates counted.
fn worth(context: &Context<'_>, before: &Hypothesis, after: &Hypothesis) -> (f64, f64) {
    let scale = after.scale();
    let coefficients = after.structure.shared.len() - before.structure.shared.len();
    let likelihood = context.likelihood(before.deviance(scale), after.deviance(scale));
    let p = p_value(likelihood, coefficients) * context.catalogue.len() as f64;
    (gain(context, before, after, scale), p.min(1.0))
}

/// `None` where the simulator refuses the effects of a hypothesis: a formula may divide by 0 without the effects it came with.
fn simulated<T>(fitted: Result<T>) -> Result<Option<T>> {
    match fitted {
        Err(Error::Simulator { .. }) => Ok(None),
        fitted => fitted.map(Some),
    }
}

/// What takes the place of effects that cannot be judged one by one: the best effect that is simulated without others.
fn best_alone<'a>(context: &Context<'a>, alone: &[CandidateFit<'a>]) -> Result<Revision<'a>> {
    let fitted = alone.iter().filter(|candidate| candidate.excluded.is_none()).find_map(|one| one.model.as_ref());
    let model = fitted.map(|model| model.again(context)).transpose()?;
    Ok(Revision::Replaced(model.map(Box::new)))
}

/// For each effect: its gain, and what explains as much in its place; or a better hypothesis, one effect swapped or removed.
/// Steps that were scored are found in `steps`, others are added there.
fn judge_selected<'a>(
    context: &Context<'a>,
    (base, alone): (&Hypothesis<'a>, &[CandidateFit<'a>]),
    steps: &mut Vec<SelectionStep<'a>>,
    model: &Hypothesis<'a>,
) -> Result<Revision<'a>> {
    let effects = model.structure.effects.clone();
    let mut selected = Vec::new();
    for &entry in &effects {
        let others: Vec<usize> = effects.iter().copied().filter(|&e| e != entry).collect();
        if !others.is_empty() && !needs_no_evidence(context, entry) && is_idle(model, entry) {
            // It may have led the others out of a local minimum, and is not needed there.
            let Some(without) = simulated(context.fit_near(&others, model))? else {
                return best_alone(context, alone);
            };
            if worth(context, &without, model).0 < least_gain(context, effects.len()) {
                return Ok(Revision::Replaced(Some(Box::new(without))));
            }
        }
        let (without, candidates) = if others.is_empty() {
            (base, alone)
        } else {
            let Some(step) = simulated(SelectionStep::of(context, steps, &others, model))? else {
                return best_alone(context, alone);
            };
            (&step.model, step.candidates.as_slice())
        };
        let (gain, p_value) = worth(context, without, model);
        let least = least_gain(context, effects.len());
        let earned = gain >= least && is_significant(context, p_value) && is_material(context, without, model);
        if !earned && !needs_no_evidence(context, entry) {
            let fitted = if others.is_empty() { None } else { Some(Box::new(without.again(context)?)) };
            return Ok(Revision::Replaced(fitted));
        }
        let excluded = confusable_set::excluded_rival(context, without, model, candidates);
        let others = confusable_set::others(context, without, model, entry, candidates);
        let firm = |other: usize| is_required(context, entry) && !is_required(context, other);
        if let Some(better) = others.iter().find(|(other, gap)| *gap < -1.0 && !firm(*other))
            && effects.len() > 1
        {
            let found = candidates.iter().find(|c| c.entry == better.0).and_then(|c| c.model.as_ref());
            if let Some(found) = found {
                return Ok(Revision::Replaced(Some(Box::new(found.again(context)?))));
            }
        }
        selected.push(SelectedEffect { entry, gain, p_value, others, equals: Vec::new(), excluded });
    }
    Ok(Revision::Retained(selected))
}

/// Puts the twins of every selected effect first among what could be in its place.
pub(in crate::diagnose) fn add_exact_twins(context: &Context, found: &mut Selection) {
    let Some(best) = &found.best else { return };
    for selected in &mut found.selected {
        for (twin, _) in confusable_set::exact_twins(context, best, selected.entry) {
            selected.others.retain(|(other, _)| *other != twin);
            selected.others.insert(0, (twin, 0.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::catalogue::Entry;
    use crate::diagnose::judge::adequacy::is_adequate;
    use crate::diagnose::tests::zoo::{FRICTION, REST, entry, in_swings, names};
    use crate::simulator::{Side, Twin};

    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    fn found(truth: &[(&str, f64)], count: u32) -> Vec<String> {
        let mut found = Vec::new();
        in_swings(truth, count, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let best = search(context, base, |_, _| true, &|_| {}).unwrap().best;
            found = best.map_or_else(Vec::new, |best| {
                names(context, &best.structure.effects).into_iter().map(String::from).collect()
            });
        });
        found
    }

    #[test]
    fn what_is_missing_is_selected_and_nothing_else() {
        assert!(found(&[], 3).is_empty());
        assert_eq!(found(&[(FRICTION, 0.1)], 3), ["viscous_friction"]);
        let mut both = found(&[(FRICTION, 0.2), (REST, 0.05)], 4);
        both.sort_unstable();
        assert_eq!(both, ["rest_angle", "viscous_friction"]);
    }

    #[test]
    fn a_refused_hypothesis_is_none_and_a_failed_simulator_is_an_error() {
        let refused = Error::Simulator { at: "a=1".into(), message: "it divides by 0".into() };
        assert_eq!(simulated::<u8>(Err(refused)).unwrap(), None);
        assert_eq!(simulated(Ok(3)).unwrap(), Some(3));
        assert!(simulated::<u8>(Err(Error::SimulatorBroken { message: "it ended".into() })).is_err());
    }

    /// What takes the place of effects that cannot be judged is an effect of its own, and never an excluded one.
    #[test]
    fn the_best_effect_alone_takes_the_place_of_those_that_cannot_be_judged() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let alone = score_candidates(context, &base, &[]);
            let Revision::Replaced(Some(best)) = best_alone(context, &alone).unwrap() else { panic!("none") };
            assert_eq!(names(context, &best.structure.effects), ["viscous_friction"]);
            assert!(matches!(best_alone(context, &[]).unwrap(), Revision::Replaced(None)));
        });
    }

    #[test]
    fn a_single_motion_shows_one_effect_at_most() {
        assert!(found(&[(FRICTION, 0.2), (REST, 0.05)], 1).len() <= 1);
    }

    /// The context in which the rest angle is a twin of friction on this side.
    fn with_twin<'a>(context: &Context<'a>, side: Side) -> Context<'a> {
        let mut catalogue: Vec<Entry> = context.catalogue.to_vec();
        let friction = entry(context, "viscous_friction");
        let twin = Twin { name: "rest_angle".into(), side, separated_by: "look it up".into() };
        catalogue[friction].of[0].exact_twins = vec![twin];
        Context { catalogue: catalogue.into(), ..context.clone() }
    }

    #[test]
    fn a_twin_comes_first_on_its_side_alone() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |plain| {
            for side in [Side::Any, Side::Above] {
                let context = with_twin(plain, side);
                let base = fit_without_effects(&context).unwrap();
                let mut found = search(&context, base, is_adequate, &|_| {}).unwrap();
                add_exact_twins(&context, &mut found);
                let rest = entry(&context, "rest_angle");
                assert_eq!(found.selected[0].others.first(), Some(&(rest, 0.0)), "{side:?}");
                let best = found.best.as_ref().unwrap();
                let mut below = Hypothesis {
                    structure: context.structure(&best.structure.effects).unwrap(),
                    fit: best.fit.clone(),
                };
                let own = below.structure.of_effect(0)[0];
                below.fit.point.parameters[own] = -0.1;
                let twins = confusable_set::exact_twins(&context, &below, found.selected[0].entry);
                assert_eq!(twins.len(), usize::from(side == Side::Any));
            }
        });
    }
}
