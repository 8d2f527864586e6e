//! One throw, with what has to be there taken to be there.
//!
//! Air brakes a ball of known mass and size, whether that shows or not. Where something larger is missing as well, as a wrong
//! scale of the picture, drag alone earns little beside it, and neither of them alone explains the throw. So where one throw
//! is not explained otherwise, what has to be there comes first without having to earn its place; the one effect that one
//! throw may show besides is looked for beside it, and has to earn its own. The answer leaves a choice in any case.

use super::Progress;
use super::search::Found;
use super::sets::Set;
use super::study::{Model, Study};
use crate::Result;

impl<'a> Study<'a> {
    /// The simulation with what has to be there, where it is taken to be there; else `None`.
    pub fn expected(&self, base: &Model<'a>) -> Result<Option<Model<'a>>> {
        let certain: Vec<usize> = (0..self.catalogue.len()).filter(|&entry| self.certain(entry)).collect();
        if !self.expecting || certain.is_empty() {
            return Ok(None);
        }
        self.fit_near(&certain, base).map(Some)
    }

    /// Whether `model` holds nothing that was found, only what was expected.
    pub fn only_expected(&self, model: &Model) -> bool {
        model.structure.effects.iter().all(|&entry| self.unasked(entry))
    }

    /// Whether the effect is there without having to earn its place.
    pub fn unasked(&self, entry: usize) -> bool {
        self.expecting && self.certain(entry)
    }

    /// The search of one throw from what has to be there; `None` where nothing has to, or more than one throw was made.
    /// From then on every search of this study begins so.
    pub fn search_expecting(&mut self, found: &Found<'a>, progress: &dyn Fn(Progress)) -> Result<Option<Found<'a>>> {
        if !self.single() || !(0..self.catalogue.len()).any(|entry| self.certain(entry)) {
            return Ok(None);
        }
        self.expecting = true;
        // A misfit that bends slowly passes for noise that remembers, and whitening would hide it.
        self.sets.iter_mut().for_each(|set: &mut Set| set.colour(0.0));
        let base = self.fit_near(&[], &found.base)?;
        let found = self.search(base, progress)?;
        let whole = found.best.as_ref().is_some_and(|best| !self.only_expected(best));
        Ok(whole.then_some(found))
    }
}
