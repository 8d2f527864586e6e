//! Noise that seems to remember for long: a misfit looks the same, and whitening hides it.

use super::Progress;
use super::answer::Test;
use super::colour;
use super::search::Found;
use super::sets::Set;
use super::study::Study;
use crate::Result;

/// A lag-one correlation above this is more than sensors and trackers are known for at the rates that people record at.
const LONG: f64 = 0.7;
/// Where effects take so much of the correlation away, it was theirs.
const TAKEN: f64 = 0.5;

impl<'a> Study<'a> {
    /// The search with white noise, beside one that took a long memory for the noise's. `None` where no effect takes the
    /// memory away: then it stays what it was taken for. Otherwise the noise is coloured as the effects leave it.
    ///
    /// # Errors
    /// Where the simulator refuses.
    pub fn search_without_memory(
        &mut self,
        found: &Found<'a>,
        rho: &mut f64,
        progress: &dyn Fn(Progress),
    ) -> Result<Option<Found<'a>>> {
        if *rho <= LONG {
            return Ok(None);
        }
        let known = self.sets.clone();
        self.sets.iter_mut().for_each(|set: &mut Set| set.colour(0.0));
        let base = self.fit_near(&[], &found.base)?;
        let white = self.search(base, progress)?;
        let left = white.best.as_ref().map(|best| self.weighted(best)).transpose()?;
        if left.is_some_and(|left| colour::correlation(&self.sets, &left) < *rho - TAKEN) {
            *rho = 0.0;
            return self.search_again(white, rho, progress).map(Some);
        }
        self.sets = known;
        Ok(None)
    }
}

/// Fails where the noise that was whitened remembers for longer than noise is known to: nothing tells it from a misfit.
pub(super) fn believable(rho: f64) -> Option<Test> {
    (rho > LONG).then_some(Test { name: "correlation of the noise", value: rho, threshold: LONG, passed: false })
}
