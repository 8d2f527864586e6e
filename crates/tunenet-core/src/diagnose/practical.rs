//! A second look for recordings of the world, where with enough data every statistical test fails.
//!
//! Whatever the best model leaves is taken for noise that remembers: the residual's own spread, and only as many independent
//! values as its correlation leaves. What then still stands out has to take most of the gap away.

use super::control::{control, unseen};
use super::held_out::HeldOut;
use super::search::Found;
use super::sets::Set;
use super::study::{Model, Study};
use super::{Progress, Test};
use crate::Result;

/// What may be left beyond noise, as a share of what the effects took away (of mean squares).
pub(super) const LEFT_SHARE: f64 = 0.1;
/// ... where each of them has to be there anyhow (drag of a ball of known mass and size): most of what was missing is
/// accounted for, and the rest is something else. Whether such an effect exists is no question; how large it is, is.
const LEFT_SHARE_CERTAIN: f64 = 1.0 / 3.0;
/// Effects have to take the residual of unseen recordings down to this share ...
pub(super) const CONFIRMED: f64 = 0.5;
/// ... and a wrong effect has to leave this many times as much.
pub(super) const CONTROL: f64 = 1.3;
/// An effect may differ from recording to recording by this share of itself; what is only like it differs by more.
const UNSTEADY: f64 = 0.15;
/// An effect has to reduce the mean square by this factor to be worth a name.
pub(super) const WORTH: f64 = 1.3;
/// Correlations above this would leave next to no independent value.
const GREATEST: f64 = 0.97;

/// A second look, with what the first leaves taken for noise.
pub(super) struct Second<'a> {
    pub found: Found<'a>,
    pub before: Option<HeldOut>,
    pub tests: Vec<Test>,
}

pub(super) fn practically<'a>(
    study: &mut Study<'a>,
    first: &Found<'a>,
    held_out: &mut [Set],
    floor: f64,
    progress: &dyn Fn(Progress),
) -> Result<Second<'a>> {
    let unseen_floor = mean_square(held_out);
    let mut found = study.search_practically(first, held_out, progress)?;
    let before = unseen(study, &found.base, held_out)?;
    let after = found.best.as_ref().map_or(Ok(None), |best| unseen(study, best, held_out))?;
    if let (Some(before), Some(after)) = (&before, &after) {
        study.admit_equals(&mut found, held_out, before.rmse, after.rmse)?;
    }
    let control = control(study, &found, held_out)?.map(|c| c.1);
    let tests = study.practical_tests(&found, (floor, unseen_floor), before.as_ref().zip(after.as_ref()), control)?;
    Ok(Second { found, before, tests })
}

impl<'a> Study<'a> {
    /// Takes what `model` leaves for noise.
    fn take_rest_for_noise(&mut self, model: &Model, held_out: &mut [Set]) -> Result<()> {
        let plain = self.joint(&model.structure).plain_residuals(&model.fit.point)?;
        let (mut product, mut square) = (0.0, 0.0);
        let channels = self.sets.first().map_or(0, Set::width);
        let mut pooled = vec![(0.0, 0.0); channels];
        for (set, values) in self.sets.iter_mut().zip(&plain) {
            let width = set.width();
            for (channel, pooled) in pooled.iter_mut().enumerate().take(width) {
                let kept: Vec<f64> =
                    (channel..values.len()).step_by(width).filter(|&i| set.keep[i]).map(|i| values[i]).collect();
                let sum: f64 = kept.iter().map(|v| v * v).sum();
                if kept.is_empty() || sum <= 0.0 {
                    continue;
                }
                let spread = (sum / kept.len() as f64).sqrt();
                pooled.0 += sum;
                pooled.1 += kept.len() as f64;
                square += sum / (spread * spread);
                product += kept.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (spread * spread);
                set.noise[channel] = set.noise[channel].max(spread);
            }
            set.colour(0.0);
        }
        for set in held_out {
            for (noise, (sum, count)) in set.noise.iter_mut().zip(&pooled) {
                if *count > 0.0 {
                    *noise = noise.max((sum / count).sqrt());
                }
            }
            set.colour(0.0);
        }
        let rho = if square > 0.0 { (product / square).clamp(0.0, GREATEST) } else { 0.0 };
        // What a mean of correlated values is worth in independent ones.
        self.independent = (1.0 - rho) / (1.0 + rho);
        Ok(())
    }

    /// The search again with what `found` leaves taken for noise.
    pub fn search_practically(
        &mut self,
        found: &Found<'a>,
        held_out: &mut [Set],
        progress: &dyn Fn(Progress),
    ) -> Result<Found<'a>> {
        let best = found.best.as_ref().unwrap_or(&found.base);
        self.take_rest_for_noise(best, held_out)?;
        let base = self.fit_near(&[], &found.base)?;
        self.search(base, progress)
    }

    /// Where a single effect was found: counts every other that does as well on recordings that were not fitted among what
    /// could stand in its place.
    pub fn admit_equals(&self, found: &mut Found, held_out: &[Set], before: f64, after: f64) -> Result<()> {
        let [place] = found.places.as_mut_slice() else { return Ok(()) };
        for trial in found.alone.iter().filter(|t| t.entry != place.entry && t.excluded.is_none()) {
            let Some(model) = &trial.model else { continue };
            let reached = self.held_out(model, held_out)?.rmse;
            if reached <= CONFIRMED * before && reached < CONTROL * after {
                place.equals.push(trial.entry);
            }
        }
        Ok(())
    }

    /// Whether the effects found take away enough; the floors are the noise of the recordings themselves, and of the unseen
    /// ones, as mean squares of plain residuals.
    pub fn practical_tests(
        &self,
        found: &Found,
        (floor, unseen_floor): (f64, f64),
        unseen: Option<(&HeldOut, &HeldOut)>,
        control: Option<f64>,
    ) -> Result<Vec<Test>> {
        let Some(best) = &found.best else { return Ok(Vec::new()) };
        let square = |model: &Model| -> Result<f64> {
            let plain = self.joint(&model.structure).plain_residuals(&model.fit.point)?;
            Ok(super::held_out::rmse(&self.sets, &plain, 0.0).powi(2))
        };
        let (before, after) = (square(&found.base)?, square(best)?);
        let left = (after - floor).max(0.0) / (before - after).max(f64::MIN_POSITIVE);
        let certain = best.structure.effects.iter().all(|&entry| self.certain(entry));
        let threshold = if certain { LEFT_SHARE_CERTAIN } else { LEFT_SHARE };
        let mut tests = vec![Test { name: "left over taken away", value: left, threshold, passed: left <= threshold }];
        let value = self.unsteadiness(best);
        let passed = certain || value <= UNSTEADY;
        tests.push(Test { name: "difference between recordings", value, threshold: UNSTEADY, passed });
        if let Some((before, after)) = unseen {
            // Where it is no question whether the effects are there, only what is no noise has to shrink.
            let noise = if certain { unseen_floor } else { 0.0 };
            let beyond = |rmse: f64| (rmse * rmse - noise).max(0.0).sqrt();
            let after = beyond(after.rmse);
            let value = after / beyond(before.rmse).max(f64::MIN_POSITIVE);
            let passed = value <= CONFIRMED;
            tests.push(Test { name: "unseen residual after over before", value, threshold: CONFIRMED, passed });
            if let Some(control) = control {
                let value = after / beyond(control).max(f64::MIN_POSITIVE);
                let threshold = CONTROL.recip();
                tests.push(Test {
                    name: "unseen residual over that of a wrong effect",
                    value,
                    threshold,
                    passed: value <= threshold,
                });
            }
        }
        Ok(tests)
    }

    /// The recordings' own noise as a mean square of plain residuals.
    pub fn floor(&self) -> f64 {
        mean_square(&self.sets)
    }
}

/// The noise of these recordings as a mean square of plain residuals.
fn mean_square(sets: &[Set]) -> f64 {
    let (mut squares, mut samples) = (0.0, 0.0);
    for set in sets {
        let width = set.width();
        let kept = set.keep.iter().enumerate().filter(|(_, keep)| **keep);
        squares += kept.map(|(i, _)| set.noise[i % width].powi(2)).sum::<f64>();
        samples += set.count() as f64 / width as f64;
    }
    squares / f64::max(samples, 1.0)
}
