//! What a fit is worth: whether noise explains the rest, what each parameter's interval means, and what the data cannot tell.

use nalgebra::DMatrix;

use super::fit::Fit;
use super::outcome::Estimate;
use super::starts::local_estimate;
use super::unknowns::Point;
use super::{Adequacy, Tuning};
use crate::observation::Note;

/// An interval as wide as this share of the bounds says no more than the bounds do: a value drawn evenly from them has a
/// 95 % interval of .95.
const UNINFORMATIVE_SHARE: f64 = 0.9;
/// A combination of parameters whose standard deviation exceeds this share of their bounds is as wide as an even draw from
/// them (1/√12).
const LOOSE_DIRECTION: f64 = 0.29;
/// A parameter takes part in a direction from this share on.
const TAKES_PART: f64 = 0.3;

impl Tuning<'_> {
    /// Whether any recording keeps more than its noise explains; says by how much.
    pub(super) fn poor(&self, fit: &Fit, notes: &mut Vec<Note>) -> bool {
        let mut poor = false;
        for (d, recording) in self.recordings.iter().enumerate() {
            let share = self.free.len().div_ceil(self.recordings.len());
            let adequacy =
                Adequacy::of(&recording.seen, &self.noise[d], &fit.residuals[d], recording.own.len() + share);
            if adequacy.poor() {
                poor = true;
                let which = if self.numbers.last() > Some(&1) {
                    format!("{}: ", self.settings.name_of(self.numbers[d] - 1))
                } else {
                    String::new()
                };
                let text = format!(
                    "{which}the tuned rollout leaves {:.1} times the noise, more than the {:.1} that chance explains",
                    adequacy.ratio, adequacy.limit
                );
                notes.push(Note::new(
                    "fit.poor",
                    text,
                    "an effect is missing from the simulation, or the recording is of something else",
                ));
            } else if !adequacy.tested {
                let text = format!("{} samples are too few to tell noise from misfit", recording.seen.len());
                notes.push(Note::new("fit.untested", text, "bring a longer recording"));
            }
        }
        poor
    }

    /// Where the record as a whole is not explained, what its events alone say stands: a force missing in flight must not
    /// be booked as restitution.
    pub(super) fn fall_back_on_local(&self, fit: &mut Fit, interval95: &mut [(f64, f64)], notes: &mut Vec<Note>) {
        for (&i, interval) in self.free.iter().zip(interval95) {
            let p = &self.simulator.parameters()[i];
            if let Some((value, sd)) = local_estimate(self.recordings, i) {
                let text = format!(
                    "`{}` is read off the contacts alone ({value:.4}); the whole record would give {:.4}",
                    p.name, fit.point.parameters[i]
                );
                fit.point.parameters[i] = value.clamp(p.min, p.max);
                let (low, high) = (value - 1.96 * sd, value + 1.96 * sd);
                *interval = (low.clamp(p.min, p.max), high.clamp(p.min, p.max));
                notes.push(Note::new("fit.local", text, ""));
            }
        }
    }

    pub(super) fn noise_floor(&self) -> f64 {
        let squares: f64 = self
            .recordings
            .iter()
            .zip(self.noise)
            .map(|(r, n)| r.seen.len() as f64 * n.iter().map(|s| s * s).sum::<f64>())
            .sum();
        (squares / self.recordings.iter().map(|r| r.seen.len()).sum::<usize>() as f64).sqrt()
    }

    pub(super) fn estimates(
        &self,
        start: &Point,
        fit: &Fit,
        interval95: &[(f64, f64)],
        notes: &mut Vec<Note>,
    ) -> Vec<Estimate> {
        let mut all = Vec::new();
        for (i, p) in self.simulator.parameters().iter().enumerate().filter(|(_, p)| p.tune) {
            let place = self.free.iter().position(|&f| f == i);
            let interval = place.map_or((p.min, p.max), |k| (interval95[k].0.max(p.min), interval95[k].1.min(p.max)));
            let identified = place.is_some() && interval.1 - interval.0 < UNINFORMATIVE_SHARE * p.span();
            let value = fit.point.parameters[i];
            if !identified {
                let reason = self.recordings.iter().find_map(|r| r.silent[i].clone());
                let moot = place.is_some_and(|k| !fit.covariance[(k, k)].is_finite());
                notes.push(reason.unwrap_or_else(|| undetermined(&p.name, interval, moot)));
            } else if value <= p.min || value >= p.max {
                let text = format!("`{}` ends on its bound {value}", p.name);
                notes.push(Note::new(
                    "parameter.at_bound",
                    text,
                    "check the bounds, the units and the surface's height",
                ));
            }
            all.push(Estimate {
                name: p.name.clone(),
                unit: p.unit.clone(),
                before: start.parameters[i],
                value,
                interval95: interval,
                bounds: (p.min, p.max),
                identified,
            });
        }
        all
    }
}

/// The note on a parameter that the data leave open.
fn undetermined(name: &str, interval: (f64, f64), moot: bool) -> Note {
    let remedy = "bring a recording in which it matters";
    if moot {
        return Note::new("parameter.no_effect", format!("`{name}` changes nothing in these recordings"), remedy);
    }
    let text =
        format!("the data do not determine `{name}`: any value from {:.3} to {:.3} fits", interval.0, interval.1);
    Note::new("parameter.not_identifiable", text, remedy)
}

/// Names every combination of parameters along which the data leave everything open although each may seem bounded alone.
pub(super) fn name_directions(tuning: &Tuning, fit: &Fit, notes: &mut Vec<Note>) {
    let parameters: Vec<_> = tuning.free.iter().map(|&i| &tuning.simulator.parameters()[i]).collect();
    let finite = fit.covariance.iter().all(|v| v.is_finite());
    if parameters.len() < 2 || !finite {
        return;
    }
    let scaled = DMatrix::from_fn(parameters.len(), parameters.len(), |i, j| {
        fit.covariance[(i, j)] / (parameters[i].span() * parameters[j].span())
    });
    let eigen = scaled.symmetric_eigen();
    for (k, variance) in eigen.eigenvalues.iter().enumerate() {
        let axis = eigen.eigenvectors.column(k);
        let mut part: Vec<usize> = (0..parameters.len()).filter(|&i| axis[i].abs() > TAKES_PART).collect();
        part.sort_by(|a, b| axis[*b].abs().total_cmp(&axis[*a].abs()));
        if variance.max(0.0).sqrt() > LOOSE_DIRECTION && part.len() > 1 {
            let terms: Vec<String> = part
                .iter()
                .map(|&i| format!("{:+.2} {}", axis[i] * axis[part[0]].signum(), parameters[i].name))
                .collect();
            let text = format!("the data do not determine the combination {}", terms.join(" "));
            notes.push(Note::new(
                "parameter.direction",
                text,
                "fix one of them, or bring a recording that separates them",
            ));
        }
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
