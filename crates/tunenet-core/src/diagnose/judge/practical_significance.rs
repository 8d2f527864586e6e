//! Practical significance: with enough real data every statistical test fails.
//!
//! Whatever the best model leaves is taken for autocorrelated noise: the residual's own spread, and only as many independent
//! values as its correlation leaves. What then still stands out has to take most of the gap away.

use crate::Result;
use crate::diagnose::Test;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::evidence::rmse;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::diagnose::hypothesis::plausibility::is_required;
use crate::diagnose::judge::held_out_proof::HeldOut;
use crate::diagnose::judge::heterogeneity::relative_heterogeneity;

/// What may be left beyond noise, as a share of what the effects took away (of mean squares).
pub(in crate::diagnose) const LEFT_SHARE: f64 = 0.1;
/// ... where each of them has to be there in any case (drag of a body of known mass and size): most of what was missing is
/// accounted for, and the rest is something else. Whether such an effect exists is no question; how large it is, is.
const LEFT_SHARE_CERTAIN: f64 = 1.0 / 3.0;
/// What exceeds a limit so many times does not fall below it by another weighting.
const FAR: f64 = 2.0;
/// Effects have to take the residual of held-out recordings down to this share ...
pub(in crate::diagnose) const CONFIRMED: f64 = 0.5;
/// ... and a wrong effect has to leave this many times as much.
pub(in crate::diagnose) const CONTROL: f64 = 1.3;
/// An effect may differ from recording to recording by this share of itself; what is only like it differs by more.
const UNSTEADY: f64 = 0.15;

/// Whether the effects found take away enough; the floors are the noise of the recordings themselves, and of the held-out
/// ones, as mean squares of plain residuals.
pub(in crate::diagnose) fn practical_tests(
    context: &Context<'_>,
    found: &Selection,
    (floor, held_out_floor): (f64, f64),
    held_out: Option<(&HeldOut, &HeldOut)>,
    control: Option<f64>,
) -> Result<Vec<Test>> {
    let Some(best) = &found.best else { return Ok(Vec::new()) };
    let left = left_over_taken_away(context, (&found.base, best), floor)?;
    let certain = best.structure.effects.iter().all(|&entry| is_required(context, entry));
    let threshold = if certain { LEFT_SHARE_CERTAIN } else { LEFT_SHARE };
    let mut tests = vec![Test { name: "left over taken away", value: left, threshold, passed: left <= threshold }];
    let value = relative_heterogeneity(context, best);
    let passed = certain || value <= UNSTEADY;
    tests.push(Test { name: "difference between recordings", value, threshold: UNSTEADY, passed });
    if let Some((before, after)) = held_out {
        // Where it is no question whether the effects are there, only what is no noise has to shrink.
        let noise = if certain { held_out_floor } else { 0.0 };
        let beyond = |rmse: f64| (rmse * rmse - noise).max(0.0).sqrt();
        let after = beyond(after.rmse);
        let value = after / beyond(before.rmse).max(f64::MIN_POSITIVE);
        let passed = value <= CONFIRMED;
        tests.push(Test { name: "held-out residual, share left", value, threshold: CONFIRMED, passed });
        if let Some(control) = control {
            let value = after / beyond(control).max(f64::MIN_POSITIVE);
            let threshold = CONTROL.recip();
            tests.push(Test {
                name: "held-out residual over that of a wrong effect",
                value,
                threshold,
                passed: value <= threshold,
            });
        }
    }
    Ok(tests)
}

/// What `best` leaves beyond the noise, as a share of what it takes away from `base` (of mean squares of plain residuals).
pub(in crate::diagnose) fn left_over_taken_away(
    context: &Context,
    (base, best): (&Hypothesis, &Hypothesis),
    floor: f64,
) -> Result<f64> {
    let square = |model: &Hypothesis| -> Result<f64> {
        let plain = context.joint(&model.structure).plain_residuals(&model.fit.point)?;
        Ok(rmse(context.recordings(), &plain, 0.0).powi(2))
    };
    let (before, after) = (square(base)?, square(best)?);
    Ok((after - floor).max(0.0) / (before - after).max(f64::MIN_POSITIVE))
}

/// Whether effects that were found with the noise as it is leave so much that none found with more noise can pass
/// [`practical_tests`]: those are fitted less closely.
pub(in crate::diagnose) fn leaves_too_much(context: &Context<'_>, found: &Selection, floor: f64) -> Result<bool> {
    let Some(best) = &found.best else { return Ok(false) };
    Ok(left_over_taken_away(context, (&found.base, best), floor)? > FAR * largest_left_share(context))
}

/// The largest share that any effects may leave of what they take away.
pub(in crate::diagnose) fn largest_left_share(context: &Context<'_>) -> f64 {
    let certain = (0..context.catalogue.len()).any(|entry| is_required(context, entry));
    if certain { LEFT_SHARE_CERTAIN } else { LEFT_SHARE }
}

/// The noise of these recordings as a mean square of plain residuals.
pub(in crate::diagnose) fn noise_floor(recordings: &[PreparedRecording]) -> f64 {
    let (mut squares, mut samples) = (0.0, 0.0);
    for recording in recordings {
        let (yardsticks, width) = (recording.yardsticks(), recording.width());
        let kept = recording.keep.iter().enumerate().filter(|(_, keep)| **keep);
        squares += kept.map(|(i, _)| (recording.noise[i % width] / yardsticks[i % width]).powi(2)).sum::<f64>();
        samples += recording.count() as f64 / recording.values_per_sample();
    }
    squares / f64::max(samples, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::judge::adequacy::is_adequate;
    use crate::diagnose::tests::zoo::{FRICTION, NOISE_RAD, in_swings};

    use crate::diagnose::hypothesis::forward_selection::search;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::judge::held_out_proof::validate;

    #[test]
    fn an_effect_that_takes_nearly_all_away_is_significant() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let found = search(context, fit_without_effects(context).unwrap(), is_adequate, &|_| {}).unwrap();
            let reach = |model| validate(context, model).unwrap().unwrap();
            let (before, after) = (reach(&found.base), reach(found.best.as_ref().unwrap()));
            let floors = (noise_floor(context.recordings()), noise_floor(&context.evidence.validation));
            assert!((floors.0.sqrt() / NOISE_RAD - 1.0).abs() < 0.2, "{floors:?}");
            let tests = practical_tests(context, &found, floors, Some((&before, &after)), None).unwrap();
            assert!(tests.len() == 3 && tests.iter().all(|t| t.passed), "{tests:?}");
            // The same effect that leaves what it found takes nothing away.
            let tests = practical_tests(context, &found, floors, Some((&before, &before)), None).unwrap();
            assert!(tests.iter().any(|t| !t.passed));
        });
    }
}
