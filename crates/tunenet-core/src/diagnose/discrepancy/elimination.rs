//! Backward elimination (Efroymson 1960): an effect that does next to nothing in addition to the others goes, least first.

use super::scale::{FINISH, LOSS};
use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::candidate_scores::gain;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::judge::held_out_proof::validate;
use crate::estimate::huber::huber_cost;
use crate::statistics::root_mean_square;

/// An effect that leaves more than this share of what held-out recordings leave without it does next to nothing there.
pub(super) const CONFIRMING: f64 = 0.99;

/// The hypothesis without the effects that do next to nothing in addition to the others.
///
/// # Errors
/// Where the simulator refuses.
pub(super) fn eliminated<'a>(context: &Context<'a>, mut best: Hypothesis<'a>) -> Result<Hypothesis<'a>> {
    while let Some((_, without)) = idle(context, &best)? {
        best = without;
    }
    Ok(best)
}

/// Of several effects of `best` the one that is missed least of those that do next to nothing in addition to the others, and the
/// hypothesis without it: it gains less than distinguishes two explanations, explains less of every channel than half a step of the
/// integration does, or less than a hundredth of what held-out recordings leave, by their root mean square and by the misfit that is
/// minimised.
///
/// # Errors
/// Where the simulator refuses.
pub(super) fn idle<'a>(context: &Context<'a>, best: &Hypothesis<'a>) -> Result<Option<(usize, Hypothesis<'a>)>> {
    let effects = &best.structure.effects;
    if effects.len() < 2 {
        return Ok(None);
    }
    let after = validate(context, best)?;
    let mut least: Option<(f64, usize, Hypothesis<'a>)> = None;
    for &entry in effects {
        let others: Vec<usize> = effects.iter().copied().filter(|&other| other != entry).collect();
        let without = context.fit_near_with(&others, best, FINISH)?;
        let before = validate(context, &without)?;
        let unconfirmed = after.as_ref().zip(before.as_ref()).is_some_and(|(after, before)| {
            let [with, without] = [after, before].map(|held_out| huber_cost(&held_out.residuals, LOSS));
            after.rmse > CONFIRMING * before.rmse && with > CONFIRMING * CONFIRMING * without
        });
        let lost = without.fit.cost - best.fit.cost;
        let weak = gain(context, &without, best, best.scale()) < context.settings.margin;
        let idle = weak || unconfirmed || is_within_step_error(context, &without, best);
        if idle && least.as_ref().is_none_or(|(smallest, ..)| lost < *smallest) {
            least = Some((lost, entry, without));
        }
    }
    Ok(least.map(|(_, entry, without)| (entry, without)))
}

/// Whether `with` leaves less of no channel than `without`, root mean square, by as much as half a step of the integration moves it:
/// recordings that another simulator made differ by as much from this one.
pub(super) fn is_within_step_error(context: &Context, without: &Hypothesis, with: &Hypothesis) -> bool {
    let left = |model: &Hypothesis| context.joint(&model.structure).plain_residuals(&model.fit.point).ok();
    let (Some(without), Some(with)) = (left(without), left(with)) else { return false };
    let width = context.recordings().first().map_or(0, PreparedRecording::width);
    let square = |all: &[Vec<f64>], channel: usize| {
        root_mean_square(all.iter().flat_map(|values| values.iter().skip(channel).step_by(width).copied())).powi(2)
    };
    width > 0
        && (0..width).all(|channel| {
            let explained = (square(&without, channel) - square(&with, channel)).max(0.0).sqrt();
            let of = |recording: &PreparedRecording| Some(*recording.prepared.step_error.as_ref()?.get(channel)?);
            context.recordings().iter().all(|recording| of(recording).is_some_and(|error| explained < error))
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::evidence::Evidence;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings, names};

    /// Of two effects, the one that is missing stays.
    #[test]
    fn an_effect_that_does_nothing_in_addition_goes() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let base = fit_without_effects(context).unwrap();
            let both = ["rest_angle", "viscous_friction"].map(|name| entry(context, name));
            let found = context.fit_near(&both, &base).unwrap();
            assert_eq!(idle(context, &found).unwrap().map(|(entry, _)| entry), Some(both[0]));
            let left = eliminated(context, found).unwrap();
            assert_eq!(names(context, &left.structure.effects), ["viscous_friction"]);
            assert!(idle(context, &left).unwrap().is_none(), "a single effect is not compared with others");
        });
    }

    /// What an effect explains is more than half a step of the integration moves, or less.
    #[test]
    fn an_effect_may_do_less_than_half_a_step_of_the_integration() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let base = fit_without_effects(context).unwrap();
            let best = context.fit_near(&[entry(context, "viscous_friction")], &base).unwrap();
            let within = |error: Option<f64>| {
                let mut evidence = Evidence::clone(&context.evidence);
                evidence.training.iter_mut().for_each(|one| one.prepared.step_error = error.map(|error| vec![error]));
                is_within_step_error(&context.with_evidence(evidence), &base, &best)
            };
            assert_eq!([Some(1e-4), Some(1.0), None].map(within), [false, true, false]);
        });
    }
}
