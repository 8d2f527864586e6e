//! What recordings that were not fitted say of the answer, of the next best, and of a wrong one.

use super::held_out::HeldOut;
use super::search::Found;
use super::sets::Set;
use super::study::{Model, Study};
use crate::Result;

/// Candidates that are tried on held-out recordings.
const MOST_RATIOS: usize = 3;

/// `model` on the held-out recordings, where there are any.
pub(super) fn unseen(study: &Study, model: &Model, sets: &[Set]) -> Result<Option<HeldOut>> {
    if sets.is_empty() { Ok(None) } else { study.held_out(model, sets).map(Some) }
}

/// A wrong effect on the held-out recordings: the candidate that was fitted and gained least.
pub(super) fn control(study: &Study, found: &Found, sets: &[Set]) -> Result<Option<(&'static str, f64)>> {
    let named = |entry: usize| {
        found.places.iter().any(|p| {
            p.entry == entry
                || p.equals.contains(&entry)
                || p.others.iter().any(|(other, gap)| *other == entry && *gap < study.settings.margin)
        })
    };
    let wrong = found.alone.iter().rev().find(|t| t.excluded.is_none() && !named(t.entry));
    let (Some(wrong), false) = (wrong, sets.is_empty()) else { return Ok(None) };
    let model = study.fit_near(&[wrong.entry], &found.base)?;
    Ok(Some((study.catalogue[wrong.entry].name, study.held_out(&model, sets)?.rmse)))
}

/// How far the best candidates, each alone, take the held-out residual down.
pub(super) fn ratios(
    study: &Study,
    found: &Found,
    sets: &[Set],
    before: Option<&HeldOut>,
) -> Result<Vec<(usize, f64)>> {
    let (Some(before), Some(_)) = (before, &found.best) else { return Ok(Vec::new()) };
    let fitted = found.alone.iter().filter_map(|t| t.model.as_ref().map(|model| (t.entry, model)));
    fitted
        .take(MOST_RATIOS)
        .map(|(entry, model)| Ok((entry, study.held_out(model, sets)?.rmse / before.rmse)))
        .collect()
}
