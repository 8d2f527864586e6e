//! Multistart from Halton's points (Halton 1960): of the fit without any effect, and of coefficients that only shape an effect; and from
//! the initial states that first samples show, of an effect that turns a motion round.

use crate::Result;
use crate::diagnose::evidence::sample::Sample;
use crate::diagnose::hypothesis::context::{COMPARED, Context, FULL, Hypothesis};
use crate::diagnose::hypothesis::joint::{Effort, Joint, Outcome, Point, Which, spread};
use crate::diagnose::hypothesis::structure::{SharedParameter, Structure};
use crate::estimate::GROWING_SHARES;
use crate::estimate::projection::{Projector, orthonormal, stack};
use crate::statistics::dot;

/// Shares of the recordings that are fitted one after the other: the count of events stays right on the way.
const HORIZONS: [f64; 2] = [0.45, 0.7];
const EARLY: Effort = Effort { steps: 20, derivatives: 6, ends_measured: false, tolerance: 0.5, horizon: 1.0, ..FULL };
const MOST_STARTS: usize = 3;
/// Starts that lead so near to each other, as a share of the bounds, lead to the same.
const SAME: f64 = 1e-3;
/// A fit that leaves this many times the noise may sit in a wrong local minimum.
const SUSPICIOUS: f64 = 3.0;
/// What misses an effect and leaves this many times the noise may have led the initial states away from what the first samples show.
const LEFT: f64 = 1.5;
/// Starts across the bounds of each object's first parameters.
const SPREAD: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Starts all over the bounds, where those above end in a suspicious local minimum.
const SCATTERED: u32 = 48;
/// Bases of Halton's points, one to a parameter.
pub(in crate::diagnose) const PRIMES: [u32; 8] = [2, 3, 5, 7, 11, 13, 17, 19];

/// Values of the coefficients that shape an effect at which it is scored.
const SHAPES: u32 = 24;
/// From so many of them fits begin.
const SHAPE_STARTS: usize = 3;
/// First and last step of the search from there, as a share of the bounds.
const FIRST_STEP: f64 = 0.1;
const LAST_STEP: f64 = 0.02;
/// What explains less than so many mean squares of a value does so by chance, and is not improved.
const CHANCE: f64 = 12.0;
/// Bounds of a shape whose ratio is larger are covered evenly in its logarithm.
const WIDE: f64 = 10.0;

/// The digits of `number` to base `prime` behind the point, the lowest first (Halton 1960): evenly over 0 to 1.
pub(in crate::diagnose) fn radical_inverse(mut number: u32, prime: u32) -> f64 {
    let (mut weight, mut sum) = (1.0, 0.0);
    while number > 0 {
        weight /= f64::from(prime);
        sum += f64::from(number % prime) * weight;
        number /= prime;
    }
    sum
}

/// Fits from several starts.
#[derive(Default)]
struct Tries {
    /// Whether a part of the recordings that is far off makes a fit suspicious as well: of what goes its own way from its first samples on,
    /// one may be lost while the others fit.
    by_parts: bool,
    best: Option<Outcome>,
    refused: Option<crate::Error>,
    /// Where they led early on, to go nowhere twice.
    seen: Vec<Vec<f64>>,
}

impl Tries {
    fn suspicious(&self) -> bool {
        let leaves =
            |best: &Outcome| spread(&best.residuals) >= SUSPICIOUS || self.by_parts && robust_rms(best) >= SUSPICIOUS;
        self.best.as_ref().is_some_and(leaves)
    }

    /// From the first few of `ranked` over these growing shares of the recordings, until one leaves no suspicion.
    fn fit(&mut self, joint: &Joint, structure: &Structure, ranked: Vec<Point>, shares: &[f64]) {
        for start in ranked.into_iter().take(MOST_STARTS) {
            let early = |point: Point, horizon: f64| joint.fit(point, Effort { horizon, ..EARLY }).map(|f| f.point);
            let Some((beginning, longer)) = shares.split_first() else { return };
            let first = early(start, *beginning);
            if let Ok(point) = &first {
                let spans = || structure.shared.iter().map(|shared| shared.parameter.span());
                let same = |other: &Vec<f64>| {
                    other.iter().zip(&point.parameters).zip(spans()).all(|((a, b), span)| (a - b).abs() < SAME * span)
                };
                if self.seen.iter().any(same) {
                    continue;
                }
                self.seen.push(point.parameters.clone());
            }
            let fit = longer.iter().fold(first, |point, share| early(point?, *share)).and_then(|p| joint.fit(p, FULL));
            match fit {
                Ok(fit) => {
                    if self.best.as_ref().is_none_or(|b| fit.cost < b.cost) {
                        self.best = Some(fit);
                    }
                    if !self.suspicious() {
                        break;
                    }
                }
                Err(error) => self.refused = Some(error),
            }
        }
    }
}

/// The best fit of the simulation as it is.
pub(in crate::diagnose) fn fit_without_effects<'a>(context: &Context<'a>) -> Result<Hypothesis<'a>> {
    if let Some(found) = fit_from_a_sample(context)? {
        return Ok(found);
    }
    let structure = context.structure(&[])?;
    let joint = context.joint(&structure);
    let mut tries = Tries { by_parts: is_begun(context), ..Tries::default() };
    tries.fit(&joint, &structure, ranked(&joint, starts(context, &structure), 1.0), &HORIZONS);
    // Where the first samples show the initial states, the beginning of a record shows the parameters before later motion has made many
    // local minima.
    if tries.by_parts && tries.suspicious() {
        let early = ranked(&joint, starts(context, &structure), GROWING_SHARES[0]);
        tries.seen.clear();
        tries.fit(&joint, &structure, early, &GROWING_SHARES);
    }
    if tries.suspicious()
        && structure.shared.len() > 1
        && structure.shared.iter().all(|shared| local_estimate(context, shared).is_none())
    {
        tries.fit(&joint, &structure, ranked(&joint, halton_starts(context, &structure), 1.0), &HORIZONS);
    }
    let fit = tries.best.ok_or_else(|| {
        // Where none simulates, what is said of the file's own values is reported.
        let nuisances =
            || starts(context, &structure).first().and_then(|nuisances| joint.residuals(nuisances, 1.0).err());
        tries.refused.or_else(nuisances).unwrap_or_else(|| crate::Error::Simulator {
            at: "every start".into(),
            message: "no start within the bounds could be simulated".into(),
        })
    })?;
    Ok(Hypothesis { structure, fit })
}

/// The fit of a sample of many recordings, continued in all of them. `None` where there are few, or where it leaves more of all than of the
/// sample.
fn fit_from_a_sample<'a>(context: &Context<'a>) -> Result<Option<Hypothesis<'a>>> {
    let Some(Sample { evidence, fitted }) = context.evidence.sample(1).filter(|_| context.shows_free_motions()) else {
        return Ok(None);
    };
    let few = fit_without_effects(&context.with_evidence(evidence))?;
    let Point { parameters, nuisances: found } = &few.fit.point;
    let mut nuisances: Vec<Vec<f64>> = context.recordings().iter().map(|r| r.prepared.nuisance_values()).collect();
    for (&i, found) in fitted.iter().zip(found) {
        nuisances[i].clone_from(found);
    }
    let structure = context.structure(&[])?;
    let joint = context.joint(&structure);
    let start = Point { parameters: parameters.clone(), nuisances };
    let Ok(early) = joint.fit(start, Effort { horizon: HORIZONS[1], ..EARLY }) else { return Ok(None) };
    let Ok(fit) = joint.fit(early.point, COMPARED) else { return Ok(None) };
    if spread(&fit.residuals) >= LEFT * spread(&few.fit.residuals) {
        return Ok(None);
    }
    // Where nothing may be missing, its covariance is that of the answer.
    let fit = if spread(&fit.residuals) < LEFT { joint.fit(fit.point, FULL)? } else { fit };
    Ok(Some(Hypothesis { structure, fit }))
}

/// Whether recordings show initial states by their first samples, and `model`, which follows the motion as a whole, may have others that
/// are far off.
pub(in crate::diagnose) fn first_samples_show_more(context: &Context<'_>, model: &Hypothesis) -> bool {
    is_begun(context) && (spread(&model.fit.residuals) >= LEFT || robust_rms(&model.fit) >= LEFT)
}

/// What a fit leaves in units of the noise: the root of the mean of the squares, large ones as the robust cost counts them.
fn robust_rms(fit: &Outcome) -> f64 {
    let count = fit.residuals.iter().map(Vec::len).sum::<usize>().max(1);
    (2.0 * (fit.cost - fit.prior_part).max(0.0) / count as f64).sqrt()
}

/// Whether first samples show initial states of a recording.
fn is_begun(context: &Context<'_>) -> bool {
    context.recordings().iter().any(|r| r.prepared.begin.iter().any(Option::is_some))
}

/// The hypothesis of an effect in addition to `model`, fitted over growing shares of the recordings, with `coefficients` to begin with;
/// nothing where it cannot be simulated.
pub(in crate::diagnose) fn fit_from_first_samples<'a>(
    context: &Context<'a>,
    model: &Hypothesis<'a>,
    (entry, coefficients): (usize, &[f64]),
) -> Option<Hypothesis<'a>> {
    let structure = context.structure(&[model.structure.effects.as_slice(), &[entry]].concat()).ok()?;
    let joint = context.joint(&structure);
    let mut parameters = structure.carry(&model.structure, &model.fit.point.parameters);
    parameters[model.structure.shared.len()..].copy_from_slice(coefficients);
    let nuisances = context.recordings().iter().map(|r| r.prepared.nuisance_values()).collect();
    let longer =
        |point: Point, horizon: &f64| joint.fit(point, Effort { horizon: *horizon, ..EARLY }).map(|fit| fit.point);
    let point = GROWING_SHARES.iter().try_fold(Point { parameters, nuisances }, longer).ok()?;
    let fit = joint.fit(point, FULL).ok()?;
    Some(Hypothesis { structure, fit })
}

/// Starts all over the bounds, where nothing in the recordings says where to begin: Halton's points.
fn halton_starts(context: &Context<'_>, structure: &Structure) -> Vec<Point> {
    let nuisances: Vec<Vec<f64>> = context.recordings().iter().map(|r| r.prepared.nuisance_values()).collect();
    let parameters = |number: u32| {
        let primes = PRIMES.iter().copied().cycle();
        let each = structure.shared.iter().map(|shared| &shared.parameter).zip(primes);
        each.map(|(p, prime)| p.min + radical_inverse(number, prime) * p.span()).collect()
    };
    (1..=SCATTERED).map(|number| Point { parameters: parameters(number), nuisances: nuisances.clone() }).collect()
}

/// The starts that simulate, best over a share of the recordings first; every object has its own order where objects have no parameter in
/// common.
fn ranked(joint: &Joint, starts: Vec<Point>, share: f64) -> Vec<Point> {
    let rolled: Vec<(Vec<Vec<f64>>, Point)> =
        starts.into_iter().filter_map(|point| Some((joint.residuals(&point, share).ok()?, point))).collect();
    let mut ranked: Vec<Point> = rolled.iter().map(|(_, point)| point.clone()).collect();
    for part in joint.parts() {
        let size = |residuals: &[Vec<f64>]| {
            let mine: Vec<Vec<f64>> = part.recordings.iter().map(|&d| residuals[d].clone()).collect();
            // A robust size: a start that is right for most of the record is a good one.
            spread(&mine)
        };
        let mut order: Vec<(f64, &Point)> = rolled.iter().map(|(r, point)| (size(r), point)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (to, (_, from)) in ranked.iter_mut().zip(order) {
            part.columns.iter().for_each(|&column| to.parameters[column] = from.parameters[column]);
        }
    }
    ranked
}

/// Parameters as the files give them, as the events suggest them, and spread over the bounds.
fn starts(context: &Context<'_>, structure: &Structure) -> Vec<Point> {
    let nuisances: Vec<Vec<f64>> = context.recordings().iter().map(|r| r.prepared.nuisance_values()).collect();
    let given: Vec<f64> = structure.shared.iter().map(|shared| shared.parameter.value).collect();
    let local: Vec<f64> = structure
        .shared
        .iter()
        .map(|shared| local_estimate(context, shared).unwrap_or(shared.parameter.value))
        .collect();
    let mut all = vec![given, local.clone()];
    for share in SPREAD {
        let spread = structure.shared.iter().zip(&local);
        all.push(
            spread
                .map(|(shared, local)| match local_estimate(context, shared) {
                    Some(_) => *local,
                    None => shared.parameter.min + share * shared.parameter.span(),
                })
                .collect(),
        );
    }
    all.dedup();
    all.into_iter().map(|parameters| Point { parameters, nuisances: nuisances.clone() }).collect()
}

/// What the neighbourhood of the events alone says of a parameter.
fn local_estimate(context: &Context<'_>, shared: &SharedParameter) -> Option<f64> {
    let object = shared.object?;
    let parameters = context.subjects[object].simulator.parameters();
    let i = parameters.iter().position(|p| p.name == shared.parameter.name)?;
    let each = || context.recordings().iter().filter(|r| r.object == object).filter_map(|r| r.prepared.local[i]);
    let weight: f64 = each().map(|l| l.sd.powi(-2)).sum();
    let value = each().map(|l| l.value * l.sd.powi(-2)).sum::<f64>() / weight;
    value.is_finite().then(|| value.clamp(shared.parameter.min, shared.parameter.max))
}

/// Values of an effect's coefficients at which its columns explain most, best first: variable projection (Golub and Pereyra
/// 1973) over Halton's points of those that only shape it, the best of them improved by a compass search (Kolda, Lewis and
/// Torczon 2003). None where no coefficient only shapes it.
pub(in crate::diagnose) fn best_shapes(
    joint: &Joint,
    residuals: &[Vec<f64>],
    point: &Point,
    known: usize,
    projector: &Projector,
    left: &[f64],
) -> Vec<Vec<f64>> {
    let shared = &joint.structure.shared;
    let shapes: Vec<usize> = (known..shared.len()).filter(|&index| shared[index].shape).collect();
    if shapes.is_empty() {
        return Vec::new();
    }
    let lengths: Vec<usize> = residuals.iter().map(Vec::len).collect();
    let at = |shares: &[f64]| {
        let mut tried = point.clone();
        for (&index, share) in shapes.iter().zip(shares) {
            let (min, max) = (shared[index].parameter.min, shared[index].parameter.max);
            let wide = min > 0.0 && max > WIDE * min;
            tried.parameters[index] = if wide { min * (max / min).powf(*share) } else { min + share * (max - min) };
        }
        tried
    };
    let explained = |shares: &[f64]| -> f64 {
        let which = Which { first: known, nuisances: false, ..Which::ALL };
        let columns = joint.columns_of(&at(shares), residuals, which, |index| !shapes.contains(index));
        let sizes = (known..shared.len()).filter(|index| !shapes.contains(index));
        let projected = sizes.map(|index| {
            let mut column = stack(&columns, &lengths, index);
            projector.project(&mut column);
            column
        });
        orthonormal(projected.collect()).iter().map(|direction| dot(direction, left).powi(2)).sum()
    };
    let mut all: Vec<(f64, Vec<f64>)> = (1..=SHAPES)
        .map(|number| {
            let shares: Vec<f64> =
                (0..shapes.len()).map(|k| radical_inverse(number, PRIMES[k % PRIMES.len()])).collect();
            (explained(&shares), shares)
        })
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.truncate(SHAPE_STARTS);
    let chance = CHANCE * dot(left, left) / left.len().max(1) as f64;
    for (most, shares) in &mut all {
        let mut step = if *most > chance { FIRST_STEP } else { 0.0 };
        while step >= LAST_STEP {
            let moves = (0..shares.len()).flat_map(|k| [(k, step), (k, -step)]);
            let tried = moves.map(|(k, by)| {
                let mut moved = shares.clone();
                moved[k] = (moved[k] + by).clamp(0.0, 1.0);
                (explained(&moved), moved)
            });
            match tried.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(value, _)| *value > *most) {
                Some(better) => (*most, *shares) = better,
                None => step *= 0.5,
            }
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.iter().map(|(_, shares)| at(shares).parameters[known..].to_vec()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::in_swings;

    #[test]
    fn scattered_points_are_even_in_every_base() {
        let first = |prime| [1, 2, 3, 4].map(|number| radical_inverse(number, prime));
        assert_eq!(first(2), [0.5, 0.25, 0.75, 0.125]);
        let thirds = first(3);
        let expected = [1.0 / 3.0, 2.0 / 3.0, 1.0 / 9.0, 4.0 / 9.0];
        assert!(thirds.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{thirds:?}");
    }

    #[test]
    fn the_parameter_is_found_from_afar() {
        in_swings(&[], 3, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert!((base.fit.point.parameters[0] - 0.8).abs() < 1e-3, "{:?}", base.fit.point.parameters);
            assert!((base.scale() - 1.0).abs() < 0.2, "{}", base.scale());
        });
    }
}
