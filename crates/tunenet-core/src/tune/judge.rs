//! Verdict of a fit: residuals against noise, the status of each parameter, and what the data do not determine.

use crate::findings;
use nalgebra::DMatrix;

use super::Tuning;
use super::outcome::{Estimate, Status, Stop, Verdict};
use super::starts::local_estimate;
use crate::estimate::{Adequacy, Fit, Information, Interval, Point, ScaleEstimate, UNINFORMATIVE_SHARE, floor};
use crate::observation::{Kind, Note, three_digits, with_decimals};
use crate::simulator::Parameter;
use crate::statistics::NORMAL_95;

/// One-sided level of the score test at a bound: a truth exactly on its bound is called wrong once in a thousand
/// recordings.
const BOUND_LEVEL: f64 = 0.999;
/// The same in standard deviations, where these are known.
const BOUND_SDS: f64 = 3.09;
/// ... and where it would carry the parameter farther beyond than this share of the bounds. Nearly exact recordings show
/// less than that of any two simulators.
const PRACTICAL_SHARE: f64 = 1e-5;

impl Tuning<'_> {
    /// How the residuals of recording `d` compare with its noise.
    fn adequacy(&self, fit: &Fit, d: usize) -> Adequacy {
        let share = self.free.len().div_ceil(self.recordings.len());
        let recording = &self.recordings[d];
        let (noise, fitted) = (floor(recording), (recording.nuisances.len() + share, recording.discrepancy));
        if recording.residual_scale.is_none() {
            return Adequacy::of(&recording.seen, &noise, &fit.residuals[d], fitted);
        }
        // The fit divides residuals by their scale estimate; here they are compared with the noise.
        let scale: Vec<f64> = self.noise[d].iter().zip(&noise).map(|(weight, noise)| weight / noise).collect();
        let residuals: Vec<f64> =
            fit.residuals[d].iter().enumerate().map(|(i, r)| r * scale[i % scale.len()]).collect();
        Adequacy::of(&recording.seen, &noise, &residuals, fitted)
    }

    /// Whether any recording keeps more than its noise explains.
    pub(super) fn poor(&self, fit: &Fit) -> bool {
        (0..self.recordings.len()).any(|d| self.adequacy(fit, d).poor())
    }

    /// Reports by how much the residual exceeds the noise, and where that cannot be tested.
    pub(super) fn report_misfit(&self, fit: &Fit, poor: bool, notes: &mut Vec<Note>) {
        for (d, recording) in self.recordings.iter().enumerate() {
            let adequacy = self.adequacy(fit, d);
            if poor && adequacy.poor() {
                let which = if self.numbers.last() > Some(&1) {
                    format!("{}: ", self.settings.name_of(self.numbers[d] - 1))
                } else {
                    String::new()
                };
                let channels = self.simulator.channels();
                let place = channels.get(adequacy.worst).filter(|_| channels.len() > 1);
                let place = place.map_or_else(String::new, |c| format!(" of `{}`", c.name));
                let text = format!(
                    "{which}the tuned rollout leaves {} times the noise{place}, more than the limit {:.1} for white noise",
                    with_decimals(adequacy.ratio, 1),
                    adequacy.limit
                );
                notes.push(Note::new(
                    findings::FIT_POOR,
                    text,
                    "search for the missing effect with a diagnosis of the same recordings",
                ));
            } else if !adequacy.tested {
                let text = format!("{} samples are too few to separate noise from misfit", recording.seen.len());
                notes.push(Note::new(findings::FIT_UNTESTED, text, "bring a longer recording"));
            }
        }
    }

    /// Reports where intervals were not checked.
    pub(super) fn report_unchecked(&self, fit: &Fit, notes: &mut Vec<Note>) {
        if self.settings.quick {
            let text = "only the first fit was made; intervals are those of the curvature, and were not checked";
            notes.push(Note::new(findings::FIT_QUICK, text, "leave out the option for checked intervals"));
        } else if !fit.cut_short && self.takes_curvature(fit) {
            let text = "the fit is poor: intervals are those of the curvature, and were not checked";
            notes.push(Note::new(findings::INTERVALS_CURVATURE, text, ""));
        }
    }

    /// What is said where the limit on rollouts ended something.
    pub(super) fn limit_note(&self, stop: Stop) -> Option<Note> {
        let most = self.settings.max_rollouts.filter(|_| self.log.was_short())?;
        let what = if stop == Stop::Limit {
            "ended the fit before it had converged: values are the best so far, and their intervals are the bounds"
        } else {
            "ended searches and checks after the fit; intervals that were not checked are those of the curvature"
        };
        let text = format!("the limit of {most} rollouts {what}");
        Some(Note::new(findings::ROLLOUTS_LIMIT, text, "allow more rollouts"))
    }

    /// There are no more numbers than parameters: such a fit is always exact, so there is no estimate of its uncertainty.
    fn too_short(&self) -> Option<Note> {
        let values: usize = self.recordings.iter().map(|r| r.seen.values().len()).sum();
        let fitted = self.free.len() + self.recordings.iter().map(|r| r.nuisances.len()).sum::<usize>();
        (values <= fitted && !self.free.is_empty()).then(|| {
            let text = format!(
                "{values} measured numbers always fit {fitted} parameters exactly, so the uncertainty is not known"
            );
            let one = if self.simulator.kind() == Kind::EventTimes { "event time" } else { "sample" };
            let more = (fitted + 1 - values).div_ceil(self.simulator.channels().len());
            let least = if more == 1 { format!("1 more {one}") } else { format!("{more} more {one}s") };
            Note::new(findings::RECORDINGS_SHORT, text, format!("bring at least {least}"))
        })
    }

    /// Status and interval of each free parameter after its fit.
    pub(super) fn standings(
        &self,
        fit: &Fit,
        known: &Information,
        scale: &ScaleEstimate,
        interval95: &[Interval],
    ) -> Vec<Standing> {
        let each = |(k, interval): (usize, &Interval)| {
            let p = &self.simulator.parameters()[self.free[k]];
            let value = fit.point.parameters[self.free[k]];
            // Where a fit was ended on its way, nothing says how far it had to go.
            if fit.cut_short {
                return Standing { interval: (p.min, p.max), status: Status::Pinned, beyond: 0.0, reported: true };
            }
            let (low, high) = (interval.low.value.max(p.min), interval.high.value.min(p.max));
            let weak = high - low >= UNINFORMATIVE_SHARE * p.span() || interval.open(value, p.span());
            let within = |null: bool| known.directions.iter().any(|d| d.null == null && d.parts().contains(&k));
            let beyond = known.score[k];
            let outward = value <= p.min && beyond < 0.0 || value >= p.max && beyond > 0.0;
            let status = if within(true) || weak && within(false) {
                Status::Direction
            } else if !known.covariance[(k, k)].is_finite() && (low, high) == (p.min, p.max) {
                Status::NoEffect
            } else if weak {
                Status::Weak
            } else if outward && self.against_bound(known, scale, k) {
                Status::AtBound
            } else {
                Status::Pinned
            };
            Standing { interval: (low, high), status, beyond, reported: false }
        };
        interval95.iter().enumerate().map(each).collect()
    }

    /// Whether the score of parameter `k` at its bound is significant, and the step beyond large enough to matter.
    fn against_bound(&self, known: &Information, scale: &ScaleEstimate, k: usize) -> bool {
        let span = self.simulator.parameters()[self.free[k]].span();
        let beyond = known.score[k].abs();
        beyond > scale.one_sided(BOUND_LEVEL) && beyond * scale.sd(known.covariance[(k, k)]) > PRACTICAL_SHARE * span
    }

    /// If the record as a whole is not explained, the estimate from its events only is used: a force missing between events must not
    /// be booked as the events' doing. Says whether there was anything to fall back on; `whole` is the gap of the fit to the whole.
    pub(super) fn fall_back_on_local(
        &self,
        fit: &mut Fit,
        found: &mut [Standing],
        whole: f64,
        notes: &mut Vec<Note>,
    ) -> bool {
        let mut fell = false;
        let unit = &self.simulator.channels()[0].unit;
        for (&i, standing) in self.free.iter().zip(found) {
            let p = &self.simulator.parameters()[i];
            if let Some((value, sd)) = local_estimate(self.recordings, i) {
                let text = format!(
                    "`{}` = {} comes from the events only, because the full fit is poor; the gap above is that of this value. \
                     The full fit gives {}, with a gap of {} {unit}",
                    p.name,
                    with_decimals(value, 4),
                    with_decimals(fit.point.parameters[i], 4),
                    three_digits(whole)
                );
                fit.point.parameters[i] = value.clamp(p.min, p.max);
                *standing = Standing::local(p, value, sd, standing);
                notes.push(Note::new(findings::FIT_LOCAL, text, ""));
                fell = true;
            }
        }
        fell
    }

    /// What noise alone leaves, as [`Problem::rmse`](crate::estimate::Problem::rmse) counts it.
    pub(super) fn noise_floor(&self) -> f64 {
        let (mut squares, mut samples) = (0.0, 0.0);
        for (recording, weights) in self.recordings.iter().zip(self.noise) {
            let one_unit = recording.seen.common_unit().is_some();
            let unit = |weight: f64| if one_unit { 1.0 } else { weight };
            let square: f64 = floor(recording).iter().zip(weights).map(|(sd, w)| (sd / unit(*w)).powi(2)).sum();
            let rows = recording.seen.len() as f64;
            squares += rows * square;
            samples += if one_unit { rows } else { rows * weights.len() as f64 };
        }
        (squares / samples).sqrt()
    }

    /// The answer for every parameter to tune. One on which nothing depends keeps its value.
    pub(super) fn estimates(
        &self,
        start: &Point,
        fit: &mut Fit,
        found: &[Standing],
        notes: &mut Vec<Note>,
    ) -> Vec<Estimate> {
        let mut all = Vec::new();
        for (i, p) in self.simulator.parameters().iter().enumerate().filter(|(_, p)| p.tune) {
            let free = self.free.iter().position(|&f| f == i);
            let silent = Standing { interval: (p.min, p.max), status: Status::NoEffect, beyond: 0.0, reported: false };
            let standing = free.map_or(silent, |k| found[k]);
            if standing.status == Status::NoEffect {
                fit.point.parameters[i] = start.parameters[i];
            }
            let value = fit.point.parameters[i];
            let reason = self.recordings.iter().find_map(|r| r.silent[i].clone()).filter(|_| free.is_none());
            notes.extend(reason.or_else(|| standing.note(p, value)));
            all.push(Estimate {
                name: p.name.clone(),
                unit: p.unit.clone(),
                before: start.parameters[i],
                value,
                interval95: standing.interval,
                bounds: (p.min, p.max),
                identified: standing.status.identified(),
                status: standing.status,
            });
        }
        all
    }
}

/// How one free parameter stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct Standing {
    /// Its 95 % interval within the bounds.
    interval: (f64, f64),
    status: Status,
    /// Score at its bound, in standard deviations.
    beyond: f64,
    /// Whether the reason was reported already.
    reported: bool,
}

impl Standing {
    /// Of a parameter that was read off the events. One that lies beyond a bound is set to the bound; `whole` is its
    /// status by the fit to everything, whose score may exceed the bound as well.
    fn local(p: &Parameter, value: f64, sd: f64, whole: &Self) -> Self {
        let held = value.clamp(p.min, p.max);
        // Beyond a bound, the interval begins there.
        let (low, high) = ((held - NORMAL_95 * sd).max(p.min), (held + NORMAL_95 * sd).min(p.max));
        let beyond = (value - held).abs();
        let far = beyond > BOUND_SDS * sd && beyond > PRACTICAL_SHARE * p.span();
        let on_bound = held <= p.min || held >= p.max;
        let score = if on_bound && whole.status == Status::AtBound { whole.beyond.abs() } else { 0.0 };
        let status = if high - low >= UNINFORMATIVE_SHARE * p.span() {
            Status::Weak
        } else if far || score > 0.0 {
            Status::AtBound
        } else {
            Status::Pinned
        };
        Self { interval: (low, high), status, beyond: score.max(beyond / sd), reported: false }
    }

    /// What a user should know of it.
    fn note(&self, p: &Parameter, value: f64) -> Option<Note> {
        let name = &p.name;
        let remedy = "bring a recording in which it matters";
        let (low, high) = self.interval;
        match self.status {
            Status::NoEffect => {
                let text = format!("`{name}` changes nothing in these recordings, so it keeps its value {value}");
                Some(Note::new(findings::PARAMETER_NO_EFFECT, text, remedy))
            }
            Status::Weak if self.reported => None,
            Status::Weak => {
                let (low, high) = (with_decimals(low, 3), with_decimals(high, 3));
                let text = format!("the data do not determine `{name}`: any value from {low} to {high} fits");
                Some(Note::new(findings::PARAMETER_NOT_IDENTIFIABLE, text, remedy))
            }
            Status::AtBound => {
                let text = format!(
                    "`{name}` ends on its bound {value}, and the data favour values beyond it by {} standard deviations",
                    with_decimals(self.beyond.abs(), 1)
                );
                Some(Note::new(
                    findings::PARAMETER_AT_BOUND,
                    text,
                    "widen the bound if it may lie beyond; otherwise check the units and what the simulation leaves out",
                ))
            }
            Status::Pinned if !self.reported && (value <= p.min || value >= p.max) => {
                let text = format!("`{name}` lies on its bound {value}, as it may: its interval is one-sided");
                // A bound that is no end by nature may be too near.
                let remedy = if value == 0.0 { "" } else { "widen the bound if the value may lie beyond" };
                Some(Note::new(findings::PARAMETER_ONE_SIDED, text, remedy))
            }
            Status::Pinned | Status::Direction => None,
        }
    }
}

/// Leaves every parameter open that the data have a bearing on, where there are too few of them; says whether that is so.
pub(super) fn leave_open_where_short(tuning: &Tuning, found: &mut [Standing], notes: &mut Vec<Note>) -> bool {
    let Some(note) = tuning.too_short() else { return false };
    notes.push(note);
    for (&i, standing) in tuning.free.iter().zip(found).filter(|(_, s)| s.status != Status::NoEffect) {
        let p = &tuning.simulator.parameters()[i];
        *standing = Standing { interval: (p.min, p.max), status: Status::Weak, beyond: 0.0, reported: true };
    }
    true
}

/// What is to be said of the whole.
pub(super) fn verdict(parameters: &[Estimate], poor: bool) -> Verdict {
    if parameters.iter().any(|p| !p.identified) {
        Verdict::NotIdentifiable
    } else if poor || parameters.iter().any(|p| p.status == Status::AtBound) {
        Verdict::PoorFit
    } else {
        Verdict::Tuned
    }
}

/// The places of the free parameters that a joint region is about: those on which the recordings have a bearing of their
/// own.
pub(super) fn joint(found: &[Standing]) -> Vec<usize> {
    let bears = |s: &Standing| !matches!(s.status, Status::NoEffect | Status::Direction);
    (0..found.len()).filter(|&k| bears(&found[k])).collect()
}

/// Names every combination of parameters along which the data leave everything open although each may seem bounded alone.
pub(super) fn name_directions(tuning: &Tuning, known: &Information, notes: &mut Vec<Note>) {
    for direction in &known.directions {
        let parts = direction.parts();
        let lead = direction.axis[parts[0]].signum();
        let term = |&i: &usize| {
            let name = &tuning.simulator.parameters()[tuning.free[i]].name;
            format!("{:+.2} {name}", direction.axis[i] * lead)
        };
        let terms: Vec<String> = parts.iter().map(term).collect();
        let text = format!("the data do not determine the combination {}", terms.join(" "));
        notes.push(Note::new(
            findings::PARAMETER_DIRECTION,
            text,
            "fix one of them, or bring a recording that separates them",
        ));
    }
}

/// Correlations from covariances; 0 where a variance is infinite.
pub(super) fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        if i == j {
            1.0
        } else if scale.is_finite() && scale > 0.0 {
            covariance[(i, j)] / scale
        } else {
            0.0
        }
    })
}
