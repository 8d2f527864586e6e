//! What effects that a diagnosis named begin with in a search for a law.

use tunenet_core::diagnose::NamedEffect;
use tunenet_core::law::Named;

/// An effect of a diagnosis of one object, with what was found of it.
pub fn named(one: &NamedEffect) -> Named {
    let values = one.coefficients.iter().flat_map(|fitted| &fitted.values).map(|value| value.value);
    Named { name: one.effect.name.to_string(), values: values.collect() }
}
