//! The judgement of the attempt that the strategies ended with: residual diagnostics, validation, verdict.

use crate::Result;
use crate::diagnose::Test;
use crate::diagnose::answer::Verdict;
use crate::diagnose::answer::intervals::Intervals;
use crate::diagnose::answer::verdict::{Decision, decide};
use crate::diagnose::discrepancy::discrepancy_doubt;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::evidence::rmse;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::diagnose::judge::adequacy::noise_correlation;
use crate::diagnose::judge::held_out_proof::{HeldOut, validate};
use crate::diagnose::judge::validation_doubt::{Doubt, validation_doubt};
use crate::diagnose::strategy::{Attempt, Control, RandomParameter, Scope};
use crate::simulator::Text;
use crate::statistics::mad_sd;

/// A model may not raise the held-out residual by more than this factor.
const HELD_OUT_WORSE: f64 = 1.05;
/// Where nothing is missing from the recordings that were fitted, one that is held out leaves no more than this many times what they leave.
const NOTHING_HELD_OUT: f64 = 1.5;
/// The same of things that are not expected to be explained down to their noise, whose held-out recordings are of other setups.
const NOTHING_IN_OTHER_SETUPS: f64 = 3.0;

/// Everything judged.
pub(in crate::diagnose) struct Judgement<'a> {
    pub context: Context<'a>,
    pub found: Selection<'a>,
    pub scope: Scope,
    pub decision: Decision,
    pub tests: Vec<Test>,
    /// Whether the effects stand by their practical significance.
    pub practical: bool,
    /// The held-out recordings without any effect, and with those found.
    pub before: Option<HeldOut>,
    pub after: Option<HeldOut>,
    /// What wrong effects reach.
    pub control: Control,
    /// The lag-1 correlation of the noise.
    pub lag1: f64,
    /// The mean square that noise alone leaves.
    pub floor: f64,
    /// Root mean square of what the best hypothesis leaves of the recordings that were fitted, in the channels' unit.
    pub left: f64,
    /// Whether recordings differ among themselves by more than their noise.
    pub heterogeneous: bool,
    /// The parameter that differs between recordings.
    pub random_parameter: Option<RandomParameter>,
    /// The recording that disagrees with all others: its position among the recordings given.
    pub odd: Option<usize>,
    /// A held-out recording that disagrees with those that were fitted, from which nothing is missing: its position among the recordings
    /// given, and how many times as much as in these it leaves.
    pub contradicts: Option<(usize, f64)>,
}

impl<'a> Judgement<'a> {
    /// Judges `attempt`.
    pub fn new(mut attempt: Attempt<'a>) -> Result<Self> {
        let control = match attempt.control.take() {
            Some(control) => control,
            None => attempt.negative_control()?,
        };
        let Attempt {
            context,
            found,
            scope,
            residuals,
            practical,
            before,
            lag1,
            floor,
            per_recording,
            random_parameter,
            odd,
            ..
        } = attempt;
        let whole = scope == Scope::Whole;
        let mut tests = residuals.tests;
        if found.best.is_none() {
            tests.extend(noise_correlation(&context.evidence, lag1));
        }
        let after = match &found.best {
            Some(best) => validate(&context, best)?,
            None => before.clone(),
        };
        tests.extend(worse_on_held_out(before.as_ref(), after.as_ref()));
        let worst =
            after.as_ref().filter(|_| found.best.is_none()).and_then(|held| worst_held_out(&context, &held.residuals));
        // Copies of the motion that was fitted confirm nothing.
        let evidence = &context.evidence;
        let another = |recording: &PreparedRecording| {
            !evidence.shows_one_motion() || recording.motion != evidence.training[0].motion
        };
        let confirmed = practical.is_none() || evidence.validation.iter().any(another);
        let left = root_mean_square(&context, found.best.as_ref().unwrap_or(&found.base))?;
        let worst = worst.map(|(recording, ratio)| (recording, ratio / (left / floor.sqrt()).max(1.0)));
        let threshold = if evidence.discrepancy() { NOTHING_IN_OTHER_SETUPS } else { NOTHING_HELD_OUT };
        tests.extend(worst.map(|(_, value)| Test {
            name: "held-out residual over fitted",
            value,
            threshold,
            passed: value <= threshold,
        }));
        let contradicts = worst.filter(|(_, ratio)| *ratio > threshold);
        let held_out = (before.as_ref(), after.as_ref());
        let noise = floor.sqrt();
        let doubt = doubt_of(&context, &found, held_out, (left.max(noise), noise), practical.is_some());
        let doubt = doubt.filter(|_| whole);
        let differs = per_recording.map(|fits| Doubt::DiffersBetweenRecordings(fits.effects));
        let random = random_parameter.as_ref().map(|random| Doubt::ParameterDiffers(random.name.clone()));
        let unvaried = evidence.is_one_setup_of_several_channels().then_some(Doubt::OneSetup);
        let heterogeneous = whole && (practical.is_some() || residuals.heterogeneous);
        let doubt = doubt.or(differs).or(random).or(unvaried);
        let doubt = match (doubt, &found.best) {
            (None, Some(best)) => including_absence(&context, best, heterogeneous)?.map(Doubt::Undetermined),
            (doubt, _) => doubt.filter(|_| !found.selected.is_empty()),
        };
        let decision = decide(&context, &found, practical.as_ref().unwrap_or(&tests), confirmed, doubt);
        let significant = whole && practical.is_some();
        tests.extend(practical.into_iter().flatten());
        Ok(Self {
            context,
            found,
            scope,
            decision,
            tests,
            practical: significant,
            before,
            after,
            control,
            lag1,
            floor,
            left,
            heterogeneous,
            random_parameter,
            odd,
            contradicts,
        })
    }

    /// Whether effects are reported, be it with others in their place.
    pub fn reports_effects(&self) -> bool {
        matches!(self.decision.verdict, Verdict::Named | Verdict::OneOf)
    }

    /// The best hypothesis, be it that nothing is missing.
    pub fn best(&self) -> &Hypothesis<'a> {
        self.found.best.as_ref().unwrap_or(&self.found.base)
    }

    /// The hypothesis that the answer reports: without effects where none are reported.
    pub fn last(&self) -> &Hypothesis<'a> {
        if self.reports_effects() { self.best() } else { &self.found.base }
    }

    /// Whether what lies between events is explained, and the events are not.
    pub fn events_open(&self) -> bool {
        matches!(self.scope, Scope::Segments { events_open: true })
    }
}

/// What speaks against naming the effects of `found` alone: of things that are not expected to be explained down to their noise, by tests
/// of their own. `left` is what the effects leave of the recordings that were fitted, and the noise, root mean squares.
fn doubt_of(
    context: &Context,
    found: &Selection,
    held_out: (Option<&HeldOut>, Option<&HeldOut>),
    left: (f64, f64),
    practical: bool,
) -> Option<Doubt> {
    let all = || validation_doubt(context, found, held_out, left, practical);
    if context.evidence.driven() || !context.evidence.discrepancy() {
        return all();
    }
    let doubt = discrepancy_doubt(context, found, held_out, left, practical);
    if practical { doubt } else { doubt.or_else(all) }
}

/// Root mean square of what a hypothesis leaves of the recordings that were fitted, in the channels' unit.
pub(in crate::diagnose) fn root_mean_square(context: &Context, model: &Hypothesis) -> Result<f64> {
    let plain = context.joint(&model.structure).plain_residuals(&model.fit.point)?;
    Ok(rmse(context.recordings(), &plain, 0.0))
}

/// Of recordings that no simulation explains down to their noise: an effect whose intervals all include its absence.
fn including_absence(context: &Context, best: &Hypothesis, heterogeneous: bool) -> Result<Option<Text>> {
    if !context.evidence.discrepancy() {
        return Ok(None);
    }
    let intervals = Intervals::new(context, best, heterogeneous)?;
    let shown = |position: usize| {
        best.structure.switches(position).any(|(column, absent)| {
            let (low, high) = intervals.of(column);
            absent < low || absent > high
        })
    };
    let effects = &best.structure.effects;
    let lost = (0..effects.len()).find(|position| !shown(*position));
    Ok(lost.map(|position| context.catalogue[effects[position]].name.clone()))
}

/// Of recordings that are held out, but of logs of a driven mechanism: the one that leaves most, as its position among the recordings given,
/// and its residuals over their noise: their root mean square, or the robust scale of its worst channel where that is less, since a few
/// outliers are no disagreement.
fn worst_held_out(context: &Context, residuals: &[Vec<f64>]) -> Option<(usize, f64)> {
    if context.evidence.driven() {
        return None;
    }
    let of = |(recording, residuals): (&PreparedRecording, &Vec<f64>)| {
        let kept = || residuals.iter().enumerate().filter(|(i, _)| recording.keep[*i]);
        let mean_square = kept().map(|(_, r)| r * r).sum::<f64>() / kept().count().max(1) as f64;
        let channel = |c: usize| mad_sd(kept().filter(|(i, _)| i % recording.width() == c).map(|(_, r)| *r));
        (recording.index, (0..recording.width()).map(channel).fold(0.0, f64::max).min(mean_square.sqrt()))
    };
    let all = context.evidence.validation.iter().zip(residuals).map(of);
    all.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Whether the effects raise the residual of recordings that were not fitted.
fn worse_on_held_out(before: Option<&HeldOut>, after: Option<&HeldOut>) -> Option<Test> {
    let value = after?.rmse / before?.rmse.max(f64::MIN_POSITIVE);
    let passed = value <= HELD_OUT_WORSE;
    Some(Test { name: "held-out residual after over before", value, threshold: HELD_OUT_WORSE, passed })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::diagnose::evidence::Evidence;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};
    use crate::observation::Circumstances;

    use crate::diagnose::strategy::explain;

    #[test]
    fn several_channels_in_one_setup_are_doubted() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let mut evidence = Evidence::clone(&context.evidence);
            for recording in &mut evidence.training {
                recording.prepared.discrepancy = true;
            }
            assert!(!evidence.is_one_setup_of_several_channels(), "a single channel");
            for recording in &mut evidence.training {
                recording.noise.push(1.0);
            }
            assert!(evidence.is_one_setup_of_several_channels());
            let other = Circumstances { setup: 1, ..Circumstances::default() };
            evidence.training[1].prepared.circumstances = Some(Arc::new(other));
            assert!(!evidence.is_one_setup_of_several_channels(), "another setup");
        });
    }

    /// Only where no simulation follows the recordings down to their noise: otherwise the criterion has decided.
    #[test]
    fn an_effect_whose_interval_includes_its_absence_is_doubted() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let mut evidence = Evidence::clone(&context.evidence);
            evidence.training.iter_mut().for_each(|one| one.prepared.discrepancy = true);
            let real = context.with_evidence(evidence);
            let base = fit_without_effects(context).unwrap();
            let both = [entry(context, "viscous_friction"), entry(context, "rest_angle")];
            let of = |context: &Context, effects: &[usize]| {
                including_absence(context, &context.fit_near(effects, &base).unwrap(), false).unwrap()
            };
            assert_eq!(of(&real, &both).as_deref(), Some("rest_angle"));
            assert_eq!(of(&real, &both[..1]), None);
            assert_eq!(of(context, &both), None);
        });
    }

    /// Of things that are not expected to be explained down to their noise, held-out recordings of other setups may leave more than those that
    /// were fitted, and far more shows that these hide something.
    #[test]
    fn far_more_in_other_setups_contradicts_that_nothing_is_missing() {
        in_swings(&[], 4, 1, |context| {
            let of = |times: f64| {
                let mut evidence = Evidence::clone(&context.evidence);
                evidence.training.iter_mut().for_each(|one| one.prepared.discrepancy = true);
                evidence.validation[0].noise.iter_mut().for_each(|noise| *noise /= times);
                let context = context.with_evidence(evidence);
                let judged = Judgement::new(explain(&context, &|_| {}).unwrap()).unwrap();
                (judged.decision.verdict, judged.contradicts.is_some())
            };
            assert_eq!(of(1.0), (Verdict::None, false));
            assert_eq!(of(2.0), (Verdict::None, false));
            assert_eq!(of(5.0), (Verdict::Unknown, true));
        });
    }

    #[test]
    fn a_hypothesis_is_reported_with_its_effects() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let judged = Judgement::new(explain(context, &|_| {}).unwrap()).unwrap();
            assert_eq!((judged.decision.verdict, judged.reports_effects()), (Verdict::Named, true));
            assert_eq!(judged.last().structure.effects.len(), 1);
            assert!(judged.control.wrong.is_some() && !judged.practical && !judged.events_open());
            assert!(judged.tests.iter().all(|t| t.passed), "{:?}", judged.tests);
        });
        in_swings(&[], 3, 0, |context| {
            let judged = Judgement::new(explain(context, &|_| {}).unwrap()).unwrap();
            assert!(!judged.reports_effects() && judged.last().structure.effects.is_empty());
        });
    }
}
