//! Physical plausibility: which coefficients are physical, and which effects are required, optional or implausible.

use crate::Result;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};

/// Why a coefficient of `model` is implausible: outside what is physical, or pushed against a bound.
pub(in crate::diagnose) fn implausible(context: &Context<'_>, model: &Hypothesis) -> Option<String> {
    let spread = (model.deviance(model.scale()) / context.count() as f64).sqrt();
    for (position, &entry) in model.structure.effects.iter().enumerate() {
        for object in 0..context.subjects.len() {
            let effect = &context.catalogue[entry].of[object];
            let places = model.structure.of_effect(position);
            let globals = &model.structure.globals;
            let mine: Vec<usize> =
                places.into_iter().filter(|&g| globals[g].object.is_none_or(|o| o == object)).collect();
            for g in mine {
                let (value, p) = (model.fit.point.parameters[g], &globals[g].parameter);
                let k = globals[g].effect.map_or(0, |e| e.1);
                let coefficient = &effect.coefficients[k];
                let slack = 2.0 * spread * model.fit.covariance[(g, g)].max(0.0).sqrt();
                let (low, high) = effect.plausible[k];
                if value < low - slack || value > high + slack {
                    return Some(format!(
                        "`{}` would be {value:.3e} {}, outside {low} to {high}",
                        p.name, coefficient.unit
                    ));
                }
                if value != coefficient.absent && (value <= p.min || value >= p.max) {
                    return Some(format!("`{}` runs into its bound {value}", p.name));
                }
            }
        }
    }
    None
}

/// Whether the effect has to be there in every object, so that recordings need only say how large it is.
pub(in crate::diagnose) fn is_required(context: &Context<'_>, entry: usize) -> bool {
    context.catalogue[entry].of.iter().all(crate::simulator::Effect::required)
}

/// Whether `other` explains what `entry` does, but is not to be expected of these objects as `entry` is.
pub(in crate::diagnose) fn is_less_plausible(context: &Context<'_>, other: usize, entry: usize) -> bool {
    implausible_reason(context, other).is_some() && implausible_reason(context, entry).is_none()
}

pub(in crate::diagnose) fn implausible_reason(context: &Context<'_>, entry: usize) -> Option<&'static str> {
    let of = &context.catalogue[entry].of;
    of.iter().all(|effect| effect.implausible.is_some()).then_some(of[0].implausible)?
}

/// The simulation with what has to be there, where it is taken to be there; else `None`.
pub(in crate::diagnose) fn required_model<'a>(
    context: &Context<'a>,
    base: &Hypothesis<'a>,
) -> Result<Option<Hypothesis<'a>>> {
    let certain: Vec<usize> = (0..context.catalogue.len()).filter(|&entry| is_required(context, entry)).collect();
    if !context.required_first || certain.is_empty() {
        return Ok(None);
    }
    context.fit_near(&certain, base).map(Some)
}

/// Whether `model` holds nothing that was found, only what was expected.
pub(in crate::diagnose) fn holds_only_required(context: &Context<'_>, model: &Hypothesis) -> bool {
    model.structure.effects.iter().all(|&entry| needs_no_evidence(context, entry))
}

/// Whether the effect is there without having to earn its place.
pub(in crate::diagnose) fn needs_no_evidence(context: &Context<'_>, entry: usize) -> bool {
    context.required_first && is_required(context, entry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};

    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    #[test]
    fn a_negative_friction_is_implausible_and_a_fitted_one_is_not() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let mut model = context.fit_near(&[entry(context, "viscous_friction")], &base).unwrap();
            assert_eq!(implausible(context, &model), None);
            model.fit.point.parameters[1] = -0.2;
            assert!(implausible(context, &model).unwrap().contains("outside 0 to 1.5"));
        });
    }

    #[test]
    fn nothing_is_required_of_a_pendulum() {
        in_swings(&[], 1, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let first = Context { required_first: true, ..context.clone() };
            assert!(required_model(&first, &base).unwrap().is_none());
            assert!((0..first.catalogue.len()).all(|e| !is_required(&first, e) && !is_less_plausible(&first, e, 0)));
        });
    }
}
