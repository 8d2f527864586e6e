//! Physical plausibility: which coefficients are physical, and which effects are required, optional or implausible.

use std::fmt;

use serde::Serialize;

use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::joint::{Joint, Point, Which};
use crate::estimate::jacobian::Columns;
use crate::estimate::projection::{Projector, stack};
use crate::observation::{after_number, three_digits};
use crate::simulator::Text;
use crate::statistics::dot;
use crate::{Error, Result};

/// An effect that all of its physical bounds moves less than this (root of the summed squares, in units of the noise) is
/// not there to be seen.
const VISIBLE: f64 = 3.0;

/// Why a candidate cannot be the answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", content = "of", rename_all = "snake_case")]
pub enum Exclusion {
    /// The simulator refuses it, with this sentence.
    Refused(String),
    /// No recording depends on it.
    NoInfluence,
    /// Something that is fitted in any case does the same: what, in words.
    Redundant(&'static str),
    /// Even its physical bounds move the recordings by less than their noise.
    BelowNoise,
    /// It would need a coefficient that is not physical.
    Implausible(OutOfRange),
}

impl Exclusion {
    /// A candidate that the simulator refuses, by its own sentence without the values that it was asked for.
    pub(in crate::diagnose) fn refused(error: &crate::Error) -> Self {
        Self::Refused(match error {
            crate::Error::Simulator { message, .. } => message.clone(),
            other => other.to_string(),
        })
    }
}

impl fmt::Display for Exclusion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Refused(error) => write!(f, "it cannot be simulated here: {error}"),
            Self::NoInfluence => f.write_str("these recordings do not depend on it"),
            Self::Redundant(same) => f.write_str(same),
            Self::BelowNoise => f.write_str("its effect in these recordings would stay below the noise"),
            Self::Implausible(coefficient) => coefficient.fmt(f),
        }
    }
}

/// A coefficient outside its physical bounds, or on a bound of the fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutOfRange {
    /// The name of its effect.
    pub effect: Text,
    /// The position of its object among the subjects.
    pub object: usize,
    /// Its name as a parameter.
    pub coefficient: String,
    /// The value that the recordings ask for.
    pub value: f64,
    /// Its unit in words.
    pub unit: Text,
    /// Its physical bounds; `None` where it ends on a bound of the fit.
    pub physical: Option<(f64, f64)>,
    /// The settings on which the physical bounds rest.
    pub rests_on: Vec<Text>,
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { coefficient, value, unit, .. } = self;
        match self.physical {
            Some((low, high)) => {
                let (low, high) = (three_digits(low), three_digits(high));
                let value = three_digits(*value);
                write!(f, "`{coefficient}` would be {value}{}, outside {low} to {high}", after_number(unit))
            }
            None => write!(f, "`{coefficient}` runs into its bound {value}"),
        }
    }
}

/// A coefficient of `model` that is implausible: outside what is physical, or pushed against a bound. An effect of which each
/// object has its own coefficients is implausible where it is so in most objects: one object whose size is wrong in its file speaks
/// against that file, not against the effect.
pub(in crate::diagnose) fn implausible(context: &Context<'_>, model: &Hypothesis) -> Option<OutOfRange> {
    (0..model.structure.effects.len()).find_map(|position| {
        let of_objects = out_of_range(context, model, position);
        let bad = of_objects.iter().flatten().count();
        if 2 * bad > of_objects.len() { of_objects.into_iter().flatten().next() } else { None }
    })
}

/// Whether an object needs a coefficient of `model` that is not physical for it.
pub(in crate::diagnose) fn strains_an_object(context: &Context<'_>, model: &Hypothesis) -> bool {
    (0..model.structure.effects.len())
        .any(|position| out_of_range(context, model, position).iter().any(Option::is_some))
}

/// For every object with recordings: a coefficient of the structure's effect at `position` that is implausible there.
pub(in crate::diagnose) fn out_of_range(
    context: &Context<'_>,
    model: &Hypothesis,
    position: usize,
) -> Vec<Option<OutOfRange>> {
    let recorded = |object: &usize| context.recordings().iter().any(|recording| recording.object == *object);
    let objects = (0..context.subjects.len()).filter(recorded);
    objects.map(|object| out_of_range_of(context, model, position, object)).collect()
}

fn out_of_range_of(context: &Context<'_>, model: &Hypothesis, position: usize, object: usize) -> Option<OutOfRange> {
    let spread = (model.deviance(model.scale()) / context.count() as f64).sqrt();
    let effect = &context.catalogue[model.structure.effects[position]].of[object];
    let shared = &model.structure.shared;
    let mine = model
        .structure
        .of_effect(position)
        .into_iter()
        .filter(|&column| shared[column].object.is_none_or(|o| o == object));
    mine.into_iter().find_map(|column| {
        let (value, p) = (model.fit.point.parameters[column], &shared[column].parameter);
        let k = shared[column].effect.map_or(0, |e| e.1);
        let coefficient = &effect.coefficients[k];
        let slack = 2.0 * spread * model.fit.covariance[(column, column)].max(0.0).sqrt();
        let (low, high) = effect.plausible[k];
        let unphysical = value < low - slack || value > high + slack;
        let at_bound = value != coefficient.absent && (value <= p.min || value >= p.max);
        (unphysical || at_bound).then(|| OutOfRange {
            effect: effect.name.clone(),
            object,
            coefficient: p.name.clone(),
            value,
            unit: coefficient.unit.clone(),
            physical: unphysical.then_some((low, high)),
            rests_on: if unphysical { effect.plausible_rests_on.clone() } else { Vec::new() },
        })
    })
}

/// Whether the effect has to be there in every object, so that recordings need only say how large it is.
pub(in crate::diagnose) fn is_required(context: &Context<'_>, entry: usize) -> bool {
    context.catalogue[entry].of.iter().all(crate::simulator::Effect::required)
}

/// How far an effect that is implausible for these objects has to stay behind another, by the information criterion, so that the other
/// is preferred: below 2 the evidence is "not worth more than a bare mention" (Kass and Raftery 1995), and no prior decides.
const PREFERRED: f64 = 2.0;

/// Whether `other` explains what `entry` does, falling `gap` behind it, but is not to be expected of these objects as `entry` is.
pub(in crate::diagnose) fn is_less_plausible(context: &Context<'_>, other: usize, entry: usize, gap: f64) -> bool {
    gap > PREFERRED && implausible_reason(context, other).is_some() && implausible_reason(context, entry).is_none()
}

pub(in crate::diagnose) fn implausible_reason<'a>(context: &'a Context<'_>, entry: usize) -> Option<&'a str> {
    let of = &context.catalogue[entry].of;
    of.iter().all(|effect| effect.implausible.is_some()).then_some(of[0].implausible.as_deref())?
}

/// The simulation with what has to be there, where it is taken to be there; else `None`.
pub(in crate::diagnose) fn required_model<'a>(
    context: &Context<'a>,
    base: &Hypothesis<'a>,
) -> Result<Option<Hypothesis<'a>>> {
    let certain: Vec<usize> = (0..context.catalogue.len()).filter(|&entry| is_required(context, entry)).collect();
    if !context.required_first || certain.is_empty() {
        return Ok(None);
    }
    context.fit_near(&certain, base).map(Some)
}

/// Whether `model` holds nothing that was found, only what was expected.
pub(in crate::diagnose) fn holds_only_required(context: &Context<'_>, model: &Hypothesis) -> bool {
    model.structure.effects.iter().all(|&entry| needs_no_evidence(context, entry))
}

/// Whether the effect is part of every hypothesis, whatever it gains.
pub(in crate::diagnose) fn needs_no_evidence(context: &Context<'_>, entry: usize) -> bool {
    context.required_first && is_required(context, entry)
}

/// Why the simulator refuses the coefficients from `known` on in the first recording, where it refuses them at their typical sizes on every
/// side of `point` within their bounds: what has no derivative is refused in all recordings.
pub(super) fn refusal(joint: &Joint, point: &Point, known: usize) -> Option<Error> {
    let samples = joint.recordings.first()?.clock().len();
    let mut refused = None;
    for sign in [1.0, -1.0] {
        let mut tried = point.clone();
        for (value, shared) in tried.parameters.iter_mut().zip(&joint.structure.shared).skip(known) {
            let typical = shared.absent.map_or(0.0, |(_, typical)| typical);
            *value = (*value + sign * typical).clamp(shared.parameter.min, shared.parameter.max);
        }
        if tried.parameters != point.parameters {
            refused = Some(joint.plain(0, &tried.parameters, &tried.nuisances[0], samples).err()?);
        }
    }
    refused
}

/// What a candidate's coefficients do to the residuals.
pub(in crate::diagnose) struct Influence {
    pub columns: Vec<Columns>,
    /// The columns, stacked, without what the parameters of the model do.
    pub projected: Vec<Vec<f64>>,
    /// The sum of squares of the columns, and of the projected ones.
    pub whole: f64,
    pub rest: f64,
    /// Whether one of them can be seen within the physical bounds.
    pub seen: bool,
}

/// The influence of the coefficients from `known` on at `point`: by small steps, and where that is not seen by visible ones.
pub(in crate::diagnose) fn influence(
    context: &Context<'_>,
    entry: usize,
    (joint, point, known): (&Joint, &Point, usize),
    model: &Hypothesis,
    projector: &Projector,
) -> Influence {
    let lengths: Vec<usize> = model.fit.residuals.iter().map(Vec::len).collect();
    let mut found = Influence { columns: Vec::new(), projected: Vec::new(), whole: 0.0, rest: 0.0, seen: false };
    for visibly in [false, true] {
        let which = Which { first: known, nuisances: false, visibly, ..Which::ALL };
        let columns = joint.columns(point, &model.fit.residuals, which);
        found = Influence { columns, projected: Vec::new(), whole: 0.0, rest: 0.0, seen: false };
        for (index, shared) in joint.structure.shared.iter().enumerate().skip(known) {
            let mut column = stack(&found.columns, &lengths, index);
            found.whole += dot(&column, &column);
            projector.project(&mut column);
            let size = dot(&column, &column);
            found.rest += size;
            let (absent, coefficient) = (shared.absent.map_or(0.0, |a| a.0), shared.effect.map_or(0, |e| e.1));
            let (low, high) = context.catalogue[entry].of[shared.object.unwrap_or(0)].plausible[coefficient];
            found.seen |= size.sqrt() * (high - absent).abs().max((absent - low).abs()) > VISIBLE;
            found.projected.push(column);
        }
        if found.seen {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_swings};

    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    #[test]
    fn a_negative_friction_is_implausible_and_a_fitted_one_is_not() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let mut model = context.fit_near(&[entry(context, "viscous_friction")], &base).unwrap();
            assert_eq!(implausible(context, &model), None);
            model.fit.point.parameters[1] = -0.2;
            let found = implausible(context, &model).unwrap();
            assert!(found.to_string().contains("outside 0 to 1.50") && found.effect == "viscous_friction", "{found}");
        });
    }

    #[test]
    fn nothing_is_required_of_a_pendulum() {
        in_swings(&[], 1, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let first = Context { required_first: true, ..context.clone() };
            assert!(required_model(&first, &base).unwrap().is_none());
            assert!(
                (0..first.catalogue.len()).all(|e| !is_required(&first, e) && !is_less_plausible(&first, e, 0, 9.0))
            );
        });
    }
}
