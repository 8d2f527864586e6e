//! Negative control: the held-out residual with a wrong effect, which a right one has to go well below, and with the best candidates.

use crate::Result;
use crate::diagnose::hypothesis::context::{COMPARED, Context};
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::diagnose::judge::held_out_proof::{HeldOut, validate_near};
use crate::simulator::Text;

/// Candidates that are tried on held-out recordings.
const MOST_RATIOS: usize = 3;

/// A wrong effect on the held-out recordings, the candidate that was fitted and gained least: its name and what it reaches. `before` is
/// what the simulation without effects reaches in the same context.
pub(in crate::diagnose) fn negative_control(
    context: &Context,
    found: &Selection,
    before: Option<&HeldOut>,
) -> Result<Option<(Text, f64)>> {
    let named = |entry: usize| {
        found.selected.iter().any(|p| {
            p.entry == entry
                || p.equals.contains(&entry)
                || p.others.iter().any(|(other, gap)| *other == entry && *gap < context.settings.margin)
        })
    };
    let wrong = found.alone.iter().rev().find(|c| c.excluded.is_none() && !named(c.entry));
    let (Some(wrong), Some(before)) = (wrong, before) else { return Ok(None) };
    let model = context.fit_near_with(&[wrong.entry], &found.base, COMPARED)?;
    Ok(validate_near(context, &model, before)?
        .map(|reached| (context.catalogue[wrong.entry].name.clone(), reached.rmse)))
}

/// How far the best candidates, each alone, take the held-out residual down.
pub(in crate::diagnose) fn ratios(
    context: &Context,
    found: &Selection,
    before: Option<&HeldOut>,
) -> Result<Vec<(usize, f64)>> {
    let (Some(before), Some(_)) = (before, &found.best) else { return Ok(Vec::new()) };
    let fitted = found.alone.iter().filter_map(|c| c.model.as_ref().map(|model| (c.entry, model)));
    let ratio = |(entry, model)| {
        Ok(validate_near(context, model, before)?.map(|reached: HeldOut| (entry, reached.rmse / before.rmse)))
    };
    fitted.take(MOST_RATIOS).filter_map(|one| ratio(one).transpose()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::judge::adequacy::is_adequate;
    use crate::diagnose::judge::held_out_proof::validate;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings};

    use crate::diagnose::hypothesis::forward_selection::search;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    #[test]
    fn a_wrong_effect_does_not_reach_what_the_true_one_does() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let found = search(context, fit_without_effects(context).unwrap(), is_adequate, &|_| {}).unwrap();
            let before = validate(context, &found.base).unwrap();
            let (name, wrong) = negative_control(context, &found, before.as_ref()).unwrap().unwrap();
            let reached = validate(context, found.best.as_ref().unwrap()).unwrap().unwrap().rmse;
            assert!(name != "viscous_friction" && wrong > 1.3 * reached, "{name}: {wrong} {reached}");
            let ratios = ratios(context, &found, before.as_ref()).unwrap();
            assert_eq!(context.catalogue[ratios[0].0].name, "viscous_friction");
            assert!(ratios[0].1 < 0.5, "{ratios:?}");
        });
    }
}
