//! Fits per recording: every recording is fitted as an object of its own, so that no number has to be the same in two of them.
//! Cochran's Q (Cochran 1954) tests which numbers then differ.

use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::catalogue::Entry;
use crate::diagnose::hypothesis::context::{COMPARED, Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::search;
use crate::diagnose::hypothesis::joint::{Outcome, Point};
use crate::diagnose::hypothesis::structure::SharedParameter;
use crate::diagnose::judge::adequacy::is_adequate;
use crate::diagnose::{Progress, Subject};
use crate::simulator::Text;
use crate::statistics::{dot, upper_chi_squared};

/// Fewer recordings show no difference between them.
const FEWEST: usize = 3;
/// Estimates that agree less probably than this differ; those that agree at least as probably as the second may be the same.
const DIFFER: f64 = 1e-4;
const SAME: f64 = 1e-2;
/// One recording is odd where it leaves this many times the noise and every other less than the second.
const ODD_RMS: f64 = 1.5;
const GOOD_RMS: f64 = 1.2;

/// Fits of every recording by itself.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct PerRecordingFits {
    /// The effects that it takes.
    pub effects: Vec<Text>,
    /// Gain of the information criterion over the tuned simulation that all recordings share.
    pub gain: f64,
    /// Whether what is left is noise.
    pub adequate: bool,
    /// For each tuned parameter and coefficient of one object: its estimates by recording.
    pub estimates: Vec<Estimates>,
    /// Root mean square of what is left of each recording, in units of its noise.
    pub rms: Vec<f64>,
    /// The lag-1 correlation of the noise.
    pub lag1: f64,
}

/// One number as each recording shows it.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::diagnose) struct Estimates {
    /// Its name as a parameter.
    pub name: String,
    /// Whether it is a coefficient of an effect.
    pub coefficient: bool,
    /// Value and standard error by recording; an infinite error where a recording says nothing.
    pub each: Vec<(f64, f64)>,
}

impl Estimates {
    /// Cochran's Q of these recordings, and its degrees of freedom.
    fn q(&self, of: impl Fn(usize) -> bool) -> (f64, f64) {
        let used: Vec<(f64, f64)> = (0..self.each.len())
            .filter(|&recording| of(recording) && self.each[recording].1.is_finite() && self.each[recording].1 > 0.0)
            .map(|recording| (self.each[recording].0, self.each[recording].1.powi(-2)))
            .collect();
        let whole: f64 = used.iter().map(|(_, weight)| weight).sum();
        let mean = used.iter().map(|(value, weight)| value * weight).sum::<f64>() / whole;
        (used.iter().map(|(value, weight)| weight * (value - mean).powi(2)).sum(), used.len() as f64 - 1.0)
    }

    fn p_value(&self, of: impl Fn(usize) -> bool) -> f64 {
        let (q, freedom) = self.q(of);
        if freedom < 1.0 { 1.0 } else { upper_chi_squared(q, freedom) }
    }

    /// Whether the recordings show different values.
    pub fn differ(&self) -> bool {
        self.p_value(|_| true) < DIFFER
    }

    /// The standard deviation between recordings, by the moments of Q (`DerSimonian` and Laird 1986).
    pub fn spread(&self) -> f64 {
        let (q, freedom) = self.q(|_| true);
        let weights: Vec<f64> =
            self.each.iter().filter(|e| e.1.is_finite() && e.1 > 0.0).map(|e| e.1.powi(-2)).collect();
        let whole: f64 = weights.iter().sum();
        let scale = whole - dot(&weights, &weights) / whole;
        ((q - freedom) / scale).max(0.0).sqrt()
    }
}

impl PerRecordingFits {
    /// The one recording without which all others agree; `None` where there is no such one, or several.
    pub fn odd(&self) -> Option<usize> {
        let count = self.rms.len();
        if count <= FEWEST {
            return None;
        }
        let good = |recording: usize| self.rms[recording] < GOOD_RMS;
        let unlike = |odd: &usize| self.rms[*odd] > ODD_RMS && (0..count).all(|other| other == *odd || good(other));
        if let Some(odd) = (0..count).find(unlike) {
            return Some(odd);
        }
        let differing: Vec<&Estimates> = self.estimates.iter().filter(|one| one.differ()).collect();
        let agree = |without: &usize| differing.iter().all(|one| one.p_value(|recording| recording != *without) > SAME);
        let mut alone = (0..count).filter(agree);
        let odd = alone.next().filter(|_| !differing.is_empty())?;
        alone.next().is_none().then_some(odd)
    }
}

/// By which effects every recording is explained.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::diagnose) enum How {
    /// By the effects of the model that they start from.
    SameEffects,
    /// By whatever effects a search finds.
    Search,
}

/// Fits every recording by itself from the values of `model`, which all share; `None` where that is the same as fitting them
/// together.
///
/// # Errors
/// Where a simulator refuses.
pub(in crate::diagnose) fn fit_per_recording(
    context: &Context,
    model: &Hypothesis,
    how: How,
    progress: &dyn Fn(Progress),
) -> Result<Option<PerRecordingFits>> {
    let recordings = context.recordings();
    let few = recordings.len() < FEWEST;
    if few || context.evidence.driven() || !context.given.is_empty() || context.event_effects.is_some() {
        return Ok(None);
    }
    let one = |recording: &PreparedRecording| {
        let Subject { name, simulator } = &context.subjects[recording.object];
        Subject { name: name.clone(), simulator: *simulator }
    };
    let subjects: Vec<Subject> = recordings.iter().map(one).collect();
    let entry = |entry: &Entry| Entry {
        of: recordings.iter().map(|recording| entry.of[recording.object].clone()).collect(),
        seen: entry.seen.clone(),
        name: entry.name.clone(),
    };
    let as_object =
        |(object, recording): (usize, &PreparedRecording)| PreparedRecording { object, ..recording.clone() };
    let training = recordings.iter().enumerate().map(as_object).collect();
    let evidence = Evidence { training, validation: Vec::new(), noise: context.evidence.noise };
    let catalogue = context.catalogue.iter().map(entry).collect();
    let mut separate = Context::new(&subjects, evidence, catalogue, context.settings, &context.rollouts);
    let effects = &model.structure.effects;
    let structure = separate.structure(effects)?;
    let value = |shared: &SharedParameter| {
        let object = shared.object.map(|recording| recordings[recording].object);
        let known = model.structure.shared.iter().zip(&model.fit.point.parameters);
        let mut same =
            known.filter(|(other, _)| other.object == object && other.parameter.name == shared.parameter.name);
        same.next().map_or(shared.parameter.value, |(_, value)| *value)
    };
    let point = Point {
        parameters: structure.shared.iter().map(value).collect(),
        nuisances: model.fit.point.nuisances.clone(),
    };
    let near = Hypothesis { structure, fit: Outcome { point, ..model.fit.clone() } };
    if how == How::Search {
        let found = search(&separate, separate.fit_near(effects, &near)?, is_adequate, progress)?;
        let best = found.best.as_ref().unwrap_or(&found.base);
        return Ok(Some(fits(context, model, (&separate, best))));
    }
    let mut close = separate.fit_near_with(effects, &near, COMPARED)?;
    let mut found = fits(context, model, (&separate, &close));
    // What the recordings share may have left the correlation that was taken for the noise's.
    let less = |evidence: &Evidence| evidence.noise.lag1() < separate.evidence.noise.lag1();
    let is_open = !found.adequate && found.odd().is_none();
    if let Some(evidence) = if is_open { separate.learn_noise(&close)?.filter(less) } else { None } {
        separate = separate.with_evidence(evidence);
        close = separate.fit_near_with(effects, &close, COMPARED)?;
        found = PerRecordingFits { gain: found.gain, ..fits(context, model, (&separate, &close)) };
    }
    // Standard errors are those of derivatives that were measured.
    if !found.adequate && found.odd().is_none() {
        return Ok(Some(found));
    }
    let best = separate.fit_near(effects, &close)?;
    Ok(Some(PerRecordingFits { gain: found.gain, ..fits(context, model, (&separate, &best)) }))
}

/// What `best`, in which every recording is an object of its own, says next to `model`, which they share.
fn fits(context: &Context, model: &Hypothesis, (separate, best): (&Context, &Hypothesis)) -> PerRecordingFits {
    let extra = best.structure.shared.len().saturating_sub(model.structure.shared.len());
    let scale = model.scale();
    let rms = |values: &Vec<f64>| (dot(values, values) / values.len().max(1) as f64).sqrt();
    PerRecordingFits {
        effects: best.structure.effects.iter().map(|&e| separate.catalogue[e].name.clone()).collect(),
        gain: context.criterion(model.deviance(scale), best.deviance(scale), extra as f64),
        adequate: is_adequate(separate, best),
        estimates: estimates(best, context.recordings().len()),
        rms: best.fit.residuals.iter().map(rms).collect(),
        lag1: separate.evidence.noise.lag1(),
    }
}

/// Every number of `model` that each recording has for itself.
fn estimates(model: &Hypothesis, count: usize) -> Vec<Estimates> {
    let mut all: Vec<Estimates> = Vec::new();
    for (column, shared) in model.structure.shared.iter().enumerate() {
        let Some(recording) = shared.object else { continue };
        let name = &shared.parameter.name;
        let position = all.iter().position(|one| one.name == *name).unwrap_or_else(|| {
            let each = vec![(0.0, f64::INFINITY); count];
            all.push(Estimates { name: name.clone(), coefficient: shared.effect.is_some(), each });
            all.len() - 1
        });
        let spread = model.scale().max(1.0);
        let value = model.fit.point.parameters[column];
        all[position].each[recording] = (value, spread * model.fit.covariance[(column, column)].max(0.0).sqrt());
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::tests::zoo::in_swings;

    fn of(values: &[f64], rms: &[f64]) -> PerRecordingFits {
        let each = values.iter().map(|value| (*value, 0.01)).collect();
        let estimates = vec![Estimates { name: "stiffness".into(), coefficient: false, each }];
        PerRecordingFits { effects: Vec::new(), gain: 100.0, adequate: true, estimates, rms: rms.to_vec(), lag1: 0.0 }
    }

    /// Q of ±0.1 with errors of 0.01 is 100 each; the moments give the standard deviation back.
    #[test]
    fn estimates_that_scatter_differ_and_their_spread_is_found() {
        let one = &of(&[0.7, 0.9, 0.7, 0.9], &[1.0; 4]).estimates[0];
        assert!(one.differ() && (one.q(|_| true).0 - 400.0).abs() < 1e-9);
        assert!((one.spread() - (0.01f64 * 4.0 / 3.0 - 1e-4).sqrt()).abs() < 1e-12);
        assert!(!of(&[0.8, 0.81, 0.79, 0.8], &[1.0; 4]).estimates[0].differ());
    }

    #[test]
    fn one_recording_is_odd_and_two_are_not() {
        assert_eq!(of(&[0.8, 0.8, 0.6, 0.81, 0.79], &[1.0; 5]).odd(), Some(2));
        assert_eq!(of(&[0.8, 0.8, 0.6, 0.6, 0.79], &[1.0; 5]).odd(), None);
        assert_eq!(of(&[0.8; 5], &[1.0, 1.0, 1.0, 4.0, 1.0]).odd(), Some(3));
        assert_eq!(of(&[0.8; 5], &[1.0; 5]).odd(), None);
    }

    #[test]
    fn recordings_of_one_pendulum_agree_and_too_few_say_nothing() {
        in_swings(&[], 4, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let fits = fit_per_recording(context, &base, How::SameEffects, &|_| {}).unwrap().unwrap();
            assert!(fits.adequate && fits.gain < 0.0 && fits.odd().is_none(), "{fits:?}");
            assert!(fits.estimates.iter().all(|one| !one.differ() && one.each.len() == 4));
        });
        in_swings(&[], 2, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert!(fit_per_recording(context, &base, How::Search, &|_| {}).unwrap().is_none());
        });
    }
}
