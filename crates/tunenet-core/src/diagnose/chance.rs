//! Chance at contacts weighed against the catalogue.

use super::Progress;
use super::answer::Test;
use super::catalogue::Entry;
use super::joint::{Outcome, Point};
use super::scatter::Scatter;
use super::search::{Found, Place};
use super::stage::Trial;
use super::study::{Model, Study};
use crate::Result;

/// Whether chance at contacts explains more than anything else, or what nothing else does.
pub(super) fn by_chance(study: &Study, found: &mut Found, tests: &[Test]) -> Result<Option<Scatter>> {
    let significant = |s: &Scatter| s.gain > study.settings.margin && s.p_value < study.settings.significance;
    let alone = study.scatter(&found.base)?.filter(significant);
    if let (Some(chance), Some(entry)) = (&alone, study.catalogue.iter().position(Entry::chance)) {
        found.alone.push(Trial::unfitted(entry, chance.gain));
        found.alone.sort_by(Trial::order);
    }
    // At the misfit's own scale, as the gain by chance is.
    let others = found.best.as_ref().map_or(0.0, |best| study.gain(&found.base, best, found.base.scale()));
    if alone.as_ref().is_some_and(|s| s.gain > others) {
        return Ok(alone);
    }
    let adequate = tests.iter().all(|t| t.passed);
    match &found.best {
        Some(best) if !adequate => Ok(study.scatter(best)?.filter(significant)),
        _ => Ok(None),
    }
}

/// The search again, every bounce with a tilt of its own.
pub(super) fn with_chance<'a>(
    study: &Study<'a>,
    plain: Found<'a>,
    scatter: &Scatter,
    progress: &dyn Fn(Progress),
) -> Result<Found<'a>> {
    let entry = study.catalogue.iter().position(Entry::chance).unwrap_or(0);
    let mut own = plain.base.fit.point.own.clone();
    own.iter_mut().zip(&scatter.unknowns).for_each(|(own, tilts)| own.extend(tilts.iter().map(|t| t.value)));
    let near = Model {
        structure: study.structure(&[])?,
        fit: Outcome { point: Point { globals: plain.base.fit.point.globals.clone(), own }, ..plain.base.fit.clone() },
    };
    let base = study.fit_near(&[], &near)?;
    let again = study.search(base, progress)?;
    let place = Place { entry, gain: scatter.gain, p_value: scatter.p_value, others: Vec::new(), equals: Vec::new() };
    let places = std::iter::once(place).chain(again.places).collect();
    let best = Some(again.best.unwrap_or(again.base));
    Ok(Found { base: plain.base, alone: plain.alone, best, places })
}
