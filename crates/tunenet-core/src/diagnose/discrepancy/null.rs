//! The simulation without effects, from several starts: dry and viscous friction have local minima that no single start leaves
//! (multistart with Halton's points: Halton 1960).

use super::scale::{BRIEF, FINISH};
use crate::Result;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::joint::{Outcome, Point, spread};
use crate::diagnose::hypothesis::multistart::{PRIMES, radical_inverse};

/// Points within the bounds that are looked at.
const LOOKED_AT: u32 = 40;
/// The best of them from which fits begin, next to the values of the files.
const STARTS: usize = 4;
/// Fits that go on to the end.
const FINISHED: usize = 2;

/// The best fit of the simulation as it is.
///
/// # Errors
/// Where every start is refused.
pub(in crate::diagnose) fn fit_null<'a>(context: &Context<'a>) -> Result<Hypothesis<'a>> {
    let structure = context.structure(&[])?;
    let joint = context.joint(&structure);
    let nuisances: Vec<Vec<f64>> = context.sets().iter().map(|s| s.prepared.nuisance_values()).collect();
    let point = |parameters: Vec<f64>| Point { parameters, nuisances: nuisances.clone() };
    let given = point(structure.globals.iter().map(|g| g.parameter.value).collect());
    let place = |number: u32| {
        let each = structure.globals.iter().map(|g| &g.parameter).zip(PRIMES.iter().copied().cycle());
        // The square of a share: sizes of friction and inertia are rarely near the top of their bounds.
        let share = |number, prime| radical_inverse(number, prime).powi(2);
        point(each.map(|(p, prime)| p.min + share(number, prime) * p.span()).collect())
    };
    let mut looked: Vec<(f64, Point)> = (1..=LOOKED_AT)
        .map(place)
        .filter_map(|start| Some((spread(&joint.residuals(&start, 1.0).ok()?), start)))
        .collect();
    looked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let starts = std::iter::once(given).chain(looked.into_iter().take(STARTS).map(|(_, start)| start));
    let mut refused = None;
    let mut brief: Vec<Outcome> = Vec::new();
    for start in starts {
        match joint.fit(start, BRIEF) {
            Ok(found) => brief.push(found),
            Err(error) => refused = Some(error),
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::in_swings;

    #[test]
    fn the_parameter_is_found_from_afar() {
        in_swings(&[], 3, 0, |context| {
            let base = fit_null(context).unwrap();
            assert!((base.fit.point.parameters[0] - 0.8).abs() < 1e-3, "{:?}", base.fit.point.parameters);
        });
    }
}
