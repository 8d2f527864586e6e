//! Score test of candidates (Rao 1948) with steps of visible size: limits and delays have no slope where they are absent.

use std::sync::Arc;

use rayon::prelude::*;

use crate::diagnose::hypothesis::candidate_scores::{CLEARLY_LEFT, LEFT_OVER};
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::joint::{Joint, Point, Which};
use crate::diagnose::hypothesis::plausibility::Exclusion;
use crate::diagnose::hypothesis::wording::done_already;
use crate::estimate::jacobian::Columns;
use crate::estimate::projection::{Projector, orthonormal};
use crate::statistics::dot;

/// Steps away from absence, in typical sizes.
const SIZES: [f64; 2] = [1.0, 4.0];
/// A step that shows the slope at absence, in typical sizes.
const SLIGHT: f64 = 0.01;
/// Of an effect that parameters already hold, they do all but this share (of squares) of the slope. Larger steps are bent, and leave more.
const HELD: f64 = 1e-4;

/// Where candidates are scored.
pub(super) struct Linearised {
    /// The parameters of the hypothesis.
    pub parameters: Vec<f64>,
    /// The derivatives there, of each recording.
    pub columns: Vec<Columns>,
}

/// What a candidate promises in addition to a hypothesis.
pub(super) struct Scored {
    pub entry: usize,
    /// Where it was scored.
    pub at: Arc<Linearised>,
    /// The values of its coefficients at which it promises most; empty where none promises anything.
    pub start: Vec<f64>,
    /// The sum of squares that the linear prediction leaves.
    pub left: f64,
    /// The gain of the information criterion in the linear prediction.
    pub predicted: f64,
    pub excluded: Option<Exclusion>,
    /// Orthonormal projected columns.
    pub span: Vec<Vec<f64>>,
}

impl Scored {
    /// Whether a fit can begin where it was scored.
    pub fn has_start(&self) -> bool {
        self.excluded.is_none() && !self.start.is_empty()
    }
}

/// Every candidate in addition to `model`, most promising first.
pub(super) fn score<'a>(context: &Context<'a>, model: &Hypothesis<'a>) -> Vec<Scored> {
    let (joint, residuals) = (context.joint(&model.structure), &model.fit.residuals);
    let columns = joint.columns(&model.fit.point, residuals, Which::ALL);
    let lengths: Vec<usize> = residuals.iter().map(Vec::len).collect();
    let projector = Projector::new(&columns, &lengths, model.structure.shared.len());
    let at = Arc::new(Linearised { parameters: model.fit.point.parameters.clone(), columns });
    let mut left = residuals.concat();
    projector.project(&mut left);
    let open = (0..context.catalogue.len()).filter(|&e| !model.has(e) && !context.catalogue[e].is_random_effect());
    let open: Vec<usize> = open.collect();
    let mut scored: Vec<Scored> =
        open.par_iter().map(|&entry| one(context, (model, &at), entry, &projector, &left)).collect();
    scored.sort_by(|a, b| b.predicted.total_cmp(&a.predicted).then(a.entry.cmp(&b.entry)));
    scored
}

/// Whether the slopes at absence of all coefficients that have one are those of parameters: the effect is another name of these.
fn is_held(joint: &Joint, point: &Point, (model, known): (&Hypothesis, usize), projector: &Projector) -> bool {
    let slight = |k: usize| {
        let shared = &joint.structure.shared[k];
        let typical = shared.absent.map_or(1.0, |(_, typical)| typical);
        let (low, high) = (shared.parameter.min, shared.parameter.max);
        let step = if point.parameters[k] + SLIGHT * typical <= high { SLIGHT } else { -SLIGHT } * typical;
        (k, (point.parameters[k] + step).clamp(low, high))
    };
    // Whether any of these slopes leaves more than this share, and whether there is any slope.
    let leaves = |group: &[usize], share: f64| {
        let steps: Vec<(usize, f64)> = group.iter().map(|&k| slight(k)).collect();
        let Ok(changes) = changes(joint, point, &model.fit.residuals, &steps) else { return (true, false) };
        let (mut more, mut sloped) = (false, false);
        for mut column in changes {
            let whole = dot(&column, &column);
            projector.project(&mut column);
            more |= whole > 0.0 && dot(&column, &column) > share * whole;
            sloped |= whole > 0.0;
        }
        (more, sloped)
    };
    // Slopes that share a rollout are not exact; what they leave beyond doubt spares the others.
    if joint.separable && joint.groups(known).iter().any(|group| leaves(group, CLEARLY_LEFT).0) {
        return false;
    }
    let mut sloped = false;
    for k in known..joint.structure.shared.len() {
        let (more, own) = leaves(&[k], HELD);
        if more {
            return false;
        }
        sloped |= own;
    }
    sloped
}

/// The value at so many steps from where an effect is absent. Where the larger of both sizes is beyond the bounds, it is half way from the
/// smaller one to the bound: a limit shows only below what is asked for.
fn step_to((absent, step): (f64, f64), size: f64, (low, high): (f64, f64)) -> Option<f64> {
    let within = |value: &f64| (low..=high).contains(value);
    let value = absent + size * step;
    if within(&value) {
        return Some(value);
    }
    let smaller = Some(absent + SIZES[0] * step).filter(|smaller| size > SIZES[0] && within(smaller))?;
    Some(smaller.midpoint(value.clamp(low, high)))
}

/// How residuals change by each of these steps of shared parameters to these values, from one rollout of each recording: the step itself,
/// not its slope, as what counts is its direction. Where there are several, each is what changes in the channels on which it acts directly.
///
/// # Errors
/// Where the simulator refuses.
fn changes(
    joint: &Joint,
    point: &Point,
    residuals: &[Vec<f64>],
    steps: &[(usize, f64)],
) -> crate::Result<Vec<Vec<f64>>> {
    let mut tried = point.clone();
    for &(k, value) in steps {
        tried.parameters[k] = value;
    }
    let found = joint.residuals(&tried, 1.0)?;
    let (width, alone) = (joint.width(), steps.len() == 1);
    let of = |&(k, _): &(usize, f64)| {
        let own = joint.structure.shared[k].parameter.channels.as_deref().unwrap_or_default();
        let shows = |i: usize| alone || own.contains(&(i % width));
        let both = found.iter().zip(residuals).flat_map(|(new, old)| new.iter().zip(old).enumerate());
        both.map(|(i, (new, old))| if shows(i) { new - old } else { 0.0 }).collect()
    };
    Ok(steps.iter().map(of).collect())
}

fn one(
    context: &Context,
    (model, at): (&Hypothesis, &Arc<Linearised>),
    entry: usize,
    projector: &Projector,
    left: &[f64],
) -> Scored {
    let none = |excluded| Scored {
        entry,
        at: Arc::clone(at),
        start: Vec::new(),
        left: f64::INFINITY,
        predicted: f64::NEG_INFINITY,
        excluded: Some(excluded),
        span: Vec::new(),
    };
    let effects = [model.structure.effects.as_slice(), &[entry]].concat();
    let structure = match context.structure(&effects) {
        Ok(structure) => structure,
        Err(error) => return none(Exclusion::refused(&error)),
    };
    let joint = context.joint(&structure);
    let known = model.structure.shared.len();
    let parameters = structure.carry(&model.structure, &model.fit.point.parameters);
    let point = Point { parameters, nuisances: model.fit.point.nuisances.clone() };
    let at_rest: Vec<f64> = point.parameters[known..].to_vec();
    if model.structure.repeats(&context.catalogue[entry]) || is_held(&joint, &point, (model, known), projector) {
        return none(Exclusion::Redundant(done_already(context)));
    }
    let before = model.deviance(model.scale());
    let coefficients = (structure.shared.len() - known) as f64;
    let mut best = none(Exclusion::NoInfluence);
    let mut refused = None;
    let (mut moved, mut new) = (false, false);
    for (sign, size) in [1.0, -1.0].into_iter().flat_map(|sign| SIZES.map(|size| (sign, size))) {
        let mut start = at_rest.clone();
        let mut columns = Vec::new();
        let step = |k: usize| {
            let shared = &structure.shared[k];
            let (absent, typical) = shared.absent.unwrap_or((0.0, 1.0));
            step_to((absent, sign * typical), size, (shared.parameter.min, shared.parameter.max))
        };
        for group in joint.groups(known) {
            let steps: Vec<(usize, f64)> = group.into_iter().filter_map(|k| Some((k, step(k)?))).collect();
            if steps.is_empty() {
                continue;
            }
            let changes = match changes(&joint, &point, &model.fit.residuals, &steps) {
                Ok(changes) => changes,
                Err(error) => {
                    refused = Some(Exclusion::refused(&error));
                    continue;
                }
            };
            for ((k, value), mut column) in steps.into_iter().zip(changes) {
                let whole = dot(&column, &column);
                projector.project(&mut column);
                let rest = dot(&column, &column);
                moved |= whole > 0.0;
                if whole > 0.0 && rest > LEFT_OVER * whole {
                    new = true;
                    start[k - known] = value;
                    columns.push(column);
                }
            }
        }
        if columns.is_empty() {
            continue;
        }
        let span = orthonormal(columns.clone());
        let explained: f64 = span.iter().map(|direction| dot(direction, left).powi(2)).sum();
        // Only a step to this side counts: residuals have to fall along it.
        let towards = columns.iter().map(|column| dot(column, left)).fold(f64::INFINITY, f64::min) < 0.0;
        let rest = (before - explained).max(1e-3 * before);
        let predicted = context.criterion(before, rest, coefficients);
        if towards && predicted > best.predicted {
            best = Scored { entry, at: Arc::clone(at), start, left: rest, predicted, excluded: None, span };
        }
    }
    if best.excluded.is_some() {
        best.excluded = match (refused, moved, new) {
            (Some(refused), false, _) => Some(refused),
            (_, true, false) => Some(Exclusion::Redundant(done_already(context))),
            (_, true, true) => None,
            _ => Some(Exclusion::NoInfluence),
        };
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::null::fit_null;
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};

    #[test]
    fn what_is_missing_promises_most() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let base = fit_null(context).unwrap();
            let scored = score(context, &base);
            assert_eq!(scored[0].entry, entry(context, "viscous_friction"));
            assert!(scored[0].predicted > 0.0 && scored[0].excluded.is_none());
        });
    }

    #[test]
    fn a_large_step_stays_within_the_bounds() {
        let fraction = |size| step_to((1.0, -0.3), size, (0.02, 1.0));
        assert_eq!((fraction(1.0), fraction(4.0)), (Some(0.7), Some(0.36)));
        assert_eq!(step_to((1.0, 0.3), 4.0, (0.02, 1.0)), None);
        assert_eq!(step_to((0.0, 0.1), 4.0, (0.0, 2.0)), Some(0.4));
    }

    /// With an effect in the place of parameters, the effect itself is one of them.
    #[test]
    fn what_parameters_hold_already_is_held() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let friction = entry(context, "viscous_friction");
            let base = fit_null(context).unwrap();
            let structure = context.structure(&[friction]).unwrap();
            let joint = context.joint(&structure);
            let parameters = structure.carry(&base.structure, &base.fit.point.parameters);
            let point = Point { parameters, nuisances: base.fit.point.nuisances.clone() };
            let lengths: Vec<usize> = base.fit.residuals.iter().map(Vec::len).collect();
            let projector =
                |held: usize| Projector::new(&joint.columns(&point, &base.fit.residuals, Which::ALL), &lengths, held);
            assert!(is_held(&joint, &point, (&base, 1), &projector(2)), "projected out with its own slope");
            assert!(!is_held(&joint, &point, (&base, 1), &projector(1)));
        });
    }
}
