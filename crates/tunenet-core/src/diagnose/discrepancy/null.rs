//! The simulation without effects, from several starts: dry and viscous friction have local minima that no single start leaves
//! (multistart with Halton's points: Halton 1960; of a robot with several joints, from where an evolution strategy leads each of them).

use super::scale::{BRIEF, FINISH};
use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::diagnose::hypothesis::joint::{Effort, Joint, Outcome, Point, Which, spread};
use crate::diagnose::hypothesis::multistart::{PRIMES, radical_inverse};
use crate::estimate::blockwise_search::blockwise_search;
use crate::estimate::separable_blocks::{Blocks, Place};
use crate::simulator::Parameter;

/// Points within the bounds that are looked at, for each channel.
const LOOKED_AT: usize = 40;
/// Points of several joints are compared by so many recordings at most.
const FEW: usize = 4;
/// Searches of every block of a robot with several joints, each from a part of these points.
const SEARCHES: usize = 3;
/// The best of them from which fits begin, next to the values of the files.
const STARTS: usize = 4;
/// Fits that go on to the end.
const FINISHED: usize = 2;
/// Such a fit where several channels are measured: it has many parameters.
const FINISH_OF_SEVERAL: Effort = Effort { steps: 60, derivatives: 25, ..FINISH };
/// So many of the best candidates lead to other starts.
const STRIPPED: usize = 2;
/// The share of each recording that shows a basin before late motion has made many.
const BEGINNING: f64 = 0.5;
/// Bounds are decades apart where the upper one is at least so many times the lower one.
const DECADES: f64 = 100.0;
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
    let width = context.recordings().first().map_or(1, PreparedRecording::width);
    let nth_start = |number: u32| {
        let each = structure.shared.iter().map(|shared| &shared.parameter).zip(PRIMES.iter().copied().cycle());
        let value = |(parameter, prime): (&Parameter, u32)| {
            // Of one joint no search follows, and fits begin from values near the lower bounds.
            let spacing = if width > 1 { Spacing::of(parameter) } else { Spacing::Squares };
            spacing.value(parameter, radical_inverse(number, prime))
        };
        point(each.map(value).collect())
    };
    let shown_by = if width > 1 { joint.recordings.len().min(FEW) } else { joint.recordings.len() };
    let few = Joint { recordings: &joint.recordings[..shown_by], ..context.joint(&structure) };
    let mut looked: Vec<(f64, Place)> = (1..)
        .take(LOOKED_AT * width)
        .map(nth_start)
        .filter_map(|start| {
            let left = few.residuals(&start, 1.0).ok()?;
            Some((spread(&left), Place::new(start, &left, width)))
        })
        .collect();
    looked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let blocks = blocks(&joint, &given, width);
    let places: Vec<Place> = looked.into_iter().map(|(_, place)| place).collect();
    let starts: Vec<Point> = match &blocks {
        Some(blocks) => searched(&few, blocks, &places).into_iter().collect(),
        None => places.into_iter().take(STARTS).map(|place| place.point).collect(),
    };
    let mut refused = None;
    let mut brief: Vec<Outcome> = Vec::new();
    for start in std::iter::once(given).chain(starts) {
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
    let finish = if blocks.is_some() { FINISH_OF_SEVERAL } else { FINISH };
    let finished = brief.into_iter().take(FINISHED).filter_map(|found| joint.fit(found.point, finish).ok());
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

/// Where searches of every block lead, each from what suits it best of a part of these places; `None` where there are none.
fn searched(joint: &Joint, blocks: &Blocks, places: &[Place]) -> Option<Point> {
    let bounds: Vec<&Parameter> = joint.structure.shared.iter().map(|shared| &shared.parameter).collect();
    let one = |part: usize| {
        let own: Vec<Place> = places.iter().skip(part).step_by(SEARCHES).cloned().collect();
        let start = blocks.recombined(&own).or_else(|| Some(own.first()?.point.clone()))?;
        let at = |shares: &[f64]| {
            let each = bounds.iter().zip(shares);
            let parameters = each.map(|(parameter, share)| Spacing::of(parameter).value(parameter, *share)).collect();
            let point = Point { parameters, nuisances: start.nuisances.clone() };
            let left = joint.residuals(&point, 1.0).ok()?;
            Some(Place::new(point, &left, joint.width()))
        };
        let each = bounds.iter().zip(&start.parameters);
        let shares = each.map(|(parameter, value)| Spacing::of(parameter).share(parameter, *value)).collect();
        at(&blockwise_search(blocks, shares, |shares| Some(at(shares)?.misfits)))
    };
    let found: Vec<Place> = (0..SEARCHES).filter_map(one).collect();
    let whole = |place: &Place| place.misfits.iter().sum::<f64>();
    let best = || found.iter().min_by(|a, b| whole(a).total_cmp(&whole(b)));
    blocks.recombined(&found).or_else(|| Some(best()?.point.clone()))
}

/// How values lie evenly between the bounds of a parameter.
#[derive(Clone, Copy)]
enum Spacing {
    /// In equal ratios: one bound is decades above the other, as of a gain of which nothing is known.
    Ratios,
    /// By the square of the share of the way: friction and inertia are rarely near the top of their bounds.
    Squares,
    /// In equal steps.
    Steps,
}

impl Spacing {
    fn of(parameter: &Parameter) -> Self {
        match parameter.min {
            least if least > 0.0 && parameter.max >= DECADES * least => Self::Ratios,
            least if least >= 0.0 => Self::Squares,
            _ => Self::Steps,
        }
    }

    /// The value at a share of the way from the lower to the upper bound.
    fn value(self, parameter: &Parameter, share: f64) -> f64 {
        match self {
            Self::Ratios => parameter.min * (parameter.max / parameter.min).powf(share),
            Self::Squares => parameter.min + share.powi(2) * parameter.span(),
            Self::Steps => parameter.min + share * parameter.span(),
        }
    }

    /// The share at which a value is.
    fn share(self, parameter: &Parameter, value: f64) -> f64 {
        match self {
            Self::Ratios => (value / parameter.min).ln() / (parameter.max / parameter.min).ln(),
            Self::Squares => ((value - parameter.min) / parameter.span()).sqrt(),
            Self::Steps => (value - parameter.min) / parameter.span(),
        }
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
    fn shares_go_from_bound_to_bound_and_back() {
        let of = |least: f64, greatest: f64| Parameter::new("p", "1", greatest, least, greatest).unwrap();
        let (gain, friction, zero) = (of(0.001, 10.0), of(0.0, 2.0), of(-1.0, 1.0));
        let at = |parameter: &Parameter, share: f64| Spacing::of(parameter).value(parameter, share);
        assert!((at(&gain, 0.5) - 0.1).abs() < 1e-12, "in equal ratios");
        assert_eq!((at(&friction, 0.5), at(&zero, 0.5)), (0.5, 0.0));
        for parameter in [gain, friction, zero] {
            for share in [0.0, 0.3, 1.0] {
                let back = Spacing::of(&parameter).share(&parameter, at(&parameter, share));
                assert!((back - share).abs() < 1e-12, "{} {back}", parameter.max);
            }
        }
    }

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
