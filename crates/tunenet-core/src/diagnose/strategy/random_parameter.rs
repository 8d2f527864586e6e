//! Random parameter (Laird and Ware 1982): a tuned parameter that every recording draws anew from one normal distribution, as the
//! friction of a surface that is not the same everywhere.

use super::per_recording_fits::{How, fit_per_recording};
use super::{Attempt, Refinement, Scope};
use crate::Result;
use crate::diagnose::Progress;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::search;
use crate::diagnose::hypothesis::joint::{Outcome, Point};
use crate::diagnose::judge::adequacy::is_adequate;
use crate::simulator::Parameter;

/// A parameter that differs between recordings.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::diagnose) struct RandomParameter {
    /// Its name.
    pub name: String,
    /// Its standard deviation between recordings.
    pub sd: f64,
}

pub(super) struct ParameterDiffers;

impl Refinement for ParameterDiffers {
    fn applies(&self, attempt: &Attempt) -> bool {
        attempt.scope == Scope::Whole && !attempt.residuals.passed()
    }

    fn attempt<'a>(&self, attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
        let mut adequate = None;
        for model in std::iter::once(&attempt.found.base).chain(&attempt.found.best) {
            let Some(fits) = fit_per_recording(&attempt.context, model, How::SameEffects, progress)? else { break };
            if let Some(odd) = fits.odd() {
                let odd = Some(attempt.context.recordings()[odd].index);
                return Ok(Attempt { odd, ..attempt });
            }
            if fits.adequate {
                adequate = Some(fits);
                break;
            }
        }
        let Some(fits) = adequate else { return Ok(attempt) };
        let differing: Vec<_> = fits.estimates.iter().filter(|one| one.differ()).collect();
        let [one] = differing[..] else { return Ok(attempt) };
        if one.coefficient {
            return Ok(attempt);
        }
        let random = RandomParameter { name: one.name.clone(), sd: one.spread() };
        // One value for all recordings may have left the correlation that was taken for the noise's.
        let evidence = Evidence::clone(&attempt.context.evidence).prewhitened(fits.lag1);
        let context = drawn_anew(&attempt.context.with_evidence(evidence), &random);
        let mut nuisances = attempt.found.base.fit.point.nuisances.clone();
        for values in &mut nuisances {
            values.push(0.0);
        }
        let point = Point { parameters: attempt.found.base.fit.point.parameters.clone(), nuisances };
        let near =
            Hypothesis { structure: context.structure(&[])?, fit: Outcome { point, ..attempt.found.base.fit.clone() } };
        let base = context.fit_near(&[], &near)?;
        let found = search(&context, base, is_adequate, progress)?;
        let explained = Attempt::tested(context, found, Scope::Whole, None)?;
        Ok(if explained.residuals.passed() { Attempt { random_parameter: Some(random), ..explained } } else { attempt })
    }
}

/// The context in which every recording has a deviation of its own from the parameter that all share.
fn drawn_anew<'a>(context: &Context<'a>, random: &RandomParameter) -> Context<'a> {
    let mut evidence = Evidence::clone(&context.evidence);
    for recording in evidence.training.iter_mut().chain(&mut evidence.validation) {
        let parameters = context.subjects[recording.object].simulator.parameters();
        let Some(position) = parameters.iter().position(|p| p.name == random.name) else { continue };
        let Parameter { unit, .. } = &parameters[position];
        let span = parameters[position].span();
        let name = format!("{}.deviation", random.name);
        let Ok(deviation) = Parameter::new(name, unit.clone(), 0.0, -span, span) else { continue };
        recording.prepared.nuisances.push(deviation);
        recording.prior_sd.push(random.sd);
        recording.random_parameter = Some(position);
    }
    context.with_evidence(evidence)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::strategy::whole_record::WholeRecord;
    use crate::diagnose::tests::zoo::{in_context, swing};
    use crate::testing::{Exact, Pendulum};

    /// Six pendulums whose lengths scatter by 2 %.
    #[test]
    fn a_length_that_differs_from_swing_to_swing_is_a_random_parameter() {
        let lengths = [0.81, 0.78, 0.82, 0.79, 0.815, 0.785];
        let seen: Vec<_> = (0u32..).zip(lengths).map(|(k, length)| swing(&[("length", length)], k)).collect();
        in_context(&Exact::new(Pendulum), &seen, 1, |context| {
            let whole = WholeRecord.attempt(Attempt::tuned(context).unwrap(), &|_| {}).unwrap();
            assert!(ParameterDiffers.applies(&whole));
            let found = ParameterDiffers.attempt(whole, &|_| {}).unwrap();
            let random = found.random_parameter.clone().unwrap();
            assert!(random.name == "length" && (random.sd - 0.017).abs() < 0.005, "{random:?}");
            assert!(found.residuals.passed() && found.found.best.is_none());
        });
    }
}
