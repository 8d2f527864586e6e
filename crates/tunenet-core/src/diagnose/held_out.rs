//! Recordings that were not fitted: only their start states are, and then their later part is predicted.

use super::fit::Effort;
use super::joint::{Joint, Point};
use super::sets::Set;
use super::study::{FULL, Model, Study};
use crate::Result;

const EARLY: Effort = Effort { steps: 6, tolerance: 0.5, horizon: 0.45 };
/// The share of a recording from which the rest is forecast.
const KNOWN: f64 = 0.4;
/// Of so many recordings of one object one may be set aside.
const ONE_OF: usize = 4;

/// How far a model lies from recordings that it never saw, in the channels' unit.
#[derive(Debug, Clone)]
pub(super) struct HeldOut {
    /// Root mean square with their start states fitted.
    pub rmse: f64,
    /// Root mean square of the later part, forecast from the first [`KNOWN`].
    pub forecast: f64,
    /// Weighted residuals, shape `[recording][sample · channel]`.
    pub residuals: Vec<Vec<f64>>,
    /// Their own unknowns.
    pub own: Vec<Vec<f64>>,
}

impl Study<'_> {
    /// Judges `model` by recordings that were not fitted.
    pub fn held_out(&self, model: &Model, sets: &[Set]) -> Result<HeldOut> {
        let structure = self.structure(&model.structure.effects)?.frozen(&model.fit.point.globals);
        let joint = Joint { structure: &structure, sets, rollouts: &self.rollouts };
        let start = Point { globals: Vec::new(), own: sets.iter().map(|s| s.prepared.own_values()).collect() };
        let early = joint.fit(start, EARLY, None)?.point;
        let whole = joint.fit(early.clone(), FULL, None)?.point;
        let plain = joint.plain_residuals(&whole)?;
        let known = joint.fit(early, Effort { horizon: KNOWN, ..FULL }, None)?.point;
        let ahead = joint.plain_residuals(&known)?;
        let mut residuals = plain.clone();
        for (set, values) in sets.iter().zip(&mut residuals) {
            let width = set.width();
            values
                .iter_mut()
                .enumerate()
                .for_each(|(i, v)| *v = if set.keep[i] { *v / set.noise[i % width] } else { 0.0 });
        }
        Ok(HeldOut { rmse: rmse(sets, &plain, 0.0), forecast: rmse(sets, &ahead, KNOWN), residuals, own: whole.own })
    }
}

/// Root mean square of plain residuals from the share `from` of each recording on, a sample of several channels counted
/// once; what is set aside does not count.
pub(super) fn rmse(sets: &[Set], plain: &[Vec<f64>], from: f64) -> f64 {
    let (mut squares, mut samples) = (0.0, 0.0);
    for (set, values) in sets.iter().zip(plain) {
        let begin = from * values.len() as f64;
        let kept = values.iter().enumerate().filter(|(i, _)| set.keep[*i] && *i as f64 >= begin);
        let (sum, count) = kept.fold((0.0, 0.0), |(sum, count), (_, v)| (sum + v * v, count + 1.0));
        squares += sum;
        samples += count / set.width() as f64;
    }
    if samples > 0.0 { (squares / samples).sqrt() } else { 0.0 }
}

/// Which recordings to set aside where none is given: of each object with enough of them every fourth, beginning where the
/// seed says. `objects` are the objects of the usable recordings.
pub(super) fn set_aside(objects: &[usize], seed: u64) -> Vec<usize> {
    let mut chosen = Vec::new();
    let most = objects.iter().copied().max().map_or(0, |m| m + 1);
    for object in 0..most {
        let mine: Vec<usize> = (0..objects.len()).filter(|&i| objects[i] == object).collect();
        let count = mine.len() / ONE_OF;
        let offset = usize::try_from(seed % ONE_OF as u64).unwrap_or(0);
        chosen.extend((0..count).map(|k| mine[k * ONE_OF + offset]));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::set_aside;

    #[test]
    fn one_in_four_of_each_object_is_set_aside() {
        assert!(set_aside(&[0, 0, 0], 0).is_empty());
        assert_eq!(set_aside(&[0, 0, 0, 0, 1, 1], 2), [2]);
        assert_eq!(set_aside(&[0, 1, 0, 1, 0, 1, 0, 1], 1), [2, 3]);
    }
}
