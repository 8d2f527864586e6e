//! The simulation without effects, from several starts: dry and viscous friction have local minima that no single start leaves
//! (multistart with Halton's points: Halton 1960).

use super::scale::{BRIEF, FINISH};
use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::diagnose::hypothesis::joint::{Effort, Joint, Outcome, Point, Which, spread};
use crate::diagnose::hypothesis::multistart::{PRIMES, radical_inverse};
use crate::estimate::separable_blocks::{Blocks, Place};

/// Points within the bounds that are looked at.
const LOOKED_AT: u32 = 40;
/// The best of them from which fits begin, next to the values of the files.
const STARTS: usize = 4;
/// Fits that go on to the end.
const FINISHED: usize = 2;
/// So many of the best candidates lead to other starts.
const STRIPPED: usize = 2;
/// The share of each recording that shows a basin before late motion has made many.
const BEGINNING: f64 = 0.5;
/// Another minimum is lower by at least so much in cost: what the information criterion takes for a clear difference.
const BETTER: f64 = 3.0;

/// The best fit of the simulation as it is.
///
/// # Errors
/// Where every start is refused.
pub(in crate::diagnose) fn fit_null<'a>(context: &Context<'a>) -> Result<Hypothesis<'a>> {
    let structure = context.structure(&[])?;
    let joint = context.joint(&structure);
    let nuisances: Vec<Vec<f64>> = context.recordings().iter().map(|r| r.prepared.nuisance_values()).collect();
    let point = |parameters: Vec<f64>| Point { parameters, nuisances: nuisances.clone() };
    let given = point(structure.shared.iter().map(|shared| shared.parameter.value).collect());
    let nth_start = |number: u32| {
        let each = structure.shared.iter().map(|shared| &shared.parameter).zip(PRIMES.iter().copied().cycle());
        // The square of a share: sizes of friction and inertia are rarely near the top of their bounds.
        let share = |number, prime| radical_inverse(number, prime).powi(2);
        point(each.map(|(p, prime)| p.min + share(number, prime) * p.span()).collect())
    };
    let width = context.recordings().first().map_or(1, PreparedRecording::width);
    let mut looked: Vec<(f64, Place)> = (1..=LOOKED_AT)
        .map(nth_start)
        .filter_map(|start| {
            let left = joint.residuals(&start, 1.0).ok()?;
            Some((spread(&left), Place::new(start, &left, width)))
        })
        .collect();
    looked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let blocks = blocks(&joint, &given, width);
    let places: Vec<Place> = looked.into_iter().map(|(_, place)| place).collect();
    let joined = blocks.as_ref().and_then(|blocks| blocks.recombined(&places));
    let across = places.into_iter().take(STARTS).map(|place| place.point);
    let mut refused = None;
    let mut brief: Vec<Outcome> = Vec::new();
    for start in std::iter::once(given).chain(joined).chain(across) {
        match joint.fit(start, BRIEF) {
            Ok(found) => brief.push(found),
            Err(error) => refused = Some(error),
        }
    }
    let found = |fit: &Outcome| Place::new(fit.point.clone(), &fit.residuals, width);
    let places: Vec<Place> = brief.iter().map(found).collect();
    let joined = blocks.as_ref().and_then(|blocks| blocks.recombined(&places));
    brief.extend(joined.and_then(|start| joint.fit(start, BRIEF).ok()));
    brief.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let finished = brief.into_iter().take(FINISHED).filter_map(|found| joint.fit(found.point, FINISH).ok());
    let best = finished.min_by(|a, b| a.cost.total_cmp(&b.cost));
    match (best, refused) {
        (Some(fit), _) => Ok(Hypothesis { structure, fit }),
        (None, Some(error)) => Err(error),
        (None, None) => Err(crate::Error::Simulator {
            at: "every start".into(),
            message: "no start within the bounds could be simulated".into(),
        }),
    }
}

/// Which channels share parameters, by derivatives at `point`, where several channels are measured.
fn blocks(joint: &Joint, point: &Point, width: usize) -> Option<Blocks> {
    let left = (width > 1).then(|| joint.residuals(point, 1.0).ok()).flatten()?;
    let columns = joint.columns(point, &left, Which { nuisances: false, ..Which::ALL });
    Some(Blocks::new(&columns, width, joint.structure.shared.len()))
}

/// A better fit of the simulation as it is than `base`, from where effects of `found` lead to, with these taken away, or from where the
/// first half of the recordings does; `None` where there is none. What an effect gains by leading out of a local minimum is not its own.
pub(in crate::diagnose) fn better_null<'a>(
    context: &Context<'a>,
    base: &Hypothesis<'a>,
    found: &Selection<'a>,
) -> Result<Option<Hypothesis<'a>>> {
    let structure = context.structure(&[])?;
    let joint = context.joint(&structure);
    let count = structure.shared.len();
    let near = |model: &Hypothesis| Point {
        parameters: model.fit.point.parameters[..count].to_vec(),
        nuisances: base.fit.point.nuisances.clone(),
    };
    let earning = found.alone.iter().filter(|candidate| candidate.gain > context.settings.margin);
    let alone = earning.filter_map(|candidate| candidate.model.as_ref()).take(STRIPPED);
    let mut starts: Vec<Point> = found.best.iter().chain(alone).map(near).collect();
    if !starts.is_empty() {
        let early = joint.fit(base.fit.point.clone(), Effort { horizon: BEGINNING, ..BRIEF });
        starts.extend(early.map(|early| early.point));
    }
    let fits = starts.into_iter().filter_map(|start| joint.fit(start, BRIEF).ok());
    let Some(best) = fits.min_by(|a, b| a.cost.total_cmp(&b.cost)) else { return Ok(None) };
    if best.cost > base.fit.cost - BETTER {
        return Ok(None);
    }
    let fit = joint.fit(best.point, FINISH)?;
    Ok(Some(Hypothesis { structure, fit }))
}

/// The simulation as it is, fitted from the values of `near`, if that is a better minimum than `base`.
///
/// # Errors
/// Where the simulator refuses.
pub(in crate::diagnose) fn lower_null<'a>(
    context: &Context<'a>,
    base: &Hypothesis<'a>,
    near: &Hypothesis<'a>,
) -> Result<Option<Hypothesis<'a>>> {
    let found = context.fit_near_with(&[], near, FINISH)?;
    Ok((found.fit.cost < base.fit.cost - BETTER).then_some(found))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::forward_selection::search;
    use crate::diagnose::judge::adequacy::is_adequate;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings};

    #[test]
    fn the_parameter_is_found_from_afar() {
        in_swings(&[], 3, 0, |context| {
            let base = fit_null(context).unwrap();
            assert!((base.fit.point.parameters[0] - 0.8).abs() < 1e-3, "{:?}", base.fit.point.parameters);
        });
    }

    #[test]
    fn a_lower_minimum_replaces_a_fit_and_an_equal_one_does_not() {
        in_swings(&[], 3, 0, |context| {
            let best = fit_null(context).unwrap();
            assert!(lower_null(context, &best, &best).unwrap().is_none());
            let structure = context.structure(&[]).unwrap();
            let mut fit = best.fit.clone();
            fit.cost += 100.0;
            let found = lower_null(context, &Hypothesis { structure, fit }, &best).unwrap().unwrap();
            assert!((found.fit.cost - best.fit.cost).abs() < 1.0);
        });
    }

    /// From a fit that is wrong an effect leads back; from the best one nothing does.
    #[test]
    fn a_better_fit_is_found_where_an_effect_leads_and_none_beyond_the_best() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let best = fit_null(context).unwrap();
            let again = || Hypothesis { structure: context.structure(&[]).unwrap(), fit: best.fit.clone() };
            let found = search(context, again(), is_adequate, &|_| {}).unwrap();
            assert!(better_null(context, &best, &found).unwrap().is_none());
            let mut wrong = again();
            wrong.fit.point.parameters[0] = 0.9;
            wrong.fit.cost = best.fit.cost + 100.0;
            let better = better_null(context, &wrong, &found).unwrap().unwrap();
            assert!((better.fit.cost - best.fit.cost).abs() < 1.0);
            assert!(
                better_null(context, &wrong, &Selection::tuned(again())).unwrap().is_none(),
                "nothing leads anywhere"
            );
        });
    }
}
