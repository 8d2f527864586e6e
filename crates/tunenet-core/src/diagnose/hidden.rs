//! Flights of a recording that are hidden from the fit and predicted from the others: what confirms an effect where no
//! recording of the same object can be set aside.

use super::joint::Joint;
use super::sets::Set;
use super::study::{FULL, Model, Study};
use crate::Result;

/// Every so many flights one is hidden, the first never: nothing else tells how it began.
const EVERY: usize = 3;

impl Study<'_> {
    /// Root mean square, in units of what each channel takes for noise, of what `model`, fitted anew to the other flights, leaves on those hidden, every one but the first
    /// of each recording in its turn. `None` where no recording bounces twice.
    pub fn hidden(&self, model: &Model) -> Result<Option<f64>> {
        let (mut squares, mut samples) = (0.0, 0.0);
        for turn in 0..EVERY {
            let (shown, judged): (Vec<Set>, Vec<Set>) = self.sets.iter().map(|set| without(set, turn)).unzip();
            let count: usize = judged.iter().map(Set::count).sum();
            if count == 0 {
                continue;
            }
            let joint = Joint { structure: &model.structure, sets: &shown, rollouts: &self.rollouts };
            let point = joint.fit(model.fit.point.clone(), FULL, None)?.point;
            for (set, plain) in judged.iter().zip(joint.plain_residuals(&point)?) {
                let kept = plain.iter().enumerate().filter(|(i, _)| set.keep[*i]);
                squares += kept.map(|(i, v)| (v / set.noise[i % set.width()]).powi(2)).sum::<f64>();
            }
            samples += count as f64;
        }
        Ok((samples > 0.0).then(|| (squares / samples).sqrt()))
    }
}

/// A recording without the flights of this turn, and with them alone.
fn without(set: &Set, turn: usize) -> (Set, Set) {
    let width = set.width();
    let (mut shown, mut judged) = (set.clone(), set.clone());
    for (k, t) in set.clock().iter().enumerate() {
        let flight = set.contacts.partition_point(|c| c <= t);
        let hide = flight > 0 && flight % EVERY == turn;
        for i in k * width..(k + 1) * width {
            shown.keep[i] &= !hide;
            judged.keep[i] &= hide;
        }
    }
    shown.colour(0.0);
    (shown, judged)
}
