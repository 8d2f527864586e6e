//! Required effects first: of a single motion, what is physically required is part of every hypothesis from the start.
//!
//! Air brakes a body of known mass and size, whether that shows or not. Where something larger is missing as well, as a wrong
//! scale of the picture, drag alone earns little in addition to it, and neither of them alone explains the motion. So where one motion
//! is not explained otherwise, required effects come first, whatever they gain. The one effect that a single motion may show in
//! addition is searched for with these in place, and has to gain enough. The answer leaves a choice in any case.

use super::{Attempt, Refinement};
use crate::Result;
use crate::diagnose::Progress;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::hypothesis::context::Context;
use crate::diagnose::hypothesis::forward_selection::{Selection, search};
use crate::diagnose::hypothesis::plausibility::{holds_only_required, implausible, is_required};
use crate::diagnose::judge::adequacy::is_adequate;
use crate::diagnose::strategy::discrepancy_as_noise::with_inflated_noise;

pub(super) struct RequiredEffectsFirst;

impl Refinement for RequiredEffectsFirst {
    fn applies(&self, attempt: &Attempt) -> bool {
        attempt.may_inflate_noise()
    }

    fn attempt<'a>(&self, attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
        let Some((context, found)) = search_required_first(&attempt.context, &attempt.found, progress)? else {
            return Ok(attempt);
        };
        let second = with_inflated_noise(&context, &found, attempt.floor, progress)?;
        let plausible = second.found.best.as_ref().is_some_and(|model| {
            !holds_only_required(&second.context, model) && implausible(&second.context, model).is_none()
        });
        Ok(if plausible && second.passes() { attempt.replaced(second) } else { attempt })
    }
}

/// The search of one motion from what is required; `None` where nothing is, or where more than one motion was recorded.
/// Every search in the context that it returns begins so.
fn search_required_first<'a>(
    context: &Context<'a>,
    found: &Selection<'a>,
    progress: &dyn Fn(Progress),
) -> Result<Option<(Context<'a>, Selection<'a>)>> {
    let any_required = || (0..context.catalogue.len()).any(|entry| is_required(context, entry));
    if !context.evidence.shows_one_motion() || !any_required() {
        return Ok(None);
    }
    // A misfit that bends slowly passes for autocorrelated noise, and prewhitening would hide it.
    let evidence = Evidence::clone(&context.evidence).prewhitened(0.0);
    let context = Context { required_first: true, ..context.with_evidence(evidence) };
    let base = context.fit_near(&[], &found.base)?;
    let found = search(&context, base, is_adequate, progress)?;
    let whole = found.best.as_ref().is_some_and(|best| !holds_only_required(&context, best));
    Ok(whole.then_some((context, found)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings};

    use crate::diagnose::strategy::Scope;

    #[test]
    fn where_nothing_is_required_the_attempt_stays() {
        in_swings(&[(FRICTION, 0.15)], 1, 0, |context| {
            let attempt = Attempt::tuned(context).unwrap();
            let tested = Attempt::tested(attempt.context, attempt.found, Scope::Whole, None).unwrap();
            assert!(RequiredEffectsFirst.applies(&tested), "a single motion that is not explained");
            let same = RequiredEffectsFirst.attempt(tested, &|_| {}).unwrap();
            assert!(same.practical.is_none() && !same.context.required_first);
        });
    }
}
