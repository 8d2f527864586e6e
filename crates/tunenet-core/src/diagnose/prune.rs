//! Effects that are real to the last digit and worth no name: what they take away is nothing beside the others.

use super::held_out::rmse;
use super::search::Found;
use super::study::{Model, Study};
use crate::Result;

/// An effect without which less than this share of the mean square comes back that all take away is worth no name.
const NEGLIGIBLE: f64 = 0.01;

impl<'a> Study<'a> {
    /// Mean square of the plain residuals.
    fn square(&self, model: &Model) -> Result<f64> {
        let plain = self.joint(&model.structure).plain_residuals(&model.fit.point)?;
        Ok(rmse(&self.sets, &plain, 0.0).powi(2))
    }

    /// Drops effects, the least first, as long as what each brought is negligible.
    pub fn prune(&self, found: &mut Found<'a>) -> Result<()> {
        let before = self.square(&found.base)?;
        while let Some(best) = &found.best
            && best.structure.effects.len() > 1
        {
            let after = self.square(best)?;
            let mut least: Option<(f64, usize, Model<'a>)> = None;
            for &entry in &best.structure.effects {
                let others: Vec<usize> = best.structure.effects.iter().copied().filter(|&e| e != entry).collect();
                let without = self.fit_near(&others, best)?;
                let share = (self.square(&without)? - after) / (before - after).max(f64::MIN_POSITIVE);
                if least.as_ref().is_none_or(|(smallest, ..)| share < *smallest) {
                    least = Some((share, entry, without));
                }
            }
            let Some((_, entry, without)) = least.filter(|(share, ..)| *share < NEGLIGIBLE) else { break };
            found.places.retain(|place| place.entry != entry);
            found.best = Some(without);
        }
        Ok(())
    }
}
