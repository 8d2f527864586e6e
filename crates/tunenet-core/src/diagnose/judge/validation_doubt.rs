//! What keeps a name in doubt although every test of the residual passed: a discrepancy that remains, and held-out recordings that
//! do not bear the effects out.

use crate::diagnose::hypothesis::context::Context;
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::diagnose::hypothesis::plausibility::is_required;
use crate::diagnose::judge::held_out_proof::HeldOut;
use crate::diagnose::judge::random_effect_diagnostics::p_value_of_draws;

/// The right effects leave of held-out recordings no more than this many times what they leave of those that were fitted. Over 600
/// blind sets 99 % of the right names stay below 1.09, and wrong ones exceed 1.25.
const HELD_OUT_OVER_FITTED: f64 = 1.2;

/// Draws that are less probable than this as random ones are not.
const DRAWS_SIGNIFICANCE: f64 = 0.01;

/// Why the effects found are not named alone; `None` where nothing speaks against it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::diagnose) enum ValidationDoubt {
    /// They are practically significant, and leave more than noise.
    DiscrepancyRemains,
    /// They worsen the forecast of held-out recordings.
    ForecastWorse,
    /// Draws of a random effect depend on their recording or on the motion.
    DrawsNotRandom,
    /// They leave more of held-out recordings than of those that were fitted.
    HeldOutUnexplained,
}

impl ValidationDoubt {
    /// In words, to stand before "so".
    pub fn text(self) -> &'static str {
        match self {
            Self::DiscrepancyRemains => "a discrepancy beyond noise remains that no effect explains",
            Self::ForecastWorse => "the forecast of held-out recordings gets worse with it",
            Self::DrawsNotRandom => "deflections at contacts depend on the recording or on the motion",
            Self::HeldOutUnexplained => "held-out recordings leave more than those that were fitted",
        }
    }
}

/// What speaks against naming the effects of `found` alone. `fitted` is the root mean square of what they leave of the recordings
/// that were fitted, or the noise where that is larger; `practical` is whether they are practically significant only.
///
/// Effects that are physically required exist anyhow: that they leave something is no doubt of them. Logs of a driven mechanism never
/// reach noise level, and are left to their own tests.
pub(in crate::diagnose) fn validation_doubt(
    context: &Context,
    found: &Selection,
    (before, after): (Option<&HeldOut>, Option<&HeldOut>),
    fitted: f64,
    practical: bool,
) -> Option<ValidationDoubt> {
    let best = found.best.as_ref().filter(|_| !context.evidence.driven())?;
    if best.structure.effects.iter().all(|&entry| is_required(context, entry)) {
        return None;
    }
    if practical {
        return Some(ValidationDoubt::DiscrepancyRemains);
    }
    if p_value_of_draws(context, best, after) < DRAWS_SIGNIFICANCE {
        return Some(ValidationDoubt::DrawsNotRandom);
    }
    let (before, after) = (before?, after?);
    if after.forecast > before.forecast {
        Some(ValidationDoubt::ForecastWorse)
    } else if after.rmse > HELD_OUT_OVER_FITTED * fitted {
        Some(ValidationDoubt::HeldOutUnexplained)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::forward_selection::search;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::judge::adequacy::is_adequate;
    use crate::diagnose::judge::held_out_proof::validate;
    use crate::diagnose::tests::zoo::{FRICTION, NOISE_RAD, in_swings};

    #[test]
    fn a_right_name_stands_and_a_worse_forecast_is_a_doubt() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let found = search(context, fit_without_effects(context).unwrap(), is_adequate, &|_| {}).unwrap();
            let before = validate(context, &found.base).unwrap().unwrap();
            let after = validate(context, found.best.as_ref().unwrap()).unwrap().unwrap();
            let doubt = |after: &HeldOut, practical| {
                validation_doubt(context, &found, (Some(&before), Some(after)), NOISE_RAD, practical)
            };
            assert_eq!(doubt(&after, false), None);
            assert_eq!(doubt(&after, true), Some(ValidationDoubt::DiscrepancyRemains));
            let worse = HeldOut { forecast: 1.01 * before.forecast, ..after.clone() };
            assert_eq!(doubt(&worse, false), Some(ValidationDoubt::ForecastWorse));
            let unexplained = HeldOut { rmse: 1.3 * NOISE_RAD, ..after };
            assert_eq!(doubt(&unexplained, false), Some(ValidationDoubt::HeldOutUnexplained));
        });
    }

    #[test]
    fn without_effects_there_is_nothing_to_doubt() {
        in_swings(&[], 3, 0, |context| {
            let found = search(context, fit_without_effects(context).unwrap(), is_adequate, &|_| {}).unwrap();
            assert_eq!(validation_doubt(context, &found, (None, None), NOISE_RAD, true), None);
        });
    }
}
