//! Unmeasured axes: what acts along them alone is neither free nor a candidate.

use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::catalogue::Entry;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::joint::{Joint, Point, Which};
use crate::estimate::projection::stack;
use crate::statistics::dot;

/// A coefficient that moves the recordings by less than this share of what another of its effect does is not seen.
const UNOBSERVED_SHARE: f64 = 1e-3;
/// ... nor is one of a driven recording that moves it by less than this over all its physical range (root of the summed squares, in
/// units of the noise).
const VISIBLE: f64 = 2.0;

/// The context with nuisance parameters along axes that were not measured held, and no coefficient free that acts along them
/// alone. An initial velocity across the measured plane would otherwise let a hidden rotation act as any force within it.
pub(in crate::diagnose) fn without_unmeasured<'a>(context: Context<'a>, base: &Hypothesis) -> Result<Context<'a>> {
    let mut evidence = Evidence::clone(&context.evidence);
    let complete = |recording: &PreparedRecording| recording.unmeasured().is_empty() && !recording.driven();
    if evidence.training.iter().chain(&evidence.validation).all(complete) {
        return Ok(context);
    }
    let structure = context.structure(&[])?;
    for (recordings, nuisances) in
        [(&mut evidence.training, Some(&base.fit.point.nuisances)), (&mut evidence.validation, None)]
    {
        let nuisances =
            nuisances.cloned().unwrap_or_else(|| recordings.iter().map(|r| r.prepared.nuisance_values()).collect());
        let here = Point { parameters: base.fit.point.parameters.clone(), nuisances };
        let joint = Joint { structure: &structure, recordings, separable: false, rollouts: &context.rollouts };
        let residuals = joint.residuals(&here, 1.0)?;
        let columns = joint.columns(&here, &residuals, Which::ALL);
        for (recording, one) in recordings.iter_mut().zip(&columns) {
            recording.hold_silent(&one.nuisances);
        }
    }
    let observed = |(position, entry): (usize, &Entry)| {
        let seen = if entry.seen.len() > 1 { observable(&context, position, base)? } else { entry.seen.clone() };
        Ok(Entry { seen, ..entry.clone() })
    };
    let catalogue = context.catalogue.iter().enumerate().map(observed).collect::<Result<_>>()?;
    Ok(Context { catalogue, ..context.with_evidence(evidence) })
}

/// Which coefficients of an effect the recordings depend on.
fn observable(context: &Context<'_>, entry: usize, base: &Hypothesis) -> Result<Vec<bool>> {
    let structure = context.structure(&[entry])?;
    let known = base.structure.shared.len();
    let mut parameters = structure.carry(&base.structure, &base.fit.point.parameters);
    let driven = context.evidence.driven();
    // The speed at which friction falls has no slope where there is no friction.
    for (value, shared) in parameters.iter_mut().zip(&structure.shared).skip(known).filter(|_| driven) {
        let present = shared.absent.map_or(*value, |(absent, typical)| absent + typical);
        *value = present.clamp(shared.parameter.min, shared.parameter.max);
    }
    let point = Point { parameters, nuisances: base.fit.point.nuisances.clone() };
    let which = Which { first: known, nuisances: false, ..Which::ALL };
    let joint = context.joint(&structure);
    let residuals = if driven { joint.residuals(&point, 1.0)? } else { base.fit.residuals.clone() };
    let columns = joint.columns(&point, &residuals, which);
    let lengths: Vec<usize> = base.fit.residuals.iter().map(Vec::len).collect();
    let mut sizes = vec![0.0f64; context.catalogue[entry].seen.len()];
    let mut visible = vec![false; sizes.len()];
    for (index, shared) in structure.shared.iter().enumerate().skip(known) {
        let column = stack(&columns, &lengths, index);
        if let Some((_, k)) = shared.effect {
            let size = dot(&column, &column).sqrt();
            let (low, high) = context.catalogue[entry].of[shared.object.unwrap_or(0)].plausible[k];
            visible[k] |= size * (high - low) > VISIBLE;
            sizes[k] = sizes[k].max(size);
        }
    }
    // A joint whose axis stands upright has no offset to see; where none of an effect is visible, that is said of the effect.
    if driven {
        let none = visible.iter().all(|seen| !seen);
        return Ok(visible.into_iter().map(|seen| seen || none).collect());
    }
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    Ok(sizes.into_iter().map(|size| largest <= 0.0 || size > UNOBSERVED_SHARE * largest).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::tests::zoo::{LEVER_FRICTION, entry, in_levers};
    use crate::testing::Levers;

    /// The second lever is held: its friction cannot be seen, its bias can.
    #[test]
    fn friction_of_a_joint_that_is_held_is_not_free() {
        in_levers(&Levers::new().unwrap(), &[(LEVER_FRICTION, 0.5)], |context| {
            let base = fit_without_effects(context).unwrap();
            let context = without_unmeasured(context.clone(), &base).unwrap();
            assert_eq!(context.catalogue[entry(&context, "viscous_friction")].seen, [true, false]);
            assert_eq!(context.catalogue[entry(&context, "torque_bias")].seen, [true, true]);
        });
    }
}
