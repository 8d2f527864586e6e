//! Grid search over the coefficients of candidates with a growing horizon: what makes a motion swing has many local minima, and the first
//! part of the recordings the fewest.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::scale::BRIEF;
use super::stage::{Stage, finish};
use crate::diagnose::hypothesis::candidate_scores::CandidateFit;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::joint::{Effort, Point, spread};
use crate::diagnose::hypothesis::structure::Global;

/// Shares of the recordings that are fitted, one after the other.
const HORIZONS: [f64; 3] = [0.3, 0.5, 0.75];
/// The first of these fits, which every start gets.
const FIRST: Effort = Effort { steps: 4, derivatives: 2, ends_measured: false, tolerance: 4.0, horizon: HORIZONS[0] };
/// The least value of the grid in typical sizes, the ratio of one to the next, up to the bound, and the most values to a side.
const LEAST: f64 = 0.3;
const RATIO: f64 = 1.6;
const MOST_VALUES: usize = 11;
/// Rollouts of first parts that this takes at most, by candidates in their order, most promising first.
const BUDGET: usize = 30_000;
/// Starts that go on: of every candidate the one that suits the first part best, and so many of all that suit the whole best.
const GOING_ON: usize = 6;

/// A value of the grid, from which a fit begins.
#[derive(Clone, Copy)]
struct GridPoint {
    /// Position of the candidate among the trials of the stage, and its entry of the catalogue.
    trial: usize,
    entry: usize,
    /// Position among the shared parameters, and the value there.
    place: usize,
    value: f64,
}

/// A start after its first fit.
struct Start<'a> {
    /// Position among the trials of the stage.
    trial: usize,
    model: Hypothesis<'a>,
    /// The misfit of the whole recordings there.
    whole: f64,
}

/// The stage with candidates fitted from afar where that is better than from where they are absent.
pub(super) fn widened<'a>(context: &Context<'a>, mut stage: Stage<'a>) -> Stage<'a> {
    let model = &stage.model;
    let open = stage.trials.iter().enumerate().filter(|(_, trial)| trial.excluded.is_none());
    let of_each = FIRST.derivatives * (model.structure.globals.len() + 1) + FIRST.steps + 2;
    let affordable = BUDGET / (of_each * context.sets().len()).max(1);
    let grids = open.flat_map(|(place, trial)| grid_of(context, model, (place, trial.entry)));
    let starts: Vec<GridPoint> = grids.take(affordable).collect();
    let first = starts.par_iter().filter_map(|start| first_fit(context, model, *start));
    let mut first: Vec<Start> = first.collect();
    first.sort_by(|a, b| a.model.fit.cost.total_cmp(&b.model.fit.cost));
    let mut seen = BTreeSet::new();
    let mut best: Vec<usize> = (0..first.len()).filter(|&place| seen.insert(first[place].trial)).collect();
    let mut by_whole: Vec<usize> = (0..first.len()).collect();
    by_whole.sort_by(|a, b| first[*a].whole.total_cmp(&first[*b].whole));
    best.extend(by_whole.into_iter().take(GOING_ON));
    best.sort_unstable();
    best.dedup();
    let ends: Vec<(usize, Option<Hypothesis>)> =
        best.par_iter().map(|&place| (first[place].trial, grown(context, &first[place].model))).collect();
    for (place, found) in ends {
        let Some(found) = found else { continue };
        let known: &mut CandidateFit = &mut stage.trials[place];
        if known.model.as_ref().is_none_or(|known| found.fit.cost < known.fit.cost) {
            known.model = Some(found);
        }
    }
    finish(context, stage)
}

/// Values of a coefficient from a part of its typical size to its bounds, to both sides.
fn values(global: &Global) -> Vec<f64> {
    let (absent, typical) = global.absent.unwrap_or((0.0, 1.0));
    let side = |sign: f64| {
        let bound = if sign > 0.0 { global.parameter.max } else { global.parameter.min };
        let reach = (bound - absent) * sign;
        let sizes = std::iter::successors(Some(LEAST * typical), |size| Some(size * RATIO));
        sizes
            .take_while(move |size| *size > 0.0 && *size < reach)
            .take(MOST_VALUES)
            .map(move |size| absent + sign * size)
    };
    side(1.0).chain(side(-1.0)).collect()
}

/// The grid of one candidate, the `trial`th of the stage: every coefficient alone.
fn grid_of(context: &Context, model: &Hypothesis, (trial, entry): (usize, usize)) -> Vec<GridPoint> {
    let Ok(structure) = context.structure(&[model.structure.effects.as_slice(), &[entry]].concat()) else {
        return Vec::new();
    };
    let new = structure.globals.iter().enumerate().skip(model.structure.globals.len());
    let each = new.filter(|(_, global)| !global.shape);
    let of = |(place, global)| values(global).into_iter().map(move |value| GridPoint { trial, entry, place, value });
    each.flat_map(of).collect()
}

/// The candidate fitted to the first part of the recordings.
fn first_fit<'a>(context: &Context<'a>, model: &Hypothesis<'a>, start: GridPoint) -> Option<Start<'a>> {
    let GridPoint { trial, entry, place, value } = start;
    let structure = context.structure(&[model.structure.effects.as_slice(), &[entry]].concat()).ok()?;
    let mut parameters = structure.carry(&model.structure, &model.fit.point.parameters);
    parameters[place] = value;
    let joint = context.joint(&structure);
    let start = Point { parameters, nuisances: model.fit.point.nuisances.clone() };
    let fit = joint.fit(start, FIRST).ok()?;
    let whole = spread(&joint.residuals(&fit.point, 1.0).ok()?);
    Some(Start { trial, model: Hypothesis { structure, fit }, whole })
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
    use super::super::stage::stage;
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};
    use crate::simulator::Parameter;

    fn global(bounds: (f64, f64), absent: (f64, f64)) -> Global {
        let parameter = Parameter::new("p", "1", absent.0, bounds.0, bounds.1).unwrap();
        Global { parameter, object: None, effect: Some((0, 0)), absent: Some(absent), shape: false }
    }

    #[test]
    fn the_grid_goes_from_a_part_of_the_typical_size_to_the_bounds_of_both_sides() {
        let found = values(&global((0.0, 0.1), (0.0, 0.01)));
        assert_eq!(found.len(), 8, "{found:?}");
        assert!(found[0] == LEAST * 0.01 && found.iter().all(|value| *value < 0.1));
        let found = values(&global((-1e3, 1e3), (0.0, 0.1)));
        assert_eq!((found.len(), found[0], found[MOST_VALUES]), (2 * MOST_VALUES, LEAST * 0.1, -LEAST * 0.1));
        assert!(values(&global((0.0, 1.0), (1.0, 0.2))).iter().all(|value| *value < 1.0 && *value > 0.0));
    }

    /// A candidate that was not fitted is found from its grid, and one that nothing needs gains nothing.
    #[test]
    fn what_was_not_fitted_is_found() {
        for (truth, gains) in [(&[(FRICTION, 0.15)][..], true), (&[], false)] {
            in_swings(truth, 3, 0, |context| {
                let mut before = stage(context, fit_null(context).unwrap());
                before.trials.iter_mut().for_each(|trial| trial.model = None);
                let found = widened(context, before);
                let friction = entry(context, "viscous_friction");
                let trial = found.trials.iter().find(|trial| trial.entry == friction).unwrap();
                assert_eq!(trial.gain > context.settings.margin, gains, "{}", trial.gain);
                if let (Some(model), true) = (&trial.model, gains) {
                    assert!((model.fit.point.parameters[1] - 0.15).abs() < 0.01, "{:?}", model.fit.point.parameters);
                }
            });
        }
    }
}
