//! What fits: Algorithm 1, the fit through rollouts, intervals and verdicts.
//!
//! ```text
//! recordings → prepare → Algorithm 1 (with a network) → fit with own unknowns → intervals → verdict
//! ```
//!
//! [`tune`] runs the whole chain; the pieces are public for those who want only one.

mod adequacy;
mod algorithm1;
mod bounce_noise;
mod fit;
mod interval;
mod outcome;
mod residual;
mod starts;
mod unknowns;

pub use adequacy::Adequacy;
pub use algorithm1::{Loop, Walk, walk};
pub use fit::{Fit, Problem};
pub use interval::{LEVEL, Spread, intervals};
pub use outcome::{Estimate, Gap, Iteration, Outcome, Stop, Verdict};
pub use residual::channel_noise;
use starts::local_estimate;
pub use unknowns::{Point, free};

use nalgebra::DMatrix;

use crate::network::Model;
use crate::observation::{Note, Observation};
use crate::simulator::{Preparation, Prepared, Simulator};
use crate::{Error, Result};

/// An interval as wide as this share of the bounds says no more than the bounds do: a value drawn evenly from them has a
/// 95 % interval of .95.
const UNINFORMATIVE_SHARE: f64 = 0.9;
/// How to tune.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Iterations of Algorithm 1 where a model is given.
    pub iterations: usize,
    /// Start values by name, instead of the simulator's own.
    pub initial: Vec<(String, f64)>,
    /// Keep values within the bounds during Algorithm 1. The paper does so in its third experiment only.
    pub clamp: bool,
    /// Finish with a fit through rollouts and return the best iterate; off, the last iterate of Algorithm 1 stands, as in
    /// the paper.
    pub finish: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { iterations: 5, initial: Vec::new(), clamp: true, finish: true }
    }
}

/// Tunes `simulator` to `observations`, all of the same thing: shared parameters, and for each recording its own unknowns.
///
/// ```
/// # use tunenet_core::{observation::{Channel, Observation, Kind}, simulator::{Parameter, Simulator}, tune};
/// struct Cooling(Vec<Parameter>, Vec<Channel>);
/// impl Simulator for Cooling {
///     fn parameters(&self) -> &[Parameter] { &self.0 }
///     fn channels(&self) -> &[Channel] { &self.1 }
///     fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], values: &mut [f64]) -> Result<(), String> {
///         clock.iter().zip(values).for_each(|(t, v)| *v = (-p[0] * t).exp());
///         Ok(())
///     }
/// }
/// let cup = Cooling(vec![Parameter::new("rate", "1/s", 0.5, 0.0, 5.0)?], vec![Channel::new("warmth", "1")]);
/// let clock: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
/// let warmth = clock.iter().map(|t| (-1.25 * t).exp()).collect();
/// let seen = Observation::new(Kind::Other, cup.channels().to_vec(), clock, warmth)?;
/// let outcome = tune::tune(&cup, &[seen], None, &tune::Settings::default())?;
/// assert_eq!(outcome.verdict, tune::Verdict::Tuned);
/// assert!((outcome.parameters[0].value - 1.25).abs() < 1e-6);
/// # Ok::<(), tunenet_core::Error>(())
/// ```
///
/// # Errors
/// [`Error::Setting`] where no parameter may be tuned, or `initial` names none or lies outside its bounds;
/// [`Error::Model`] where the model does not fit; whatever the simulator refuses.
pub fn tune(
    simulator: &dyn Simulator,
    observations: &[Observation],
    model: Option<&Model>,
    settings: &Settings,
) -> Result<Outcome> {
    let mut notes = Vec::new();
    let (mut recordings, mut used) = (Vec::new(), Vec::new());
    for seen in observations {
        match simulator.prepare(seen)? {
            Preparation::Usable(prepared) => {
                notes.extend(prepared.notes.iter().cloned());
                recordings.push(*prepared);
                used.push(true);
            }
            Preparation::Rejected(note) => {
                notes.push(note);
                used.push(false);
            }
        }
    }
    if recordings.is_empty() {
        return Ok(rejected(notes, used));
    }
    if !simulator.parameters().iter().any(|p| p.tune) {
        let expected = "at least one parameter with `tune = true`".into();
        return Err(Error::Setting { name: "parameters", expected, found: "none".into() });
    }
    let noise: Vec<Vec<f64>> = recordings.iter().map(|r| channel_noise(&r.seen)).collect();
    let free = free(simulator.parameters(), &recordings);
    let session = Session { simulator, recordings: &recordings, noise: &noise, free: &free, settings };
    let mut outcome = session.run(model)?;
    outcome.notes.splice(0..0, notes);
    outcome.used = used;
    Ok(outcome)
}

fn rejected(notes: Vec<Note>, used: Vec<bool>) -> Outcome {
    Outcome {
        verdict: Verdict::Rejected,
        parameters: Vec::new(),
        correlation: DMatrix::zeros(0, 0),
        iterations: Vec::new(),
        gap: None,
        rollouts: 0,
        stop: Stop::Nothing,
        notes,
        point: None,
        used,
    }
}

/// One call of [`tune`] with everything prepared.
struct Session<'a> {
    simulator: &'a dyn Simulator,
    recordings: &'a [Prepared],
    noise: &'a [Vec<f64>],
    free: &'a [usize],
    settings: &'a Settings,
}

impl Session<'_> {
    fn problem(&self) -> Problem<'_> {
        Problem { simulator: self.simulator, recordings: self.recordings, noise: self.noise, free: self.free }
    }

    fn start(&self) -> Result<Point> {
        let mut point = Point::start(self.simulator, self.recordings);
        for (name, value) in &self.settings.initial {
            let known = || self.simulator.parameters().iter().map(|p| p.name.clone()).collect::<Vec<_>>().join(", ");
            let position =
                self.simulator.parameters().iter().position(|p| p.name == *name).ok_or_else(|| Error::Setting {
                    name: "initial",
                    expected: format!("a parameter: {}", known()),
                    found: format!("`{name}`"),
                })?;
            let p = &self.simulator.parameters()[position];
            if !(p.min..=p.max).contains(value) {
                let expected = format!("{} to {} for `{name}`", p.min, p.max);
                return Err(Error::Setting { name: "initial", expected, found: value.to_string() });
            }
            point.parameters[position] = *value;
        }
        Ok(point)
    }

    fn run(&self, model: Option<&Model>) -> Result<Outcome> {
        let problem = self.problem();
        let start = self.start()?;
        // The gap before is the old parameters' best: only the recordings' own unknowns are fitted.
        let before = Problem { free: &[], ..self.problem() }.fit(start.clone(), 1.0)?;
        let mut rollouts = before.rollouts;
        let gap_before = problem.rmse(&before.residuals);
        let (mut iterations, mut stop, mut notes) = (Vec::new(), Stop::Converged, Vec::new());
        let mut near = Point { parameters: start.parameters.clone(), own: before.point.own.clone() };
        if let Some(model) = model.filter(|_| self.recordings.len() == 1 && !self.free.is_empty()) {
            let secant = self.settings.finish && self.free.len() == 1;
            let how = Loop {
                iterations: self.settings.iterations,
                clamp: self.settings.clamp,
                secant,
                best: self.settings.finish,
            };
            let walk = walk(self.simulator, &self.recordings[0], model, start.clone(), how)?;
            rollouts += walk.rollouts;
            iterations = walk.iterations;
            near = walk.point;
            stop = Stop::Iterations;
        }
        let mut fit = if self.settings.finish || iterations.is_empty() {
            let (fit, used) = self.best_fit(&near)?;
            rollouts += used;
            if iterations.is_empty() {
                iterations.push(Iteration { k: 0, parameters: near.at(self.free), rmse: gap_before });
            }
            let after = fit.trace.iter().skip(1).enumerate();
            let first = iterations.len();
            iterations.extend(after.map(|(i, (parameters, rmse))| Iteration {
                k: first + i,
                parameters: parameters.clone(),
                rmse: *rmse,
            }));
            fit
        } else {
            let fit = problem.evaluate(near)?;
            rollouts += fit.rollouts;
            fit
        };
        let (mut interval95, used) = intervals(&problem, &fit)?;
        rollouts += used;
        let poor = self.poor(&fit, &mut notes);
        // The paper's last iterate stands as it is; anything else would not be the paper's.
        if poor && self.settings.finish {
            self.fall_back_on_local(&mut fit, &mut interval95, &mut notes);
            // The recordings' own unknowns follow the parameters that now stand.
            let own = Problem { free: &[], ..self.problem() }.fit(fit.point, 1.0)?;
            rollouts += own.rollouts;
            (fit.point, fit.residuals) = (own.point, own.residuals);
        }
        let gap = Gap {
            unit: self.simulator.channels()[0].unit.clone(),
            before: gap_before,
            after: problem.rmse(&fit.residuals),
            noise_floor: self.noise_floor(),
        };
        let parameters = self.estimates(&start, &fit, &interval95, &mut notes);
        let verdict = if parameters.iter().any(|p| !p.identified) {
            Verdict::NotIdentifiable
        } else if poor {
            Verdict::PoorFit
        } else {
            Verdict::Tuned
        };
        let correlation = correlation(&fit.covariance);
        let (gap, point) = (Some(gap), Some(fit.point));
        Ok(Outcome {
            verdict,
            parameters,
            correlation,
            iterations,
            gap,
            rollouts,
            stop,
            notes,
            point,
            used: Vec::new(),
        })
    }

    /// Whether any recording keeps more than its noise explains; says by how much.
    fn poor(&self, fit: &Fit, notes: &mut Vec<Note>) -> bool {
        let mut poor = false;
        for (d, recording) in self.recordings.iter().enumerate() {
            let share = self.free.len().div_ceil(self.recordings.len());
            let adequacy =
                Adequacy::of(&recording.seen, &self.noise[d], &fit.residuals[d], recording.own.len() + share);
            if adequacy.poor() {
                poor = true;
                let which = if self.recordings.len() > 1 { format!("recording {}: ", d + 1) } else { String::new() };
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
    fn fall_back_on_local(&self, fit: &mut Fit, interval95: &mut [(f64, f64)], notes: &mut Vec<Note>) {
        for (&i, interval) in self.free.iter().zip(interval95) {
            let p = &self.simulator.parameters()[i];
            if let Some((value, sd)) = local_estimate(self.recordings, i) {
                let text = format!(
                    "`{}` is read off the contacts alone ({value:.4}); the whole record would give {:.4}",
                    p.name, fit.point.parameters[i]
                );
                fit.point.parameters[i] = value.clamp(p.min, p.max);
                *interval = ((value - 1.96 * sd).max(p.min), (value + 1.96 * sd).min(p.max));
                notes.push(Note::new("fit.local", text, ""));
            }
        }
    }

    fn noise_floor(&self) -> f64 {
        let squares: f64 = self
            .recordings
            .iter()
            .zip(self.noise)
            .map(|(r, n)| r.seen.len() as f64 * n.iter().map(|s| s * s).sum::<f64>())
            .sum();
        (squares / self.recordings.iter().map(|r| r.seen.len()).sum::<usize>() as f64).sqrt()
    }

    fn estimates(&self, start: &Point, fit: &Fit, interval95: &[(f64, f64)], notes: &mut Vec<Note>) -> Vec<Estimate> {
        let mut all = Vec::new();
        for (i, p) in self.simulator.parameters().iter().enumerate().filter(|(_, p)| p.tune) {
            let place = self.free.iter().position(|&f| f == i);
            let interval = place.map_or((p.min, p.max), |k| (interval95[k].0.max(p.min), interval95[k].1.min(p.max)));
            let identified = place.is_some() && interval.1 - interval.0 < UNINFORMATIVE_SHARE * p.span();
            let value = fit.point.parameters[i];
            if !identified {
                let reason = self.recordings.iter().find_map(|r| r.silent[i].clone());
                notes.push(reason.unwrap_or_else(|| {
                    let text = format!(
                        "the data do not determine `{}`: any value from {:.3} to {:.3} fits",
                        p.name, interval.0, interval.1
                    );
                    Note::new("parameter.not_identifiable", text, "bring a recording in which it matters")
                }));
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

fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
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
