//! Refinements by which recordings are explained as they are, tried in order: each takes the attempt before it, and returns a
//! better one or the same.

mod by_name;
mod discrepancy_as_noise;
mod per_event_effect;
pub(in crate::diagnose) mod per_recording_fits;
mod random_parameter;
mod required_effects_first;
mod segment_wise;
mod segments_alone;
mod sign_ambiguous;
mod unmeasured_axes;
mod whole_record;

use crate::Result;
use crate::diagnose::discrepancy::{
    Gated, better_null, fit_null, is_far_above_noise, lower_null, search_gated, with_groups,
};
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::sample::Sample;
use crate::diagnose::hypothesis::candidate_scores::{CandidateFit, gain};
use crate::diagnose::hypothesis::confusable_set::exact_twins;
use crate::diagnose::hypothesis::context::{COMPARED, Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::{SelectedEffect, Selection, add_exact_twins};
use crate::diagnose::hypothesis::joint::{Effort, Outcome, Point, Which};
use crate::diagnose::hypothesis::multistart::fit_without_effects;
use crate::diagnose::judge::adequacy::{
    RESOLVED, ResidualDiagnostics, is_adequate, is_below_steps, residual_diagnostics,
};
use crate::diagnose::judge::held_out_proof::{HeldOut, validate};
use crate::diagnose::judge::negative_control::{negative_control, ratios};
use crate::diagnose::judge::practical_significance::noise_floor;
use crate::diagnose::{Progress, Test};
use crate::estimate::jacobian::Columns;
use crate::simulator::Text;
use discrepancy_as_noise::kept_with_inflated_noise;
use per_event_effect::with_draws_of_all;
use per_recording_fits::PerRecordingFits;
pub(in crate::diagnose) use random_parameter::RandomParameter;
use sign_ambiguous::fix_sign_ambiguous;
use unmeasured_axes::without_unmeasured;
use whole_record::WholeRecord;

/// What an attempt has looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::diagnose) enum Scope {
    /// The simulation was tuned; no effect was looked for yet.
    Tuned,
    /// Whole recordings.
    Whole,
    /// What lies between events, and then the events themselves.
    Segments {
        /// Whether the events leave something that no effect takes away.
        events_open: bool,
    },
}

/// What recordings that were not fitted say of wrong effects.
pub(in crate::diagnose) struct Control {
    /// A wrong effect, and the root mean square that it reaches.
    pub wrong: Option<(Text, f64)>,
    /// Of the best candidates: the held-out residual of each alone over that without it.
    pub ratios: Vec<(usize, f64)>,
}

/// An attempt to explain the recordings.
pub(in crate::diagnose) struct Attempt<'a> {
    pub context: Context<'a>,
    pub found: Selection<'a>,
    pub scope: Scope,
    /// Whether what is left of whole recordings looks like noise.
    pub residuals: ResidualDiagnostics,
    /// The tests of practical significance that the effects passed, where they were needed.
    pub practical: Option<Vec<Test>>,
    /// The held-out recordings without any effect.
    pub before: Option<HeldOut>,
    /// The lag-1 correlation of the noise, by which whole recordings were prewhitened.
    pub lag1: f64,
    /// The noise of the recordings as a mean square.
    pub floor: f64,
    /// The negative control, where it was made before a random effect was added.
    pub control: Option<Control>,
    /// Fits of every recording by itself, where they explain as much as a random effect of events explains of all together.
    pub per_recording: Option<PerRecordingFits>,
    /// The parameter that differs between recordings.
    pub random_parameter: Option<RandomParameter>,
    /// The recording that disagrees with all others: its position among the recordings given.
    pub odd: Option<usize>,
}

impl<'a> Attempt<'a> {
    /// The simulation as it is, tuned.
    pub fn tuned(context: &Context<'a>) -> Result<Self> {
        let context = context.with_evidence(fix_sign_ambiguous(context)?);
        let base = fit_without_effects(&context)?;
        let context = without_unmeasured(context, &base)?;
        Ok(Self::started(context, base))
    }

    /// The simulation as `base` fits it.
    fn started(context: Context<'a>, base: Hypothesis<'a>) -> Self {
        let found = Selection::tuned(base);
        let floor = noise_floor(context.recordings());
        let (scope, residuals) = (Scope::Tuned, ResidualDiagnostics::default());
        Self {
            context,
            found,
            scope,
            residuals,
            practical: None,
            before: None,
            lag1: 0.0,
            floor,
            control: None,
            per_recording: None,
            random_parameter: None,
            odd: None,
        }
    }

    /// What was found in `context`, tested.
    pub fn tested(
        context: Context<'a>,
        mut found: Selection<'a>,
        scope: Scope,
        practical: Option<Vec<Test>>,
    ) -> Result<Self> {
        add_exact_twins(&context, &mut found);
        let before = validate(&context, &found.base)?;
        let residuals = residual_diagnostics(&context, found.best.as_ref().unwrap_or(&found.base));
        let (lag1, floor) = (context.evidence.noise.lag1(), noise_floor(context.recordings()));
        Ok(Self {
            context,
            found,
            scope,
            residuals,
            practical,
            before,
            lag1,
            floor,
            control: None,
            per_recording: None,
            random_parameter: None,
            odd: None,
        })
    }

    /// The best hypothesis, be it that nothing is missing.
    pub fn last(&self) -> &Hypothesis<'a> {
        self.found.best.as_ref().unwrap_or(&self.found.base)
    }

    /// Whether something is left of whole recordings that could be taken for noise: a recording confirms then what takes the
    /// large part away. Without one that could, a large part taken away proves no name; of a single motion it leaves a choice.
    pub fn may_inflate_noise(&self) -> bool {
        let evidence = &self.context.evidence;
        let confirmable = !evidence.validation.is_empty() || evidence.shows_one_motion_per_object();
        self.scope == Scope::Whole
            && self.practical.is_none()
            && confirmable
            && !self.residuals.passed()
            && self.odd.is_none()
    }

    /// Whether it explains whole recordings by effects that are the same in all of them, or not at all.
    fn is_plain(&self) -> bool {
        let context = &self.context;
        let is_free = !context.required_first && context.given.is_empty() && context.spared.is_empty();
        let is_alike = self.random_parameter.is_none() && self.per_recording.is_none() && self.odd.is_none();
        self.scope == Scope::Whole && is_alike && is_free
    }

    /// What wrong effects reach on held-out recordings.
    pub fn negative_control(&self) -> Result<Control> {
        let wrong = negative_control(&self.context, &self.found, self.before.as_ref())?;
        Ok(Control { wrong, ratios: ratios(&self.context, &self.found, self.before.as_ref())? })
    }
}

/// A way to explain recordings that those before it leave unexplained.
trait Refinement {
    /// Whether it is worth trying after `attempt`.
    fn applies(&self, attempt: &Attempt) -> bool;

    /// What it makes of the recordings; `attempt` itself where that is no better.
    ///
    /// # Errors
    /// Where the simulator refuses.
    fn attempt<'a>(&self, attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>>;
}

/// In the order in which they are tried.
const REFINEMENTS: [&dyn Refinement; 6] = [
    &segment_wise::SegmentWise,
    &whole_record::WholeRecord,
    &random_parameter::ParameterDiffers,
    &discrepancy_as_noise::DiscrepancyAsNoise,
    &required_effects_first::RequiredEffectsFirst,
    &per_event_effect::PerEventEffect,
];

/// Tunes the simulation as it is, then tries every refinement that applies. Where no recording is expected to be explained down to its
/// noise, held-out recordings decide: at once where the tuned simulation is far from it, and else where it turns out so.
pub(super) fn explain<'a>(context: &Context<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
    progress(Progress::Tuning);
    if context.evidence.discrepancy() {
        return explain_discrepant(context, progress);
    }
    let attempt = Attempt::tuned(context)?;
    // What is left shows in more recordings where it is small.
    for times in [1, 2] {
        match in_a_sample(&attempt, times, progress)? {
            InSample::Found(found) => return Ok(*found),
            InSample::TooFew => {}
            InSample::NotAlike => break,
        }
    }
    refined(attempt, progress)
}

/// What a sample of many recordings says of all: what it shows, fitted to all; that more recordings are needed, as effects explain the sample
/// and not all, or all of it but one recording; or nothing.
enum InSample<'a> {
    Found(Box<Attempt<'a>>),
    TooFew,
    NotAlike,
}

/// By every refinement that applies.
fn refined<'a>(mut attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
    for refinement in REFINEMENTS {
        let enough = attempt.context.settings.quick && attempt.scope != Scope::Tuned;
        if !enough && refinement.applies(&attempt) {
            attempt = refinement.attempt(attempt, progress)?;
        }
    }
    Ok(attempt)
}

/// What is missing from many recordings as a sample of them, so many times the least, shows it, fitted to all.
fn in_a_sample<'a>(attempt: &Attempt<'a>, times: usize, progress: &dyn Fn(Progress)) -> Result<InSample<'a>> {
    let context = &attempt.context;
    let Some(Sample { evidence, .. }) = context.evidence.sample(times) else { return Ok(InSample::NotAlike) };
    if context.settings.quick || !context.shows_free_motions() || is_adequate(context, attempt.last()) {
        return Ok(InSample::NotAlike);
    }
    let few = context.with_evidence(evidence);
    let base = fit_without_effects(&few)?;
    let sampled = refined(Attempt::started(few, base), progress)?;
    if !sampled.is_plain() {
        return Ok(if sampled.odd.is_some() { InSample::TooFew } else { InSample::NotAlike });
    }
    let before = context.with_evidence(Evidence::clone(&context.evidence).prewhitened(sampled.lag1));
    let (mut all, last) = (before.clone(), sampled.last());
    let mut model = at(&all, (&last.structure.effects, &last.fit), attempt.found.base.fit.point.nuisances.clone())?;
    let is_explained = sampled.residuals.passed();
    let effort = if is_explained { COMPARED } else { ROUGH };
    model = all.fit_near_with(&last.structure.effects, &model, effort)?;
    if sampled.context.event_effects.is_some() {
        let Some((drawn, near)) = with_draws_of_all(&all, &model)? else { return Ok(InSample::NotAlike) };
        model = drawn.fit_near_with(&last.structure.effects, &near, effort)?;
        all = drawn;
    }
    if let Some(evidence) = all.learn_noise(&model)? {
        all = all.with_evidence(evidence);
        model = all.fit_near_with(&last.structure.effects, &model, effort)?;
    }
    if is_adequate(&all, &model) != is_explained {
        return Ok(if is_explained { InSample::TooFew } else { InSample::NotAlike });
    }
    if is_explained {
        model = all.fit_near(&last.structure.effects, &model)?;
    }
    let Some(selected) = selected_in_all(&all, &model, &sampled)? else { return Ok(InSample::NotAlike) };
    // What was compared in the sample gains in proportion to the number of values.
    let share = all.count() as f64 / sampled.context.count() as f64;
    let alone = sampled.found.alone.iter().map(|one| CandidateFit {
        excluded: one.excluded.clone(),
        ..CandidateFit::unfitted(one.entry, one.gain * share)
    });
    let base = before.fit_near(&[], &attempt.found.base)?;
    let best = sampled.found.best.is_some().then_some(model);
    let found = Selection { base, alone: alone.collect(), best, selected };
    if sampled.practical.is_some() {
        let tested = Attempt::tested(all, Selection::tuned(found.base.again(&before)?), Scope::Whole, None)?;
        let second = kept_with_inflated_noise(&before, found, tested.floor)?;
        let passed = second.passes().then(|| Box::new(tested.replaced(second)));
        return Ok(passed.map_or(InSample::NotAlike, InSample::Found));
    }
    let of_base = if sampled.context.event_effects.is_some() { validate(&before, &found.base)? } else { None };
    let tested = Attempt::tested(all, found, Scope::Whole, None)?;
    let found = Attempt { before: of_base.or(tested.before), control: sampled.control, ..tested };
    Ok(InSample::Found(Box::new(found)))
}

/// The effects of a sample in all recordings, where `model` has them: what could be in their place is fitted to all. `None` where something
/// else is better there.
fn selected_in_all<'a>(
    context: &Context<'a>,
    model: &Hypothesis<'a>,
    sampled: &Attempt<'a>,
) -> Result<Option<Vec<SelectedEffect>>> {
    let times = context.count() as f64 / sampled.context.count() as f64;
    let mut all = sampled.found.selected.clone();
    for one in &mut all {
        one.gain *= times;
        let Some(place) = model.structure.effects.iter().position(|&entry| entry == one.entry) else { continue };
        let twins = exact_twins(context, model, one.entry);
        // Where something is left, the distance is that in the sample, which is less than that in all.
        let is_open = |(other, gap): &(usize, f64)| {
            let is_close = *gap < context.settings.margin && sampled.residuals.passed();
            is_close && twins.iter().all(|(twin, _)| twin != other)
        };
        let mut without = None;
        for (other, gap) in one.others.iter_mut().filter(|other| is_open(other)) {
            let without = without.get_or_insert_with(|| Without::effect(context, model, place));
            // From where the sample has it, if alone; a fit may end in another local minimum, and then the sample's distance counts.
            let alone = sampled.found.alone.iter().find(|one| one.entry == *other).and_then(|one| one.model.as_ref());
            let rival = without.with(context, *other, alone)?;
            *gap = gain(context, &rival, model, model.scale()).min(*gap * times);
            if *gap < -1.0 {
                return Ok(None);
            }
        }
        one.others.sort_by(|a, b| a.1.total_cmp(&b.1));
    }
    Ok(Some(all))
}

/// A hypothesis less one of its effects, and the derivatives by the parameters that are left.
struct Without<'m, 'a> {
    model: &'m Hypothesis<'a>,
    effects: Vec<usize>,
    columns: Vec<Columns>,
    /// How many shared parameters are left.
    known: usize,
}

impl<'m, 'a> Without<'m, 'a> {
    /// Without the effect at this place.
    fn effect(context: &Context<'a>, model: &'m Hypothesis<'a>, place: usize) -> Self {
        let (structure, fit) = (&model.structure, &model.fit);
        let columns = context.joint(structure).columns(&fit.point, &fit.residuals, Which::ALL);
        let is_left = |&i: &usize| structure.shared[i].effect.is_none_or(|(effect, _)| effect != place);
        let left: Vec<usize> = (0..structure.shared.len()).filter(is_left).collect();
        let mut effects = structure.effects.clone();
        effects.remove(place);
        Self { model, effects, columns: columns.iter().map(|one| one.at(&left)).collect(), known: left.len() }
    }

    /// With another effect in its place, fitted from where it stands `alone` in a sample, if it does.
    fn with(&self, context: &Context<'a>, effect: usize, alone: Option<&Hypothesis<'a>>) -> Result<Hypothesis<'a>> {
        let structure = context.structure(&[self.effects.as_slice(), &[effect]].concat())?;
        let (shared, fit) = (&self.model.structure, &self.model.fit);
        let parameters = match alone.filter(|alone| alone.structure.effects == structure.effects) {
            Some(alone) => alone.fit.point.parameters.clone(),
            None => structure.carry(shared, &fit.point.parameters),
        };
        let start = Point { parameters, nuisances: fit.point.nuisances.clone() };
        let fit = context.joint(&structure).fit_extended(start, (&self.columns, self.known), ROUGH)?;
        Ok(Hypothesis { structure, fit })
    }
}

/// A hypothesis with the parameters of a fit to other recordings of the same object.
fn at<'a>(
    context: &Context<'a>,
    (effects, fit): (&[usize], &Outcome),
    nuisances: Vec<Vec<f64>>,
) -> Result<Hypothesis<'a>> {
    let point = Point { parameters: fit.point.parameters.clone(), nuisances };
    Ok(Hypothesis { structure: context.structure(effects)?, fit: Outcome { point, ..fit.clone() } })
}

/// A fit to many recordings, from values of a few, that is only compared.
const ROUGH: Effort = Effort { steps: 8, derivatives: 2, ..COMPARED };

/// Right effects leave up to this many times what the tuned simulation leaves of held-out recordings in which a joint sticks: where it
/// does, is decided by thousandths.
const WORSE: f64 = 1.02;

/// So often a better fit of the simulation as it is begins the search again.
const MOST_RETURNS: usize = 2;

fn explain_discrepant<'a>(context: &Context<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
    let context = &with_groups(context)?;
    let mut base = fit_null(context)?;
    let mut returns = 0;
    loop {
        while !is_far_above_noise(context, &base) {
            let again = Hypothesis { structure: context.structure(&[])?, fit: base.fit.clone() };
            let attempt = WholeRecord.attempt(Attempt::started(context.clone(), again), progress)?;
            let better = if returns < MOST_RETURNS { better_null(context, &base, &attempt.found)? } else { None };
            if let Some(better) = better {
                (base, returns) = (better, returns + 1);
                continue;
            }
            if attempt.residuals.passed() {
                return borne_out(attempt);
            }
            break;
        }
        let gated = search_gated(context, &base, progress)?;
        // What leads out of a local minimum without a name of its own may lead to where nothing is missing.
        let better = if gated.found.best.is_none() && returns <= MOST_RETURNS {
            lower_null(context, &base, &gated.found.base)?.filter(|better| !is_far_above_noise(context, better))
        } else {
            None
        };
        if let Some(better) = better {
            (base, returns) = (better, MOST_RETURNS + 1);
            continue;
        }
        let floor = noise_floor(context.recordings());
        let Gated { context, found, tests } = gated;
        let practical = found.best.is_some().then_some(tests);
        return borne_out(Attempt { floor, ..Attempt::tested(context, found, Scope::Whole, practical)? });
    }
}

/// The attempt without its effects, where held-out recordings are no better with them and what is left without them is noise, or hardly
/// better and it is less than a step of the sensor; and where they are worse by more than luck.
fn borne_out(attempt: Attempt) -> Result<Attempt> {
    let (Some(best), Some(before)) = (&attempt.found.best, &attempt.before) else { return Ok(attempt) };
    let Some(after) = validate(&attempt.context, best)? else { return Ok(attempt) };
    let below = is_below_steps(&attempt.context, &attempt.found.base);
    let least = if below {
        RESOLVED
    } else if residual_diagnostics(&attempt.context, &attempt.found.base).passed() {
        1.0
    } else {
        WORSE
    };
    if after.rmse < least * before.rmse {
        return Ok(attempt);
    }
    let found = Selection { best: None, selected: Vec::new(), ..attempt.found };
    Attempt::tested(attempt.context, found, Scope::Whole, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings};

    /// What held-out recordings bear out stays, and what they do not goes where nothing else is left.
    #[test]
    fn an_effect_that_held_out_recordings_do_not_bear_out_is_left_out() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let found = WholeRecord.attempt(Attempt::tuned(context).unwrap(), &|_| {}).unwrap();
            assert_eq!(borne_out(found).unwrap().last().structure.effects.len(), 1);
        });
        in_swings(&[], 4, 1, |context| {
            let mut found = WholeRecord.attempt(Attempt::tuned(context).unwrap(), &|_| {}).unwrap();
            let mut wrong = context.fit_near(&[0], &found.found.base).unwrap();
            *wrong.fit.point.parameters.last_mut().unwrap() += 0.1;
            found.found.best = Some(wrong);
            assert!(borne_out(found).unwrap().last().structure.effects.is_empty());
        });
    }

    /// The same effect as in all recordings, its value fitted to all, by fewer rollouts.
    #[test]
    fn what_many_recordings_miss_is_searched_in_a_sample() {
        in_swings(&[(FRICTION, 0.15)], 40, 8, |context| {
            let searched = |context: &Context| {
                let found = refined(Attempt::tuned(context).unwrap(), &|_| {}).unwrap();
                (found.last().structure.effects.clone(), found.last().fit.point.parameters.clone())
            };
            let (effects, parameters) = searched(context);
            let in_all = context.rollouts.count();
            let found = explain(context, &|_| {}).unwrap();
            assert_eq!(found.last().structure.effects, effects);
            for (sampled, all) in found.last().fit.point.parameters.iter().zip(&parameters) {
                assert!((sampled - all).abs() < 1e-3 * all.abs(), "{sampled} {all}");
            }
            assert!(found.residuals.passed() && found.control.is_some());
            assert_eq!(found.context.recordings().len(), 32);
            let rollouts = context.rollouts.count() - in_all;
            assert!(rollouts < in_all, "{rollouts} {in_all}");
        });
        in_swings(&[], 40, 8, |context| {
            let tuned = Attempt::tuned(context).unwrap();
            assert!(matches!(in_a_sample(&tuned, 1, &|_| {}).unwrap(), InSample::NotAlike));
        });
    }

    #[test]
    fn a_tuned_simulation_has_looked_for_no_effect_yet() {
        in_swings(&[(FRICTION, 0.15)], 3, 1, |context| {
            let attempt = Attempt::tuned(context).unwrap();
            assert!(attempt.scope == Scope::Tuned && attempt.found.best.is_none() && !attempt.may_inflate_noise());
            let tested = Attempt::tested(attempt.context, attempt.found, Scope::Whole, None).unwrap();
            assert!(tested.before.is_some() && tested.may_inflate_noise(), "something is left, and could be confirmed");
        });
    }
}
