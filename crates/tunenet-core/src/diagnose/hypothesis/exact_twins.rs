//! Exact twins of effects: what no recording distinguishes from them, by what the catalogue says of both.

use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::simulator::Text;

/// The twins of an effect as `model` has it, by their positions in the catalogue, each with what distinguishes both.
pub(in crate::diagnose) fn exact_twins<'c>(
    context: &'c Context,
    model: &Hypothesis,
    entry: usize,
) -> Vec<(usize, &'c Text)> {
    let structure = &model.structure;
    let Some(position) = structure.effects.iter().position(|&e| e == entry) else { return Vec::new() };
    let own = structure.of_effect(position);
    let value =
        |&g: &usize| (model.fit.point.parameters[g], structure.globals[g].absent.map_or(0.0, |(absent, _)| absent));
    let alike = context.catalogue[entry].of[0].exact_twins.iter().filter(|twin| twin.side.holds(own.iter().map(value)));
    let known = |name: &Text| context.catalogue.iter().position(|other| other.name == *name);
    let found = alike.filter_map(|twin| Some((known(&twin.name)?, &twin.separated_by)));
    found.filter(|(other, _)| !model.has(*other)).collect()
}

/// Puts the twins of every selected effect first among what could be in its place.
pub(in crate::diagnose) fn add_exact_twins(context: &Context, found: &mut Selection) {
    let Some(best) = &found.best else { return };
    for place in &mut found.places {
        for (twin, _) in exact_twins(context, best, place.entry) {
            place.others.retain(|(other, _)| *other != twin);
            place.others.insert(0, (twin, 0.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::catalogue::Entry;
    use crate::diagnose::hypothesis::forward_selection::search;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::judge::adequacy::is_adequate;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};
    use crate::simulator::{Side, Twin};

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
            for (side, expected) in [(Side::Any, true), (Side::Above, true)] {
                let context = with_twin(plain, side);
                let base = fit_without_effects(&context).unwrap();
                let mut found = search(&context, base, is_adequate, &|_| {}).unwrap();
                add_exact_twins(&context, &mut found);
                let rest = entry(&context, "rest_angle");
                assert_eq!(found.places[0].others.first() == Some(&(rest, 0.0)), expected, "{side:?}");
                let best = found.best.as_ref().unwrap();
                let below = Hypothesis {
                    structure: context.structure(&best.structure.effects).unwrap(),
                    fit: best.fit.clone(),
                };
                let mut below = below;
                let own = below.structure.of_effect(0)[0];
                below.fit.point.parameters[own] = -0.1;
                let twins = exact_twins(&context, &below, found.places[0].entry);
                assert_eq!(twins.len(), usize::from(side == Side::Any));
            }
        });
    }
}
