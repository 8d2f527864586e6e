//! Backward elimination of effects that are significant and negligible next to the others.

use crate::Result;
use crate::diagnose::evidence::rmse;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::Selection;

/// An effect without which less than this share of the mean square comes back that all take away is worth no name.
const NEGLIGIBLE: f64 = 0.01;

/// Mean square of the plain residuals.
fn mean_square(context: &Context<'_>, model: &Hypothesis) -> Result<f64> {
    let plain = context.joint(&model.structure).plain_residuals(&model.fit.point)?;
    Ok(rmse(context.recordings(), &plain, 0.0).powi(2))
}

/// Removes effects, the least first, as long as what each brought is negligible.
pub(in crate::diagnose) fn prune<'a>(context: &Context<'a>, found: &mut Selection<'a>) -> Result<()> {
    let before = mean_square(context, &found.base)?;
    while let Some(best) = &found.best
        && best.structure.effects.len() > 1
    {
        let after = mean_square(context, best)?;
        let mut least: Option<(f64, usize, Hypothesis<'a>)> = None;
        for &entry in &best.structure.effects {
            let others: Vec<usize> = best.structure.effects.iter().copied().filter(|&e| e != entry).collect();
            let without = context.fit_near(&others, best)?;
            let share = (mean_square(context, &without)? - after) / (before - after).max(f64::MIN_POSITIVE);
            if least.as_ref().is_none_or(|(smallest, ..)| share < *smallest) {
                least = Some((share, entry, without));
            }
        }
        let Some((_, entry, without)) = least.filter(|(share, ..)| *share < NEGLIGIBLE) else { break };
        found.selected.retain(|selected| selected.entry != entry);
        found.best = Some(without);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};

    use crate::diagnose::hypothesis::forward_selection::SelectedEffect;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    #[test]
    fn an_effect_that_takes_nothing_away_is_removed() {
        in_swings(&[(FRICTION, 0.2)], 3, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let effects = ["viscous_friction", "rest_angle"].map(|name| entry(context, name));
            let best = context.fit_near(&effects, &base).unwrap();
            let selected = |entry| SelectedEffect {
                entry,
                gain: 50.0,
                p_value: 0.0,
                others: Vec::new(),
                equals: Vec::new(),
                excluded: None,
            };
            let selected = effects.map(selected).to_vec();
            let mut found = Selection { base, alone: Vec::new(), best: Some(best), selected };
            prune(context, &mut found).unwrap();
            assert_eq!(found.best.unwrap().structure.effects, effects[..1]);
            assert_eq!(found.selected.len(), 1);
        });
    }
}
