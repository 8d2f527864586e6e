//! Grid search over the coefficients of candidates with a growing horizon: what makes a motion swing has many local minima, and the first
//! part of the recordings the fewest.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::scale::BRIEF;
use super::selection_step::{DiscrepancyStep, finish};
use crate::diagnose::hypothesis::candidate_scores::CandidateFit;
use crate::diagnose::hypothesis::context::{Context, FULL, Hypothesis};
use crate::diagnose::hypothesis::joint::{Effort, Point, spread};
use crate::diagnose::hypothesis::structure::SharedParameter;

/// Shares of the recordings that are fitted, one after the other.
const HORIZONS: [f64; 3] = [0.3, 0.5, 0.75];
/// The first of these fits, which every start gets.
const FIRST: Effort =
    Effort { steps: 4, derivatives: 2, ends_measured: false, tolerance: 4.0, horizon: HORIZONS[0], ..FULL };
/// The least value of the grid in typical sizes, the ratio of one to the next, up to the bound, and the most values to a side.
const LEAST: f64 = 0.3;
const RATIO: f64 = 1.3;
const MOST_VALUES: usize = 20;
/// Rollouts of first parts that this takes at most, by candidates in their order, most promising first.
const BUDGET: usize = 60_000;
/// The least share of the grid that is worth a search.
const COVERED: f64 = 0.25;
/// Starts that go on: of every candidate the one that suits the first part best, and so many of all that suit the whole best.
const GOING_ON: usize = 6;

/// A value of the grid, from which a fit begins.
#[derive(Clone, Copy)]
struct GridPoint {
    /// Position of the candidate in its step, and its entry of the catalogue.
    candidate: usize,
    entry: usize,
    /// Column of the shared parameter, and its value.
    column: usize,
    value: f64,
}

/// A start after its first fit.
struct Start<'a> {
    /// Position of the candidate in its step.
    candidate: usize,
    model: Hypothesis<'a>,
    /// The misfit of the whole recordings there.
    whole: f64,
}

/// The step with candidates fitted from the grid where that is better than from where they are absent.
pub(super) fn widened<'a>(context: &Context<'a>, mut step: DiscrepancyStep<'a>) -> DiscrepancyStep<'a> {
    let model = &step.model;
    let open = step.candidates.iter().enumerate().filter(|(_, candidate)| candidate.excluded.is_none());
    let affordable = affordable(context, model);
    let grids = open.flat_map(|(position, candidate)| grid_of(context, model, (position, candidate.entry)));
    let starts: Vec<GridPoint> = grids.take(affordable).collect();
    let first = starts.par_iter().filter_map(|start| first_fit(context, model, *start));
    let mut first: Vec<Start> = first.collect();
    first.sort_by(|a, b| a.model.fit.cost.total_cmp(&b.model.fit.cost));
    let mut seen = BTreeSet::new();
    let mut best: Vec<usize> = (0..first.len()).filter(|&start| seen.insert(first[start].candidate)).collect();
    let mut by_whole: Vec<usize> = (0..first.len()).collect();
    by_whole.sort_by(|a, b| first[*a].whole.total_cmp(&first[*b].whole));
    best.extend(by_whole.into_iter().take(GOING_ON));
    best.sort_unstable();
    best.dedup();
    let ends: Vec<(usize, Option<Hypothesis>)> =
        best.par_iter().map(|&start| (first[start].candidate, grown(context, &first[start].model))).collect();
    for (candidate, found) in ends {
        let Some(found) = found else { continue };
        let known: &mut CandidateFit = &mut step.candidates[candidate];
        if known.model.as_ref().is_none_or(|known| found.fit.cost < known.fit.cost) {
            known.model = Some(found);
        }
    }
    finish(context, step)
}

/// How many starts the budget has.
fn affordable(context: &Context, model: &Hypothesis) -> usize {
    let of_each = FIRST.derivatives * (model.structure.shared.len() + 1) + FIRST.steps + 4;
    BUDGET / (of_each * context.recordings().len()).max(1)
}

/// Whether the budget covers enough of the grid of all candidates in addition to `model`: of many joints it covers one candidate alone.
pub(super) fn is_affordable(context: &Context, model: &Hypothesis) -> bool {
    let whole: usize = (0..context.catalogue.len()).map(|entry| grid_of(context, model, (0, entry)).len()).sum();
    affordable(context, model) as f64 >= COVERED * whole as f64
}

/// Values of a coefficient from a part of its typical size to its bounds, to both sides.
fn values(shared: &SharedParameter) -> Vec<f64> {
    let (absent, typical) = shared.absent.unwrap_or((0.0, 1.0));
    let side = |sign: f64| {
        let bound = if sign > 0.0 { shared.parameter.max } else { shared.parameter.min };
        let reach = (bound - absent) * sign;
        let sizes = std::iter::successors(Some(LEAST * typical), |size| Some(size * RATIO));
        sizes
            .take_while(move |size| *size > 0.0 && *size < reach)
            .take(MOST_VALUES)
            .map(move |size| absent + sign * size)
    };
    side(1.0).chain(side(-1.0)).collect()
}

/// The grid of one candidate, given by its position in its step and its entry of the catalogue: every coefficient alone.
fn grid_of(context: &Context, model: &Hypothesis, (candidate, entry): (usize, usize)) -> Vec<GridPoint> {
    let Ok(structure) = context.structure(&[model.structure.effects.as_slice(), &[entry]].concat()) else {
        return Vec::new();
    };
    let new = structure.shared.iter().enumerate().skip(model.structure.shared.len());
    let each = new.filter(|(_, shared)| !shared.shape);
    let of =
        |(column, shared)| values(shared).into_iter().map(move |value| GridPoint { candidate, entry, column, value });
    each.flat_map(of).collect()
}

/// The candidate fitted to the first part of the recordings.
fn first_fit<'a>(context: &Context<'a>, model: &Hypothesis<'a>, start: GridPoint) -> Option<Start<'a>> {
    let GridPoint { candidate, entry, column, value } = start;
    let structure = context.structure(&[model.structure.effects.as_slice(), &[entry]].concat()).ok()?;
    let joint = context.joint(&structure);
    // Where something large is missing, the fit without it may be farther from what is true than the values of the files.
    let given: Vec<f64> = model.structure.shared.iter().map(|shared| shared.parameter.value).collect();
    let starts = [&model.fit.point.parameters, &given].map(|from| {
        let mut parameters = structure.carry(&model.structure, from);
        parameters[column] = value;
        Point { parameters, nuisances: model.fit.point.nuisances.clone() }
    });
    let misfit = |start: &Point| joint.residuals(start, FIRST.horizon).map_or(f64::INFINITY, |all| spread(&all));
    let [fitted, given] = starts;
    let start = if misfit(&given) < misfit(&fitted) { given } else { fitted };
    let fit = joint.fit(start, FIRST).ok()?;
    let whole = spread(&joint.residuals(&fit.point, 1.0).ok()?);
    Some(Start { candidate, model: Hypothesis { structure, fit }, whole })
}

/// A start fitted to more and more of the recordings.
fn grown<'a>(context: &Context<'a>, from: &Hypothesis<'a>) -> Option<Hypothesis<'a>> {
    let structure = context.structure(&from.structure.effects).ok()?;
    let joint = context.joint(&structure);
    let mut point = from.fit.point.clone();
    for horizon in HORIZONS.into_iter().skip(1) {
        point = joint.fit(point, Effort { horizon, ..BRIEF }).ok()?.point;
    }
    let fit = joint.fit(point, BRIEF).ok()?;
    Some(Hypothesis { structure, fit })
}

#[cfg(test)]
mod tests {
    use super::super::null::fit_null;
    use super::super::selection_step::selection_step;
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};
    use crate::simulator::Parameter;

    fn shared(bounds: (f64, f64), absent: (f64, f64)) -> SharedParameter {
        let parameter = Parameter::new("p", "1", absent.0, bounds.0, bounds.1).unwrap();
        SharedParameter { parameter, object: None, effect: Some((0, 0)), absent: Some(absent), shape: false }
    }

    #[test]
    fn the_grid_goes_from_a_part_of_the_typical_size_to_the_bounds_of_both_sides() {
        let found = values(&shared((0.0, 0.1), (0.0, 0.01)));
        assert_eq!(found.len(), 14, "{found:?}");
        assert!(found[0] == LEAST * 0.01 && found.iter().all(|value| *value < 0.1));
        let found = values(&shared((-1e3, 1e3), (0.0, 0.1)));
        assert_eq!((found.len(), found[0], found[MOST_VALUES]), (2 * MOST_VALUES, LEAST * 0.1, -LEAST * 0.1));
        assert!(values(&shared((0.0, 1.0), (1.0, 0.2))).iter().all(|value| *value < 1.0 && *value > 0.0));
    }

    /// A candidate that was not fitted is found from its grid, and one that nothing needs gains nothing.
    #[test]
    fn what_was_not_fitted_is_found() {
        for (truth, gains) in [(&[(FRICTION, 0.15)][..], true), (&[], false)] {
            in_swings(truth, 3, 0, |context| {
                let mut before = selection_step(context, fit_null(context).unwrap());
                before.candidates.iter_mut().for_each(|candidate| candidate.model = None);
                let found = widened(context, before);
                let friction = entry(context, "viscous_friction");
                let candidate = found.candidates.iter().find(|candidate| candidate.entry == friction).unwrap();
                assert_eq!(candidate.gain > context.settings.margin, gains, "{}", candidate.gain);
                if let (Some(model), true) = (&candidate.model, gains) {
                    assert!((model.fit.point.parameters[1] - 0.15).abs() < 0.01, "{:?}", model.fit.point.parameters);
                }
            });
        }
    }
}
