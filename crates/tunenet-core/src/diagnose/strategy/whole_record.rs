//! Whole recordings: learn the noise from the tuned simulation, search, and search again where the effects show another noise.

use super::{Attempt, Refinement, Scope};
use crate::Result;
use crate::diagnose::Progress;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::ar1_correlation;
use crate::diagnose::hypothesis::context::Context;
use crate::diagnose::hypothesis::forward_selection::{Selection, search, search_again};
use crate::diagnose::judge::adequacy::{is_adequate, long_lag1};

/// Where effects take so much of the correlation away, it was theirs.
const TAKEN: f64 = 0.5;

pub(super) struct WholeRecord;

impl Refinement for WholeRecord {
    fn applies(&self, attempt: &Attempt) -> bool {
        attempt.scope == Scope::Tuned
    }

    fn attempt<'a>(&self, attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
        let (mut context, mut base) = (attempt.context, attempt.found.base);
        if let Some(evidence) = context.learn_noise(&base)? {
            context = context.with_evidence(evidence);
            base = context.fit_near(&[], &base)?;
        }
        let found = search(&context, base, is_adequate, progress)?;
        let (mut context, mut found) = search_again(context, found, is_adequate, progress)?;
        if let Some(white) = search_white(&context, &found, progress)? {
            (context, found) = white;
        }
        Attempt::tested(context, found, Scope::Whole, None)
    }
}

/// The search with white noise, next to one that took a long autocorrelation for the noise's. `None` where no effect takes the
/// correlation away: then it stays what it was taken for. Otherwise the noise is modelled as the effects leave it.
///
/// # Errors
/// Where the simulator refuses.
fn search_white<'a>(
    context: &Context<'a>,
    found: &Selection<'a>,
    progress: &dyn Fn(Progress),
) -> Result<Option<(Context<'a>, Selection<'a>)>> {
    let rho = context.evidence.noise.lag1();
    if rho <= long_lag1(&context.evidence) {
        return Ok(None);
    }
    let white = context.with_evidence(Evidence::clone(&context.evidence).prewhitened(0.0));
    let base = white.fit_near(&[], &found.base)?;
    let found = search(&white, base, is_adequate, progress)?;
    let left = found.best.as_ref().map(|best| white.weighted(best)).transpose()?;
    if left.is_some_and(|left| ar1_correlation::correlation(white.recordings(), &left) < rho - TAKEN) {
        return search_again(white, found, is_adequate, progress).map(Some);
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings, names};

    #[test]
    fn whole_recordings_show_the_missing_effect() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let attempt = Attempt::tuned(context).unwrap();
            assert!(WholeRecord.applies(&attempt));
            let attempt = WholeRecord.attempt(attempt, &|_| {}).unwrap();
            assert_eq!(names(&attempt.context, &attempt.last().structure.effects), ["viscous_friction"]);
            assert!(attempt.residuals.passed() && attempt.lag1 == 0.0);
            assert!(!WholeRecord.applies(&attempt), "once is enough");
        });
    }
}
