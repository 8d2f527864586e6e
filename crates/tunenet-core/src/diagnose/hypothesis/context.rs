//! What every step of a diagnosis is given, and a hypothesis with its fit. Values: a step that needs another context copies
//! it with a changed field.

use std::sync::Arc;

use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::ar1_correlation;
use crate::diagnose::evidence::outliers;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::catalogue::Entry;
use crate::diagnose::hypothesis::joint::{Effort, Joint, Outcome, Point};
use crate::diagnose::hypothesis::structure::{FixedEffect, Structure};
use crate::diagnose::{Settings, Subject};
use crate::estimate::RolloutLog;
use crate::estimate::huber::huber_cost;
use crate::estimate::information_criterion::{bic_gain, likelihood_gain};

/// A full fit.
pub(in crate::diagnose) const FULL: Effort =
    Effort { steps: 40, derivatives: 12, ends_measured: true, tolerance: 0.02, horizon: 1.0, hopeless: f64::INFINITY };
/// A fit of a hypothesis that is only compared: it ends as soon as its steps gain what its derivatives predict. Its covariance is rough.
pub(in crate::diagnose) const COMPARED: Effort = Effort { ends_measured: false, ..FULL };
/// A change of the noise's lag-1 correlation below this is left.
const CORRELATION_CHANGE: f64 = 0.05;

/// Of a single motion, explanations are left up to this many times the usual margin. It is not named alone, since what
/// is in no catalogue looks like one of its entries in one motion, by any margin; unless the effect has to be there, as
/// drag of a body of known mass and size.
pub(in crate::diagnose) const SINGLE_MOTION_MARGIN: f64 = 10.0;

/// A random effect of events: every event has draws of its own from one distribution.
#[derive(Debug, Clone, Copy)]
pub(in crate::diagnose) struct EventEffects {
    /// The standard deviation of a draw, in the unit of the effect's coefficient.
    pub sd: f64,
    /// How many draws are fitted.
    pub count: usize,
}

/// What is known, and what may be missing.
#[derive(Clone)]
pub(in crate::diagnose) struct Context<'a> {
    pub subjects: &'a [Subject<'a>],
    pub evidence: Arc<Evidence>,
    pub catalogue: Arc<[Entry]>,
    pub settings: &'a Settings,
    /// The random effect of events, where it is part of every hypothesis.
    pub event_effects: Option<EventEffects>,
    /// Effects that are fixed at known values.
    pub given: Arc<[FixedEffect]>,
    /// Effects, by their positions in the catalogue, and objects in which they are absent.
    pub spared: Arc<[(usize, usize)]>,
    /// Whether what is physically required is part of every hypothesis from the start.
    pub required_first: bool,
    /// Whether a rollout shows derivatives by parameters of several channels: these hardly act on each other's.
    pub separable: bool,
    /// Counts rollouts against the allowance.
    pub rollouts: RolloutLog,
}

/// A hypothesis: effects, parameters and nuisance parameters, with their fit.
pub(in crate::diagnose) struct Hypothesis<'a> {
    pub structure: Structure<'a>,
    pub fit: Outcome,
}

impl<'a> Hypothesis<'a> {
    /// The same fit as a hypothesis of its own.
    pub fn again(&self, context: &Context<'a>) -> Result<Self> {
        Ok(Self { structure: context.structure(&self.structure.effects)?, fit: self.fit.clone() })
    }

    /// The robust sum of squares in units of the noise, losses changing over at 4 times `scale`, with that of the nuisance
    /// parameters from their priors.
    pub fn deviance(&self, scale: f64) -> f64 {
        2.0 * (huber_cost(&self.fit.residuals, scale) + self.fit.prior_part)
    }

    /// The scale of the robust loss.
    pub fn scale(&self) -> f64 {
        self.fit.scale
    }

    pub fn has(&self, entry: usize) -> bool {
        self.structure.effects.contains(&entry)
    }
}

impl<'a> Context<'a> {
    /// Where a diagnosis begins: nothing fixed, nothing required, no random effect. Rollouts count in `rollouts`, whose answers are not used:
    /// they may be of other subjects.
    pub fn new(
        subjects: &'a [Subject<'a>],
        evidence: Evidence,
        catalogue: Vec<Entry>,
        settings: &'a Settings,
        rollouts: &RolloutLog,
    ) -> Self {
        Self {
            subjects,
            evidence: Arc::new(evidence),
            catalogue: catalogue.into(),
            settings,
            event_effects: None,
            given: Arc::new([]),
            spared: Arc::new([]),
            required_first: false,
            separable: false,
            rollouts: rollouts.apart(),
        }
    }

    /// The same with other evidence.
    pub fn with_evidence(&self, evidence: Evidence) -> Self {
        Self { evidence: Arc::new(evidence), ..self.clone() }
    }

    /// The recordings that are fitted.
    pub fn recordings(&self) -> &[PreparedRecording] {
        &self.evidence.training
    }

    /// The share of the values that counts as independent.
    pub fn effective_fraction(&self) -> f64 {
        self.evidence.noise.effective_fraction()
    }

    pub fn joint<'b>(&'b self, structure: &'b Structure<'b>) -> Joint<'b> {
        Joint { structure, recordings: self.recordings(), separable: self.separable, rollouts: &self.rollouts }
    }

    pub fn structure(&self, effects: &[usize]) -> Result<Structure<'a>> {
        let fixed = (&self.given[..], &self.spared[..]);
        Structure::new(self.subjects, self.recordings(), &self.catalogue, effects, fixed, self.event_effects.is_some())
    }

    /// Whether several motions without inputs were recorded. Only for these are searches left out that cannot succeed. In a single motion, or
    /// in a mechanism with inputs, a search with another noise model finds other effects.
    pub fn shows_free_motions(&self) -> bool {
        let free = |recording: &PreparedRecording| !recording.driven() && recording.prepared.circumstances.is_none();
        self.recordings().iter().all(free) && !self.evidence.shows_one_motion()
    }

    /// The random effect of events, where every subject knows one.
    pub fn random_effect_entry(&self) -> Option<&Entry> {
        self.catalogue.iter().find(|e| e.is_random_effect())
    }

    /// How far behind the best an explanation is still left; more where no object shows a second motion, against which the
    /// values of its nuisance parameters could be held.
    pub fn margin(&self) -> f64 {
        let single = self.evidence.shows_one_motion_per_object();
        self.settings.margin * if single { SINGLE_MOTION_MARGIN } else { 1.0 }
    }

    /// How many values are fitted.
    pub fn count(&self) -> usize {
        self.evidence.count()
    }

    /// Twice the gain in logarithmic likelihood between two sums of squares.
    pub fn likelihood(&self, before: f64, after: f64) -> f64 {
        self.effective_fraction() * likelihood_gain(self.count(), before, after)
    }

    /// The fall of the information criterion by `coefficients` more numbers.
    pub fn criterion(&self, before: f64, after: f64, coefficients: f64) -> f64 {
        bic_gain(self.likelihood(before, after), self.effective_fraction() * self.count() as f64, coefficients)
    }

    /// The sum of squares at which `coefficients` more numbers gain this much over `before` by [`criterion`](Self::criterion).
    pub fn sum_of_squares(&self, before: f64, gain: f64, coefficients: f64) -> f64 {
        let count = self.effective_fraction() * self.count() as f64;
        before * (-(gain - bic_gain(0.0, count, coefficients)) / count).exp()
    }

    /// The same hypothesis with the evidence of this context, at the same values.
    pub fn evaluated(&self, model: &Hypothesis) -> Result<Hypothesis<'a>> {
        let structure = self.structure(&model.structure.effects)?;
        let fit = self.joint(&structure).evaluate(model.fit.point.clone())?;
        Ok(Hypothesis { structure, fit })
    }

    /// A hypothesis with these effects, fitted from the values of `near`.
    pub fn fit_near(&self, effects: &[usize], near: &Hypothesis) -> Result<Hypothesis<'a>> {
        self.fit_near_with(effects, near, FULL)
    }

    /// The same with this effort.
    pub fn fit_near_with(&self, effects: &[usize], near: &Hypothesis, effort: Effort) -> Result<Hypothesis<'a>> {
        let structure = self.structure(effects)?;
        let point = Point {
            parameters: structure.carry(&near.structure, &near.fit.point.parameters),
            nuisances: near.fit.point.nuisances.clone(),
        };
        let fit = self.joint(&structure).fit(point, effort)?;
        Ok(Hypothesis { structure, fit })
    }

    /// Residuals of a model in units of the noise, not whitened; outliers stay 0.
    pub fn weighted(&self, model: &Hypothesis) -> Result<Vec<Vec<f64>>> {
        let mut plain = self.joint(&model.structure).plain_residuals(&model.fit.point)?;
        for (recording, values) in self.recordings().iter().zip(&mut plain) {
            let width = recording.width();
            for (i, value) in values.iter_mut().enumerate() {
                *value = if recording.keep[i] { *value / recording.noise[i % width] } else { 0.0 };
            }
        }
        Ok(plain)
    }

    /// The variance of the noise, taken from what `model` leaves, by which its covariance is multiplied.
    pub fn variance(&self, model: &Hypothesis) -> f64 {
        let freedom = self.count() as f64 - model.structure.shared.len() as f64;
        model.deviance(model.scale()) / freedom.max(1.0) / self.effective_fraction()
    }

    /// The evidence less the outliers that `model` leaves, prewhitened by the correlation of its residuals; `None` where that
    /// changes nothing, so that no fit has to be made again.
    pub fn learn_noise(&self, model: &Hypothesis) -> Result<Option<Evidence>> {
        let mut weighted = self.joint(&model.structure).plain_residuals(&model.fit.point)?;
        for (recording, values) in self.recordings().iter().zip(&mut weighted) {
            let width = recording.width();
            values.iter_mut().enumerate().for_each(|(i, v)| *v /= recording.noise[i % width]);
        }
        let mut learned = Evidence::clone(&self.evidence);
        let outliers = outliers::set_aside(&mut learned.training, &weighted);
        let rho = if self.evidence.discrepancy() {
            ar1_correlation::whole_correlation(&learned.training, &weighted)
        } else {
            ar1_correlation::correlation(&learned.training, &weighted)
        };
        let changed = outliers > 0 || (rho - self.evidence.noise.lag1()).abs() > CORRELATION_CHANGE;
        Ok(changed.then(|| learned.prewhitened(rho)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{in_context, in_swings, swings};

    use crate::diagnose::evidence::NoiseModel;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::observation::Observation;
    use crate::testing::{Exact, Pendulum};

    #[test]
    fn a_single_motion_leaves_a_wider_margin() {
        in_swings(&[], 1, 0, |one| {
            in_swings(&[], 2, 0, |two| {
                assert_eq!(one.margin(), SINGLE_MOTION_MARGIN * two.margin());
            });
        });
    }

    #[test]
    fn a_sum_of_squares_gains_what_it_is_meant_to() {
        in_swings(&[], 2, 0, |context| {
            let after = context.sum_of_squares(900.0, 35.0, 2.0);
            assert!((context.criterion(900.0, after, 2.0) - 35.0).abs() < 1e-9, "{after}");
        });
    }

    #[test]
    fn white_noise_teaches_nothing_and_an_outlier_is_left_out() {
        in_swings(&[], 2, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert!(context.learn_noise(&base).unwrap().is_none());
        });
        let mut seen = swings(&[], 2);
        let values: Vec<f64> =
            seen[1].values().iter().enumerate().map(|(i, v)| if i == 90 { v + 0.1 } else { *v }).collect();
        let one = &seen[1];
        seen[1] = Observation::new(one.kind(), one.channels().to_vec(), one.clock().to_vec(), values).unwrap();
        in_context(&Exact::new(Pendulum), &seen, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let learned = context.learn_noise(&base).unwrap().unwrap();
            assert!(!learned.training[1].keep[90] && learned.count() + 1 == context.count());
            // What was known before stays as it was.
            assert!(context.evidence.training[1].keep[90] && context.evidence.noise == NoiseModel::White);
        });
    }
}
